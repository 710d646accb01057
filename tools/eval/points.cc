#include "tools/eval/points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "builder/ingest/vectors.h"
#include "tools/eval/pairing.h"

namespace landfix::eval {
namespace {

constexpr double kDistances_m[] = {1, 2, 3, 4, 6, 8, 10};
constexpr double kConfidences[] = {0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};
constexpr int kSteps = 10;

cv::Point2d middle_of(const ingest::VectorPart& part) {
  if (part.shape != ingest::Shape::kPolygon) return part.centroid;
  std::vector<cv::Point2f> around;  // the centroid: floats would be too coarse for northings
  for (const cv::Point2d& p : part.points) around.emplace_back(p - part.centroid);
  return part.centroid + cv::Point2d(cv::minAreaRect(around).center);
}

std::string text_of(const ingest::Tags& tags, const char* key, const std::string& otherwise) {
  const auto found = tags.find(key);
  return found == tags.end() ? otherwise : found->second;
}

bool inside(const ingest::GridBounds& b, const cv::Point2d& p) {
  return p.x >= b.west_m && p.x <= b.east_m && p.y >= b.south_m && p.y <= b.north_m;
}

template <typename Point>
std::vector<cv::Point2d> places_of(std::span<const Point> points) {
  std::vector<cv::Point2d> out;
  for (const Point& p : points) out.push_back(p.at);
  return out;
}

bool near_unsure(const cv::Point2d& p, std::span<const KnownPoint> known, double reach_m) {
  return std::any_of(known.begin(), known.end(), [&](const KnownPoint& k) {
    return !k.sure && std::hypot(k.at.x - p.x, k.at.y - p.y) <= std::max(reach_m, k.reach_m);
  });
}

std::vector<FoundPoint> surer_than(std::span<const FoundPoint> found, double confidence) {
  std::vector<FoundPoint> out;
  for (const FoundPoint& f : found)
    if (f.confidence >= confidence) out.push_back(f);
  return out;
}

PointReport::Row row_of(const PointMatch& m, double reach_m, double confidence) {
  return {reach_m, confidence, m.sure, m.sure_found, m.found(), m.found_right()};
}

double share(size_t part, size_t whole) { return whole > 0 ? double(part) / double(whole) : 0; }

std::string text_of(const PointReport::Row& r) {
  return fmt::format("recall {:.3f} ({} of {}), precision {:.3f} ({} of {})\n", share(r.sure_found, r.sure),
                     r.sure_found, r.sure, share(r.right, r.found), r.right, r.found);
}

nlohmann::ordered_json json_of(const std::vector<PointReport::Row>& rows) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const PointReport::Row& r : rows)
    out.push_back({{"distance_m", r.reach_m},
                   {"confidence", r.confidence},
                   {"recall", share(r.sure_found, r.sure)},
                   {"precision", share(r.right, r.found)},
                   {"known", r.sure},
                   {"known_found", r.sure_found},
                   {"found", r.found},
                   {"found_right", r.right}});
  return out;
}

}  // namespace

std::vector<KnownPoint> read_known_points(const std::string& path, const std::string& kind, bool any,
                                          const tiles::Zone& zone, const ingest::GridBounds& bounds) {
  std::vector<KnownPoint> out;
  size_t number = 0;
  ingest::read_vectors(path, "", zone, bounds, [&](const ingest::VectorFeature& feature) {
    ++number;
    if (text_of(feature.tags, "kind", any ? kind : "") != kind) return;
    const std::string sure = text_of(feature.tags, "sure", "1"), length = text_of(feature.tags, "length_m", "0"),
                      width = text_of(feature.tags, "width_m", "0");
    for (const ingest::VectorPart& part : feature.parts)
      out.push_back({middle_of(part), sure != "0" && sure != "false",
                     std::max(std::atof(length.c_str()), std::atof(width.c_str())) / 2,
                     text_of(feature.tags, "id", std::to_string(number))});
  });
  return out;
}

ingest::GridBounds read_extent(const std::string& path, const tiles::Zone& zone, const ingest::GridBounds& bounds) {
  ingest::GridBounds out;
  ingest::read_vectors(path, "", zone, bounds, [&](const ingest::VectorFeature& feature) {
    for (const ingest::VectorPart& part : feature.parts)
      for (const cv::Point2d& p : part.points) out.extend({p.x, p.y, p.x, p.y});
  });
  return out;
}

size_t PointMatch::found() const {
  return size_t(std::count_if(right.begin(), right.end(), [](const auto& r) { return r.has_value(); }));
}

size_t PointMatch::found_right() const {
  return size_t(std::count_if(right.begin(), right.end(), [](const auto& r) { return r.value_or(false); }));
}

PointMatch match_points(std::span<const FoundPoint> found, std::span<const KnownPoint> known,
                        const ingest::GridBounds& extent, double reach_m) {
  PointMatch out;
  out.distance_m.assign(known.size(), std::numeric_limits<double>::quiet_NaN());
  for (const FoundPoint& f : found)
    out.right.push_back(inside(extent, f.at) && !near_unsure(f.at, known, reach_m) ? std::optional<bool>(false)
                                                                                   : std::nullopt);
  for (const Pair& p : nearest_pairs(places_of(found), places_of(known), reach_m)) {
    const size_t k = p.b;
    out.distance_m[k] = p.distance_m;
    out.right[p.a] = known[k].sure ? std::optional<bool>(true) : std::nullopt;
    out.sure_found += known[k].sure;
  }
  out.sure = size_t(std::count_if(known.begin(), known.end(), [](const KnownPoint& k) { return k.sure; }));
  return out;
}

Reliability reliability_of(std::span<const FoundPoint> found, const PointMatch& match) {
  Reliability out;
  out.steps.resize(kSteps);
  for (size_t i = 0; i < found.size(); ++i) {
    if (!match.right[i]) continue;
    Reliability::Step& step = out.steps[size_t(std::clamp(int(found[i].confidence * kSteps), 0, kSteps - 1))];
    ++step.count;
    step.right += *match.right[i];
    step.confidence += found[i].confidence;
  }
  for (Reliability::Step& s : out.steps) s.confidence = s.count > 0 ? s.confidence / double(s.count) : 0;
  return out;
}

PointReport report_points(std::span<const FoundPoint> found, std::span<const KnownPoint> known,
                          const ingest::GridBounds& extent, double reach_m, double confidence) {
  PointReport out;
  const std::vector<FoundPoint> sure = surer_than(found, confidence);
  for (const double d : kDistances_m)
    out.by_distance.push_back(row_of(match_points(sure, known, extent, d), d, confidence));
  for (const double c : kConfidences)
    out.by_confidence.push_back(row_of(match_points(surer_than(found, c), known, extent, reach_m), reach_m, c));
  out.reliability = reliability_of(found, match_points(found, known, extent, reach_m));
  return out;
}

std::string to_text(const PointReport& report) {
  std::string out;
  for (const PointReport::Row& r : report.by_distance)
    out += fmt::format("within {:4g} m (confidence {:.2g}): ", r.reach_m, r.confidence) + text_of(r);
  for (const PointReport::Row& r : report.by_confidence)
    out += fmt::format("confidence {:.1f} (within {:g} m): ", r.confidence, r.reach_m) + text_of(r);
  for (const Reliability::Step& s : report.reliability.steps)
    if (s.count > 0)
      out += fmt::format("said {:.2f}: right {:.2f} ({} of {})\n", s.confidence, share(s.right, s.count), s.right,
                         s.count);
  return out;
}

nlohmann::ordered_json to_json(const PointReport& report) {
  nlohmann::ordered_json steps = nlohmann::ordered_json::array();
  for (const Reliability::Step& s : report.reliability.steps)
    steps.push_back({{"confidence", s.confidence}, {"count", s.count}, {"right", s.right}});
  return {{"by_distance", json_of(report.by_distance)},
          {"by_confidence", json_of(report.by_confidence)},
          {"reliability", steps}};
}

size_t found_again(std::span<const FoundPoint> a, std::span<const FoundPoint> b, double reach_m) {
  return nearest_pairs(places_of(a), places_of(b), reach_m).size();
}

}  // namespace landfix::eval

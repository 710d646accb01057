// Fits the weights by which builder/landmarks/broad_regions.cc judges fields, on drawn worlds, or judges what it finds
// in others:
//   landfix_fit_fields fit    prints weights from worlds 701 to 708 for that file
//   landfix_fit_fields judge  precision and recall in worlds 501, 502 and 511, which nothing was fitted on
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "builder/landmarks/broad_regions.h"
#include "tools/synth/world.h"

namespace landfix {
namespace {

using landmarks::BroadRegion;
using synth::Season;
using tiles::LandmarkClass;

constexpr int kSide_m = 1500;
constexpr double kLike = 0.5, kNear_m = 10;  // intersection over union and distance of centres of what is right
using Weights = Eigen::Matrix<double, int(landmarks::kBroadNumbers), 1>;

synth::WorldOptions world(uint64_t seed, Season season, int year, double azimuth, double elevation,
                          bool varied = false) {
  synth::WorldOptions o;
  o.seed = seed, o.season = season, o.year = year, o.size_m = kSide_m;
  o.sun_azimuth_deg = azimuth, o.sun_elevation_deg = elevation;
  o.varied_roads = varied;
  return o;
}

std::vector<synth::WorldOptions> worlds_to_fit() {
  std::vector<synth::WorldOptions> out = {
      world(701, Season::kSummer, 2020, 150, 45),       world(702, Season::kAutumn, 2022, 235, 25),
      world(703, Season::kWinter, 2021, 180, 20),       world(704, Season::kWinter, 2020, 170, 18),
      world(705, Season::kSpring, 2018, 120, 35, true), world(706, Season::kSummer, 2019, 210, 55, true),
      world(707, Season::kAutumn, 2017, 110, 25),       world(708, Season::kSpring, 2023, 250, 40)};
  out[3].snow = true;
  out[4].relief_m = 80;
  return out;
}

std::vector<synth::WorldOptions> worlds_to_judge() {
  return {world(501, Season::kSummer, 2020, 150, 45), world(501, Season::kWinter, 2018, 170, 22),
          world(502, Season::kAutumn, 2021, 220, 30), world(511, Season::kSummer, 2020, 150, 45, true),
          world(511, Season::kWinter, 2018, 170, 22, true)};
}

// A mask of pixels of 4 m at its place.
struct Shape {
  cv::Rect box;
  cv::Mat mask;
  cv::Point2d centre;  // metres from the north-western corner, y south
  bool is_broad = false;
};

Shape shape_of(const std::vector<cv::Point2f>& outline_m) {
  constexpr int kShift = 4;
  Shape out;
  const cv::Moments m = cv::moments(outline_m);
  out.centre = {m.m10 / m.m00, m.m01 / m.m00};
  const cv::RotatedRect rect = cv::minAreaRect(outline_m);
  const cv::Rect2f around = cv::boundingRect(outline_m);
  const bool is_whole = around.x > 4 && around.y > 4 && around.br().x < kSide_m - 4 && around.br().y < kSide_m - 4;
  out.is_broad = is_whole && std::max(rect.size.width, rect.size.height) >= float(landmarks::kBroadLeast_m) &&
                 std::min(rect.size.width, rect.size.height) >= 40;
  out.box = {int(around.x) / 4 - 1, int(around.y) / 4 - 1, int(around.width) / 4 + 4, int(around.height) / 4 + 4};
  out.mask = cv::Mat::zeros(out.box.size(), CV_8U);
  std::vector<cv::Point> polygon;
  for (const cv::Point2f& p : outline_m)
    polygon.emplace_back(cvRound((double(p.x) / 4 - out.box.x - 0.5) * (1 << kShift)),
                         cvRound((double(p.y) / 4 - out.box.y - 0.5) * (1 << kShift)));
  cv::fillPoly(out.mask, std::vector<std::vector<cv::Point>>{polygon}, 1, cv::LINE_8, kShift);
  return out;
}

Shape shape_of(const BroadRegion& b) {
  const cv::Moments m = cv::moments(b.region.mask, true);
  const cv::Point2d corner = b.region.box.tl();
  return {b.region.box, b.region.mask, (cv::Point2d(m.m10 / m.m00 + 0.5, m.m01 / m.m00 + 0.5) + corner) * 4, true};
}

double likeness(const Shape& a, const Shape& b) {
  const cv::Rect both = a.box & b.box;
  if (both.empty()) return 0;
  const int common = cv::countNonZero(a.mask(both - a.box.tl()) & b.mask(both - b.box.tl()));
  return common / double(cv::countNonZero(a.mask) + cv::countNonZero(b.mask) - common);
}

// What is right of `found`: whether it is like a truth, how far their centres are apart.
struct Match {
  const Shape* truth = nullptr;
  double away_m = 0;
  bool is_right() const { return truth && away_m <= kNear_m; }
};

Match match(const Shape& found, const std::vector<Shape>& truths) {
  for (const Shape& t : truths)
    if (likeness(found, t) >= kLike) return {&t, cv::norm(found.centre - t.centre)};  // no two can be
  return {};
}

struct Drawn {
  cv::Mat view;
  std::vector<Shape> fields;
};

Drawn draw(const synth::WorldOptions& options) {
  const synth::World drawn(options);
  const double west_m = options.west_m, north_m = options.south_m + kSide_m;
  const features::GridImage image = drawn.ortho({west_m, north_m, kSide_m, kSide_m, landmarks::kLandmarkGsd_m});
  Drawn out;
  landmarks::find_landmarks(image, cv::Rect({}, image.pixels.size()), landmarks::default_object_model(), &out.view);
  for (const synth::Field& f : drawn.labels(drawn.extent()).fields) {
    std::vector<cv::Point2f> outline;
    for (const synth::Point& p : f.outline) outline.emplace_back(float(p.x - west_m), float(north_m - p.y));
    out.fields.push_back(shape_of(outline));
  }
  return out;
}

struct Example {
  Weights numbers;
  bool is_right = false;
  int first = 0, count = 0, world = 0;
};

Weights fitted(const std::vector<Example>& examples, const std::vector<size_t>& which, double ridge) {
  Weights w = Weights::Zero();
  for (int i = 0; i < 50; ++i) {
    Eigen::Matrix<double, w.RowsAtCompileTime, w.RowsAtCompileTime> curvature = ridge * decltype(curvature)::Identity();
    curvature(0, 0) = 1e-9;
    Weights slope = -ridge * w;
    slope(0) = 0;
    for (const size_t k : which) {
      const Example& e = examples[k];
      const double p = 1 / (1 + std::exp(-w.dot(e.numbers)));
      curvature += p * (1 - p) * e.numbers * e.numbers.transpose();
      slope += (double(e.is_right) - p) * e.numbers;
    }
    w += curvature.ldlt().solve(slope);
  }
  return w;
}

// Those that find_broad would choose.
std::vector<size_t> chosen(const std::vector<Example>& examples, const Weights& w, double least) {
  std::vector<size_t> order(examples.size()), out;
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, std::greater(), [&](size_t i) { return w.dot(examples[i].numbers); });
  for (const size_t i : order) {
    const Example& e = examples[i];
    if (w.dot(e.numbers) < std::log(least / (1 - least))) break;
    if (std::ranges::none_of(out, [&](size_t k) {
          const Example& o = examples[k];
          return o.world == e.world && o.first < e.first + e.count && e.first < o.first + o.count;
        }))
      out.push_back(i);
  }
  return out;
}

void fit() {
  std::vector<Example> examples;
  int world_index = 0;
  for (const synth::WorldOptions& options : worlds_to_fit()) {
    const Drawn drawn = draw(options);
    for (const BroadRegion& b : landmarks::broad_candidates(drawn.view, LandmarkClass::kField))
      examples.push_back(
          {Weights(b.numbers.data()), match(shape_of(b), drawn.fields).is_right(), b.first, b.count, world_index});
    ++world_index;
  }
  std::vector<size_t> all(examples.size());
  for (size_t i = 0; i < all.size(); ++i) all[i] = i;
  Weights w = fitted(examples, all, 1);
  // Regions are chosen by their probability: calibrated anew (Platt) on those alone.
  for (int i = 0; i < 3; ++i) {
    std::vector<Example> scores = examples;
    for (Example& e : scores) {
      const double score = w.dot(e.numbers);
      e.numbers.setZero();
      e.numbers(0) = 1, e.numbers(1) = score;
    }
    const Weights line = fitted(scores, chosen(examples, w, 0.05), 0.01);
    w *= line(1);
    w(0) += line(0);
  }
  fmt::print("{} regions, weights {{{:.4f}}}\n", examples.size(), fmt::join(w.data(), w.data() + w.size(), ", "));
}

void judge() {
  for (const synth::WorldOptions& options : worlds_to_judge()) {
    const Drawn drawn = draw(options);
    const std::vector<BroadRegion> found = landmarks::chosen_regions(drawn.view, LandmarkClass::kField);
    const auto broad = std::ranges::count_if(drawn.fields, &Shape::is_broad);
    for (const double least : {landmarks::kLeastConfidence, 0.5, 0.7}) {
      size_t count = 0, like = 0, right = 0, hit = 0;
      std::vector<double> away_m;
      for (const BroadRegion& b : found) {
        if (b.confidence < least) continue;
        const Match m = match(shape_of(b), drawn.fields);
        ++count, like += m.truth != nullptr, right += m.is_right();
        hit += m.truth && m.truth->is_broad;
        if (m.truth) away_m.push_back(m.away_m);
      }
      std::ranges::sort(away_m);
      const auto share = [&](size_t of) { return double(of) / double(std::max(count, size_t(1))); };
      const auto quantile = [&](double q) {
        return away_m.empty() ? 0 : away_m[size_t(q * double(away_m.size() - 1))];
      };
      fmt::print(
          "{} {}: confidence {}: {} found, like a field {:.3f}, right {:.3f}; of {} broad fields {:.3f}; centre "
          "median {:.1f} m, 90 % {:.1f} m\n",
          options.seed, name_of(options.season), least, count, share(like), share(right), broad,
          double(hit) / double(std::max(broad, std::ptrdiff_t(1))), quantile(0.5), quantile(0.9));
    }
  }
}

}  // namespace
}  // namespace landfix

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "fit") == 0) return landfix::fit(), 0;
  if (argc == 2 && std::strcmp(argv[1], "judge") == 0) return landfix::judge(), 0;
  fmt::print(stderr, "usage: landfix_fit_fields fit|judge\n");
  return 2;
}

#include "builder/landmarks/known.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>
#include <tuple>

#include "builder/error.h"
#include "builder/ingest/vectors.h"
#include "builder/landmarks/orientation.h"
#include "builder/landmarks/preference.h"
#include "builder/landmarks/road_network.h"

namespace landfix::landmarks {
namespace {

using ingest::Shape;
using tiles::Landmark;

constexpr std::array<double, tiles::kLandmarkClasses> kPointSize_m = {10, 100, 6, 20, 20};  ///< by class

/// The smallest rectangle around a polygon.
Landmark enclosing(const ingest::VectorPart& polygon, Kind kind) {
  const cv::Point2d origin = polygon.points.front();  // floats would be too coarse for northings
  std::vector<cv::Point2f> around;
  for (const cv::Point2d& p : polygon.points) around.emplace_back(p - origin);
  const cv::RotatedRect rectangle = cv::minAreaRect(around);
  std::array<cv::Point2f, 4> corner;
  rectangle.points(corner.data());
  cv::Point2f length = corner[1] - corner[0], width = corner[2] - corner[1];
  if (std::hypot(length.x, length.y) < std::hypot(width.x, width.y)) std::swap(length, width);
  Landmark m;
  m.length_m = std::hypot(length.x, length.y);
  m.width_m = std::hypot(width.x, width.y);
  const bool is_building = kind == Kind::kBuilding;
  const cv::Point2d centre = is_building ? origin + cv::Point2d(rectangle.center) : polygon.centroid;
  m.east_m = centre.x;
  m.north_m = centre.y;
  if (is_building || m.length_m > kElongated * m.width_m) m.orientation_rad = orientation_of(length.x, length.y);
  return m;
}

Landmark around_point(const ingest::VectorPart& point, const ingest::Tags& tags, Kind kind) {
  Landmark m;
  m.east_m = point.centroid.x;
  m.north_m = point.centroid.y;
  m.length_m = m.width_m = kPointSize_m[size_t(kind)];
  if (const auto crown = metres_of(tags, "diameter_crown")) m.length_m = m.width_m = *crown;
  if (const auto radius = metres_of(tags, "radius_m")) m.length_m = m.width_m = 2 * *radius;
  if (const auto length = metres_of(tags, "length_m")) m.length_m = m.width_m = *length;
  if (const auto width = metres_of(tags, "width_m")) m.width_m = std::min(*width, m.length_m);
  return m;
}

/// Collects what the features of all inputs are, source by source.
class Reader {
 public:
  explicit Reader(const ingest::GridBounds& bounds) : bounds_(bounds) {}

  void read(const VectorInput& input, const tiles::Zone& zone) {
    ++source_;
    left_out_ = 0;
    found_.clear();
    seen_.clear();
    layers_.clear();
    if (input.kind) note(*input.kind);
    const ingest::VectorFile file = ingest::read_vectors(
        input.path, input.layer, zone, bounds_, [&](const ingest::VectorFeature& feature) { take(input, feature); });
    known_.sources.push_back(file.source);
    known_.warnings.insert(known_.warnings.end(), file.warnings.begin(), file.warnings.end());
    if (!file.is_openstreetmap) require_kinds(input);
    add_new(known_.landmarks, found_);
    if (left_out_ > 0)
      known_.warnings.push_back(fmt::format("{}: {} features are left out: their tags or shapes are those of no {}",
                                            input.path, left_out_,
                                            input.kind ? name_of(*input.kind) : "landmark or road"));
  }

  Known finish() {
    known_.roads = road_graph(std::move(lines_), bounds_);
    return std::move(known_);
  }

 private:
  void note(Kind kind) { (kind == Kind::kRoad ? known_.has_roads : known_.has_landmarks) = true; }

  void take(const VectorInput& input, const ingest::VectorFeature& feature) {
    bool& is_told = layers_[feature.layer];
    is_told = is_told || input.kind || has_known_tags(feature.tags) || kind_of_layer(feature.layer);
    bool is_left_out = false;
    for (const ingest::VectorPart& part : feature.parts) {
      const std::optional<Kind> kind = kind_of(input, feature, part.shape);
      if (kind) note(*kind);
      if (!kind || (*kind == Kind::kRoad) != (part.shape == Shape::kLine))
        is_left_out = true;
      else if (*kind == Kind::kRoad)
        add_road(part, feature.tags);
      else
        add_landmark(part.shape == Shape::kPoint ? around_point(part, feature.tags, *kind) : enclosing(part, *kind),
                     *kind);
    }
    left_out_ += is_left_out;
  }

  // Layers that nothing says the kind of are none of ours beside others of their file; alone they are a mistake.
  void require_kinds(const VectorInput& input) {
    const bool any_told = std::ranges::any_of(layers_, [](const auto& entry) { return entry.second; });
    for (const auto& [layer, is_told] : layers_) {
      if (is_told) continue;
      const std::string text = fmt::format(
          "{}, layer \"{}\": neither tags of OpenStreetMap nor the layer's name say what its features are. "
          "Say it: --vectors {}:{}=KIND, of {}",
          input.path, layer, input.path, layer, kKindNames);
      if (!any_told) throw Error(ExitCode::kBadInput, text);
      known_.warnings.push_back(text);
    }
  }

  void add_road(const ingest::VectorPart& part, const ingest::Tags& tags) {
    Centreline line{{}, road_width_m(tags), road_layer(tags), source_};
    for (const cv::Point2d& p : part.points) line.points.push_back({p.x, p.y});
    lines_.push_back(std::move(line));
  }

  void add_landmark(Landmark m, Kind kind) {
    m.cls = tiles::LandmarkClass(uint8_t(kind));
    m.confidence = 1;
    m.epochs_seen = 0;
    m.source = source_;
    const bool inside = m.east_m >= bounds_.west_m && m.east_m < bounds_.east_m && m.north_m >= bounds_.south_m &&
                        m.north_m < bounds_.north_m;
    const auto at = tiles::lattice_point(m.east_m, m.north_m);
    if (inside && at &&
        seen_.emplace(kind, at->east, at->north, tiles::size_level(m.length_m), tiles::size_level(m.width_m)).second)
      found_.push_back(m);
  }

  const ingest::GridBounds bounds_;
  Known known_;
  std::vector<Centreline> lines_;
  uint16_t source_ = 0;
  // Of the input that is being read.
  std::vector<Landmark> found_;
  std::map<std::string, bool> layers_;  ///< whether anything says what their features are
  std::set<std::tuple<Kind, int64_t, int64_t, uint32_t, uint32_t>> seen_;
  uint64_t left_out_ = 0;  ///< features, or parts of them
};

}  // namespace

VectorInput parse_input(const std::string& text) {
  VectorInput input{text, {}, {}};
  if (ingest::file_exists(text)) return input;
  if (const size_t at = text.rfind('='); at != std::string::npos) {
    input.kind = kind_named(text.substr(at + 1));
    if (!input.kind)
      throw Error(ExitCode::kUsage, fmt::format("--vectors {}: \"{}\" is no kind; expected one of {}", text,
                                                text.substr(at + 1), kKindNames));
    input.path.resize(at);
  }
  if (ingest::file_exists(input.path)) return input;
  if (const size_t at = input.path.rfind(':'); at != std::string::npos) {
    input.layer = input.path.substr(at + 1);
    input.path.resize(at);
  }
  return input;
}

std::optional<Kind> kind_of(const VectorInput& input, const ingest::VectorFeature& feature, ingest::Shape shape) {
  if (input.kind) return input.kind;
  if (has_known_tags(feature.tags)) return kind_of_tags(feature.tags, shape);
  return kind_of_layer(feature.layer);
}

Known read_known(const std::vector<VectorInput>& inputs, const tiles::Zone& zone, const ingest::GridBounds& bounds) {
  Reader reader(bounds);
  for (const VectorInput& input : inputs) reader.read(input, zone);
  return reader.finish();
}

std::string text_of(const std::vector<Landmark>& landmarks) {
  static constexpr std::array<const char*, tiles::kLandmarkClasses> kPlurals = {"buildings", "fields", "trees",
                                                                                "water areas", "paved areas"};
  std::vector<std::string> counts;
  for (uint32_t c = 0; c < tiles::kLandmarkClasses; ++c)
    if (const auto n = std::ranges::count(landmarks, tiles::LandmarkClass(c), &Landmark::cls); n > 0)
      counts.push_back(fmt::format("{} {}", n, kPlurals[c]));
  return counts.empty() ? "nothing" : fmt::format("{}", fmt::join(counts, ", "));
}

std::string text_of(const std::vector<tiles::RoadGraph>& roads) {
  double length_m = 0;
  ptrdiff_t intersections = 0;
  for (const tiles::RoadGraph& graph : roads) {
    for (const tiles::RoadEdge& edge : graph.edges) length_m += tiles::length_of(graph, edge);
    intersections += std::ranges::count(graph.nodes, tiles::RoadNodeKind::kIntersection, &tiles::RoadNode::kind);
  }
  return fmt::format("{:.1f} km, {} intersections", length_m / 1000, intersections);
}

}  // namespace landfix::landmarks

#include "builder/landmarks/fusion.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "builder/landmarks/preference.h"
#include "builder/point_grid.h"

namespace landfix::landmarks {
namespace {

using tiles::Landmark;

constexpr double kSameShare = 0.25, kSameSize = 2, kGridSide_m = 32;
constexpr double kLongest_m = 724;  // a tile keeps none longer

double reach_of(const Landmark& m) { return std::max(kSamePlace_m, kSameShare * m.length_m); }

cv::Point2d place_of(const Landmark& m) { return {m.east_m, m.north_m}; }

bool is_of_like_size(const Landmark& a, const Landmark& b) {
  const auto within = [](double x, double y) { return x <= kSameSize * y && y <= kSameSize * x; };
  return within(a.length_m, b.length_m) && within(a.width_m, b.width_m);
}

auto order_of(const Sighting& s) {
  const Landmark& m = s.landmark;
  return std::tuple(s.epoch, -m.confidence, m.north_m, m.east_m, m.cls, m.length_m, m.width_m);
}

// The views of one object; the first is that of the newest date.
struct Object {
  std::vector<const Sighting*> views;
};

Landmark fused(const Object& object) {
  const auto confidence = [](const Sighting* s) { return s->landmark.confidence; };
  Landmark out = (*std::ranges::max_element(object.views, {}, confidence))->landmark;
  double weight = 0, east = 0, north = 0, chances = 1, newest = 0;
  const Landmark& origin = object.views.front()->landmark;  // sums of metres near it keep their digits
  for (const Sighting* s : object.views) {
    const Landmark& m = s->landmark;
    weight += m.confidence;
    east += m.confidence * (m.east_m - origin.east_m);
    north += m.confidence * (m.north_m - origin.north_m);
    chances = std::max(chances, double(s->chances));
    if (s->is_newest && m.cls != tiles::LandmarkClass::kField) newest = m.confidence;
  }
  if (weight > 0) out.east_m = origin.east_m + east / weight, out.north_m = origin.north_m + north / weight;
  out.confidence = std::max(newest, weight / std::max(chances, double(object.views.size())));
  out.epochs_seen = uint16_t(object.views.size());
  return out;
}

}  // namespace

std::vector<Landmark> fuse_epochs(std::vector<Sighting> sightings) {
  std::ranges::sort(sightings, {}, order_of);
  std::vector<Object> objects;
  PointGrid grid(kGridSide_m);  // of the objects' first views
  for (const Sighting& s : sightings) {
    const cv::Point2d at = place_of(s.landmark);
    Object* nearest = nullptr;
    double least_m = reach_of(s.landmark);
    grid.within(at, least_m, [&](const cv::Point2d& place, int id) {
      Object& object = objects[size_t(id)];
      const Landmark& first = object.views.front()->landmark;
      const double away_m = cv::norm(place - at);
      const bool is_free = object.views.back()->epoch != s.epoch;  // sightings come date by date
      if (is_free && first.cls == s.landmark.cls && is_of_like_size(first, s.landmark) && away_m <= least_m) {
        nearest = &object;
        least_m = away_m;
      }
    });
    if (!nearest) {
      grid.add(at, int(objects.size()));
      nearest = &objects.emplace_back();
    }
    nearest->views.push_back(&s);
  }
  std::vector<Landmark> out;
  for (const Object& object : objects)
    if (const Landmark m = fused(object); m.confidence >= kLeastConfidence) out.push_back(m);
  std::ranges::sort(out, {}, [](const Landmark& m) { return std::tuple(m.north_m, m.east_m, m.cls, m.length_m); });
  return out;
}

std::vector<Sighting> without_covered(const std::vector<Sighting>& sightings) {
  std::vector<Sighting> out;
  PointGrid grid(kLongest_m);
  for (const Sighting& s : sightings) {
    bool is_covered = false;
    grid.within(place_of(s.landmark), kLongest_m, [&](const cv::Point2d&, int id) {
      const Sighting& other = out[size_t(id)];
      is_covered = is_covered || (other.epoch == s.epoch && other.landmark.cls == s.landmark.cls &&
                                  covers(other.landmark, s.landmark));
    });
    if (is_covered) continue;
    grid.add(place_of(s.landmark), int(out.size()));
    out.push_back(s);
  }
  return out;
}

void drop_on_roads(std::vector<Landmark>& landmarks, const tiles::RoadGraph& roads) {
  constexpr double kStep_m = 1, kLikely = 0.5, kMiddle = 1.0 / 3, kWidest_m = 15;
  PointGrid grid(kGridSide_m);
  std::vector<double> reach_m;  // of every point of the grid
  for (const tiles::RoadEdge& edge : roads.edges) {
    if (edge.confidence < kLikely) continue;
    std::vector<cv::Point2d> line;
    for (const tiles::RoadPoint& p : tiles::line_of(roads, edge)) line.emplace_back(p.east_m, p.north_m);
    for (size_t i = 1; i < line.size(); ++i) {
      const cv::Point2d leg = line[i] - line[i - 1];
      const int steps = std::max(1, int(std::ceil(cv::norm(leg) / kStep_m)));
      for (int k = 0; k < steps; ++k) {
        grid.add(line[i - 1] + leg * (double(k) / steps), int(reach_m.size()));
        reach_m.push_back(kMiddle * std::min(edge.width_m, kWidest_m));
      }
    }
  }
  std::erase_if(landmarks, [&](const Landmark& m) {
    if (m.cls != tiles::LandmarkClass::kBuilding) return false;
    bool is_on_road = false;
    grid.within(place_of(m), kMiddle * kWidest_m, [&](const cv::Point2d& p, int id) {
      is_on_road = is_on_road || cv::norm(p - place_of(m)) < reach_m[size_t(id)];
    });
    return is_on_road;
  });
}

}  // namespace landfix::landmarks

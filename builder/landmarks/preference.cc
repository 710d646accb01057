#include "builder/landmarks/preference.h"

#include <algorithm>
#include <boost/geometry.hpp>
#include <cmath>
#include <iterator>
#include <utility>

namespace landfix::landmarks {
namespace {

namespace bg = boost::geometry;
using tiles::Landmark;
using Place = bg::model::point<double, 2, bg::cs::cartesian>;
using Box = bg::model::box<Place>;
using Entry = std::pair<Box, size_t>;

Place place_of(const Landmark& m) { return {m.east_m, m.north_m}; }

Box around(const Landmark& m, double least_m) {
  const double reach_m = std::max(least_m, 0.5 * std::hypot(m.length_m, m.width_m));
  return {{m.east_m - reach_m, m.north_m - reach_m}, {m.east_m + reach_m, m.north_m + reach_m}};
}

bool is_the_same(const Landmark& m, const Landmark& other, double reach_m) {
  const bool is_near = std::hypot(other.east_m - m.east_m, other.north_m - m.north_m) < reach_m;
  return m.cls == other.cls && (is_near || covers(m, other));
}

}  // namespace

bool covers(const Landmark& m, const Landmark& other) {
  const double east_m = other.east_m - m.east_m, north_m = other.north_m - m.north_m;
  const double direction = std::isnan(m.orientation_rad) ? 0 : m.orientation_rad;
  const double along_m = east_m * std::sin(direction) + north_m * std::cos(direction);
  const double across_m = east_m * std::cos(direction) - north_m * std::sin(direction);
  return 2 * std::abs(along_m) <= m.length_m && 2 * std::abs(across_m) <= m.width_m;
}

void add_new(std::vector<Landmark>& landmarks, std::span<const Landmark> more, double reach_m) {
  std::vector<Entry> entries;
  for (size_t i = 0; i < landmarks.size(); ++i) entries.emplace_back(around(landmarks[i], reach_m), i);
  const bg::index::rtree<Entry, bg::index::quadratic<16>> there(entries.begin(), entries.end());
  for (const Landmark& m : more) {
    const auto is_known = [&](const Entry& entry) { return is_the_same(landmarks[entry.second], m, reach_m); };
    if (there.qbegin(bg::index::intersects(place_of(m)) && bg::index::satisfies(is_known)) == there.qend())
      landmarks.push_back(m);
  }
}

}  // namespace landfix::landmarks

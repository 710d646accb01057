#include "tools/route/path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "builder/error.h"

namespace landfix::route {
namespace {

constexpr double kGroundCheckStepM = 25;
constexpr double kMostImages = 20'000;
constexpr double kHighestM = 20'000;  ///< nothing that takes such images flies higher
constexpr double kSlowestMps = 0.01, kFastestMps = 1000;

}  // namespace

Path::Path(std::string name, std::vector<Vertex> vertices, std::vector<Leg> legs, const Heights& heights)
    : name_(std::move(name)), vertices_(std::move(vertices)), legs_(std::move(legs)), heights_(heights) {
  for (const Vertex& v : vertices_) {
    if (!(v.speed_mps >= kSlowestMps && v.speed_mps <= kFastestMps))
      throw Error(ExitCode::kBadInput, fmt::format("{}: expected a speed from {:g} to {:g} m/s, found {:g} m/s; check "
                                                   "--speed or the mission's speeds",
                                                   name_, kSlowestMps, kFastestMps, v.speed_mps));
    if (!(v.level_m <= kHighestM))
      throw Error(ExitCode::kBadInput,
                  fmt::format("{}: expected a height of at most {:g} m, found {:g} m; check its unit, and what it is "
                              "counted from",
                              name_, kHighestM, v.level_m));
  }
  double distance_m = 0, time_s = 0;
  for (size_t i = 0; i < vertices_.size(); ++i) {
    if (i > 0) {
      const double length_m = (vertices_[i].place - vertices_[i - 1].place).norm();
      distance_m += length_m;
      time_s += vertices_[i - 1].hold_s + length_m / vertices_[i].speed_mps;
    }
    starts_m_.push_back(distance_m);
    arrivals_s_.push_back(time_s);
    if (i == 0) continue;
    Leg& leg = legs_.at(vertices_[i].leg);
    if (i == 1 || vertices_[i].leg != vertices_[i - 1].leg) {
      leg.start_m = starts_m_[i - 1];
      leg.start_s = arrivals_s_[i - 1] + vertices_[i - 1].hold_s;
    }
    leg.end_m = distance_m;
    leg.end_s = time_s + vertices_[i].hold_s;
  }
  if (!(distance_m > 0)) {
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: expected at least two different places on the route, found {}; nothing is flown",
                            name_, vertices_.size()));
  }
  for (const Vertex& v : vertices_) {
    const std::optional<double> ground = heights_.ground_m(v.place.x(), v.place.y());
    if (!ground) continue;
    usual_ground_m_ = *ground;
    break;
  }
  refuse_ground();
}

std::optional<double> Path::height_of(const Vertex& v) const {
  if (!v.above_ground) return v.level_m;
  return heights_.ground_m(v.place.x(), v.place.y()).value_or(usual_ground_m_) + v.level_m;
}

Station Path::at(double distance_m) const {
  const double on_path = std::clamp(distance_m, 0.0, length_m());
  const auto after = std::upper_bound(starts_m_.begin(), starts_m_.end(), on_path);
  const size_t i = std::clamp<size_t>(size_t(after - starts_m_.begin()), 1, vertices_.size() - 1);
  const Vertex &a = vertices_[i - 1], &b = vertices_[i];
  const double length_m = starts_m_[i] - starts_m_[i - 1];
  const double share = length_m > 0 ? (on_path - starts_m_[i - 1]) / length_m : 1;
  const Eigen::Vector2d place = a.place + share * (b.place - a.place);
  Station s;
  s.distance_m = on_path;
  s.time_s = arrivals_s_[i] - (1 - share) * length_m / b.speed_mps;
  s.east_m = place.x();
  s.north_m = place.y();
  s.speed_mps = b.speed_mps;
  s.leg = b.leg;
  const std::optional<double> ground = heights_.ground_m(place.x(), place.y());
  s.known_ground = ground.has_value();
  const double ground_m = ground.value_or(usual_ground_m_);
  if (a.above_ground && b.above_ground) {
    s.agl_m = a.level_m + share * (b.level_m - a.level_m);
    s.height_m = ground_m + s.agl_m;
  } else {
    s.height_m = *height_of(a) + share * (*height_of(b) - *height_of(a));
    s.agl_m = s.height_m - ground_m;
  }
  if (a.may_touch || b.may_touch) s.agl_m = std::max(s.agl_m, 0.0);
  return s;
}

void Path::refuse_ground() const {
  const double step_m = std::max(kGroundCheckStepM, length_m() / 1e5);
  for (double d = 0; d < length_m() + step_m; d += step_m) {
    const Station s = at(d);
    if (!s.known_ground || s.agl_m >= 0) continue;
    throw Error(
        ExitCode::kBadInput,
        fmt::format("{}: {}: expected a route above the ground, found it {:.0f} m below ({:.0f} m after the start, "
                    "at {:.0f} m above the ellipsoid); fly higher, or check what the altitudes are counted from",
                    name_, legs_[s.leg].name, -s.agl_m, s.distance_m, s.height_m));
  }
}

Path path_through(const std::string& name, const std::vector<Eigen::Vector2d>& points, double level_m,
                  bool above_ground, double speed_mps, const Heights& heights) {
  std::vector<Vertex> vertices;
  std::vector<Leg> legs;
  for (size_t i = 0; i < points.size(); ++i) {
    Vertex v;
    v.place = points[i];
    v.level_m = level_m;
    v.above_ground = above_ground;
    v.speed_mps = speed_mps;
    v.leg = i == 0 ? 0 : i - 1;
    vertices.push_back(v);
    if (i == 0) continue;
    Leg leg;
    leg.name = fmt::format("leg {}", i);
    leg.item = i;
    legs.push_back(leg);
  }
  return Path(name, std::move(vertices), std::move(legs), heights);
}

const View& Image::view(double filter_sigma_m) const {
  const double search = search_m(*vehicle_, filter_sigma_m, station_.agl_m);
  const auto found = views_.find(search);
  if (found != views_.end()) return found->second;
  return views_.emplace(search, view_at(*map_, *vehicle_, station_.east_m, station_.north_m, station_.agl_m, search))
      .first->second;
}

std::vector<Image> images_along(const Path& path, const NavigabilityMap& map, const Vehicle& vehicle, double least_m) {
  least_m = std::max(least_m, path.length_m() / kMostImages);
  std::vector<Image> images;
  bool known = false;
  for (double d = 0; d < path.length_m();) {
    // The speed is that of the leg which the step begins on.
    const double step_m = std::max(vehicle.image_spacing_m(path.at(d + 1e-6).speed_mps), least_m);
    const double next = std::min(d + step_m, path.length_m());
    images.emplace_back(path.at(next), next - d, map, vehicle);
    known = known || !(images.back().view(0).reasons & (kOffMap | kNoImage));
    d = next;
  }
  if (!known) {
    const Extent e = map.extent();
    const Station s = path.at(0);
    throw Error(
        ExitCode::kNoData,
        fmt::format(
            "{}: expected a route over ground that the map knows (within east {:.0f} to {:.0f}, north {:.0f} to "
            "{:.0f}), found none of it there (it starts at east {:.0f}, north {:.0f}); choose the map of this "
            "area",
            path.name(), e.west_m, e.east_m, e.south_m, e.north_m, s.east_m, s.north_m));
  }
  return images;
}

}  // namespace landfix::route

// From a mission's waypoints to the vertices of a path.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "builder/error.h"
#include "tools/route/path.h"

namespace landfix::route {
namespace {

using mission::Action;
using mission::AltitudeReference;

constexpr double kUsualSpeedMps = 15;
constexpr int kCircleSides = 24;
constexpr double kMostCircles = 100;  ///< of one waypoint: more of the same circle say nothing new

class Builder {
 public:
  Builder(const mission::Mission& mission, const tiles::Zone& zone, const Heights& heights, const PathOptions& options)
      : mission_(mission), zone_(zone), heights_(heights), options_(options) {
    speed_mps_ =
        options.speed_mps.value_or(mission.cruise_speed_mps.value_or(mission.hover_speed_mps.value_or(kUsualSpeedMps)));
  }

  Path path() {
    start_at_home();
    for (const size_t index : mission::flown(mission_).waypoints) add(mission_.waypoints[index]);
    return Path(mission_.file, std::move(vertices_), std::move(legs_), heights_);
  }

 private:
  [[noreturn]] void refuse(ExitCode code, const std::string& text) const {
    throw Error(code, fmt::format("{}: {}", mission_.file, text));
  }

  /// Ground stations number items; lines have points alone.
  std::string name_of(const mission::Waypoint& w) const {
    if (mission_.format != mission::Format::kPlan && mission_.format != mission::Format::kWaypoints)
      return fmt::format("point {}", &w - mission_.waypoints.data() + 1);
    return w.part > 0 ? fmt::format("item {}, point {}", w.item, w.part) : fmt::format("item {}", w.item);
  }

  Eigen::Vector2d grid(const mission::Position& p, const std::string& name) const {
    constexpr double kRadians = M_PI / 180;
    const auto place = tiles::grid_from_geodetic(zone_, {p.latitude_deg * kRadians, p.longitude_deg * kRadians});
    if (!place) {
      refuse(ExitCode::kNoData,
             fmt::format("{}: expected a place in reach of the map's zone {}, found latitude {:.6f}, "
                         "longitude {:.6f}; choose the map of this area",
                         name, zone_.number, p.latitude_deg, p.longitude_deg));
    }
    return {place->east_m, place->north_m};
  }

  double needed(const Heights::Function& function, const Eigen::Vector2d& place, const char* what,
                const std::string& name) const {
    const std::optional<double> height = function(place.x(), place.y());
    if (!height) {
      refuse(ExitCode::kNoData,
             fmt::format("{}: its altitude needs {} there, which is not known; use a map that covers "
                         "it, or give altitudes above ground",
                         name, what));
    }
    return *height;
  }

  /// Height of home above the ellipsoid. An altitude of home above sea level counts before that of the ground.
  double home_height(const std::string& name) const {
    if (!mission_.home)
      refuse(ExitCode::kBadInput, fmt::format("{}: expected a home for an altitude above home", name));
    const Eigen::Vector2d place = grid(mission_.home->position, "home");
    const mission::Altitude& altitude = mission_.home->altitude;
    if (altitude.reference == AltitudeReference::kEllipsoid) return altitude.m;
    if (altitude.reference == AltitudeReference::kSeaLevel)
      return altitude.m + needed(heights_.geoid_m, place, "the geoid", "home");
    return needed(heights_.ground_m, place, "the height of the ground", "home");
  }

  void set_level(const mission::Waypoint& w, const std::string& name, Vertex& v) const {
    const mission::Altitude& altitude = w.place.altitude;
    v.above_ground = false;
    if (options_.instead_agl_m) {
      v.level_m = *options_.instead_agl_m;
      v.above_ground = true;
      return;
    }
    switch (altitude.reference) {
      case AltitudeReference::kEllipsoid:
        v.level_m = altitude.m;
        return;
      case AltitudeReference::kSeaLevel:
        v.level_m = altitude.m + needed(heights_.geoid_m, v.place, "the geoid", name);
        return;
      case AltitudeReference::kHome:
        v.level_m = altitude.m + home_height(name);
        return;
      case AltitudeReference::kTerrain:
        v.level_m = altitude.m;
        v.above_ground = true;
        return;
      case AltitudeReference::kNone:
        break;
    }
    if (!options_.agl_m && vertices_.empty()) {
      refuse(ExitCode::kUsage, fmt::format("{}: the file gives no altitude; give the height above ground", name));
    }
    v.level_m = options_.agl_m ? *options_.agl_m : vertices_.back().level_m;
    v.above_ground = options_.agl_m || vertices_.back().above_ground;
  }

  /// A vehicle that takes off elsewhere than at home has its home first.
  void start_at_home() {
    const mission::Flight flight = mission::flown(mission_);
    if (flight.waypoints.empty() || !mission_.home) return;
    const mission::Waypoint& first = mission_.waypoints[flight.waypoints.front()];
    if (first.action != Action::kTakeoff || first.implied) return;
    Vertex v;
    v.place = grid(mission_.home->position, "home");
    set_level(first, name_of(first), v);
    v.may_touch = true;
    vertices_.push_back(v);
  }

  void add(const mission::Waypoint& w) {
    const std::string name = name_of(w);
    if (w.speed && !options_.speed_mps) speed_mps_ = w.speed->mps;
    Vertex v;
    v.place = grid(w.place.position, name);
    set_level(w, name, v);
    if (w.action == Action::kLand) {
      v.level_m = 0;
      v.above_ground = true;
    }
    v.may_touch = w.action == Action::kTakeoff || w.action == Action::kLand || w.action == Action::kReturn;
    v.speed_mps = speed_mps_;
    v.hold_s = std::isfinite(w.hold_s) ? w.hold_s : 0;
    if (vertices_.empty()) {
      vertices_.push_back(v);
    } else {
      legs_.push_back({name, w.item, w.part});
      v.leg = legs_.size() - 1;
      vertices_.push_back(v);
    }
    if (w.turns > 0) circle(w, name);
  }

  /// Circles about the waypoint, as a polygon: from the waypoint to its rim, and around.
  void circle(const mission::Waypoint& w, const std::string& name) {
    const Vertex centre = vertices_.back();
    const double radius_m = w.radius_m != 0 ? w.radius_m : options_.loiter_radius_m;
    legs_.push_back({name + ", circles", w.item, w.part});
    const int sides = int(std::ceil(std::min(w.turns, kMostCircles) * kCircleSides));
    Vertex v = centre;
    v.hold_s = 0;
    v.leg = legs_.size() - 1;
    for (int i = 0; i <= sides; ++i) {
      const double bearing = 2 * M_PI * i / kCircleSides * (radius_m < 0 ? -1 : 1);
      v.place = centre.place + std::abs(radius_m) * Eigen::Vector2d(std::sin(bearing), std::cos(bearing));
      vertices_.push_back(v);
    }
  }

  const mission::Mission& mission_;
  const tiles::Zone zone_;
  const Heights& heights_;
  const PathOptions& options_;
  double speed_mps_;
  std::vector<Vertex> vertices_;
  std::vector<Leg> legs_;
};

}  // namespace

Path path_of(const mission::Mission& mission, const tiles::Zone& zone, const Heights& heights,
             const PathOptions& options) {
  return Builder(mission, zone, heights, options).path();
}

}  // namespace landfix::route

// Where a route leads over the ground: a mission, or points on the grid, as straight legs with heights and speeds.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tiles/geodesy.h"
#include "tools/mission/mission.h"
#include "tools/route/error_model.h"

namespace landfix::route {

/// What turns altitudes into heights above ellipsoid and ground; nothing where not known.
struct Heights {
  using Function = std::function<std::optional<double>(double east_m, double north_m)>;
  Function ground_m;  ///< of the ground above the ellipsoid
  Function geoid_m;   ///< of the geoid above the ellipsoid
};

/// A place on a path.
struct Station {
  double distance_m = 0, time_s = 0;
  double east_m = 0, north_m = 0;
  double height_m = 0;  ///< above the ellipsoid
  double agl_m = 0;     ///< above ground; over unknown ground, above that of the path's nearest known vertex
  double speed_mps = 0;
  size_t leg = 0;
  bool known_ground = true;
};

/// A straight piece, or the circles flown at its end.
struct Leg {
  std::string name;  ///< "item 3"; of several points of an item "item 3, point 2"; of a file without items "point 2"
  size_t item = 0, part = 0;
  double start_m = 0, end_m = 0, start_s = 0, end_s = 0;
};

struct Vertex {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double level_m = 0;  ///< above ground, or above the ellipsoid
  bool above_ground = false;
  double speed_mps = 15;   ///< of the leg that leads here
  double hold_s = 0;       ///< spent here
  size_t leg = 0;          ///< that ends here
  bool may_touch = false;  ///< the leg that leads here, or starts here, may meet the ground: take-off and landing
};

/// Immutable. Turns are corners.
class Path {
 public:
  /// `name` stands for the path in messages. Throws Error (kBadInput) for fewer than two vertices or no length, for a
  /// speed outside of 0.01 to 1000 m/s, for a height above 20 km, and where the path leads below the ground;
  /// `heights.ground_m` must outlive the path.
  Path(std::string name, std::vector<Vertex> vertices, std::vector<Leg> legs, const Heights& heights);

  double length_m() const { return starts_m_.back(); }
  double duration_s() const { return arrivals_s_.back() + vertices_.back().hold_s; }
  Station at(double distance_m) const;
  const std::vector<Leg>& legs() const { return legs_; }
  const std::vector<Vertex>& vertices() const { return vertices_; }
  const std::string& name() const { return name_; }

 private:
  std::optional<double> height_of(const Vertex& vertex) const;
  void refuse_ground() const;

  std::string name_;
  std::vector<Vertex> vertices_;
  std::vector<Leg> legs_;
  Heights heights_;
  std::vector<double> starts_m_, arrivals_s_;  ///< distance and time of arrival of each vertex
  double usual_ground_m_ = 0;                  ///< where it is not known
};

struct PathOptions {
  std::optional<double> agl_m;          ///< where the file gives no altitude
  std::optional<double> instead_agl_m;  ///< of the whole route, whatever the file says
  std::optional<double> speed_mps;      ///< of the whole route, whatever the file says
  double loiter_radius_m = 50;          ///< of circles whose radius the file leaves to the vehicle
};

/// The path of a mission as it is flown (mission::flown). Airspeed is taken as ground speed. Where nothing commands a
/// speed it is the file's cruise speed, else its hover speed, else 15 m/s. Throws Error: kUsage where no altitude is
/// known, kBadInput where a height above sea level or home cannot be resolved, a place is out of the zone's reach, or
/// as Path does.
Path path_of(const mission::Mission& mission, const tiles::Zone& zone, const Heights& heights,
             const PathOptions& options = {});

/// A path through points (east, north) at one level.
Path path_through(const std::string& name, const std::vector<Eigen::Vector2d>& points, double level_m,
                  bool above_ground, double speed_mps, const Heights& heights);

/// An image taken on a path, with what it offers to filters of any uncertainty.
class Image {
 public:
  Image(const Station& station, double flown_m, const NavigabilityMap& map, const Vehicle& vehicle)
      : station_(station), flown_m_(flown_m), map_(&map), vehicle_(&vehicle) {}

  const Station& station() const { return station_; }
  double flown_m() const { return flown_m_; }  ///< since the image before

  /// For a filter of this standard deviation. Not for concurrent calls on one object.
  const View& view(double filter_sigma_m) const;

 private:
  Station station_;
  double flown_m_;
  const NavigabilityMap* map_;
  const Vehicle* vehicle_;
  mutable std::map<double, View> views_;
};

/// The images of a flight along a path, by distance, no nearer to each other than `least_m` and no more than 20 000.
/// The first is taken one spacing after the start. Both referred to must outlive the images. Throws Error (kNoData)
/// where the map knows nothing of any part of the path.
std::vector<Image> images_along(const Path& path, const NavigabilityMap& map, const Vehicle& vehicle,
                                double least_m = 0);

}  // namespace landfix::route

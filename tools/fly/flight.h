// A simulated flight: truth along a route, sensors, and the localizer that has to live on them.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "builder/terrain/scene.h"
#include "runtime/nav/localizer.h"
#include "tools/fly/route.h"
#include "tools/fly/sensors.h"

namespace landfix::fly {

struct FlightOptions {
  double speed_mps = 15;
  /// Above ground: the terrain below the track, smoothed over `terrain_smoothing_m` to both sides, so that the aircraft
  /// does not jump over houses.
  double agl_m = 60;
  double terrain_smoothing_m = 50;
  std::optional<double> altitude_m;    ///< constant height above the ellipsoid instead of `agl_m`
  double laps = 1;                     ///< of a closed route
  double sway_rad = 1.5 * M_PI / 180;  ///< amplitude of the smooth roll and pitch of the real aircraft
  bool bank = false;  ///< roll into turns as an aeroplane does; false: stabilised camera or multicopter
  double image_interval_s = 0.5;
  double odometry_interval_s = 0.1;  ///< rounded to a whole fraction of `image_interval_s`
  double gnss_until_s = 5;
  /// The filter is told the share of odometry's drift and the size of the heading's constant error, not their draw. It
  /// knows white noise alone, but a drift keeps its direction: the noise per step is what adds up to the stated share
  /// of the distance over this distance. It has to be as long as the filter needs to see a drift. Nothing: 0.7 times
  /// the height above ground (at which attitude noise makes fixes uncertain), at least 100 m.
  std::optional<double> drift_correlation_m;
  nav::Camera camera = nav::camera_from_field_of_view(640, 480, 60 * M_PI / 180);
  SensorOptions sensors;
  nav::LocalizerOptions localizer;
};

/// The same with a localizer that knows the size of its sensors' errors, not their draw.
FlightOptions with_known_errors(FlightOptions options);

/// What was true and what was believed at the time of one image, after the image was taken in.
struct Record {
  double time_s = 0, distance_m = 0;
  terrain::Pose truth;
  bool gnss = false;                                             ///< position from GNSS, no fix wanted
  double dead_reckoning_east_m = 0, dead_reckoning_north_m = 0;  ///< odometry alone since GNSS was cut
  nav::Estimate estimate;
  nav::Fix fix;  ///< meaningless while `gnss`
};

/// Receives the picture of each image with its index; for looking at.
using FrameSink = std::function<void(size_t index, const Record& record, const cv::Mat& picture)>;

/// Flies `route` once over `scene` with the noise of `seed`; the localizer sees the map alone. One record per image.
/// While GNSS is there, its positions restart the localizer. Throws Error: kNoData where the route leaves the scene or
/// the camera sees less than half a picture of it, kBadInput for options out of range.
std::vector<Record> fly(const terrain::Scene& scene, const nav::MapSource& map, const Route& route,
                        const FlightOptions& options, uint64_t seed, const FrameSink& frames = {});

}  // namespace landfix::fly

#include "tools/fly/scene_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "builder/error.h"
#include "builder/ingest/image_set.h"

namespace landfix::fly {
namespace {

/// Ground may fall this much more below the aircraft than the height above ground says.
constexpr double kReliefReserve = 1.3;
constexpr double kSteepestViewRad = 75 * M_PI / 180;

ingest::GridBounds route_bounds(const Route& route, double margin_m) {
  ingest::GridBounds bounds;
  for (double s = 0; s <= route.length_m(); s += 5) {
    const RoutePoint p = route.at(s);
    bounds.extend({p.east_m - margin_m, p.north_m - margin_m, p.east_m + margin_m, p.north_m + margin_m});
  }
  return bounds;
}

/// Largest height above ground that the flight may have.
double highest_agl_m(const SceneSource& source, const tiles::Zone& zone, const Route& route,
                     const FlightOptions& options) {
  if (!options.altitude_m) return kReliefReserve * options.agl_m;
  double lowest_m = source.plane_height_m;
  if (source.elevation) {
    const features::GridImage heights = ingest::load_elevation(*source.elevation, zone, route_bounds(route, 50));
    cv::minMaxLoc(heights.pixels, &lowest_m, nullptr, nullptr, nullptr, heights.valid);
  }
  return std::max(1.0, *options.altitude_m - lowest_m);
}

/// How far from the point below the aircraft a corner of the picture may look.
double reach_m(const FlightOptions& options, double agl_m) {
  const double corner_rad = std::atan(
      std::hypot(0.5 * options.camera.width / options.camera.fx, 0.5 * options.camera.height / options.camera.fy));
  const double tilt_rad = 2 * options.sway_rad + (options.bank ? M_PI / 6 : 0);
  return agl_m * std::tan(std::min(corner_rad + tilt_rad, kSteepestViewRad));
}

void shift(features::GridImage& image, const Eigen::Vector2d& by) {
  image.west_m += by.x();
  image.north_m += by.y();
}

}  // namespace

terrain::Scene load_scene(const SceneSource& source, const tiles::Zone& zone, const Route& route,
                          const FlightOptions& options) {
  const double agl_m = highest_agl_m(source, zone, route, options);
  ingest::GridBounds bounds = route_bounds(route, reach_m(options, agl_m));
  // The files lie where they say; the shift moves them afterwards.
  bounds = {bounds.west_m - source.shift.x(), bounds.south_m - source.shift.y(), bounds.east_m - source.shift.x(),
            bounds.north_m - source.shift.y()};
  const double native_m = ingest::ImageSet(std::array{source.ortho}, zone).finest_gsd_m();
  const double gsd_m = std::max(native_m / 2, agl_m / kReliefReserve / options.camera.fx);
  features::GridImage ortho = ingest::load_image(source.ortho, zone, bounds, gsd_m);
  if (!ortho.valid.empty() && cv::countNonZero(ortho.valid) == 0) {
    throw Error(
        ExitCode::kNoData,
        fmt::format("{}: the route (east {:.0f}...{:.0f}, north {:.0f}...{:.0f}) does not touch this scene; move "
                    "it with --center or --route",
                    source.ortho.path, bounds.west_m, bounds.east_m, bounds.south_m, bounds.north_m));
  }
  shift(ortho, source.shift);
  if (!source.elevation) return terrain::Scene(ortho, source.plane_height_m);
  features::GridImage heights = ingest::load_elevation(*source.elevation, zone, bounds);
  shift(heights, source.shift);
  return terrain::Scene(ortho, heights);
}

}  // namespace landfix::fly

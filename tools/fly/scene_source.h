// The camera's scene from files: an orthophoto and a height model on the map's grid around a route.
#pragma once

#include <optional>

#include "builder/ingest/window.h"
#include "builder/terrain/scene.h"
#include "tools/fly/flight.h"

namespace landfix::fly {

struct SceneSource {
  ingest::SourceOptions ortho;
  std::optional<ingest::SourceOptions> elevation;  ///< none: `plane_height_m` everywhere
  double plane_height_m = 0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();  ///< added to every position of the scene, metres east and north
};

/// Everything that the camera can see along a route: the route with the reach of a tilted picture around it, at the GSD
/// of the camera on the ground but no finer than half the orthophoto's own. Throws Error as ingest does, and kNoData
/// where the route lies off the orthophoto.
terrain::Scene load_scene(const SceneSource& source, const tiles::Zone& zone, const Route& route,
                          const FlightOptions& options);

}  // namespace landfix::fly

// Where a route may not lead: polygons on the grid.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tiles/geodesy.h"
#include "tools/mission/mission.h"

namespace landfix::route {

using Polygon = std::vector<Eigen::Vector2d>;  ///< corners (east, north), not closed

class Fences {
 public:
  /// `exclusions`: to stay out of. `inclusions`: to stay within one of them, where there are any.
  explicit Fences(std::vector<Polygon> exclusions = {}, std::vector<Polygon> inclusions = {});
  ~Fences();
  Fences(const Fences&);
  Fences& operator=(const Fences&);

  /// Whether the straight line between two places keeps to them; touching counts as crossing.
  bool allow(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;

  std::vector<Polygon> exclusions() const;
  std::vector<Polygon> inclusions() const;

 private:
  struct Area;
  std::vector<Area> exclusions_, inclusions_;
};

/// The fences of a mission, circles as polygons around (exclusion) or within (inclusion) them, with more exclusions.
/// Throws Error (kNoData) where a fence is out of the zone's reach.
Fences fences_of(const mission::Mission& mission, const tiles::Zone& zone, std::vector<Polygon> exclusions = {});

}  // namespace landfix::route

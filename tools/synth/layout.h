// Everything that stands in and around a rectangle of the grid: blocks of land divided into parcels, and the roads,
// buildings, trees and lakes there. Made anew for each tile that is drawn; two layouts agree wherever they overlap.
#pragma once

#include <span>
#include <vector>

#include "tools/synth/plan.h"

namespace landfix::synth {

enum class LandUse { kField, kWood, kLot, kShore };

/// A line of the plan that bounds parcels: signed distance of q is normal · q − offset.
struct Border {
  Point normal;
  double offset = 0;
  double road_width_m = 0;  ///< 0 where no road runs along it
  bool hedge = false;

  double distance_m(Point plan) const { return normal.dot(plan) - offset; }
};

struct Parcel {
  Outline outline;  ///< plan coordinates
  LandUse use = LandUse::kField;
  Crop rotation_start = Crop::kWheat;  ///< of fields: permanent crops keep it, others rotate from year to year
  Point row_normal;                    ///< rows of plants are level lines of row_normal · q
  uint64_t key = 0;
};

/// One square of the lattice, divided by a binary tree of lines into convex parcels.
struct Block {
  struct Node {
    int border = 0;               ///< index into `borders`
    int inside = 0, outside = 0;  ///< child where the distance is ≥ 0, and where not: a node, or ~parcel
  };

  int64_t i = 0, j = 0;
  std::array<Point, 4> corners;          ///< plan: south-west, south-east, north-east, north-west
  std::array<double, 4> roundabout_m{};  ///< radii of roundabouts at the corners; 0: none
  std::vector<Border> borders;           ///< the first four are the south, east, north and west edge
  std::vector<Node> nodes;
  int root = 0;
  std::vector<Parcel> parcels;
  std::vector<Road> roads;
  std::vector<Intersection> intersections;
  std::vector<Building> buildings;
  std::vector<Point> yards;     ///< centres of farmyards, grid
  std::vector<Tree> row_trees;  ///< along avenues and in orchards

  bool contains(Point plan) const;
  /// Whether a corner, where roads of other blocks may end, is nearer than `distance_m`.
  bool near_corner(Point plan, double distance_m) const;
};

/// Where a point lies in the plan.
struct Site {
  const Block* block = nullptr;
  const Parcel* parcel = nullptr;
  const Border* border = nullptr;  ///< the nearest
  float border_m = 0;              ///< distance to it
  float road_m = 0;                ///< distance to the edge of the nearest road, negative on it
};

inline constexpr double kYardRadius_m = 24;

class Layout {
 public:
  /// Knows all that stands in `area`, and the ground for `kGroundReach_m` around it.
  Layout(const Plan& plan, const Rectangle& area);

  const std::vector<Block>& blocks() const { return blocks_; }
  const std::vector<Lake>& lakes() const { return lakes_; }
  const Plan& plan() const { return plan_; }

  /// `hint` is the block to try first (neighbouring pixels mostly share one); null for none.
  Site site(Point plan, const Block* hint) const;
  /// Height of the ground: the relief, level on lakes and falling towards their shores.
  double ground_at(Point grid) const;
  /// Sinks relief heights along a row into the lakes' basins.
  void sink_lakes(const SampleRow& row, std::span<float> height_m) const;
  double shore_distance_m(Point grid) const;  ///< to the nearest lake; large where there is none

  /// Trees that stand in `area`, in an order of their own.
  std::vector<Tree> trees(const Rectangle& area) const;

 private:
  bool grows(Point grid, uint64_t tree_key, Tree& tree) const;
  bool free_of_buildings(const Block& block, Point grid, double radius_m) const;

  const Plan& plan_;
  std::vector<Lake> lakes_;
  std::vector<Block> blocks_;
  Noise woodland_, clearing_;
};

/// Divides the block whose south-western node is (i, j). `lake` is the one it holds, or null.
Block make_block(const Plan& plan, int64_t i, int64_t j, const Lake* lake, const Noise& woodland);

}  // namespace landfix::synth

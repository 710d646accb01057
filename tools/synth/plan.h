// The plan of the world at its coarsest: a lattice of nodes about 640 m apart, moved at random. Roads run along its
// edges, villages grow around some nodes, and lakes fill the lowest of the blocks in between. Everything is a pure
// function of seed and indices.
#pragma once

#include <array>
#include <optional>

#include "tools/synth/ground.h"
#include "tools/synth/objects.h"

namespace landfix::synth {

inline constexpr double kBlock_m = 640;
inline constexpr double kBank_m = 90;  ///< the ground falls to a lake over this distance

struct Village {
  Point centre;  ///< plan coordinates
  double radius_m = 0;
};

/// A road along an edge of the lattice.
struct RoadSpec {
  RoadKind kind = RoadKind::kTrack;
  double width_m = 0;
  bool avenue = false;                  ///< trees on both sides
  double shoulder_m = 0, median_m = 0;  ///< of the width: paved strips outside of the edge lines, grass in the middle
  bool yellow = false;                  ///< its middle line
  double tree_gap_m = 3.5;              ///< of an avenue: from the edge to the trunks
};

double width_of(RoadKind kind);

class Plan {
 public:
  /// `varied`: main roads of all kinds, roundabouts, tracks and avenues of different width; else one width for each
  /// kind.
  Plan(uint64_t seed, const Ground& ground, bool varied) : seed_(seed), ground_(ground), varied_(varied) {}

  uint64_t seed() const { return seed_; }
  const Ground& ground() const { return ground_; }

  /// Node (i, j) in plan coordinates. The lattice squares stay convex.
  Point node(int64_t i, int64_t j) const;
  std::optional<Village> village(int64_t i, int64_t j) const;
  /// Road from node (i, j) to its eastern neighbour.
  std::optional<RoadSpec> road_east(int64_t i, int64_t j) const;
  /// Road from node (i, j) to its northern neighbour.
  std::optional<RoadSpec> road_north(int64_t i, int64_t j) const;
  int degree(int64_t i, int64_t j) const;
  /// Outer radius of the roundabout at node (i, j); 0 where there is none.
  double roundabout_m(int64_t i, int64_t j) const;
  /// The lake of the block whose south-western node is (i, j): blocks lower than their four neighbours hold one.
  std::optional<Lake> lake(int64_t i, int64_t j) const;

 private:
  Point block_centre(int64_t i, int64_t j) const;
  std::optional<RoadSpec> road(uint64_t road_key, uint64_t line_key, bool through_road, bool touches_village) const;

  uint64_t seed_;
  const Ground& ground_;
  const bool varied_;
};

}  // namespace landfix::synth

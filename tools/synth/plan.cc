#include "tools/synth/plan.h"

#include <algorithm>
#include <cmath>

#include "tools/synth/random.h"

namespace landfix::synth {
namespace {

constexpr uint64_t kNodeSalt = 21, kVillageSalt = 22, kEastSalt = 23, kNorthSalt = 24, kLakeSalt = 25,
                   kEastLineSalt = 26, kNorthLineSalt = 27, kRoundaboutSalt = 28, kVarietySalt = 29;
constexpr double kJitter = 0.2;  // a lattice square stays convex below 0.25

// What runs on: the same along a whole line of the lattice.
void vary_main(uint64_t line_key, RoadSpec& spec) {
  Random random(line_key);
  const double kind = random.between(0, 1);
  spec.yellow = random.chance(0.3);
  if (kind < 0.25) {  // two carriageways
    spec.median_m = random.between(2, 5);
    spec.shoulder_m = random.between(0.5, 2.5);
    spec.width_m = spec.median_m + 2 * (7 + spec.shoulder_m);
  } else if (kind < 0.6) {
    spec.shoulder_m = random.between(0.5, 2.5);
    spec.width_m = 7 + 2 * spec.shoulder_m;
  }
}

void vary(uint64_t road_key, uint64_t line_key, RoadSpec& spec) {
  Random random(mix(road_key ^ kVarietySalt));
  spec.tree_gap_m = random.between(1.6, 4);
  if (spec.kind == RoadKind::kMain) return vary_main(line_key, spec);
  spec.width_m = spec.kind == RoadKind::kMinor ? random.between(4.5, 7) : random.between(2.4, 4.2);
}

}  // namespace

double width_of(RoadKind kind) {
  switch (kind) {
    case RoadKind::kMain:
      return 7.5;
    case RoadKind::kMinor:
      return 5.5;
    case RoadKind::kStreet:
      return 5;
    case RoadKind::kTrack:
      return 3.2;
  }
  return 0;
}

Point Plan::node(int64_t i, int64_t j) const {
  Random random(key(seed_, kNodeSalt, i, j));
  const double east = static_cast<double>(i) + random.between(-kJitter, kJitter);
  const double north = static_cast<double>(j) + random.between(-kJitter, kJitter);
  return {east * kBlock_m, north * kBlock_m};
}

std::optional<Village> Plan::village(int64_t i, int64_t j) const {
  Random random(key(seed_, kVillageSalt, i, j));
  if (!random.chance(0.24)) return std::nullopt;
  return Village{node(i, j), random.between(100, 215)};
}

std::optional<RoadSpec> Plan::road(uint64_t road_key, uint64_t line_key, bool through_road,
                                   bool touches_village) const {
  Random random(road_key);
  const bool built = random.chance(through_road ? 0.95 : 0.66);
  const bool paved = random.chance(0.6);
  const bool avenue = random.chance(0.3);
  if (!built && !touches_village) return std::nullopt;
  const RoadKind kind = through_road ? RoadKind::kMain : paved || touches_village ? RoadKind::kMinor : RoadKind::kTrack;
  RoadSpec spec{kind, width_of(kind), avenue && kind != RoadKind::kTrack};
  if (varied_) vary(road_key, line_key, spec);
  return spec;
}

std::optional<RoadSpec> Plan::road_east(int64_t i, int64_t j) const {
  return road(key(seed_, kEastSalt, i, j), key(seed_, kEastLineSalt, j), j % 2 == 0,
              village(i, j) || village(i + 1, j));
}

std::optional<RoadSpec> Plan::road_north(int64_t i, int64_t j) const {
  return road(key(seed_, kNorthSalt, i, j), key(seed_, kNorthLineSalt, i), i % 3 == 0,
              village(i, j) || village(i, j + 1));
}

int Plan::degree(int64_t i, int64_t j) const {
  return road_east(i, j).has_value() + road_east(i - 1, j).has_value() + road_north(i, j).has_value() +
         road_north(i, j - 1).has_value();
}

double Plan::roundabout_m(int64_t i, int64_t j) const {
  Random random(key(seed_, kRoundaboutSalt, i, j));
  if (!varied_ || !random.chance(0.4) || degree(i, j) < 3 || village(i, j)) return 0;
  double widest = 0;
  for (const auto& road : {road_east(i, j), road_east(i - 1, j), road_north(i, j), road_north(i, j - 1)})
    if (road) widest = std::max(widest, road->kind == RoadKind::kTrack ? 0 : road->width_m);
  return widest > 0 ? std::max(random.between(12, 21), widest / 2 + 7) : 0;
}

Point Plan::block_centre(int64_t i, int64_t j) const {
  const Point plan = 0.25 * (node(i, j) + node(i + 1, j) + node(i, j + 1) + node(i + 1, j + 1));
  return ground_.grid_from_plan(plan);
}

std::optional<Lake> Plan::lake(int64_t i, int64_t j) const {
  const Point centre = block_centre(i, j);
  const double low = ground_.relief_at(centre);
  for (int64_t dj = -1; dj <= 1; ++dj) {
    for (int64_t di = -1; di <= 1; ++di) {
      if ((di == 0) != (dj == 0) && ground_.relief_at(block_centre(i + di, j + dj)) <= low) return std::nullopt;
    }
  }
  Random random(key(seed_, kLakeSalt, i, j));
  Lake lake;
  lake.centre = centre;
  lake.mean_radius_m = random.between(75, 115);
  constexpr std::array<double, 5> kShape = {0.24, 0.13, 0.08, 0.05, 0.04};
  for (size_t k = 0; k < kShape.size(); ++k) {
    lake.amplitude[k] = kShape[k] * random.between(0.4, 1);
    lake.phase[k] = random.between(0, 2 * M_PI);
  }
  // Nothing on the banks is lower than the water.
  lake.level_m = low;
  for (const Point& p : lake.outline()) {
    const Point outward = (p - centre) * (1 / cv::norm(p - centre));
    for (const double away : {0.0, 0.33, 0.67, 1.0}) {
      lake.level_m = std::min(lake.level_m, ground_.relief_at(p + outward * (away * kBank_m)));
    }
  }
  lake.level_m -= 0.3;
  return lake;
}

}  // namespace landfix::synth

#include "tools/synth/layout.h"

#include <algorithm>
#include <cmath>

#include "tools/synth/random.h"

namespace landfix::synth {
namespace {

constexpr uint64_t kWoodlandSalt = 41, kTreeSalt = 42, kClearingSalt = 43;
constexpr double kTreeCell_m = 5.6;  // at most one tree grows by chance in a square of this size
constexpr double kClearCorner_m = 7;
constexpr double kLargestBend_m = 70;
constexpr double kOffStraight_m = 0.5;  // bent roads lie nearer than this to their straight pieces

/// 1 at the shore, 0 at the far edge of the bank, with slope 0 at both.
double bank_share(double shore_distance_m) {
  const double t = std::clamp(1 - shore_distance_m / kBank_m, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

double sunk(const Lake& lake, double relief_m, Point grid) {
  const double reach = lake.largest_radius_m() + kBank_m;
  const Point d = grid - lake.centre;
  if (std::abs(d.x) >= reach || std::abs(d.y) >= reach) return relief_m;
  return relief_m + (lake.level_m - relief_m) * bank_share(lake.shore_distance_m(grid));
}

/// Gives a road a vertex at a place that it passes; elsewhere, and where it has one, nothing happens.
void add_vertex(Road& road, Point at) {
  constexpr double kSame_m = 1e-3;
  if (std::ranges::any_of(road.line, [&](Point p) { return cv::norm(p - at) < kSame_m; })) return;
  for (size_t k = 0; k + 1 < road.line.size(); ++k) {
    const Point a = road.line[k], along = road.line[k + 1] - a;
    const double t = along.dot(at - a) / along.dot(along);
    if (t < 0 || t > 1 || cv::norm(a + along * t - at) > kOffStraight_m) continue;
    road.line.insert(road.line.begin() + static_cast<std::ptrdiff_t>(k) + 1, at);
    return;
  }
}

/// Roads that meet share a vertex there: each gets one where another ends on it, be it of a neighbouring block.
void join_roads(std::vector<Block>& blocks) {
  for (const Block& from : blocks) {
    for (const Road& ending : from.roads) {
      for (const Point end : {ending.line.front(), ending.line.back()}) {
        for (Block& block : blocks) {
          for (Road& road : block.roads) {
            if (bounds_of(road.line).grown(kOffStraight_m).contains(end)) add_vertex(road, end);
          }
        }
      }
    }
  }
}

}  // namespace

bool Block::contains(Point plan) const {
  // Strictly complementary signs on common edges: every point lies in exactly one block.
  return borders[0].distance_m(plan) >= 0 && borders[1].distance_m(plan) >= 0 && borders[2].distance_m(plan) < 0 &&
         borders[3].distance_m(plan) < 0;
}

bool Block::near_corner(Point plan, double distance_m) const {
  for (size_t k = 0; k < corners.size(); ++k)
    if (cv::norm(plan - corners[k]) < std::max(distance_m, roundabout_m[k] + 3)) return true;
  return false;
}

Layout::Layout(const Plan& plan, const Rectangle& area)
    : plan_(plan),
      woodland_(key(plan.seed(), kWoodlandSalt), 1300, 300, 1.0f, 0.45f),
      clearing_(key(plan.seed(), kClearingSalt), 160, 38, 1.0f, 0.6f) {
  // A block reaches 0.2 of a lattice square beyond its own.
  const auto first = [](double low_m) {
    return static_cast<int64_t>(std::floor((low_m - kLargestBend_m) / kBlock_m - 1.2));
  };
  const auto last = [](double high_m) {
    return static_cast<int64_t>(std::floor((high_m + kLargestBend_m) / kBlock_m + 0.2));
  };
  const int64_t i0 = first(area.west_m), i1 = last(area.east_m), j0 = first(area.south_m), j1 = last(area.north_m);
  for (int64_t j = j0; j <= j1; ++j) {
    for (int64_t i = i0; i <= i1; ++i) {
      const auto lake = plan.lake(i, j);
      if (lake) lakes_.push_back(*lake);
      const std::array<Point, 4> corners = {plan.node(i, j), plan.node(i + 1, j), plan.node(i, j + 1),
                                            plan.node(i + 1, j + 1)};
      if (!bounds_of(corners).touches(area.grown(kLargestBend_m))) continue;
      blocks_.push_back(make_block(plan, i, j, lake ? &*lake : nullptr, woodland_));
    }
  }
  join_roads(blocks_);
  for (Block& block : blocks_) {
    for (Building& building : block.buildings) building.base_m = ground_at(building.centre);
  }
}

Site Layout::site(Point plan, const Block* hint) const {
  const Block* block = hint;
  if (block == nullptr || !block->contains(plan)) {
    const auto found = std::ranges::find_if(blocks_, [&](const Block& b) { return b.contains(plan); });
    // Rounding where four blocks meet can leave a point to none of them; the first block serves as well as any.
    block = found != blocks_.end() ? &*found : &blocks_.front();
  }
  double border_m = 1e30, road_m = 1e30;
  const Border* nearest = nullptr;
  const auto pass = [&](const Border& border, double distance) {
    if (distance < border_m) {
      border_m = distance;
      nearest = &border;
    }
    if (border.road_width_m > 0) road_m = std::min(road_m, distance - border.road_width_m / 2);
  };
  for (int k = 0; k < 4; ++k) pass(block->borders[k], std::abs(block->borders[k].distance_m(plan)));
  for (size_t k = 0; k < 4; ++k)
    if (block->roundabout_m[k] > 0)
      road_m = std::min(road_m, cv::norm(plan - block->corners[k]) - block->roundabout_m[k]);
  int node = block->root;
  while (node >= 0) {
    const Block::Node& n = block->nodes[node];
    const double distance = block->borders[n.border].distance_m(plan);
    pass(block->borders[n.border], std::abs(distance));
    node = distance >= 0 ? n.inside : n.outside;
  }
  return {block, &block->parcels[~node], nearest, static_cast<float>(border_m), static_cast<float>(road_m)};
}

double Layout::ground_at(Point grid) const {
  double height = plan_.ground().relief_at(grid);
  for (const Lake& lake : lakes_) height = sunk(lake, height, grid);
  return height;
}

void Layout::sink_lakes(const SampleRow& row, std::span<float> height_m) const {
  for (const Lake& lake : lakes_) {
    const double reach = lake.largest_radius_m() + kBank_m;
    if (std::abs(row.north_m - lake.centre.y) >= reach) continue;
    for (size_t k = 0; k < height_m.size(); ++k) {
      const Point p(row.east_m(static_cast<int>(k)), row.north_m);
      height_m[k] = static_cast<float>(sunk(lake, static_cast<double>(height_m[k]), p));
    }
  }
}

double Layout::shore_distance_m(Point grid) const {
  double least = 1e9;
  for (const Lake& lake : lakes_) {
    const double at_least = cv::norm(grid - lake.centre) - lake.largest_radius_m();
    if (at_least < least && at_least < kBank_m) least = std::min(least, lake.shore_distance_m(grid));
  }
  return least;
}

bool Layout::free_of_buildings(const Block& block, Point grid, double radius_m) const {
  return std::ranges::none_of(block.buildings,
                              [&](const Building& b) {
                                return cv::norm(grid - b.centre) < b.reach_m() + radius_m &&
                                       b.outside_m(b.local(grid)) < radius_m;
                              }) &&
         std::ranges::none_of(block.yards, [&](Point yard) { return cv::norm(grid - yard) < kYardRadius_m; });
}

bool Layout::grows(Point grid, uint64_t tree_key, Tree& tree) const {
  Random random(tree_key);
  const double lot = unit(random.word());
  const Point plan = plan_.ground().plan_from_grid(grid);
  const Site s = site(plan, nullptr);
  const double shore = shore_distance_m(grid);
  const bool grass = s.parcel->rotation_start == Crop::kGrass;
  double chance = 0, low = 4, high = 9;
  switch (s.parcel->use) {
    case LandUse::kWood: {
      // Old and young stands, and clearings between them.
      const double stand = static_cast<double>(clearing_.at(grid.x, grid.y));
      chance = stand < -0.42 ? 0.12 : 0.9;
      low = 9 + 6 * std::clamp(stand, -0.5, 0.5);
      high = low + 7;
      break;
    }
    case LandUse::kLot:
      chance = 0.13;
      high = 10;
      break;
    case LandUse::kShore:
      chance = shore < 10 ? 0.4 : 0.04;
      high = 13;
      break;
    case LandUse::kField:
      chance = grass ? 0.008 : 0;
      high = 15;
      break;
  }
  if (s.parcel->use != LandUse::kWood && s.border_m < 2.4) chance = s.border->hedge ? 0.85 : std::max(chance, 0.012);
  if (lot >= chance) return false;
  const double height = random.between(low, high);
  const bool spruces = s.parcel->use == LandUse::kWood && unit(mix(s.parcel->key)) < 0.35;
  tree = {grid, 0.2 * height + 0.5, height, 0, random.chance(spruces ? 0.9 : 0.08), random.word()};
  if (tree.conifer) tree.radius_m *= 0.78;
  return s.road_m > 1.2 + 0.4 * tree.radius_m && !s.block->near_corner(plan, kClearCorner_m) && shore > 1.5 &&
         free_of_buildings(*s.block, grid, 0.8 * tree.radius_m);
}

std::vector<Tree> Layout::trees(const Rectangle& area) const {
  std::vector<Tree> found;
  for (const Block& block : blocks_) {
    for (const Tree& tree : block.row_trees) {
      if (!area.contains(tree.position)) continue;
      const Site s = site(plan_.ground().plan_from_grid(tree.position), &block);
      const bool free = s.road_m > 1.5 && shore_distance_m(tree.position) > 2;
      if (free && free_of_buildings(*s.block, tree.position, tree.radius_m)) found.push_back(tree);
    }
  }
  const auto cell = [](double m) { return static_cast<int64_t>(std::floor(m / kTreeCell_m)); };
  for (int64_t j = cell(area.south_m); j <= cell(area.north_m); ++j) {
    for (int64_t i = cell(area.west_m); i <= cell(area.east_m); ++i) {
      Random random(key(plan_.seed(), kTreeSalt, i, j));
      const Point at(kTreeCell_m * (static_cast<double>(i) + random.between(0.1, 0.9)),
                     kTreeCell_m * (static_cast<double>(j) + random.between(0.1, 0.9)));
      Tree tree;
      if (area.contains(at) && grows(at, random.word(), tree)) found.push_back(tree);
    }
  }
  for (Tree& tree : found) tree.base_m = ground_at(tree.position);
  return found;
}

}  // namespace landfix::synth

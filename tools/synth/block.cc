// Divides one block of the lattice into parcels: fields outside of villages, building lots inside, down to the size
// that fits.
#include <algorithm>
#include <cmath>

#include "tools/synth/layout.h"
#include "tools/synth/random.h"

namespace landfix::synth {
namespace {

constexpr uint64_t kBlockSalt = 31, kInsideSalt = 32, kOutsideSalt = 33, kLeafSalt = 34;
constexpr double kLineStep_m = 12;       // of a road's polyline
constexpr double kShoreMargin_m = 14;    // parcels closer to a lake are wild shore
constexpr double kStreetArea_m2 = 5600;  // larger pieces of a village are opened by a street
constexpr double kMergeJunctions_m = 9;

/// A convex piece of the block; `border[k]` lies along the edge from point k to point k + 1.
struct Piece {
  Outline points;
  std::vector<int> border;

  void push(Point p, int along) {
    points.push_back(p);
    border.push_back(along);
  }
};

struct Cut {
  Piece inside, outside;
  std::vector<Point> ends;  // two, where the line meets the piece's edges
  std::vector<int> end_borders;
};

struct Frame {
  Point u, v;  // unit vectors along and across the longest edge
  Point low;   // smallest coordinates along u and v
  Point size;  // extent along u and v
  Point centroid;
  double area_m2 = 0;
};

Frame frame_of(const Outline& p) {
  Frame f;
  double longest = -1;
  Point sum(0, 0);
  for (size_t k = 0; k < p.size(); ++k) {
    const Point a = p[k], b = p[(k + 1) % p.size()];
    const double length = cv::norm(b - a);
    if (length > longest) {
      longest = length;
      f.u = (b - a) * (1 / length);
    }
    // Relative to the first point: coordinates of millions would cost the area its digits.
    const double twice = (a - p[0]).cross(b - p[0]);
    f.area_m2 += twice / 2;
    sum += (a + b + p[0]) * (twice / 3);
  }
  f.centroid = f.area_m2 > 0 ? sum * (1 / (2 * f.area_m2)) : p[0];
  f.v = Point(-f.u.y, f.u.x);
  Point high(-1e30, -1e30);
  f.low = {1e30, 1e30};
  for (const Point& q : p) {
    f.low = {std::min(f.low.x, f.u.dot(q)), std::min(f.low.y, f.v.dot(q))};
    high = {std::max(high.x, f.u.dot(q)), std::max(high.y, f.v.dot(q))};
  }
  f.size = high - f.low;
  return f;
}

Cut cut(const Piece& piece, const Border& border, int index) {
  Cut c;
  const size_t n = piece.points.size();
  for (size_t k = 0; k < n; ++k) {
    const Point a = piece.points[k], b = piece.points[(k + 1) % n];
    const double da = border.distance_m(a), db = border.distance_m(b);
    Piece& here = da >= 0 ? c.inside : c.outside;
    here.push(a, piece.border[k]);
    if ((da >= 0) == (db >= 0)) continue;
    const Point x = a + (b - a) * (da / (da - db));
    Piece& there = da >= 0 ? c.outside : c.inside;
    here.push(x, index);
    there.push(x, piece.border[k]);
    c.ends.push_back(x);
    c.end_borders.push_back(piece.border[k]);
  }
  return c;
}

class BlockMaker {
 public:
  BlockMaker(const Plan& plan, int64_t i, int64_t j, const Lake* lake, const Noise& woodland)
      : plan_(plan),
        ground_(plan.ground()),
        lake_(lake),
        woodland_(woodland),
        key_(key(plan.seed(), kBlockSalt, i, j)) {
    block_.i = i;
    block_.j = j;
    Random random(key_);
    field_area_m2_ = random.between(9000, 34000);
    strips_ = random.chance(0.45);
  }

  Block make() {
    const int64_t i = block_.i, j = block_.j;
    const Point sw = plan_.node(i, j), se = plan_.node(i + 1, j), ne = plan_.node(i + 1, j + 1),
                nw = plan_.node(i, j + 1);
    block_.corners = {sw, se, ne, nw};
    for (int64_t dj = 0; dj <= 1; ++dj) {
      for (int64_t di = 0; di <= 1; ++di) {
        if (const auto village = plan_.village(i + di, j + dj)) villages_.push_back(*village);
      }
    }
    // Neighbours compute a common edge from the same points in the same order: no rounding can open a gap between them.
    add_edge(sw, se, plan_.road_east(i, j), true);
    add_edge(se, ne, plan_.road_north(i + 1, j), false);
    add_edge(nw, ne, plan_.road_east(i, j + 1), false);
    add_edge(sw, nw, plan_.road_north(i, j), true);
    if (const int degree = plan_.degree(i, j); degree >= 3) {
      block_.intersections.push_back({ground_.grid_from_plan(sw), degree});
    }
    block_.roundabout_m = {plan_.roundabout_m(i, j), plan_.roundabout_m(i + 1, j), plan_.roundabout_m(i + 1, j + 1),
                           plan_.roundabout_m(i, j + 1)};
    Piece whole;
    for (int k = 0; k < 4; ++k) whole.push(block_.corners[k], k);
    block_.root = divide(whole, 0, key_);
    return std::move(block_);
  }

 private:
  /// The block owns the roads of its southern and western edge.
  void add_edge(Point a, Point b, const std::optional<RoadSpec>& road, bool owned) {
    const Point along = (b - a) * (1 / cv::norm(b - a));
    const Point normal(-along.y, along.x);
    block_.borders.push_back({normal, normal.dot(a), road ? road->width_m : 0, false});
    if (road && owned) add_road(a, b, *road);
  }

  void add_road(Point a, Point b, const RoadSpec& spec) {
    Road road{{}, spec.width_m, spec.kind, spec.shoulder_m, spec.median_m, spec.yellow};
    const int steps = std::max(1, static_cast<int>(std::ceil(cv::norm(b - a) / kLineStep_m)));
    for (int k = 0; k <= steps; ++k) {
      road.line.push_back(ground_.grid_from_plan(a + (b - a) * (static_cast<double>(k) / steps)));
    }
    if (spec.avenue) plant_avenue(road, spec.tree_gap_m);
    block_.roads.push_back(std::move(road));
  }

  void plant_avenue(const Road& road, double gap_m) {
    Random random(key(key_, kLeafSalt, static_cast<int64_t>(block_.row_trees.size())));
    for (size_t k = 2; k + 2 < road.line.size(); ++k) {
      const Point along = (road.line[k] - road.line[k - 1]) * (1 / cv::norm(road.line[k] - road.line[k - 1]));
      for (const double side : {-1.0, 1.0}) {
        if (!random.chance(0.85)) continue;
        const double height = random.between(7, 14);
        const double away = road.width_m / 2 + gap_m + random.between(-0.4, 0.4);
        const Point at = road.line[k] + along * random.between(-1, 1) + Point(-along.y, along.x) * (side * away);
        block_.row_trees.push_back({at, 0.22 * height + 0.8, height, 0, false, random.word()});
      }
    }
  }

  bool in_village(Point plan) const {
    if (villages_.empty()) return false;
    // The noise frays the circle into an outline that has grown.
    const double frayed = 1 + 1.1 * static_cast<double>(woodland_.at(plan.y, plan.x));
    return std::ranges::any_of(villages_,
                               [&](const Village& v) { return cv::norm(plan - v.centre) < v.radius_m * frayed; });
  }

  bool touches_village(const Piece& piece, Point centroid) const {
    return in_village(centroid) || std::ranges::any_of(piece.points, [&](Point p) { return in_village(p); });
  }

  int divide(const Piece& piece, int depth, uint64_t piece_key) {
    const Frame frame = frame_of(piece.points);
    Random random(piece_key);
    const bool village = in_village(frame.centroid);
    const bool fringe = touches_village(piece, frame.centroid);
    const double enough = village  ? random.between(520, 1150)
                          : fringe ? 4200
                                   : field_area_m2_ * random.between(0.7, 1.7);
    if (frame.area_m2 < enough || frame.size.x < 24) return leaf(piece, frame, piece_key);

    // Across the long side as a rule; along it where the land is divided into strips.
    const bool lengthwise =
        strips_ && !fringe && frame.size.x < 3.2 * frame.size.y && frame.size.y > 110 && random.chance(0.6);
    const double turn = random.between(-0.06, 0.06);
    const Point along = lengthwise ? frame.u : frame.v, across = lengthwise ? frame.v : frame.u;
    const double low = lengthwise ? frame.low.y : frame.low.x, size = lengthwise ? frame.size.y : frame.size.x;
    Border border;
    border.normal = across * std::cos(turn) + along * std::sin(turn);
    const Point through =
        frame.centroid + across * (low + size * random.between(0.4, 0.6) - across.dot(frame.centroid));
    border.offset = border.normal.dot(through);
    const auto index = static_cast<int>(block_.borders.size());
    Cut parts = cut(piece, border, index);
    if (parts.ends.size() != 2 || parts.inside.points.size() < 3 || parts.outside.points.size() < 3) {
      return leaf(piece, frame, piece_key);
    }
    if (const auto road = road_along(parts, fringe, frame.area_m2, depth, random)) {
      border.road_width_m = road->width_m;
      add_road(road_end(parts, 0), road_end(parts, 1), *road);
      add_junctions(parts, block_.roads.back());
    } else {
      border.hedge = !fringe && random.chance(0.2);
    }
    block_.borders.push_back(border);
    const auto node = static_cast<int>(block_.nodes.size());
    block_.nodes.push_back({index, 0, 0});
    const int inside = divide(parts.inside, depth + 1, key(piece_key, kInsideSalt));
    const int outside = divide(parts.outside, depth + 1, key(piece_key, kOutsideSalt));
    block_.nodes[node].inside = inside;
    block_.nodes[node].outside = outside;
    return node;
  }

  /// Streets open the pieces of a village, tracks the large pieces of farmland; each begins at a road that is there.
  std::optional<RoadSpec> road_along(const Cut& parts, bool fringe, double area_m2, int depth, Random& random) const {
    const bool wanted = random.chance(fringe ? 0.75 : 0.7);
    if (!wanted || (fringe ? area_m2 < kStreetArea_m2 : depth > 2 || area_m2 < 50000)) return std::nullopt;
    if (!is_road(parts.end_borders[0]) && !is_road(parts.end_borders[1])) return std::nullopt;
    const Point a = parts.ends[0], b = parts.ends[1];
    if (lake_ != nullptr) {
      const Point centre = ground_.plan_from_grid(lake_->centre);
      const double t = std::clamp((centre - a).dot(b - a) / (b - a).dot(b - a), 0.0, 1.0);
      if (cv::norm(a + (b - a) * t - centre) < 1.1 * lake_->largest_radius_m() + 15) return std::nullopt;
    }
    const RoadKind kind = fringe && (in_village(a) || in_village(b)) ? RoadKind::kStreet : RoadKind::kTrack;
    return RoadSpec{kind, width_of(kind), false};
  }

  bool is_road(int border) const { return block_.borders[border].road_width_m > 0; }

  /// Where the road along a cut ends: in the road that it meets, or short of a border without one.
  Point road_end(const Cut& parts, size_t end) const {
    constexpr double kShort_m = 6;
    const Point at = parts.ends[end], along = parts.ends[1 - end] - at;
    return is_road(parts.end_borders[end]) ? at : at + along * (kShort_m / cv::norm(along));
  }

  void add_junctions(const Cut& parts, Road& road) {
    for (size_t k = 0; k < 2; ++k) {
      if (!is_road(parts.end_borders[k])) continue;
      const Point at = ground_.grid_from_plan(parts.ends[k]);
      // Two roads that end at one place from both sides are a crossing, not two junctions.
      const auto near = std::ranges::find_if(block_.intersections, [&](const Intersection& other) {
        return cv::norm(other.position - at) < kMergeJunctions_m;
      });
      if (near != block_.intersections.end()) {
        ++near->degree;
        (k == 0 ? road.line.front() : road.line.back()) = near->position;
      } else {
        block_.intersections.push_back({at, 3});
      }
    }
  }

  int leaf(const Piece& piece, const Frame& frame, uint64_t piece_key) {
    Random random(key(piece_key, kLeafSalt));
    Parcel parcel;
    parcel.outline = piece.points;
    parcel.key = random.word();
    parcel.row_normal = frame.v;
    const Point centre = ground_.grid_from_plan(frame.centroid);
    const double wooded = static_cast<double>(woodland_.at(centre.x, centre.y)) + random.between(-0.06, 0.06);
    const double permanent = random.between(0, 1);
    parcel.rotation_start = permanent < 0.14   ? Crop::kGrass
                            : permanent < 0.17 ? Crop::kOrchard
                                               : static_cast<Crop>(random.word() % 9);
    if (touches_lake(piece, frame)) {
      parcel.use = LandUse::kShore;
    } else if (in_village(frame.centroid)) {
      parcel.use = LandUse::kLot;
      if (random.chance(0.88)) build_house(piece, frame, random);
    } else if (wooded > 0.27 && !touches_village(piece, frame.centroid)) {
      parcel.use = LandUse::kWood;
    } else if (parcel.rotation_start == Crop::kOrchard) {
      plant_orchard(piece, frame, random);
    } else if (frame.area_m2 > 7000 && random.chance(0.1)) {
      if (build_farm(piece, random)) parcel.rotation_start = Crop::kGrass;
    }
    block_.parcels.push_back(std::move(parcel));
    return ~(static_cast<int>(block_.parcels.size()) - 1);
  }

  bool touches_lake(const Piece& piece, const Frame& frame) const {
    if (lake_ == nullptr) return false;
    if (inside_m(piece, ground_.plan_from_grid(lake_->centre)) > 0) return true;
    if (lake_->shore_distance_m(ground_.grid_from_plan(frame.centroid)) < kShoreMargin_m) return true;
    for (size_t k = 0; k < piece.points.size(); ++k) {
      const Point a = piece.points[k], b = piece.points[(k + 1) % piece.points.size()];
      const int steps = 1 + static_cast<int>(cv::norm(b - a) / kLineStep_m);
      for (int s = 0; s < steps; ++s) {
        const Point p = ground_.grid_from_plan(a + (b - a) * (static_cast<double>(s) / steps));
        if (lake_->shore_distance_m(p) < kShoreMargin_m) return true;
      }
    }
    return false;
  }

  /// Distance to the nearest edge of the piece or of a road along it; negative outside.
  double inside_m(const Piece& piece, Point plan) const {
    double least = 1e30;
    for (size_t k = 0; k < piece.points.size(); ++k) {
      const Point a = piece.points[k], b = piece.points[(k + 1) % piece.points.size()];
      const double left = (b - a).cross(plan - a) / cv::norm(b - a);
      least = std::min(least, left - block_.borders[piece.border[k]].road_width_m / 2);
    }
    return least;
  }

  bool fits(const Piece& piece, const Building& building, double margin_m) const {
    return std::ranges::all_of(
        building.outline(), [&](Point corner) { return inside_m(piece, ground_.plan_from_grid(corner)) > margin_m; });
  }

  /// Direction on the grid of a direction on the plan.
  Point grid_direction(Point plan, Point direction) const {
    const Point d = ground_.grid_from_plan(plan + direction * 5) - ground_.grid_from_plan(plan - direction * 5);
    return d * (1 / cv::norm(d));
  }

  void build_house(const Piece& piece, const Frame& frame, Random& random) {
    Building house;
    house.key = random.word();
    const Point at = frame.centroid + frame.u * random.between(-2, 2) + frame.v * random.between(-2, 2);
    house.centre = ground_.grid_from_plan(at);
    house.axis = grid_direction(at, frame.u);
    house.length_m = std::clamp(frame.size.x * random.between(0.4, 0.62), 9.0, 22.0);
    house.width_m = std::clamp(frame.size.y * random.between(0.36, 0.55), 7.0, 11.5);
    if (house.width_m > house.length_m) std::swap(house.width_m, house.length_m);
    house.roof = random.chance(0.22) ? Roof::kFlat : Roof::kGabled;
    house.eave_m = random.between(3, 6.5);
    house.height_m =
        house.roof == Roof::kFlat ? house.eave_m : house.eave_m + house.width_m * random.between(0.3, 0.48);
    const double wing_length = random.between(3, 6), wing_width = random.between(5.5, 6.8);
    const bool wing = random.chance(0.32) && house.length_m > wing_width + 4;
    if (wing) {
      Building with_wing = house;
      with_wing.wing_length_m = wing_length;
      with_wing.wing_width_m = wing_width;
      if (fits(piece, with_wing, 2)) house = with_wing;
    }
    if (fits(piece, house, 2)) block_.buildings.push_back(house);
  }

  /// Barns around a yard, by the first road along the piece that has room.
  bool build_farm(const Piece& piece, Random& random) {
    for (size_t k = 0; k < piece.points.size(); ++k) {
      const Point a = piece.points[k], b = piece.points[(k + 1) % piece.points.size()];
      const double length = cv::norm(b - a);
      if (length < 110 || block_.borders[piece.border[k]].road_width_m <= 0) continue;
      const Point along = (b - a) * (1 / length), inward(-along.y, along.x);
      const Point yard = a + along * (length * random.between(0.4, 0.6)) + inward * 30;
      if (lake_ != nullptr && lake_->shore_distance_m(ground_.grid_from_plan(yard)) < 60) return false;
      const size_t before = block_.buildings.size();
      for (int barn = 0; barn < 3; ++barn) {
        const bool side = barn == 2;
        Building shed;
        shed.key = random.word();
        const Point at = yard + (side ? along * 24 : inward * (barn == 0 ? -15 : 17)) + along * random.between(-4, 2);
        shed.centre = ground_.grid_from_plan(at);
        shed.axis = grid_direction(at, side ? inward : along);
        shed.length_m = random.between(16, side ? 20 : 34);
        shed.width_m = random.between(9, 14);
        shed.eave_m = random.between(3.5, 5.5);
        shed.height_m = shed.eave_m + shed.width_m * random.between(0.2, 0.4);
        if (fits(piece, shed, 2)) block_.buildings.push_back(shed);
      }
      if (block_.buildings.size() == before) continue;
      block_.yards.push_back(ground_.grid_from_plan(yard));
      return true;
    }
    return false;
  }

  void plant_orchard(const Piece& piece, const Frame& frame, Random& random) {
    constexpr double kSpacing_m = 7.5;
    for (double u = frame.low.x; u < frame.low.x + frame.size.x; u += kSpacing_m) {
      for (double v = frame.low.y; v < frame.low.y + frame.size.y; v += kSpacing_m) {
        const Point plan = frame.u * u + frame.v * v;
        const double height = random.between(4, 5.5);
        const uint64_t tree_key = random.word();
        if (inside_m(piece, plan) < 5 || !random.chance(0.95)) continue;
        block_.row_trees.push_back({ground_.grid_from_plan(plan), 0.32 * height + 0.6, height, 0, false, tree_key});
      }
    }
  }

  const Plan& plan_;
  const Ground& ground_;
  const Lake* lake_;
  const Noise& woodland_;
  uint64_t key_;
  double field_area_m2_ = 0;
  bool strips_ = false;
  std::vector<Village> villages_;
  Block block_;
};

}  // namespace

Block make_block(const Plan& plan, int64_t i, int64_t j, const Lake* lake, const Noise& woodland) {
  return BlockMaker(plan, i, j, lake, woodland).make();
}

}  // namespace landfix::synth

#include "tools/synth/render.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "tools/synth/random.h"

namespace landfix::synth {
namespace {

constexpr uint64_t kSoilSalt = 51, kTextureSalt = 52, kGrowthSalt = 53, kSproutSalt = 54;
constexpr double kLargestCrown_m = 5;
constexpr float kAmbient = 0.36f;                   // share of skylight
const Colour kHaze{9, 11, 15, 3};                   // light scattered into the camera on its way
const Colour kSkyTint{0.90f, 0.97f, 1.12f, 0.75f};  // skylight is blue
constexpr float kBrightestFace = 1.4f;              // a face turned to a low sun; the sensor saturates
constexpr float kHeadland_m = 15;                   // the outer rows follow the field's edge

Colour mixed(const Colour& a, const Colour& b, float share_of_b) { return a + (b - a) * share_of_b; }

int64_t floor_of(double v) {
  const auto i = static_cast<int64_t>(v);
  return i - (v < static_cast<double>(i));
}

/// Share of a pixel that a stripe covers whose edge is `inside_m` beyond the pixel's centre.
float coverage(double inside_m, double gsd_m) {
  return static_cast<float>(std::clamp(0.5 + inside_m / gsd_m, 0.0, 1.0));
}

/// The nearest road of one surface at a pixel.
struct Paving {
  float coverage = 0;
  float across_m = 0, along_m = 0;  ///< from the centre line, from the road's beginning
  const Road* road = nullptr;
};

class Painter {
 public:
  Painter(const Plan& plan, const Lattice& lattice, const Look& look)
      : lattice_(lattice),
        look_(look),
        margin_(static_cast<int>(std::ceil(shadow_reach_m(look.sun) / lattice.gsd_m)) + 2),
        wide_(lattice.grown(margin_)),
        layout_(plan, wide_.area().grown(kLargestCrown_m)),
        trees_(layout_.trees(wide_.area().grown(kLargestCrown_m))),
        surface_(make_surface(layout_, trees_, wide_, look.season)),
        soil_(key(plan.seed(), kSoilSalt), 230, 28, 1.0f, 0.75f),
        texture_(key(plan.seed(), kTextureSalt), 13, 0.4, 0.9f, 0.8f),
        growth_(key(plan.seed(), kGrowthSalt, look.year, static_cast<int64_t>(look.season)), 95, 11, 1.0f, 0.7f),
        sprout_(key(plan.seed(), kSproutSalt, look.year, static_cast<int64_t>(look.season)), 5, 0.6, 1.0f, 0.9f),
        colour_(lattice.height, lattice.width),
        light_(lattice.height, lattice.width),
        sun_east_(static_cast<float>(std::sin(look.sun.azimuth_rad) / std::tan(look.sun.elevation_rad))),
        sun_north_(static_cast<float>(std::cos(look.sun.azimuth_rad) / std::tan(look.sun.elevation_rad))) {}

  cv::Mat paint() {
    paint_ground();
    paint_objects();
    return expose();
  }

 private:
  struct Textures {
    float soil, texture, growth, sprout;
  };

  size_t index(int x, int y) const { return static_cast<size_t>(y) * lattice_.width + x; }

  /// Light on a plane with this slope, relative to level ground.
  float light_on(float slope_east, float slope_north) const {
    const float cosine = 1 - slope_east * sun_east_ - slope_north * sun_north_;
    return std::clamp(cosine / std::sqrt(1 + slope_east * slope_east + slope_north * slope_north), 0.0f,
                      kBrightestFace);
  }

  void paint_ground() {
    const auto width = static_cast<size_t>(lattice_.width);
    std::vector<float> bend_east(width), bend_north(width), soil(width), texture(width), growth(width), sprout(width);
    const auto [gravel, asphalt] = pave();
    const Block* block = nullptr;
    for (int y = 0; y < lattice_.height; ++y) {
      const SampleRow row = lattice_.row(y);
      layout_.plan().ground().bend(row, bend_east, bend_north);
      for (auto [noise, values] :
           {std::pair(&soil_, &soil), {&texture_, &texture}, {&growth_, &growth}, {&sprout_, &sprout}}) {
        std::ranges::fill(*values, 0.0f);
        noise->add_to(row, *values);
      }
      for (int x = 0; x < lattice_.width; ++x) {
        const Point grid(row.east_m(x), row.north_m);
        const Point plan = grid + Point(static_cast<double>(bend_east[x]), static_cast<double>(bend_north[x]));
        const Site site = layout_.site(plan, block);
        block = site.block;
        const Textures t{soil[x], texture[x], growth[x], sprout[x]};
        Colour colour = land(site, plan, t);
        if (!block->yards.empty()) colour = with_yard(colour, *block, grid, t);
        colour = with_water(colour, grid, t);
        colour = with_roads(colour, gravel[index(x, y)], asphalt[index(x, y)], t);
        colour_(y, x) = colour;
        light_(y, x) = ground_light(x, y);
      }
    }
  }

  float ground_light(int x, int y) const {
    const int wx = x + margin_, wy = y + margin_;
    const auto per_m = static_cast<float>(0.5 / lattice_.gsd_m);
    return light_on((surface_.ground(wy, wx + 1) - surface_.ground(wy, wx - 1)) * per_m,
                    (surface_.ground(wy - 1, wx) - surface_.ground(wy + 1, wx)) * per_m);
  }

  Colour snowed(const Colour& colour, float cover, const Textures& t) const {
    if (!look_.snow) return colour;
    return mixed(colour, kSnow * (1 + 0.03f * t.growth),
                 std::clamp(cover + 0.25f * t.soil + 0.1f * t.texture, 0.0f, 1.0f));
  }

  Colour land(const Site& site, Point plan, const Textures& t) const {
    const Parcel& parcel = *site.parcel;
    const float variety = static_cast<float>(unit(mix(parcel.key))) - 0.5f;
    const Colour grass = grass_colour(look_.season) * (1 + 0.13f * t.texture + 0.16f * t.growth + 0.10f * t.soil);
    Colour colour;
    switch (parcel.use) {
      case LandUse::kWood:
        colour = kForestFloor * (1 + 0.3f * t.texture);
        break;
      case LandUse::kShore:
        colour = mixed(grass, kShrub, std::clamp(0.35f + 1.2f * t.soil + 0.5f * t.texture, 0.0f, 0.8f));
        break;
      case LandUse::kLot:
        colour = garden(site, grass, variety, t);
        break;
      case LandUse::kField:
        colour = field(site, plan, variety, t);
        break;
    }
    if (parcel.use == LandUse::kField) {
      // Unploughed verges between fields and along roads, with ragged edges.
      const double verge = 0.9 + (site.road_m < 5 ? 2.5 : 0) + 0.5 * static_cast<double>(t.texture);
      const double from_edge = std::min(static_cast<double>(site.border_m), static_cast<double>(site.road_m));
      colour = mixed(colour, grass, coverage(verge - from_edge, std::max(lattice_.gsd_m, 0.4)));
    }
    return snowed(colour, parcel.use == LandUse::kWood ? 0.6f : 0.9f, t);
  }

  Colour garden(const Site& site, const Colour& grass, float variety, const Textures& t) const {
    Colour colour = grass * (1 + 0.25f * variety);
    const float beds = 0.5f * t.growth + 0.5f * t.soil + 0.6f * t.texture + 0.8f * std::abs(variety);
    if (beds > 0.35f)
      colour = mixed(colour, variety > 0 ? kShrub : Colour(128, 108, 84, 120), std::min(0.75f, 1.5f * (beds - 0.35f)));
    if (site.border->road_width_m <= 0) {
      colour = mixed(colour, kShrub,
                     0.8f * coverage(0.7 + 0.3 * static_cast<double>(t.texture) - static_cast<double>(site.border_m),
                                     lattice_.gsd_m));
    }
    return colour;
  }

  Colour field(const Site& site, Point plan, float variety, const Textures& t) const {
    const Paint paint = field_paint(crop_in_year(*site.parcel, look_.year), look_.season);
    const bool headland = site.border_m < kHeadland_m;
    const double across = headland ? static_cast<double>(site.border_m) : site.parcel->row_normal.dot(plan);
    float value =
        1 + 0.22f * variety + paint.soil * t.soil + paint.growth * t.growth + 0.10f * t.sprout + 0.15f * t.texture;
    if (paint.pass_m > 0) {
      const auto pass = static_cast<double>(paint.pass_m);
      const uint64_t word = mix(site.parcel->key ^ static_cast<uint64_t>(floor_of(across / pass)));
      value += paint.pass * (static_cast<float>(unit(word)) * 2 - 1) * pass_share(pass);
    }
    if (paint.row_m > 0) {
      const double period = static_cast<double>(paint.row_m), phase = across / period;
      const double wave = 4 * std::abs(phase - static_cast<double>(floor_of(phase)) - 0.5) - 1;
      value += paint.row * static_cast<float>(wave * std::clamp(period / lattice_.gsd_m - 1, 0.0, 1.0));
    }
    Colour colour = paint.colour * value;
    // Growth changes the hue too: thin stands show the soil.
    const float thin = std::clamp(0.2f * t.growth - 0.15f * t.soil, -0.12f, 0.16f);
    colour[0] *= 1 + thin;
    colour[1] *= 1 + 0.55f * thin;
    colour[2] *= 1 + 0.3f * thin;
    if (paint.tramlines) colour = mixed(colour, Colour(138, 118, 88, 120), 0.6f * tramline(across));
    return colour;
  }

  /// Narrow stripes vanish in coarse pixels instead of aliasing.
  float pass_share(double pass_m) const {
    return static_cast<float>(std::clamp(pass_m / lattice_.gsd_m - 1, 0.0, 1.0));
  }

  /// A sprayer's two wheel tracks every 24 m.
  float tramline(double across) const {
    constexpr double kEvery_m = 24, kWheel_m = 0.9, kHalfWidth_m = 0.24;
    const double at = across - kEvery_m * static_cast<double>(floor_of(across / kEvery_m)) - kEvery_m / 2;
    const double inside = kHalfWidth_m - std::abs(std::abs(at) - kWheel_m);
    return coverage(inside, lattice_.gsd_m) * static_cast<float>(std::min(1.0, 2 * kHalfWidth_m / lattice_.gsd_m));
  }

  Colour with_yard(const Colour& colour, const Block& block, Point grid, const Textures& t) const {
    for (const Point& yard : block.yards) {
      const double inside = kYardRadius_m + 3 * static_cast<double>(t.texture) - cv::norm(grid - yard);
      if (inside > -lattice_.gsd_m) {
        return mixed(colour, snowed(kGravel * (0.9f + 0.12f * t.texture + 0.1f * t.soil), 0.5f, t),
                     coverage(inside, lattice_.gsd_m));
      }
    }
    return colour;
  }

  Colour with_water(const Colour& colour, Point grid, const Textures& t) const {
    if (layout_.lakes().empty()) return colour;
    const double shore = layout_.shore_distance_m(grid);
    if (shore > 4) return colour;
    const auto depth = static_cast<float>(std::clamp(-shore / 25, 0.0, 1.0));
    const Colour water = water_colour(look_.season) * (1.35f - 0.35f * depth + 0.05f * t.growth + 0.03f * t.texture);
    const Colour reeds = mixed(colour, Colour(128, 120, 78, 150) * (1 + 0.25f * t.texture), 0.7f);
    const Colour bank = mixed(colour, reeds, coverage(1.5 + static_cast<double>(t.growth) * 2 - shore, 2));
    return mixed(bank, water, coverage(-shore, lattice_.gsd_m));
  }

  std::pair<std::vector<Paving>, std::vector<Paving>> pave() const {
    const size_t pixels = static_cast<size_t>(lattice_.width) * lattice_.height;
    std::vector<Paving> gravel(pixels), asphalt(pixels);
    for (const Block& block : layout_.blocks()) {
      for (const Road& road : block.roads) {
        std::vector<Paving>& paving = road.kind == RoadKind::kTrack ? gravel : asphalt;
        double along = 0;
        for (size_t k = 0; k + 1 < road.line.size(); ++k) {
          pave_piece(paving, road, road.line[k], road.line[k + 1], along);
          along += cv::norm(road.line[k + 1] - road.line[k]);
        }
      }
    }
    for (const Block& block : layout_.blocks())
      for (size_t k = 0; k < 4; ++k)
        if (block.roundabout_m[k] > 0) pave_roundabout(asphalt, block.corners[k], block.roundabout_m[k]);
    return {gravel, asphalt};
  }

  /// A ring of asphalt about an island, over the roads that end there.
  void pave_roundabout(std::vector<Paving>& paving, Point corner, double radius_m) const {
    const std::array<Point, 1> centre = {layout_.plan().ground().grid_from_plan(corner)};
    lattice_.visit(bounds_of(centre).grown(radius_m + lattice_.gsd_m), [&](int x, int y, Point p) {
      const double away = cv::norm(p - centre[0]);
      const float ring = coverage(radius_m - away, lattice_.gsd_m);
      const float island = coverage(radius_m - std::max(6.0, 0.4 * radius_m) - away, lattice_.gsd_m);
      if (ring <= 0) return;
      Paving& here = paving[index(x, y)];
      here.road = nullptr;  // without markings
      here.coverage = std::max(here.coverage, ring) * (1 - island);
    });
  }

  void pave_piece(std::vector<Paving>& paving, const Road& road, Point a, Point b, double along_m) const {
    const std::array<Point, 2> ends = {a, b};
    const double length = cv::norm(b - a);
    const Point direction = (b - a) * (1 / length);
    lattice_.visit(bounds_of(ends).grown(road.width_m / 2 + lattice_.gsd_m), [&](int x, int y, Point p) {
      const double t = std::clamp(direction.dot(p - a), 0.0, length);
      const double away = cv::norm(p - a - direction * t);
      const float covered = coverage(road.width_m / 2 - away, lattice_.gsd_m);
      Paving& here = paving[index(x, y)];
      // Where roads overlap the one whose middle is nearer shows.
      const auto across = static_cast<float>(away);
      if (covered > here.coverage || (covered == here.coverage && covered > 0 && across < here.across_m)) {
        here = {covered, across, static_cast<float>(along_m + t), &road};
      }
    });
  }

  Colour with_roads(const Colour& colour, const Paving& gravel, const Paving& asphalt, const Textures& t) const {
    Colour out = colour;
    if (gravel.coverage > 0) {
      Colour track = kGravel * (0.95f + 0.10f * t.texture + 0.08f * t.soil);
      const float middle =
          coverage(0.4 + 0.15 * static_cast<double>(t.texture) - static_cast<double>(gravel.across_m), lattice_.gsd_m);
      track = mixed(track, grass_colour(look_.season), 0.6f * middle);
      out = mixed(out, snowed(track, 0.45f, t), gravel.coverage);
    }
    if (asphalt.coverage > 0) {
      Colour road = kAsphalt * (1 + 0.06f * t.texture + 0.10f * t.soil + 0.04f * t.sprout);
      if (asphalt.road != nullptr) road = with_markings(road, asphalt, t);
      out = mixed(out, snowed(road, 0.15f, t), asphalt.coverage);
    }
    return out;
  }

  /// Lines of paint on roads of two lanes and more, and the grass between two carriageways.
  Colour with_markings(const Colour& asphalt, const Paving& here, const Textures& t) const {
    const Road& road = *here.road;
    if (road.width_m <= 7) return asphalt;
    const Colour white(225, 225, 220, 200), yellow(225, 170, 60, 200);
    const auto across = static_cast<double>(here.across_m);
    const double middle = road.median_m > 0 ? across - road.median_m / 2 - 0.3 : across;
    const double edge = road.width_m / 2 - across - std::max(0.4, road.shoulder_m);
    const bool dash = here.along_m - 9 * std::floor(here.along_m / 9) < 4;
    const auto share = static_cast<float>(std::min(1.0, 0.16 / lattice_.gsd_m));
    const float at_edge = coverage(0.08 - std::abs(edge), lattice_.gsd_m);
    const bool painted = dash || road.yellow || road.median_m > 0;
    const float in_middle = painted ? coverage(0.08 - std::abs(middle), lattice_.gsd_m) : 0;
    Colour out = mixed(asphalt, white, share * std::max(at_edge, road.yellow ? 0 : in_middle));
    if (road.yellow) out = mixed(out, yellow, share * in_middle);
    if (road.median_m <= 0) return out;
    const Colour grass = grass_colour(look_.season) * (1 + 0.1f * t.texture);
    return mixed(out, grass, coverage(road.median_m / 2 - across, lattice_.gsd_m));
  }

  /// From the lowest to the highest, each over what lies below.
  void paint_objects() {
    std::vector<std::tuple<double, uint64_t, const Building*, const Tree*>> order;
    for (const Block& block : layout_.blocks()) {
      for (const Building& b : block.buildings) order.emplace_back(b.base_m + b.height_m, b.key, &b, nullptr);
    }
    for (const Tree& tree : trees_) order.emplace_back(tree.base_m + tree.height_m, tree.key, nullptr, &tree);
    std::ranges::sort(order);
    for (const auto& [top, object_key, building, tree] : order) {
      if (building != nullptr) {
        paint_building(*building);
      } else {
        paint_crown(*tree);
      }
    }
  }

  void lay(int x, int y, const Colour& colour, float light, float share) {
    colour_(y, x) = mixed(colour_(y, x), colour, share);
    light_(y, x) += (light - light_(y, x)) * share;
  }

  void paint_building(const Building& b) {
    constexpr double kApron_m = 1.6;
    const double reach = b.reach_m() + kApron_m + lattice_.gsd_m;
    const std::array<Point, 2> corners = {b.centre - Point(reach, reach), b.centre + Point(reach, reach)};
    const Colour roof = roof_colour(b) * static_cast<float>(0.9 + 0.25 * unit(mix(b.key + 1)));
    lattice_.visit(bounds_of(corners), [&](int x, int y, Point p) {
      const Point local = b.local(p);
      const double outside = b.outside_m(local);
      if (outside > kApron_m + lattice_.gsd_m) return;
      const Textures t{0, texture_.at(p.x, p.y), 0, 0};
      lay(x, y, snowed(kPaving * (1 + 0.1f * t.texture), 0.7f, t), ground_light(x, y),
          0.7f * coverage(kApron_m - outside, lattice_.gsd_m));
      const float share = coverage(-outside, lattice_.gsd_m);
      if (share <= 0) return;
      Point slope;
      b.roof_m(local, &slope);
      const Point grid_slope = b.axis * slope.x + Point(-b.axis.y, b.axis.x) * slope.y;
      const float light = light_on(static_cast<float>(grid_slope.x), static_cast<float>(grid_slope.y));
      lay(x, y, snowed(roof * (1 + 0.10f * t.texture), 0.85f, t), light, share);
    });
  }

  void paint_crown(const Tree& tree) {
    const double reach = tree.radius_m + lattice_.gsd_m;
    const std::array<Point, 2> corners = {tree.position - Point(reach, reach), tree.position + Point(reach, reach)};
    const Colour crown = crown_colour(tree, look_.season, static_cast<float>(unit(mix(tree.key))));
    const float opacity = crown_opacity(tree, look_.season);
    lattice_.visit(bounds_of(corners), [&](int x, int y, Point p) {
      const Point d = p - tree.position;
      const double away = cv::norm(d);
      const float share = coverage(tree.radius_m - away, lattice_.gsd_m);
      if (share <= 0) return;
      const Textures t{0, texture_.at(p.x, p.y), 0, 0};
      // Leaves turn every way: a crown is softer than a ball.
      const double steep = (tree.conifer ? 1.0 : 1.1 * std::min(away / tree.radius_m, 1.0)) / std::max(away, 0.3);
      const float light = light_on(static_cast<float>(-steep * d.x), static_cast<float>(-steep * d.y));
      lay(x, y, snowed(crown * (1 + 0.28f * t.texture), 0.2f, t), 0.3f + 0.7f * light, share * opacity);
    });
  }

  cv::Mat expose() const {
    const cv::Mat1f shade = shadows(surface_, look_.sun, lattice_.gsd_m, margin_);
    const int bands = look_.near_infrared ? 4 : 3;
    cv::Mat image(lattice_.height, lattice_.width, CV_8UC(bands));
    for (int y = 0; y < lattice_.height; ++y) {
      uint8_t* out = image.ptr(y);
      for (int x = 0; x < lattice_.width; ++x) {
        const float direct = light_(y, x) * (1 - shade(y, x));
        for (int band = 0; band < bands; ++band) {
          // Level ground in the sun has its own colour; shadows are lit by the sky alone and turn blue.
          const float sky = kAmbient * kSkyTint[band];
          const float value = kHaze[band] + 0.95f * colour_(y, x)[band] * (sky + (1 - sky) * direct);
          *out++ = static_cast<uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f));
        }
      }
    }
    return image;
  }

  const Lattice lattice_;
  const Look look_;
  const int margin_;
  const Lattice wide_;
  const Layout layout_;
  const std::vector<Tree> trees_;
  const Surface surface_;
  const Noise soil_, texture_, growth_, sprout_;
  cv::Mat_<Colour> colour_;
  cv::Mat1f light_;
  const float sun_east_, sun_north_;
};

}  // namespace

cv::Mat render_ortho(const Plan& plan, const Lattice& lattice, const Look& look) {
  return Painter(plan, lattice, look).paint();
}

Surface render_heights(const Plan& plan, const Lattice& lattice) {
  const Rectangle area = lattice.area().grown(kLargestCrown_m);
  const Layout layout(plan, area);
  return make_surface(layout, layout.trees(area), lattice, Season::kSummer);
}

}  // namespace landfix::synth

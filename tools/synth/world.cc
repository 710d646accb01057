#include "tools/synth/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "builder/error.h"
#include "tools/synth/render.h"

namespace landfix::synth {
namespace {

constexpr double kLineStep_m = 12;

double radians(double degrees) { return degrees * M_PI / 180; }

void expect(bool holds, const char* option, double value, const char* range) {
  if (holds) return;
  throw Error(ExitCode::kBadInput, fmt::format("synthetic world: {} is {}, expected {}; choose a value in that range",
                                               option, value, range));
}

Lattice lattice_of(const Window& w) {
  expect(w.gsd_m > 0 && std::isfinite(w.west_m) && std::isfinite(w.north_m), "window GSD", w.gsd_m, "metres above 0");
  expect(w.width > 0 && w.height > 0, "window size", std::min(w.width, w.height), "at least 1 pixel");
  return {std::llround(w.west_m / w.gsd_m), std::llround(w.north_m / w.gsd_m), w.width, w.height, w.gsd_m};
}

features::GridImage on_grid(const Lattice& lattice, const cv::Mat& pixels) {
  const Rectangle area = lattice.area();
  return {pixels, {}, area.west_m, area.north_m, lattice.gsd_m};
}

/// The polygon on the grid: its edges are bent, so they get points in between.
Outline grid_outline(const Ground& ground, const Outline& plan) {
  Outline grid;
  for (size_t k = 0; k < plan.size(); ++k) {
    const Point a = plan[k], b = plan[(k + 1) % plan.size()];
    const int steps = std::max(1, static_cast<int>(std::ceil(cv::norm(b - a) / kLineStep_m)));
    for (int s = 0; s < steps; ++s)
      grid.push_back(ground.grid_from_plan(a + (b - a) * (static_cast<double>(s) / steps)));
  }
  return grid;
}

}  // namespace

void check(const WorldOptions& o) {
  expect(o.zone >= 1 && o.zone <= 60, "zone", o.zone, "1 to 60");
  expect(o.west_m >= 100000 && o.west_m <= 900000, "easting", o.west_m, "100000 to 900000");
  expect(o.south_m >= 0 && o.south_m <= 9900000, "northing", o.south_m, "0 to 9900000");
  expect(o.size_m >= 10 && o.size_m <= 100000, "size_m", o.size_m, "10 to 100000");
  expect(o.gsd_m >= 0.05 && o.gsd_m <= 20, "gsd", o.gsd_m, "0.05 to 20");
  expect(o.dem_gsd_m >= 0.1 && o.dem_gsd_m <= 50, "dem-gsd", o.dem_gsd_m, "0.1 to 50");
  expect(o.size_m / o.gsd_m >= 1 && o.size_m / o.dem_gsd_m >= 1, "size_m", o.size_m, "at least one pixel");
  expect(o.year >= 1900 && o.year <= 2200, "year", o.year, "1900 to 2200");
  expect(std::abs(o.sun_azimuth_deg) <= 360, "sun azimuth", o.sun_azimuth_deg, "-360 to 360 degrees");
  expect(o.sun_elevation_deg >= 10 && o.sun_elevation_deg <= 90, "sun elevation", o.sun_elevation_deg,
         "10 to 90 degrees");
  expect(std::abs(o.base_height_m) <= 8000, "base height", o.base_height_m, "-8000 to 8000");
  expect(o.relief_m >= 0 && o.relief_m <= 300, "relief_m", o.relief_m, "0 to 300");
  if (o.snow && o.season != Season::kWinter) {
    throw Error(ExitCode::kBadInput,
                "synthetic world: snow in " + name_of(o.season) + "; choose the season winter for snow");
  }
}

World::World(const WorldOptions& options) : options_(options) {
  check(options);
  ground_ = std::make_unique<const Ground>(options.seed, options.base_height_m, options.relief_m);
  plan_ = std::make_unique<const Plan>(options.seed, *ground_, options.varied_roads);
}

World::~World() = default;

Rectangle World::extent() const {
  return {options_.west_m, options_.south_m, options_.west_m + options_.size_m, options_.south_m + options_.size_m};
}

features::GridImage World::ortho(const Window& window) const {
  const Lattice lattice = lattice_of(window);
  const Look look{options_.season,
                  options_.year,
                  options_.snow,
                  options_.near_infrared,
                  {radians(options_.sun_azimuth_deg), radians(options_.sun_elevation_deg)}};
  return on_grid(lattice, render_ortho(*plan_, lattice, look));
}

std::pair<features::GridImage, features::GridImage> World::heights(const Window& window) const {
  const Lattice lattice = lattice_of(window);
  const Surface surface = render_heights(*plan_, lattice);
  return {on_grid(lattice, surface.ground), on_grid(lattice, surface.top)};
}

features::GridImage World::dtm(const Window& window) const { return heights(window).first; }

features::GridImage World::dsm(const Window& window) const { return heights(window).second; }

Labels World::labels(const Rectangle& area) const {
  const Layout layout(*plan_, area);
  Labels labels;
  labels.trees = layout.trees(area);
  const auto touches = [&](const std::vector<Point>& points) { return bounds_of(points).touches(area); };
  for (const Block& block : layout.blocks()) {
    std::ranges::copy_if(block.buildings, std::back_inserter(labels.buildings),
                         [&](const Building& b) { return touches(b.outline()); });
    std::ranges::copy_if(block.roads, std::back_inserter(labels.roads), [&](const Road& r) { return touches(r.line); });
    std::ranges::copy_if(block.intersections, std::back_inserter(labels.intersections),
                         [&](const Intersection& i) { return area.contains(i.position); });
    for (const Parcel& parcel : block.parcels) {
      if (parcel.use != LandUse::kField) continue;
      Field field{grid_outline(*ground_, parcel.outline), crop_in_year(parcel, options_.year)};
      if (touches(field.outline)) labels.fields.push_back(std::move(field));
    }
  }
  std::ranges::copy_if(layout.lakes(), std::back_inserter(labels.water),
                       [&](const Lake& l) { return touches(l.outline()); });
  return labels;
}

}  // namespace landfix::synth

#include "tools/synth/surface.h"

#include "tools/synth/palette.h"

namespace landfix::synth {
namespace {

constexpr double kTallest_m = 20;      // of the objects
constexpr double kLargestSlope = 0.1;  // of the ground towards the sun, that shadows still cross
constexpr double kLongestShadow_m = 160;
constexpr float kContact_m = 0.12f;  // what is lower above a surface casts no shadow on it

void raise(Surface& surface, int x, int y, double top_m, float opacity) {
  const auto top = static_cast<float>(top_m);
  if (top <= surface.top(y, x)) return;
  surface.top(y, x) = top;
  surface.opacity(y, x) = opacity;
}

struct Step {
  ptrdiff_t offset;  // in pixels of the surface
  float rise_m;      // of the ray
};

std::vector<Step> steps_towards(const Sun& sun, double gsd_m, size_t stride) {
  const double east = std::sin(sun.azimuth_rad), north = std::cos(sun.azimuth_rad);
  const int count = static_cast<int>(shadow_reach_m(sun) / gsd_m);
  std::vector<Step> steps(count);
  for (int k = 1; k <= count; ++k) {
    const auto dx = static_cast<ptrdiff_t>(std::lround(k * east)), dy = -static_cast<ptrdiff_t>(std::lround(k * north));
    steps[k - 1] = {dy * static_cast<ptrdiff_t>(stride) + dx,
                    static_cast<float>(k * gsd_m * std::tan(sun.elevation_rad))};
  }
  return steps;
}

/// Blocked share of the ray from one pixel. It fades over the height that the ray gains per pixel: the tip of a shadow
/// moves smoothly when the object does.
float blocked(const float* top, const float* opacity, const std::vector<Step>& steps, float highest_m,
              float fade_per_m) {
  const float eye = *top + kContact_m;
  float share = 0;
  for (const Step& step : steps) {
    const float ray = eye + step.rise_m;
    if (ray > highest_m) break;
    const float above = top[step.offset] - ray;
    if (above <= 0) continue;
    share = std::max(share, std::min(1.0f, above * fade_per_m) * opacity[step.offset]);
    if (share > 0.96f) break;
  }
  return share;
}

}  // namespace

double crown_m(const Tree& tree, double away_m) {
  const double t = away_m / tree.radius_m;
  return tree.height_m * (tree.conifer ? 1 - 0.75 * t : 1 - 0.5 * t * t);
}

Surface make_surface(const Layout& layout, const std::vector<Tree>& trees, const Lattice& lattice, Season season) {
  Surface surface;
  surface.ground.create(lattice.height, lattice.width);
  for (int y = 0; y < lattice.height; ++y) {
    const std::span<float> row(surface.ground[y], static_cast<size_t>(lattice.width));
    layout.plan().ground().relief(lattice.row(y), row);
    layout.sink_lakes(lattice.row(y), row);
  }
  surface.top = surface.ground.clone();
  surface.opacity = cv::Mat1f::ones(lattice.height, lattice.width);
  for (const Block& block : layout.blocks()) {
    for (const Building& b : block.buildings) {
      const Point reach(b.reach_m(), b.reach_m());
      const std::array<Point, 2> corners = {b.centre - reach, b.centre + reach};
      lattice.visit(bounds_of(corners), [&](int x, int y, Point p) {
        const Point local = b.local(p);
        if (b.outside_m(local) <= 0) raise(surface, x, y, b.base_m + b.roof_m(local), 1);
      });
    }
  }
  for (const Tree& tree : trees) {
    const Point reach(tree.radius_m, tree.radius_m);
    const std::array<Point, 2> corners = {tree.position - reach, tree.position + reach};
    const float opacity = crown_opacity(tree, season);
    lattice.visit(bounds_of(corners), [&](int x, int y, Point p) {
      const double away = cv::norm(p - tree.position);
      if (away <= tree.radius_m) raise(surface, x, y, tree.base_m + crown_m(tree, away), opacity);
    });
  }
  return surface;
}

double shadow_reach_m(const Sun& sun) {
  return std::min(kLongestShadow_m, kTallest_m / std::max(std::tan(sun.elevation_rad) - kLargestSlope, 0.02));
}

cv::Mat1f shadows(const Surface& surface, const Sun& sun, double gsd_m, int margin) {
  const size_t stride = surface.top.step1();
  const std::vector<Step> steps = steps_towards(sun, gsd_m, stride);
  const int width = surface.top.cols - 2 * margin, height = surface.top.rows - 2 * margin;
  const auto fade_per_m = static_cast<float>(1 / (gsd_m * std::tan(sun.elevation_rad)));
  double highest = 0;
  cv::minMaxLoc(surface.top, nullptr, &highest);
  // One more pixel on each side, for the filter below.
  cv::Mat1f hard(height + 2, width + 2);
  for (int y = 0; y < hard.rows; ++y) {
    const float* top = surface.top[y + margin - 1] + margin - 1;
    const float* opacity = surface.opacity[y + margin - 1] + margin - 1;
    for (int x = 0; x < hard.cols; ++x) {
      hard(y, x) = blocked(top + x, opacity + x, steps, static_cast<float>(highest), fade_per_m);
    }
  }
  // A 1-2-1 filter: rays that go from pixel to pixel leave stairs along the sides of a shadow.
  cv::Mat1f soft(height, width);
  for (int y = 0; y < height; ++y) {
    const float *a = hard[y], *b = hard[y + 1], *c = hard[y + 2];
    for (int x = 0; x < width; ++x) {
      soft(y, x) =
          (a[x] + a[x + 2] + c[x] + c[x + 2] + 2 * (a[x + 1] + b[x] + b[x + 2] + c[x + 1]) + 4 * b[x + 1]) / 16;
    }
  }
  return soft;
}

}  // namespace landfix::synth

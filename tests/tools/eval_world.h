// A piece of a procedural world for the tests of the evaluation: seen in two seasons, as images in memory and as files.
#pragma once

#include <filesystem>
#include <string>

#include "builder/ingest/bounds.h"
#include "builder/ingest/window.h"
#include "tests/builder/ingest_fixture.h"
#include "tools/common/grid_image_io.h"
#include "tools/synth/world.h"

namespace landfix::eval {

inline const tiles::Zone kZone{33, true};
inline constexpr double kWestM = 500'000, kNorthM = 5'400'800, kSizeM = 800;

/// 800×800 pixels of 1 m, RGB, of the world with seed 5: in summer, or the year after in autumn under another sun.
inline features::GridImage ortho(synth::Season season, double size_m = kSizeM, double west_m = kWestM) {
  synth::WorldOptions o;
  o.seed = 5;
  o.season = season;
  if (season != synth::Season::kSummer) o.year = 2021, o.sun_azimuth_deg = 220, o.sun_elevation_deg = 35;
  return synth::World(o).ortho({west_m, kNorthM, int(size_m), int(size_m), 1});
}

inline const features::GridImage& summer() {
  static const features::GridImage image = ortho(synth::Season::kSummer);
  return image;
}
inline const features::GridImage& autumn() {
  static const features::GridImage image = ortho(synth::Season::kAutumn);
  return image;
}

/// A temporary folder per test, with helpers of the tests of builder/ingest.
class EvalTest : public ingest::Ingest {
 protected:
  std::string save(const std::string& name, const features::GridImage& image) const {
    tools::write_grid_image(path(name), image, kZone);
    return path(name);
  }
};

}  // namespace landfix::eval

// Ground to fly over in tests: random texture as a map in memory, and a camera that looks at it ray by ray.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "runtime/features/grid_image.h"
#include "runtime/nav/camera.h"
#include "runtime/nav/map_source.h"

namespace landfix::nav::testing {

/// Gray noise with structure from 1 to 32 pixels, the same for the same seed.
cv::Mat random_texture(int width, int height, uint64_t seed);

/// Random numbers of a test, the same on every machine.
class Random {
 public:
  explicit Random(uint64_t seed) : rng_(seed) {}
  double normal(double sigma) { return rng_.gaussian(sigma); }
  double uniform(double low, double high) { return rng_.uniform(low, high); }

 private:
  cv::RNG rng_;
};

/// A gray map of one image, its coarser levels by averaging, on ground of one height.
class ImageMap : public MapSource {
 public:
  ImageMap(const features::GridImage& finest, int levels, double ground_height_m);
  std::pair<double, double> gsd_range_m(MapLayer layer) const override;
  Status read(MapLayer layer, double west_m, double south_m, double east_m, double north_m, double gsd_m,
              features::GridImage& window) const override;
  std::optional<double> ground_height_m(double, double) const override { return ground_height_m_; }

 private:
  std::vector<features::GridImage> levels_;
  double ground_height_m_;
};

/// Where a camera stands.
struct Pose {
  double east_m = 0, north_m = 0, height_above_ground_m = 60;
  Attitude attitude;
};

/// What a camera sees of a ground image: every pixel's ray is cut with the ground plane (the test's own way round,
/// against the homography of the code) and the ground interpolated; 0 beyond the ground.
cv::Mat take_picture(const features::GridImage& ground, const Camera& camera, const Pose& pose);

}  // namespace landfix::nav::testing

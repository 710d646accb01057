// Ground to fly over in tests: random texture and fields through the seasons, and cameras that look at them.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "runtime/features/grid_image.h"
#include "runtime/nav/camera.h"
#include "runtime/nav/image_map.h"
#include "runtime/nav/matcher.h"

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

/// Fields, roofs and tracks of all sizes, in colour: `side_px` square. The same `seed` is the same place; another
/// `season` gives every one of them another colour, so that about half of all edges turn round, and adds some that are
/// there in that season only.
cv::Mat countryside(int side_px, uint64_t seed, uint64_t season = 0);

/// `pixels` as ground at 0.25 m around (0, 0).
features::GridImage ground_of(const cv::Mat& pixels);

/// Means of factor×factor pixels.
features::GridImage coarser(const features::GridImage& image, int factor);

/// A map of gray alone, on ground of one height.
class GrayMap : public ImageMap {
 public:
  GrayMap(const features::GridImage& finest, int levels, double ground_height_m)
      : ImageMap(finest, levels, ground_height_m, std::span(kMapLayers, 1)) {}
};

/// What a rectified image shows.
struct View {
  double east_m = 0, north_m = 0;  ///< true place of its middle, which is the patch's origin
  Similarity error = {};           ///< that was not known when it was rectified
  int side_px = 128;
  double gsd_m = 1;
};

/// A patch as `rectify` leaves it, each pixel the mean over the square that it covers on the ground. Ground beyond the
/// image is black.
features::GridImage look_down(const features::GridImage& ground, const View& view);

/// Where a camera stands.
struct Pose {
  double east_m = 0, north_m = 0, height_above_ground_m = 60;
  Attitude attitude;
};

/// What a camera sees of a ground image: every pixel's ray is cut with the ground plane (the test's own way round,
/// against the homography of the code) and the ground interpolated; 0 beyond the ground.
cv::Mat take_picture(const features::GridImage& ground, const Camera& camera, const Pose& pose);

}  // namespace landfix::nav::testing

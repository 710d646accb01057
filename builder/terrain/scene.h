// The ray-traced scene: an orthophoto draped over heights, and a camera that looks at it.
#pragma once

#include <optional>

#include "builder/terrain/surface.h"
#include "builder/terrain/texture.h"
#include "runtime/nav/camera.h"

namespace landfix::terrain {

/// Where a camera is: grid east and north, height above the ellipsoid, attitude relative to grid north.
struct Pose {
  double east_m = 0, north_m = 0, height_m = 0;
  nav::Attitude attitude;
};

/// What a camera sees.
struct Picture {
  cv::Mat image;  ///< CV_8UC1 or CV_8UC3 like the orthophoto; 0 where not valid
  cv::Mat valid;  ///< CV_8UC1, 255 where the pixel's ray hit ground with data
};

/// Immutable; safe to use from many threads.
class Scene {
 public:
  /// An orthophoto (CV_8UC1 or CV_8UC3) over a raster of ellipsoidal heights (CV_32FC1), both on the same grid. The
  /// raster need not match the orthophoto in extent or GSD; what lies outside either holds no data. Throws Error
  /// (kBadInput) where an image is empty or of another type.
  Scene(const features::GridImage& ortho, const features::GridImage& heights);

  /// The same over a flat plane, for places without a height model.
  Scene(const features::GridImage& ortho, double plane_height_m);

  /// The picture of a camera in a nadir mount, through its lens distortion: one ray per pixel through its centre,
  /// texture filtered to the size of the pixel on the ground, nearest gray value. No data where the distortion leads no
  /// ray to a pixel. Rows run in parallel; the result does not depend on their order.
  Picture render(const nav::Camera& camera, const Pose& pose) const;

  /// Height of the uppermost ground at a place; nothing where there are no heights.
  std::optional<double> height_below(double east_m, double north_m) const;

  const Texture& texture() const { return texture_; }
  const Surface& surface() const { return surface_; }

 private:
  void render_row(const nav::Camera& camera, const nav::Lens& lens, const Pose& pose, int row, Picture& picture) const;

  Texture texture_;
  Surface surface_;
};

}  // namespace landfix::terrain

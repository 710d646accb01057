// How well a view can be located at best, whatever matches it: the Cramér-Rao bound of its gray values.
#pragma once

#include <array>
#include <opencv2/core.hpp>

#include "runtime/features/grid_image.h"

namespace landfix::navigability {

/// Fisher information about the position of a view of one image in another one: gradients of the image, and the noise
/// that the two leave between them once gain and offset are fitted. Sums over rectangles take the same time for all.
class Information {
 public:
  /// `camera` and `map`: of one size, as nav::ImageMap takes them. Without pixels in `map` the noise is that of a
  /// camera alone.
  Information(const features::GridImage& camera, const features::GridImage& map);

  /// The least covariance of a fix in pixels squared, row-major over (east, north), of one that is known to lie within
  /// `search_px` to every side: (J + 3 / search_px² I)⁻¹ with J = Σ ∇I ∇Iᵀ / σ² (van Trees' bound; uniform before).
  /// What the images leave of `view` may be none of it.
  std::array<double, 4> least_covariance_px2(const cv::Rect& view, double search_px) const;

 private:
  enum Sum { kXX, kXY, kYY, kBoth, kCamera, kMap, kCameraCamera, kCameraMap, kMapMap, kSums };
  double noise_of(const cv::Rect& view) const;
  double sum(Sum which, const cv::Rect& r) const;

  std::array<cv::Mat, kSums> sums_;
};

/// `covariance` raised where it is below `least` in any direction; both row-major over (east, north).
std::array<double, 4> bounded_below(const std::array<double, 4>& covariance, const std::array<double, 4>& least);

}  // namespace landfix::navigability

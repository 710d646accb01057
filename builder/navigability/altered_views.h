// What a camera may see one day of ground that the sources show on a single date.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>

#include "builder/random.h"
#include "runtime/features/grid_image.h"

namespace landfix::navigability {

/// Draws views of a place as another day may show it. Every field has another tone and the texture of other ground;
/// what lies between fields stays. Shadows fall elsewhere, the camera is exposed otherwise, has noise, and is turned
/// and scaled by more or less than believed; what heights shift is made good with those of where it believes itself.
class AlteredViews {
 public:
  /// `image`: gray or red, green and blue, as nav::ImageMap takes it. `heights`: above the ellipsoid in metres,
  /// CV_32FC1 of the same grid; without pixels the ground is flat.
  explicit AlteredViews(const features::GridImage& image, const features::GridImage& heights = {});

  /// What is drawn: a square around a corner of pixels.
  struct View {
    cv::Point corner;
    int half_px = 0;           ///< half of its side
    double altitude_m = 0;     ///< of the camera above ground: how much heights shift what is seen
    double place_sigma_m = 0;  ///< how far away heights are taken from
  };

  /// The same for the same seed. Nothing is valid where the image does not reach; west and north are relative to the
  /// corner.
  features::GridImage draw(const View& view, uint64_t seed) const;

 private:
  struct Change;
  struct Day;

  Day day_of(Random& random) const;
  cv::Vec3f on_day(const cv::Point& at, const Day& day) const;
  std::optional<cv::Vec3f> between(const cv::Point2d& at, const Day& day) const;
  std::optional<double> height_at(const cv::Point2d& at) const;

  features::GridImage image_, heights_;
  cv::Mat fields_;  ///< CV_32S: number of the field that a pixel lies in, 0: none
  cv::Mat means_;   ///< CV_32FC(bands): of the field
  cv::Mat shadow_;  ///< CV_32F: share of the light that is missing there
  int field_count_ = 0;
};

}  // namespace landfix::navigability

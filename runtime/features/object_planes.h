// What tells roofs, crowns, water and pavement from open ground at one pixel: numbers that neither turning nor
// mirroring of the image nor the brightness of the light changes.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace landfix::features {

inline constexpr int kObjectPlanesGray = 36;
inline constexpr int kObjectPlanesColour = kObjectPlanesGray + 16;
/// Pixels around one that its numbers depend on.
inline constexpr int kObjectReach_px = 44;

/// Where single planes lie in the list.
enum ObjectPlane : int {
  kPlaneTone = 0,        ///< logarithm of the luminance against its surroundings of 61 pixels
  kPlaneTone3 = 1,       ///< the same, mean of 3 x 3 pixels
  kPlaneGradient = 11,   ///< its gradient, mean of 3 x 3 pixels
  kPlaneDark = 25,       ///< share of dark pixels in 7 x 7
  kPlaneRedGreen = 36,   ///< logarithm of red over green, mean of 3 x 3 pixels
  kPlaneBlueYellow = 44  ///< logarithm of blue over the root of red times green
};

/// The gradient of the tone with the angle fourfold, so that both directions of a right angle agree: length times
/// cosine and sine of four times the angle. CV_16SC1 each.
struct FourfoldGradient {
  cv::Mat cosine, sine, length;
};

/// Planes (CV_8UC1 of the image's size) of an image of one metre per pixel, CV_8UC1 or CV_8UC3 (red, green, blue);
/// kObjectPlanesGray or kObjectPlanesColour of them. Where `valid` (CV_8UC1, 0: no data; empty: all valid) is 0 the
/// tone is that of the surroundings. A pixel's numbers depend on those within kObjectReach_px alone, to the last bit.
void object_planes(const cv::Mat& image, const cv::Mat& valid, std::vector<cv::Mat>& planes,
                   FourfoldGradient& gradient);

}  // namespace landfix::features

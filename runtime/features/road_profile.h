// What the ground across a possible road looks like, in numbers that mirroring and turning the image leave as they are.
#pragma once

#include <array>
#include <opencv2/core.hpp>

namespace landfix::features {

inline constexpr int kRoadProfileFeatures = 165;
inline constexpr int kRoadProfileHaloPx = 21;
using RoadProfile = std::array<float, kRoadProfileFeatures>;

/// Describes the place (x, y) of `bands` (CV_32FC4 of road_bands(), mirrored beyond its border; the centre of the first
/// pixel is (0, 0)) for a line of direction `theta_rad`: from a patch turned to it, 28 pixels along (Hann window) and
/// 24 across, the difference of colour, luma and chroma to the centre, its gradient, its scatter along and whether it
/// is the same in both halves of the patch, at ten distances as the lesser and the greater of both sides; the same of
/// the hue where it tells something; the yellow of a middle line (the cue of DeAngelo 2016 eq. 2, as far as it is left
/// at a metre per pixel); width and response of the strips that road_response() would choose. No absolute brightness or
/// colour. Returns the width of that strip in pixels.
float road_profile(const cv::Mat& bands, double x, double y, float theta_rad, RoadProfile& profile);

}  // namespace landfix::features

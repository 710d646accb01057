// Where a road may run: an oriented filter for bands of even brightness and colour that differ from both of their
// sides.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace landfix::features {

inline constexpr int kRoadDirections = 16;            ///< steps of pi / 16, clockwise from the rows (y runs down)
inline constexpr float kRoadResponse = 0.65f;         ///< weakest response of a candidate
inline constexpr int kRoadCandidateHaloPx = 28;       ///< a candidate depends on the square of this many pixels around
inline constexpr int kRoadReach[] = {1, 2, 3, 4, 6};  ///< half widths: strips of 3, 5, 7, 9 and 13 pixels
inline constexpr int kRoadWidths = 5;

/// A pixel that may lie on a road's centreline.
struct RoadCandidate {
  int x = 0, y = 0;     ///< pixel
  float theta_rad = 0;  ///< direction of the line in [0, pi), from x towards y
  float response = 0;   ///< smoothed
};

/// What the filter compares: luma Y of BT.601, 0.7 (R - G), 0.7 ((R + G) / 2 - B), and a hue that shade leaves nearly
/// as it is: 300 (R - G - 0.45 ((R + G) / 2 - B)) / (R + G + B + 24), where 0.45 is the way of sunlight to skylight.
/// `image`: CV_8UC1 or CV_8UC3 (red, green, blue); `bands`: CV_32FC4, for gray all but the first are 0. Throws
/// cv::Exception for other types.
void road_bands(const cv::Mat& image, cv::Mat& bands);

/// Response of the filter, the greatest over directions and widths. Bands are averaged along a Hann window of +-10
/// pixels (every second one), and over strips across: m of the strip, p and n of the three pixels on its sides, l and r
/// of its own halves. Then R = (min(|p - m|, |n - m|) - |r - l|) / (sqrt(V) + 2) with the variance V along the window,
/// summed over bands and averaged over the strip: once over the first three bands and once over the hue, which finds
/// roads that shadows cross. The greater counts. `response`: CV_32FC1, `direction`: CV_8UC1 (steps of pi / 16). Beyond
/// the border the image is mirrored.
void road_response(const cv::Mat& bands, cv::Mat& response, cv::Mat& direction);

/// Pixels whose response, smoothed (sigma 0.7), is at least kRoadResponse and the greatest among the four neighbours
/// across, in the order of rows. Directions are those of the filter, turned to the least-squares line through the
/// candidates of like direction within 7 pixels, by 0.25 rad at most. `valid`: CV_8UC1 or empty (all valid): candidates
/// have only valid pixels within 10 pixels of them.
std::vector<RoadCandidate> road_candidates(const cv::Mat& bands, const cv::Mat& valid);

}  // namespace landfix::features

// Orientation in five levels a channel, and how five bit planes hold it in the tiles of the layer `orientation`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

namespace landfix::features {

inline constexpr int kOrientationPlanes = 5;
inline constexpr float kWeakOrientation = 0.1f;    ///< a component beyond it is ±1
inline constexpr float kStrongOrientation = 0.3f;  ///< and beyond this ±2

/// Rounds orientation to five levels. `ab`: H×W CV_32FC2; `levels`: H×W CV_8SC2, −2 to 2.
void orientation_levels(const cv::Mat& ab, cv::Mat& levels);

/// Levels as bit planes (schemas/FORMAT.md section 3.5): 25 pairs of levels and "no data" in five bits.
///   plane 0      0: neither a nor b is 0      1: at least one of them is 0
///   plane 1      |a| = 2                      both are 0
///   plane 2      |b| = 2                      the other's magnitude is 2
///   plane 3      a < 0                        the other is < 0
///   plane 4      b < 0                        the other is b
/// All planes set: no data. `levels`: H×W CV_8SC2; `valid`: CV_8UC1, empty: all valid. `planes`: CV_8UC1, 5·H rows of
/// 8·⌈W/64⌉ bytes, plane below plane; column x is bit x mod 64 of little-endian word x / 64; the bits that fill the
/// last word are set. Throws cv::Exception for other types.
void pack_orientation(const cv::Mat& levels, const cv::Mat& valid, cv::Mat& planes);

/// The way back, from planes as lf_read_bits leaves them. `levels`: `size` CV_8SC2, 0 without data; `valid`: CV_8UC1,
/// 255 or 0.
void unpack_orientation(const uint64_t* words, size_t row_words, size_t plane_words, cv::Size size, cv::Mat& levels,
                        cv::Mat& valid);

}  // namespace landfix::features

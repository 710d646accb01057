// Draws the orthophoto of a window: ground, roads, roofs and crowns in the light of the sun.
#pragma once

#include "tools/synth/palette.h"
#include "tools/synth/surface.h"

namespace landfix::synth {

/// When and how the picture is taken.
struct Look {
  Season season = Season::kSummer;
  int year = 2020;
  bool snow = false;
  bool near_infrared = false;  ///< a fourth band
  Sun sun;
};

/// 8-bit image, channels red, green, blue and, on wish, near infrared.
cv::Mat render_ortho(const Plan& plan, const Lattice& lattice, const Look& look);

/// Heights of ground and of all that stands on it, CV_32FC1.
Surface render_heights(const Plan& plan, const Lattice& lattice);

}  // namespace landfix::synth

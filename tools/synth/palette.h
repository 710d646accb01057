// The colours of the world by season: crops in their stages, grass, leaves, roads, roofs, water.
#pragma once

#include <opencv2/core.hpp>

#include "tools/synth/layout.h"
#include "tools/synth/season.h"

namespace landfix::synth {

/// Red, green, blue and near infrared, each 0 to 255.
using Colour = cv::Vec4f;

/// How a field looks: colour, what the soil and the growth do to it, and what the machines left.
struct Paint {
  Colour colour;
  float soil = 0;    ///< contrast of the soil's lasting patches; negative where good soil looks darker (dense crop)
  float growth = 0;  ///< contrast of this season's own patches
  float row_m = 0;   ///< spacing of rows, 0 for none
  float row = 0;     ///< their contrast
  float pass_m = 0;  ///< width of one pass of the machine, 0 for none
  float pass = 0;    ///< contrast between passes
  bool tramlines = false;
};

/// What grows on a parcel in a year: permanent crops stay, the others follow a rotation.
Crop crop_in_year(const Parcel& parcel, int year);
Paint field_paint(Crop crop, Season season);

Colour grass_colour(Season season);
Colour water_colour(Season season);
/// `variety` in [0, 1) tells one tree from another.
Colour crown_colour(const Tree& tree, Season season, float variety);
/// Share of the light that a crown holds back.
float crown_opacity(const Tree& tree, Season season);
Colour roof_colour(const Building& building);
inline const Colour kAsphalt{124, 123, 124, 105}, kGravel{184, 170, 144, 165}, kPaving{160, 154, 146, 140};
inline const Colour kForestFloor{84, 80, 56, 110}, kShrub{62, 84, 46, 150}, kSnow{236, 239, 244, 215};

}  // namespace landfix::synth

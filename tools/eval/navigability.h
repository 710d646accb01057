// What a map says beforehand about its places, against what registration then does there.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "landfix/landfix.hpp"
#include "tools/common/navigability_map.h"
#include "tools/eval/texture.h"
#include "tools/eval/trial.h"

namespace landfix::eval {

/// A registration, and what the map had said of its place.
struct Foreseen {
  Trial trial;
  tools::NavigabilityMap::Expected expected;
  std::optional<double> age_years;  ///< of the map when the camera's image was taken; the chance is for this age
  /// By kTextureNames, of the map's gray values in the template's square; absent where the map has no gray there.
  std::optional<std::array<double, kTextures>> textures;

  /// Per axis, in the mean: root of half of the covariance's trace.
  double sigma_m() const;
  /// For the statistics: `probability` and `in_ellipse` are of what was foreseen, and every sample is answered.
  Sample sample() const;
};

/// What is asked beforehand.
struct Foresight {
  const Pack& pack;
  const tools::NavigabilityMap& navigability;
  tiles::Finder finder;
  double template_m = 160;
  double gsd_m = 1;               ///< of the gray values that are looked at
  std::optional<int> camera_day;  ///< days since 1970-01-01; absent: chances hold for a map of the usual age
};

/// Of the places that the map says something about; the others are left out.
std::vector<Foreseen> foresee(std::span<const Trial> trials, const Foresight& foresight);

/// The first date in a file's name, "2018-07-16" from "m_4709963_20180716.tif" as well as from "2018-07-16.tif" or
/// "2018_07_16.tif", of the years 1900 to 2099; empty where there is none.
std::string date_in_name(const std::string& name);

/// The matcher of the evaluation as the layers know it.
tiles::Finder finder_of(const MatcherChoice& matcher);

}  // namespace landfix::eval

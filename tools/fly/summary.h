// What a flight comes to: errors, honesty of the covariance, and dead reckoning beside it.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "tools/fly/flight.h"

namespace landfix::fly {

/// Over the images after GNSS was cut, of one flight or of several together.
struct Summary {
  size_t flights = 0, images = 0;
  size_t fixes = 0;           ///< images that the localizer took in
  double rms_m = 0;           ///< horizontal distance of estimate and truth
  double percentile95_m = 0;  ///< smallest error that 95 % of the images do not exceed
  double max_m = 0;
  double inside_3_sigma = 0;          ///< share of images with the truth inside the 3-sigma ellipse
  double final_m = 0;                 ///< error at the end (several flights: root mean square)
  double distance_m = 0;              ///< flown without GNSS (mean)
  double dead_reckoning_final_m = 0;  ///< error of odometry alone at the end (several flights: root mean square)
  double dead_reckoning_max_m = 0;
  double mean_update_s = 0, median_update_s = 0;  ///< processing time of an update
};

/// Horizontal error of the estimate and of dead reckoning, metres.
double error_m(const Record& record);
double dead_reckoning_error_m(const Record& record);
/// Whether the truth lies inside the 3-sigma ellipse of the estimate.
bool inside_3_sigma(const Record& record);

/// Throws Error (kBadInput) where no flight has an image after the cut.
Summary summarize(const std::vector<std::vector<Record>>& flights);

nlohmann::json to_json(const Summary& summary);

}  // namespace landfix::fly

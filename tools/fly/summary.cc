#include "tools/fly/summary.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "builder/error.h"

namespace landfix::fly {

double error_m(const Record& r) {
  return std::hypot(r.estimate.east_m - r.truth.east_m, r.estimate.north_m - r.truth.north_m);
}

double dead_reckoning_error_m(const Record& r) {
  return std::hypot(r.dead_reckoning_east_m - r.truth.east_m, r.dead_reckoning_north_m - r.truth.north_m);
}

bool inside_3_sigma(const Record& r) {
  const double e = r.estimate.east_m - r.truth.east_m, n = r.estimate.north_m - r.truth.north_m;
  const auto& c = r.estimate.covariance_m2;
  // e' C^-1 e <= 9, multiplied by the determinant.
  const double determinant = c[0] * c[3] - c[1] * c[2];
  return determinant > 0 && c[3] * e * e - (c[1] + c[2]) * e * n + c[0] * n * n <= 9 * determinant;
}

Summary summarize(const std::vector<std::vector<Record>>& flights) {
  Summary s;
  std::vector<double> errors, updates_s;
  double squares = 0, inside = 0, final_squares = 0, dead_reckoning_squares = 0;
  for (const auto& records : flights) {
    const auto cut = std::find_if(records.begin(), records.end(), [](const Record& r) { return !r.gnss; });
    if (cut == records.end()) continue;
    ++s.flights;
    for (auto r = cut; r != records.end(); ++r) {
      errors.push_back(error_m(*r));
      squares += errors.back() * errors.back();
      inside += inside_3_sigma(*r);
      s.fixes += r->fix.status == nav::Status::kOk;
      updates_s.push_back(r->fix.processing_time_s);
      s.dead_reckoning_max_m = std::max(s.dead_reckoning_max_m, dead_reckoning_error_m(*r));
    }
    final_squares += std::pow(error_m(records.back()), 2);
    dead_reckoning_squares += std::pow(dead_reckoning_error_m(records.back()), 2);
    s.distance_m += records.back().distance_m - cut->distance_m;
  }
  if (errors.empty()) {
    throw Error(ExitCode::kBadInput,
                "flight: it ends before GNSS is cut; choose a smaller --gnss-until or a longer route");
  }
  const double count = double(errors.size()), flown = double(s.flights);
  s.images = errors.size();
  s.rms_m = std::sqrt(squares / count);
  std::sort(errors.begin(), errors.end());
  s.percentile95_m = errors[size_t(std::ceil(0.95 * count)) - 1];
  s.max_m = errors.back();
  s.inside_3_sigma = inside / count;
  s.final_m = std::sqrt(final_squares / flown);
  s.dead_reckoning_final_m = std::sqrt(dead_reckoning_squares / flown);
  s.distance_m /= flown;
  s.mean_update_s = std::accumulate(updates_s.begin(), updates_s.end(), 0.0) / count;
  const auto middle = updates_s.begin() + std::ptrdiff_t(updates_s.size() / 2);
  std::nth_element(updates_s.begin(), middle, updates_s.end());
  s.median_update_s = *middle;
  return s;
}

nlohmann::json to_json(const Summary& s) {
  return {{"flights", s.flights},
          {"images", s.images},
          {"fixes", s.fixes},
          {"rms_m", s.rms_m},
          {"percentile_95_m", s.percentile95_m},
          {"max_m", s.max_m},
          {"share_inside_3_sigma", s.inside_3_sigma},
          {"final_error_m", s.final_m},
          {"distance_without_gnss_m", s.distance_m},
          {"dead_reckoning_final_error_m", s.dead_reckoning_final_m},
          {"dead_reckoning_max_error_m", s.dead_reckoning_max_m},
          {"mean_update_ms", 1000 * s.mean_update_s},
          {"median_update_ms", 1000 * s.median_update_s}};
}

}  // namespace landfix::fly

#include "runtime/nav/localizer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "runtime/nav/likelihood.h"
#include "runtime/nav/rectify.h"
#include "runtime/nav/terrain.h"

namespace landfix::nav {
namespace {

constexpr int kMinTemplatePx =
    32;  ///< no coarser level is taken for the sake of a wide search if it made the template smaller
constexpr double kFinerThanCamera = 0.7;  ///< a map level may be finer than the camera by this factor
constexpr double kAttitudeSearchSigmas = 4;
constexpr double kNegligiblePx =
    2;  ///< by which a wrong heading or height may move the patch's rim: features are wider
constexpr double kMaxReliefPx = 256;  ///< heights from the middle of the view to its side

bool valid(const LocalizerOptions& o) {
  for (double v : {o.attitude_sigma_rad, o.attitude_bias_sigma_rad, o.map_bias_sigma_m, o.change_sigma_m,
                   o.orientation_sigma_px, o.heading_sigma_rad, o.height_sigma_m, o.independent_fraction})
    if (!(v >= 0 && std::isfinite(v))) return false;
  return o.min_pixels_per_residual > 0 && o.outlier_probability > 0 && o.outlier_probability <= 1 &&
         o.min_coverage > 0 && o.min_coverage <= 1 && o.search_tail_probability > 0 &&
         o.search_tail_probability < 0.5 && o.min_search_px >= 0 && o.max_template_px >= kMinTemplatePx &&
         o.max_window_px >= o.max_template_px + 2 * o.min_search_px;
}

RegistrationOptions registration_options(const LocalizerOptions& o) {
  RegistrationOptions r;
  r.method = o.method;
  r.gate = o.gate;
  r.min_coverage = o.min_coverage;
  r.max_window_px = o.max_window_px;
  r.outlier_probability = o.outlier_probability;
  return r;
}

/// Heights averaged over a Gaussian, of the known ones; NaN where they are not known.
void blur(double sigma_px, cv::Mat& heights) {
  const cv::Mat known = heights == heights;
  cv::Mat share;
  known.convertTo(share, CV_32F, 1.0 / 255);
  heights.setTo(0, ~known);
  for (cv::Mat* m : {&heights, &share}) cv::GaussianBlur(*m, *m, {}, sigma_px, sigma_px, cv::BORDER_REPLICATE);
  cv::divide(heights, share, heights);
  heights.setTo(std::numeric_limits<float>::quiet_NaN(), ~known);
}

/// Mean of the known heights in the middle half: not that of the one tree or roof below the filter's mean.
std::optional<double> mean_of_middle(const cv::Mat& heights) {
  const cv::Rect middle(heights.cols / 4, heights.rows / 4, (heights.cols + 1) / 2, (heights.rows + 1) / 2);
  const cv::Mat inner = heights(middle), known = inner == inner;
  return cv::countNonZero(known) ? std::optional(cv::mean(inner, known)[0]) : std::nullopt;
}

/// Positions to be tried: what the filter believes, widened by what the attitude shifts.
struct Search {
  PointMassFilter::Bounds region;
  double gsd_m;
  bool whole;  ///< false if the region had to be cut to fit the largest window
};

}  // namespace

struct Localizer::State {
  State(const MapSource& source, const LocalizerOptions& o)
      : map(source), options(o), filter(o.filter), registrar(source, registration_options(o)) {}

  Status take(const cv::Mat& image, const Camera& camera, const Attitude& attitude, double height_m, Fix& fix);
  std::pair<double, double> gsd_range_m() const;
  Status survey(const Camera& camera, const Attitude& attitude, double height_m);
  Status choose_search(const Camera& camera, const Attitude& attitude, double height_above_ground_m,
                       Search& search) const;
  Status check_age(const Search& search, Fix& fix) const;
  Status match(const Search& search, double height_above_ground_m);
  void describe(Fix& fix) const;
  /// One sigma per axis of what roll and pitch shift on the ground, `share` of the white noise's variance counted.
  double attitude_error_m(double height_above_ground_m, double share = 1) const {
    return std::hypot(options.attitude_sigma_rad * std::sqrt(share), options.attitude_bias_sigma_rad) *
           height_above_ground_m;
  }
  /// Adds what no number of images averages away.
  void add_bias(double height_above_ground_m, double change_m2, std::array<double, 4>& covariance) const {
    const double tilt_m = options.attitude_bias_sigma_rad * height_above_ground_m;
    const double variance = tilt_m * tilt_m + options.map_bias_sigma_m * options.map_bias_sigma_m + change_m2;
    covariance[0] += variance;
    covariance[3] += variance;
  }
  /// From the correlation surface to the likelihood that the filter takes in, and the record of the image.
  Status weigh(const Search& search, double height_above_ground_m, Fix& fix);
  double change_error_m() const {
    if (registration.method == Method::kOrientation) return options.orientation_sigma_px * registration.gsd_m;
    return options.change_sigma_m * (1 - std::clamp(registration.peak.value, 0.0, 1.0));
  }

  const MapSource& map;
  LocalizerOptions options;
  PointMassFilter filter;
  Registrar registrar;
  Registration registration;
  Terrain terrain;  ///< under the view
  features::GridImage patch;
  Likelihood likelihood;
  bool matched_before = false;  ///< since the start
  double flown_since_match_m = 0;
  double last_height_m = 0;       ///< above ground, at the last match
  double change_variance_m2 = 0;  ///< per axis, of the images that made the estimate
};

/// Of the layer that is matched first.
std::pair<double, double> Localizer::State::gsd_range_m() const {
  if (options.method) return map.gsd_range_m(layer_of(*options.method));
  for (const MapLayer layer : {MapLayer::kOrientation, MapLayer::kGray, MapLayer::kEdge, MapLayer::kContour})
    if (const std::pair<double, double> range = map.gsd_range_m(layer); range.first > 0) return range;
  return {0, 0};
}

/// The ground that the camera looks at from where the filter believes it to be. How far that is off decides how much of
/// the relief may be used: heights in the wrong place would print their own edges into the patch, always where the map
/// has them if the belief were right, and so confirm it. Their mean over the possible places is what is known of the
/// height at a point, and it has no such edges. Where the uncertainty is as large as the view, nothing but the mean
/// height of the ground is left.
Status Localizer::State::survey(const Camera& camera, const Attitude& attitude, double height_m) {
  const PointMassFilter::Moments now = filter.moments();
  const std::optional<double> below = map.ground_height_m(now.east_m, now.north_m);
  if (!below || !std::isfinite(*below)) return Status::kNoGroundHeight;
  terrain = {{}, *below};
  const double above_m = height_m - *below;
  cv::Point2d reach_m;
  if (const Status s = footprint_reach(camera, attitude, above_m, reach_m); s != Status::kOk) return s;
  const double position_m = std::sqrt(std::max(now.covariance_m2[0], now.covariance_m2[3]));
  const double view_m = std::max(reach_m.x, reach_m.y);
  const bool relief = position_m <= view_m;
  const double sigma_m = relief ? std::hypot(position_m, attitude_error_m(above_m)) : 0;
  const double gsd_m = std::max({0.5 * sigma_m, above_m / std::max(camera.fx, camera.fy), view_m / kMaxReliefPx});
  const double x = reach_m.x + 2 * sigma_m, y = reach_m.y + 2 * sigma_m;
  features::GridImage heights;
  const Status s = map.read_heights(now.east_m - x, now.north_m - y, now.east_m + x, now.north_m + y, gsd_m, heights);
  if (s != Status::kOk) return s == Status::kNoLayer || s == Status::kOutsideMap ? Status::kOk : s;
  const std::optional<double> mean_m = mean_of_middle(heights.pixels);
  if (mean_m && *mean_m < height_m) terrain.plane_height_m = *mean_m;
  if (!mean_m || !relief) return Status::kOk;
  blur(sigma_m / heights.gsd_m, heights.pixels);
  terrain.heights = heights;
  return Status::kOk;
}

/// The finest level that serves the camera and keeps template and window within their limits.
Status Localizer::State::choose_search(const Camera& camera, const Attitude& attitude, double height_above_ground_m,
                                       Search& search) const {
  cv::Point2d reach_m;
  if (const Status s = footprint_reach(camera, attitude, height_above_ground_m, reach_m); s != Status::kOk) return s;
  const auto [finest, coarsest] = gsd_range_m();
  if (!(finest > 0 && coarsest >= finest)) return Status::kNoLayer;
  const double template_m = 2 * std::max(reach_m.x, reach_m.y),
               camera_gsd_m = height_above_ground_m / std::max(camera.fx, camera.fy);
  const PointMassFilter::Bounds b = filter.bounds(options.search_tail_probability);
  const double margin_m = kAttitudeSearchSigmas * attitude_error_m(height_above_ground_m);
  const double search_m = std::max(b.east_m - b.west_m, b.north_m - b.south_m) + 2 * margin_m;
  double gsd = finest;
  while (2 * gsd <= coarsest) {
    const bool too_fine = gsd < kFinerThanCamera * camera_gsd_m || template_m > options.max_template_px * gsd;
    const bool too_wide = search_m + template_m > options.max_window_px * gsd && template_m > 2 * kMinTemplatePx * gsd;
    if (!too_fine && !too_wide) break;
    gsd *= 2;
  }
  const double east = 0.5 * (b.west_m + b.east_m), north = 0.5 * (b.south_m + b.north_m);
  const double least = options.min_search_px * gsd, most = 0.5 * (options.max_window_px * gsd - template_m) - gsd;
  if (most < least) return Status::kTooLarge;
  const double x = std::max(0.5 * (b.east_m - b.west_m) + margin_m, least),
               y = std::max(0.5 * (b.north_m - b.south_m) + margin_m, least);
  search.whole = std::max(x, y) <= most;
  search.region = {east - std::min(x, most), north - std::min(y, most), east + std::min(x, most),
                   north + std::min(y, most)};
  search.gsd_m = gsd;
  return Status::kOk;
}

/// Refuses a map that is too old for the policy. Without a policy the age is told where it is known. What counts is the
/// ground that the patch may show, which need not be that below the aircraft.
Status Localizer::State::check_age(const Search& search, Fix& fix) const {
  const PointMassFilter::Bounds& r = search.region;
  const double patch_east_m = patch.west_m + patch.pixels.cols * patch.gsd_m,
               patch_south_m = patch.north_m - patch.pixels.rows * patch.gsd_m;
  const std::optional<CaptureDays> days = map.capture_days(r.west_m + patch.west_m, r.south_m + patch_south_m,
                                                           r.east_m + patch_east_m, r.north_m + patch.north_m);
  if (days && options.today) fix.map_age_days = *options.today - days->oldest;
  if (!options.max_map_age_days) return Status::kOk;
  return fix.map_age_days && *fix.map_age_days <= *options.max_map_age_days ? Status::kOk : Status::kMapTooOld;
}

Status Localizer::State::match(const Search& search, double height_above_ground_m) {
  const PointMassFilter::Bounds& r = search.region;
  RegistrationPrior prior;
  prior.east_m = 0.5 * (r.west_m + r.east_m);
  prior.north_m = 0.5 * (r.south_m + r.north_m);
  const double x = 0.5 * (r.east_m - r.west_m) / prior.sigmas, y = 0.5 * (r.north_m - r.south_m) / prior.sigmas;
  prior.covariance_m2 = {x * x, 0, 0, y * y};
  const double negligible = 2 * kNegligiblePx / std::max(patch.pixels.cols, patch.pixels.rows),
               scale_sigma = options.height_sigma_m / height_above_ground_m;
  if (options.heading_sigma_rad > negligible) prior.heading_sigma_rad = options.heading_sigma_rad;
  if (scale_sigma > negligible) prior.scale_sigma = scale_sigma;
  registrar.run(patch, prior, registration);
  return registration.status;
}

Status Localizer::State::weigh(const Search& search, double above_m, Fix& fix) {
  const double pixels = cv::countNonZero(patch.valid), side_m = std::sqrt(pixels) * search.gsd_m;
  const double independent_m = options.independent_fraction * side_m;
  fix.weight = matched_before && flown_since_match_m < independent_m ? flown_since_match_m / independent_m : 1;
  const double change_m = change_error_m();
  // The attitude's white noise is new in every image, however much of the ground is not: of its variance only as much
  // may count as the tempering, which divides by the weight, restores. Half a cell and half a pixel: no peak may be
  // narrower than what either grid can show.
  const double sigma_m = std::hypot(std::hypot(attitude_error_m(above_m, fix.weight), change_m),
                                    std::hypot(0.5 * registration.gsd_m, 0.5 * filter.cell_m()));
  const double independent_pixels =
      std::min(registration.evidence.independent_pixels, pixels / options.min_pixels_per_residual);
  const LikelihoodOptions o{independent_pixels, sigma_m, options.outlier_probability};
  if (const Status s = likelihood_from_ncc(registration.surface, o, likelihood); s != Status::kOk) return s;
  if (!search.whole) likelihood.outside = 1;  // what was not searched is not excluded

  fix.covariance_m2 = covariance_m2(likelihood);
  const double left_out_m = options.attitude_sigma_rad * above_m;
  fix.covariance_m2[0] += (1 - fix.weight) * left_out_m * left_out_m;
  fix.covariance_m2[3] += (1 - fix.weight) * left_out_m * left_out_m;
  add_bias(above_m, change_m * change_m, fix.covariance_m2);
  return temper(fix.weight, likelihood);
}

/// What the registration found, as the record of the image.
void Localizer::State::describe(Fix& fix) const {
  const Peak& peak = registration.peak;
  fix.east_m = peak.east_m;
  fix.north_m = peak.north_m;
  fix.covariance_m2 = registration.covariance_m2;
  fix.probability = registration.probability;
  fix.method = registration.method;
  fix.score = peak.value;
  fix.ambiguity = peak.value > 0 ? std::clamp((peak.value - peak.gap) / peak.value, 0.0, 1.0) : 1;
  fix.rotation_rad = registration.similarity.rotation_rad;
  const bool searched = registration.rotation_sigma_rad > 0;
  fix.rotation_sigma_rad = searched ? registration.rotation_sigma_rad : options.heading_sigma_rad;
  fix.ground_height_m = terrain.plane_height_m;
  fix.gsd_m = registration.gsd_m;
}

Status Localizer::State::take(const cv::Mat& image, const Camera& camera, const Attitude& attitude, double height_m,
                              Fix& fix) {
  if (!filter.started()) return Status::kNotStarted;
  if (!std::isfinite(height_m)) return Status::kNotFinite;
  const PointMassFilter::Moments now = filter.moments();
  if (const Status s = survey(camera, attitude, height_m); s != Status::kOk) return s;
  const double above_m = height_m - terrain.plane_height_m;
  Search search;
  if (const Status s = choose_search(camera, attitude, above_m, search); s != Status::kOk) return s;
  if (const Status s =
          rectify(image, camera, attitude, {now.east_m, now.north_m, height_m}, terrain, search.gsd_m, patch);
      s != Status::kOk)
    return s;
  if (const Status s = check_age(search, fix); s != Status::kOk) return s;
  const Status matched = match(search, above_m);
  if (matched != Status::kOk && matched != Status::kImprobable) return matched;
  describe(fix);
  if (matched != Status::kOk) return matched;
  if (const Status s = weigh(search, above_m, fix); s != Status::kOk) return s;
  if (const Status s = filter.update(likelihood); s != Status::kOk) return s;
  // The image's error enters the estimate by the share of its uncertainty that the image took away.
  const auto trace = [](const PointMassFilter::Moments& m) { return m.covariance_m2[0] + m.covariance_m2[3]; };
  const double gain = std::clamp(1 - trace(filter.moments()) / trace(now), 0.0, 1.0), change_m = change_error_m();
  change_variance_m2 += gain * (change_m * change_m - change_variance_m2);

  matched_before = true;
  flown_since_match_m = 0;
  last_height_m = above_m;
  return Status::kOk;
}

Localizer::Localizer(const MapSource& map, const LocalizerOptions& options)
    : state_(std::make_unique<State>(map, options)) {}
Localizer::~Localizer() = default;
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;

Status Localizer::start(double east_m, double north_m, double sigma_m) {
  if (!valid(state_->options)) return Status::kBadValue;
  if (const Status s = state_->filter.start(east_m, north_m, sigma_m); s != Status::kOk) return s;
  state_->matched_before = false;
  state_->flown_since_match_m = 0;
  state_->last_height_m = 0;
  state_->change_variance_m2 = 0;
  return Status::kOk;
}

Status Localizer::predict(double displacement_east_m, double displacement_north_m, double sigma_m) {
  const Status s = state_->filter.predict(displacement_east_m, displacement_north_m, sigma_m, sigma_m);
  if (s == Status::kOk) state_->flown_since_match_m += std::hypot(displacement_east_m, displacement_north_m);
  return s;
}

Fix Localizer::update(const cv::Mat& image, const Camera& camera, const Attitude& attitude, double height_m,
                      double time_s) {
  const auto begin = std::chrono::steady_clock::now();
  Fix fix;
  fix.time_s = time_s;
  try {
    fix.status = state_->take(image, camera, attitude, height_m, fix);
  } catch (...) {
    fix.status = Status::kInternal;
  }
  fix.processing_time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return fix;
}

Estimate Localizer::estimate() const {
  if (!state_->filter.started()) return {};
  const PointMassFilter::Moments m = state_->filter.moments();
  Estimate estimate{Status::kOk, m.east_m, m.north_m, m.covariance_m2};
  state_->add_bias(state_->last_height_m, state_->change_variance_m2, estimate.covariance_m2);
  return estimate;
}

const PointMassFilter& Localizer::filter() const { return state_->filter; }

}  // namespace landfix::nav

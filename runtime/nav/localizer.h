// The onboard loop: map, camera image, attitude and height in; position and covariance out, without GNSS.
#pragma once

#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "runtime/nav/camera.h"
#include "runtime/nav/map_source.h"
#include "runtime/nav/point_mass_filter.h"
#include "runtime/nav/registration.h"
#include "runtime/nav/status.h"

namespace landfix::nav {

struct LocalizerOptions {
  // What the aircraft knows about its own errors.
  double attitude_sigma_rad = 0.00873;      ///< roll and pitch, independent from image to image (0.5°)
  double attitude_bias_sigma_rad = 0.0052;  ///< roll and pitch, constant in flight (0.3°): never averaged away
  double map_bias_sigma_m = 0.25;           ///< georegistration error of the map, per axis: never averaged away
  /// How far changes since the map was made (what is left of turned shadows above all) pull a match aside: times
  /// (1 − score), per axis. Neighbouring images share them, so they are never averaged away.
  double change_sigma_m = 3;
  /// The same for orientation, whose score does not tell, in pixels of the level that was matched: what moved by more
  /// than the main lobe makes another peak, what moved by less bends it.
  double orientation_sigma_px = 0.5;
  /// Of the heading and of the height above ground as given. Rotation or scale is searched where these move the rim of
  /// the view by more than the features are wide.
  double heading_sigma_rad = 0, height_sigma_m = 0;

  // The policy: what is refused before the filter sees it.
  std::optional<Method> method;         ///< absent: chosen by what the region offers
  Gate gate = Gate::kNone;              ///< the filter weighs doubtful images itself; a gate keeps them out
  std::optional<int> max_map_age_days;  ///< ground in view whose oldest image is older, or undated, is refused
  std::optional<int> today;  ///< days since 1970-01-01, for the map's age: without it a limit refuses every map

  // The measurement.
  double outlier_probability = 0.02;  ///< of an image that says nothing about the position
  double min_pixels_per_residual =
      30;  ///< template pixels that share one independent residual, however fine the texture
  double independent_fraction = 0.25;  ///< of the footprint's side, to be flown until an image counts as wholly new
  double min_coverage = 0.5;           ///< of the template that must lie on the map

  // The search.
  double search_tail_probability = 1e-4;  ///< of the filter that may lie beyond each side of the search region
  int min_search_px = 8;                  ///< smallest half-width of the search region
  int max_template_px = 320;              ///< a longer side makes the match take a coarser level
  int max_window_px = 1024;               ///< likewise for the side of the search window

  // The filter.
  PointMassFilterOptions filter;
};

/// What one image said. Everything but `status`, `time_s`, `processing_time_s` and, with kMapTooOld, `map_age_days` is
/// meaningful only if `status` is kOk (or kImprobable: a match that the gate refused).
struct Fix {
  Status status = Status::kNotStarted;
  double time_s = 0;                      ///< of the image, as given
  double east_m = 0, north_m = 0;         ///< camera position at the peak, on the grid of the map
  std::array<double, 4> covariance_m2{};  ///< of this image alone, row-major over (east, north): large where ambiguous
  double probability = 0;                 ///< that the match is the true one
  Method method = Method::kGray;          ///< that found it
  double score = 0;                       ///< height of the peak, at most 1; of gray: the NCC
  double ambiguity = 0;             ///< score of the best rival outside the main lobe over that of the peak; 0 to 1
  double rotation_rad = 0;          ///< to be added to the heading; 0 where rotation was not searched
  double rotation_sigma_rad = 0;    ///< of it; that of the heading where not searched
  std::optional<int> map_age_days;  ///< of the oldest image in the map there, if both days are known
  double weight = 0;                ///< 0 to 1: how far the image counted as independent of the one before
  double ground_height_m = 0;       ///< above the ellipsoid, mean of the view's middle
  double gsd_m = 0;                 ///< of the map level used
  double processing_time_s = 0;
};

/// Where the aircraft is. The covariance holds the filter's own (Conte 2009 eq. 5.30) and the constant errors of
/// attitude and map.
struct Estimate {
  Status status = Status::kNotStarted;
  double east_m = 0, north_m = 0;
  std::array<double, 4> covariance_m2{};  ///< row-major over (east, north)
};

/// Point-mass filter over positions on the grid of the map, fed by odometry and by correlation with the map (Conte 2009
/// §5.7, §5.8.4). Not safe for concurrent calls on one object. Nothing throws; an input that is refused leaves the
/// state unchanged.
class Localizer {
 public:
  /// `map` must outlive the localizer.
  explicit Localizer(const MapSource& map, const LocalizerOptions& options = {});
  ~Localizer();
  Localizer(Localizer&&) noexcept;
  Localizer& operator=(Localizer&&) noexcept;

  /// Begins anew at a position with a standard deviation per axis. kNotFinite, kBadValue (sigma or options).
  Status start(double east_m, double north_m, double sigma_m);

  /// Moves by an odometry displacement on the grid with its own standard deviation per axis. kNotStarted, kNotFinite,
  /// kBadValue.
  Status predict(double displacement_east_m, double displacement_north_m, double sigma_m);

  /// Matches an image with the map and takes it into the filter. Where the map has heights and the filter knows where
  /// they are, the image is rectified through them, otherwise on a plane.
  /// `image`: H×W of the camera's size, CV_8UC1 or CV_8UC3 (red, green, blue; OpenCV reads files the other way round).
  /// `attitude`: heading against grid north. `height_m`: camera above the ellipsoid.
  Fix update(const cv::Mat& image, const Camera& camera, const Attitude& attitude, double height_m, double time_s);

  Estimate estimate() const;

  /// The distribution behind the estimate.
  const PointMassFilter& filter() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace landfix::nav

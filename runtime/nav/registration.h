// Registration of a rectified patch with the map: where it lies, how it is turned, and how sure that is.
#pragma once

#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "runtime/features/grid_image.h"
#include "runtime/nav/calibration.h"
#include "runtime/nav/likelihood.h"
#include "runtime/nav/map_source.h"
#include "runtime/nav/matcher.h"
#include "runtime/nav/status.h"

namespace landfix::nav {

/// What is known before the image is looked at.
struct RegistrationPrior {
  double east_m = 0, north_m = 0;         ///< of the patch's origin: the point below the camera
  std::array<double, 4> covariance_m2{};  ///< of it, row-major over (east, north)
  double sigmas = 3;                      ///< the region searched is the bounding box of this many sigmas
  double heading_sigma_rad = 0;           ///< of the heading that the patch was rectified with; 0: exact
  double scale_sigma = 0;                 ///< of its height above ground, relative; 0: exact
};

struct RegistrationOptions {
  std::optional<Method> method;  ///< absent: chosen and combined by what the region offers ("auto")
  Gate gate = Gate::kStandard;
  double min_coverage = 0.5;  ///< of the patch that must lie on the map
  /// Rotation and scale are searched this many sigmas to either side, at most half a turn and half of the scale.
  double pose_sigmas = 2;
  int rim_px = 0;                   ///< pixels along the patch's canvas that serve the operators but do not vote
  int min_template_px = 48;         ///< a coarser level is not searched where it made the patch smaller
  double search_budget_px = 1.5e6;  ///< most positions × similarities that the search looks at; coarser beyond
  int max_window_px = 1024;         ///< of a side of the window searched; twice as many positions at the coarsest level
  double outlier_probability = 0.02;  ///< of an image that says nothing, in the likelihood
};

/// A match that needs no gate to be described: everything but `status` and `method` is meaningful only if `status` is
/// kOk or kImprobable.
struct Registration {
  Status status = Status::kInternal;
  Method method = Method::kGray;
  double gsd_m = 0;                       ///< of the surface
  features::GridImage surface;            ///< score of every position of the region, the best over all similarities
  Likelihood likelihood;                  ///< of every position, for the point-mass filter
  Peak peak;                              ///< position of the patch's origin, refined at the finest level
  std::array<double, 4> covariance_m2{};  ///< of the peak, if it is the true one; row-major over (east, north)
  double probability = 0;                 ///< that the peak is the true one
  Similarity similarity;                  ///< what the assumed heading and height had wrong
  double rotation_sigma_rad = 0, scale_sigma = 0;
  Evidence evidence;  ///< what the probability was told
};

/// Searches rotation, scale and position coarse to fine over the levels of the map. Keeps its buffers. Not for
/// concurrent calls on one object. Nothing throws.
class Registrar {
 public:
  /// `map` must outlive the registrar.
  explicit Registrar(const MapSource& map, const RegistrationOptions& options = {});
  ~Registrar();
  Registrar(Registrar&&) noexcept;
  Registrar& operator=(Registrar&&) noexcept;

  /// `patch`: rectified image, north up, CV_8UC1 or CV_8UC3 (red, green, blue) with its footprint in `valid`, at a GSD
  /// of the map's levels, `west_m` and `north_m` relative to its origin. `out.status` is kOk for a fix that passes the
  /// gate, kImprobable for one that does not, otherwise what prevents one: kNotFinite, kBadValue, kBadImage, kNoLayer,
  /// kNoTexture, kOutsideMap, kTemplateTooLarge, kTooLarge, kMapError, kInternal.
  void run(const features::GridImage& patch, const RegistrationPrior& prior, Registration& out);

  const RegistrationOptions& options() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace landfix::nav

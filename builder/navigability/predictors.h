// What a place tells about how well a camera will find itself there: evidence from the map's own images, gathered by
// the matcher that flies. model.h makes probabilities and covariances of it.
//
// Where the sources show a place on several dates, each date in turn is the camera, and the map is made of the others:
// what the dates did to each other is what the next one will do. Where they show it on one, views are drawn as other
// days may show it (altered_views.h), as many as it takes to be sure of their mean. For orientation alone: to the other
// matchers drawn days are tamer than real ones, and the date is matched with itself.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>

#include "runtime/features/grid_image.h"
#include "runtime/nav/matcher.h"

namespace landfix::navigability {

/// What is flown over a place: a view, and how far from the truth the aircraft may believe itself.
struct Footprint {
  double template_m = 160;  ///< side of the view
  double search_m = 160;    ///< searched to every side
  double hit_m = 15;        ///< an answer this near to the truth is true
};

/// Another place within the search region that looks like this one.
struct LookAlike {
  double east_m = 0, north_m = 0;  ///< from the place
  double strength = 0;             ///< its mean score over that of the place; 1: cannot be told apart
};

/// Evidence at one place. Logits are natural logarithms of odds, within ±kLargestLogit.
struct Predictors {
  int dates = 0;           ///< that show the place; 0: it cannot be judged, and nothing below is meaningful
  int newest = 0;          ///< of them: its index among the images
  double template_px = 0;  ///< side of the view at the level that was matched
  double coverage = 0;     ///< share of the view that these dates show, in the mean

  int views = 0;  ///< of other days that were matched; 0 where there are dates for it, and by matchers but orientation
  /// Of the likelihood that lies within `hit_m` of the truth: the date or drawn view that fared worst, and the mean.
  /// Without either meaningless.
  double least_logit = 0, mean_logit = 0;
  double found = 0;     ///< share of the dates, or drawn views, that were found within `hit_m`
  double accepted = 0;  ///< share of them whose match passes the standard gate

  /// Mean length of the orientation vectors in the view over its dates, 0 to 1 (features::orientation).
  double structure = 0;
  /// Σ length³ / Σ length² there: how strong those are that decide.
  double crest = 0;
  /// Mean score farther than 2·`hit_m` from the truth: high where everything in the region runs in one direction.
  double background = 0;

  /// Mean of the covariances that the matches stated, in which those that missed hardly count; row-major over (east,
  /// north), in m².
  std::array<double, 4> covariance_m2{};
  /// The Cramér-Rao bound of the view, in the mean over its dates (information.h).
  std::array<double, 4> least_covariance_m2{};
  std::optional<LookAlike> look_alike;  ///< the strongest; none where nothing beyond the main lobe scores above 0
};

inline constexpr double kLargestLogit = 9.21;  ///< odds of 1 to 10 000
inline constexpr double kLargestError = 1;     ///< of the mean over altered views: 0.03 or so of a chance
inline constexpr int kLeastViews = 2, kMostViews = 12;
inline constexpr nav::Method kOrientationOnly[] = {nav::Method::kOrientation};

/// Gathers evidence over a piece of the map. Keeps the maps of every date; not for concurrent calls on one object.
class Witness {
 public:
  /// `dates`: one image per capture date, the newest first, of one size, place and GSD, as nav::ImageMap takes them;
  /// what a camera would see are the first three of four channels. `methods`: that places can be judged by; maps are
  /// made as builds make them, orientation fused over the dates, all else from the newest that shows a pixel.
  /// `heights`: above the ellipsoid in metres, CV_32FC1 of the same grid; without pixels the ground is flat. Throws
  /// std::invalid_argument for no image or images of different shapes.
  explicit Witness(std::span<const features::GridImage> dates, std::span<const nav::Method> methods = kOrientationOnly,
                   const features::GridImage& heights = {});
  ~Witness();
  Witness(Witness&&) noexcept;
  Witness& operator=(Witness&&) noexcept;

  /// Evidence at a place by one of the methods, taken at the next corner of pixels. Dates that do not show at least
  /// half of the view have no say. Of a single date, kLeastViews are drawn or more, until the standard error of
  /// `mean_logit` is at most kLargestError, at most kMostViews. Throws std::invalid_argument for lengths that are not
  /// positive and for a method that the witness was not made for.
  Predictors at(double east_m, double north_m, const Footprint& footprint,
                nav::Method method = nav::Method::kOrientation);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace landfix::navigability

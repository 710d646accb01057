// One interface for all ways to compare a rectified patch with the map.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string_view>

#include "runtime/features/grid_image.h"
#include "runtime/nav/map_source.h"
#include "runtime/nav/status.h"

namespace landfix::nav {

enum class Method { kGray, kEdge, kContour, kOrientation };

inline constexpr Method kMethods[] = {Method::kGray, Method::kEdge, Method::kContour, Method::kOrientation};

/// "gray", "edge", "contour" or "orientation"; the way back is nothing for another name.
const char* name_of(Method method);
std::optional<Method> method_of(std::string_view name);

/// The layer of the map that a method compares with.
MapLayer layer_of(Method method);

/// What the pose that a patch was rectified with has wrong: turn clockwise by `rotation_rad`, then stretch by `scale`,
/// both about the patch's origin (the point below the camera). True heading = assumed + rotation; true height above
/// ground = assumed × scale.
struct Similarity {
  double rotation_rad = 0, scale = 1;
  bool is_identity() const { return rotation_rad == 0 && scale == 1; }
  friend bool operator==(const Similarity&, const Similarity&) = default;
};

/// Compares one patch, under several similarities, with one window at a time. Keeps its buffers. Not for concurrent
/// calls. Nothing throws.
class Matcher {
 public:
  virtual ~Matcher() = default;

  /// Computes what of the patch is compared. `image`: pixels CV_8UC1, or CV_8UC3 and more in the order red, green,
  /// blue, …; `west_m` and `north_m` relative to the patch's origin, as `rectify` leaves them. `rim_px`: so many pixels
  /// along the canvas's edges serve the operators, which look at neighbours, but do not take part themselves.
  /// kBadImage, kNoTexture (nothing to compare), kInternal.
  virtual Status set_patch(const features::GridImage& image, int rim_px = 0) = 0;

  /// `window` as MapSource::read gives it for the method's layer, of the patch's GSD and at least its size; it must
  /// live until the next window. kBadImage, kTemplateTooLarge, kInternal.
  virtual Status set_window(const features::GridImage& window) = 0;

  /// Scores of all positions at which the patch lies inside the window: (H−h+1)×(W−w+1) CV_32F with `valid`, at most 1,
  /// about 0 for unrelated content; 0 and not valid where less than `min_coverage` of the patch meets data. Its
  /// georeference makes the centre of a surface pixel the position of the patch's origin. kNoTexture, kOutsideMap (no
  /// position valid), kInternal.
  virtual Status match(const Similarity& similarity, features::GridImage& surface) = 0;

  /// The same, faster and coarser: good enough to choose among similarities.
  virtual Status match_fast(const Similarity& similarity, features::GridImage& surface) {
    return match(similarity, surface);
  }

  /// How many independent samples the last match is worth: a score with unrelated content has a variance of about one
  /// over this.
  virtual double independent_pixels() const = 0;
};

/// `min_coverage`: share of the patch's valid pixels that must meet valid pixels of the window.
std::unique_ptr<Matcher> make_matcher(Method method, double min_coverage = 0.5);

/// Turns and stretches the valid pixels of an image about its origin, on the same canvas; bilinear. Pixels of which a
/// part comes from beyond the canvas or from pixels without data are not valid. `out.valid` is always filled.
void apply(const Similarity& similarity, const features::GridImage& in, features::GridImage& out);

/// An image without its outermost pixels; shares the pixels.
features::GridImage without_rim(const features::GridImage& image, int rim_px);

/// Sets size and georeference of a surface for a patch in a window.
void prepare_surface(const features::GridImage& patch, const features::GridImage& window, features::GridImage& surface);

// One file per matcher.
std::unique_ptr<Matcher> make_ncc_matcher(Method method, double min_coverage);
std::unique_ptr<Matcher> make_contour_matcher(double min_coverage);
std::unique_ptr<Matcher> make_orientation_matcher(double min_coverage);

}  // namespace landfix::nav

// A georeferenced image as the camera of an evaluation: templates are cut out of it as if it had been photographed.
#pragma once

#include <string>

#include "builder/ingest/bounds.h"
#include "runtime/features/grid_image.h"
#include "runtime/nav/map_source.h"
#include "runtime/nav/matcher.h"
#include "tiles/geodesy.h"

namespace landfix::eval {

/// Where the templates of an evaluation may come from: a map and the level at which they are handed to the registrar.
struct MapFrame {
  std::string path;  ///< for messages
  tiles::Zone zone;
  ingest::GridBounds bounds;
  std::pair<double, double> gsd_range_m;  ///< finest and coarsest level
};

/// The finest level of the map that a camera of this GSD serves: a level may be finer than the camera, but not by more
/// than 1 / 0.7.
double level_for(const std::pair<double, double>& gsd_range_m, double camera_gsd_m);

/// Finest and coarsest level over all raster layers of a map; {0, 0} where it has none.
std::pair<double, double> raster_levels(const nav::MapSource& map);

class CameraImage {
 public:
  /// Reads what of the image lies on the map, at a level of the map: red, green and blue, or gray; a camera has no near
  /// infrared. Throws as ingest::ImageSet does, and Error(kNoData) where image and map do not overlap.
  CameraImage(const std::string& path, const MapFrame& map);

  const std::string& name() const { return name_; }
  const std::string& date() const { return date_; }  ///< "2009-08-18" by the sidecar; empty: not said
  double gsd_m() const { return image_.gsd_m; }
  double native_gsd_m() const { return native_gsd_m_; }
  const features::GridImage& image() const { return image_; }
  const ingest::GridBounds& bounds() const { return bounds_; }  ///< of the part on the map

  /// Cuts a square of `side_px` pixels (even), its middle at a position of the ground, and distorts it so that
  /// `similarity` is what is wrong with it: the pixel at p from the middle shows the ground at similarity(p). One cubic
  /// interpolation. Origin of `patch` is its middle. False where the image lacks pixels there.
  bool cut(double east_m, double north_m, int side_px, const nav::Similarity& similarity,
           features::GridImage& patch) const;

 private:
  std::string name_, date_;
  features::GridImage image_;
  ingest::GridBounds bounds_;
  double native_gsd_m_ = 0;
};

}  // namespace landfix::eval

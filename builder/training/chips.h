// Labelled windows of images: what a classifier of landmarks learns from and is judged by.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "runtime/features/grid_image.h"
#include "runtime/features/landmark_classifier.h"
#include "tiles/geodesy.h"

namespace landfix::landmarks {

/// Side of a patch around a labelled place in pixels of features::kWordGsdM: the larger square of the histogram, the
/// reach of its descriptors, and the surroundings that luminance is compared with.
inline constexpr int kPatchPx = 56;

/// A labelled place of an image, on the grid of the image's zone.
struct Chip {
  std::string id;
  double east_m = 0, north_m = 0;
  features::LandmarkLabel label = features::LandmarkLabel::kNone;
  int place = 0;  ///< chips of one place show the same ground: they are never split between training and test
};

/// An image at features::kWordGsdM with its brightness evened out, and what is labelled in it.
struct LabelledImage {
  std::string name;
  features::GridImage image;
  std::vector<Chip> chips;
  bool drawn = false;  ///< by a program: weighs less than what cameras have seen
};

/// The label of a class name; throws Error(kBadInput), naming `where`, for another word.
features::LandmarkLabel label_named(const std::string& name, const std::string& where);

/// Reads an image at features::kWordGsdM in its standard zone. Throws as ingest::load_image.
features::GridImage load_evened(const std::string& path, tiles::Zone* zone = nullptr);

/// Chips of a CSV file with the header `id,x,y,size_m,label`: centres in the CRS of the image, side in metres on the
/// ground, label as in features::kLandmarkLabelNames. Rows labelled "mixed" are left out. Chips whose squares overlap
/// (directly or through others) are one place. Throws Error: kIo for a missing file, kBadInput for a malformed line, an
/// unknown label, no chip, or one whose square is not inside the image.
LabelledImage read_chips(const std::string& csv_path, const std::string& image_path);

/// The patch around a grid position, sampled bilinearly; mirrored beyond the image.
cv::Mat patch_at(const features::GridImage& image, double east_m, double north_m);

/// How a patch is turned, scaled and mirrored before it is sampled.
struct Warp {
  double angle_rad = 0, scale = 1;
  bool mirrored = false;
};
cv::Mat patch_at(const features::GridImage& image, double east_m, double north_m, const Warp& warp);

}  // namespace landfix::landmarks

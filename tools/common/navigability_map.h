// A pack's navigability in memory: for pictures, files and routes.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "landfix/landfix.hpp"
#include "tiles/navigability.h"

namespace landfix::tools {

/// The footprints that a pack was judged for, the smallest view first, of these the smallest search.
std::vector<tiles::Footprint> footprints_of(const Pack& pack);

/// What a pack says for one footprint.
class NavigabilityMap {
 public:
  /// Throws Error: kNoData where the pack was not judged for this footprint (says for which it was), kBadPack where it
  /// is damaged. `path` is the pack's, for messages.
  NavigabilityMap(const Pack& pack, const tiles::Footprint& footprint, const std::string& path);

  const tiles::Footprint& footprint() const { return footprint_; }
  int columns() const { return nodes_.cols; }
  int rows() const { return nodes_.rows; }
  double west_m() const { return west_m_; }
  double north_m() const { return north_m_; }

  /// The node of a column (from the west) and a row (from the north); nullopt where nothing is said, as of those
  /// outside.
  std::optional<tiles::Navigability> node(int column, int row) const;
  /// The node in whose 64 m a position lies.
  std::optional<tiles::Navigability> at(double east_m, double north_m) const;
  /// The middle of a node.
  double east_of(int column) const { return west_m_ + (column + 0.5) * tiles::kNavigabilityGsd_m; }
  double north_of(int row) const { return north_m_ - (row + 0.5) * tiles::kNavigabilityGsd_m; }

 private:
  tiles::Footprint footprint_;
  cv::Mat nodes_;  ///< CV_8UC(channels of the layer)
  double west_m_ = 0, north_m_ = 0;
};

/// "water, even ground" and so on: the reasons of a place, with figures where there are some ("looks like a place 140 m
/// to the north-west"). Empty where there is none.
std::string reasons_text(const tiles::Navigability& place);

}  // namespace landfix::tools

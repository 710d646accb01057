// A pack's navigability in memory: for pictures, files and routes.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "landfix/landfix.hpp"
#include "tiles/navigability.h"

namespace landfix::tools {

/// The footprints that a pack was judged for, the smallest view first, of these the smallest search.
std::vector<tiles::Footprint> footprints_of(const Pack& pack);

/// Of footprints, the one whose view and search differ from the asked ones by the least factors; nullopt of none.
std::optional<tiles::Footprint> nearest_footprint(const std::vector<tiles::Footprint>& footprints,
                                                  const tiles::Footprint& asked);

/// Of a true fix at a place, row-major over (east, north), in m².
std::array<double, 4> covariance_of(const tiles::Navigability& place);

/// "auto", "orientation" and so on: names of the matchers in files and on the command line; nullopt for another.
const char* name_of(tiles::Finder finder);
std::optional<tiles::Finder> finder_named(std::string_view name);

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
  double spacing_m() const { return tiles::node_spacing_m(footprint_); }

  /// The node of a column (from the west) and a row (from the north); nullopt where nothing is said, as of those
  /// outside.
  std::optional<tiles::Navigability> node(int column, int row) const;
  /// The node in whose square a position lies.
  std::optional<tiles::Navigability> at(double east_m, double north_m) const;

  /// What is expected between the nodes.
  struct Expected {
    double fix_probability = 0;
    std::array<double, 4> covariance_m2{};  ///< of a true fix, row-major over (east, north)
  };
  /// Bilinear between the four nodes around, the chances by their log odds; of these nodes, those that `finder` was
  /// judged at. nullopt where there is none.
  std::optional<Expected> between(double east_m, double north_m, tiles::Finder finder) const;
  /// Whether this matcher was judged anywhere.
  bool judges(tiles::Finder finder) const;

  /// The middle of a node.
  double east_of(int column) const { return west_m_ + (column + 0.5) * spacing_m(); }
  double north_of(int row) const { return north_m_ - (row + 0.5) * spacing_m(); }

 private:
  tiles::Footprint footprint_;
  cv::Mat nodes_;  ///< CV_8UC(channels of the layer)
  double west_m_ = 0, north_m_ = 0;
};

/// "water", "uniform field" and so on. `rival_m` and its bearing, clockwise from grid north, are of the place that
/// looks alike: "looks like the place 140 m to the north-west"; 0: where it lies is not said.
std::string reason_text(tiles::Reason reason, double rival_m, double rival_bearing_rad);

/// All reasons of a place, "water, uniform field". Empty where there is none.
std::string reasons_text(const tiles::Navigability& place);

}  // namespace landfix::tools

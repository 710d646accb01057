// What is known about navigating over a place: how likely an image taken there gives a true fix, how exact that is, and
// why not. Where it comes from (a pack's layer, a field drawn by a test) is no matter for routes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "tiles/navigability.h"

namespace landfix::route {

/// Why a place is poor; bits of Navigability::reasons. The order is that of the words: the more telling first.
enum Reason : uint32_t {
  kOffMap = 1 << 0,
  kNoImage = 1 << 1,  ///< the map knows nothing of the place
  kTooLow = 1 << 2,   ///< the camera sees too little ground
  kWater = 1 << 3,
  kUniformField = 1 << 4,
  kForest = 1 << 5,
  kRepeats = 1 << 6,
  kShadow = 1 << 7,
  kStrongRelief = 1 << 8,
  kDatesDisagree = 1 << 9,
  kOneDate = 1 << 10,  ///< nothing to compare with
  kOldMap = 1 << 11,
  kPartlyOffMap = 1 << 12,
};

/// Those that maps state, and how maps call them.
inline constexpr std::array<std::pair<tiles::Reason, Reason>, tiles::kReasons> kReasonsOfMaps = {{
    {tiles::Reason::kWater, kWater},
    {tiles::Reason::kUniform, kUniformField},
    {tiles::Reason::kWood, kForest},
    {tiles::Reason::kRepeats, kRepeats},
    {tiles::Reason::kRelief, kStrongRelief},
    {tiles::Reason::kShadow, kShadow},
    {tiles::Reason::kNoData, kPartlyOffMap},
    {tiles::Reason::kDatesDisagree, kDatesDisagree},
    {tiles::Reason::kOneDate, kOneDate},
    {tiles::Reason::kOld, kOldMap},
}};

/// A pattern that looks the same so far away.
struct Repeat {
  double distance_m = 0;
  double bearing_rad = 0;  ///< from grid north, clockwise
};

struct Navigability {
  double fix_probability = 0;    ///< that an image gives a true fix which passes the gate
  double false_probability = 0;  ///< that it gives a false fix which passes the gate
  Eigen::Matrix2d covariance_m2 =
      Eigen::Matrix2d::Identity();  ///< of a true fix (east, north), without the attitude's share
  double gsd_m = 0;                 ///< of the map's level that the covariance was stated for; 0: not known
  uint32_t reasons = 0;
  std::optional<Repeat> repeat;  ///< with kRepeats
};

/// "water, looks like the place 18 m to the north": reasons in the words of tools::reason_text; empty for none.
std::string words(uint32_t reasons, const std::optional<Repeat>& repeat = std::nullopt);

/// A rectangle of the grid.
struct Extent {
  double west_m = 0, south_m = 0, east_m = 0, north_m = 0;
  bool holds(double x_m, double y_m) const {
    return x_m >= west_m && x_m <= east_m && y_m >= south_m && y_m <= north_m;
  }
};

class NavigabilityMap {
 public:
  virtual ~NavigabilityMap() = default;

  /// For a square view of side `footprint_m`, searched `search_m` to every side; what lies between the cases that a map
  /// knows is its own matter, and every length is answered. Nothing where the map knows nothing about the place.
  virtual std::optional<Navigability> at(double east_m, double north_m, double footprint_m, double search_m) const = 0;

  virtual Extent extent() const = 0;
};

/// A map that is a function; nothing is known outside of its extent.
class FunctionMap : public NavigabilityMap {
 public:
  using Function =
      std::function<std::optional<Navigability>(double east_m, double north_m, double footprint_m, double search_m)>;
  FunctionMap(const Extent& extent, Function function) : extent_(extent), function_(std::move(function)) {}

  std::optional<Navigability> at(double east_m, double north_m, double footprint_m, double search_m) const override {
    return extent_.holds(east_m, north_m) ? function_(east_m, north_m, footprint_m, search_m) : std::nullopt;
  }
  Extent extent() const override { return extent_; }

 private:
  Extent extent_;
  Function function_;
};

}  // namespace landfix::route

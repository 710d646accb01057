// Navigability: what a map says about how well a camera finds itself at a place, and how a pixel of it is coded.
// schemas/FORMAT.md section 3.5.1 is the specification.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace landfix::tiles {

/// Whose chance to find the place it is: a matcher, or the choice that takes the best of them.
enum class Finder : uint8_t { kAuto = 0, kOrientation = 1, kGray = 2, kEdge = 3, kContour = 4 };
inline constexpr size_t kFinders = 5;

/// Why a place is as it is. Values are bits in the file; readers skip those that they do not know.
enum class Reason : uint8_t {
  kWater = 0,          ///< much of the view
  kUniform = 1,        ///< few directions of gradients: bare or even ground
  kWood = 2,           ///< closed crowns
  kRepeats = 3,        ///< another place within the search looks like it: look_alike
  kRelief = 4,         ///< heights move what is seen by more than the features are wide
  kShadow = 5,         ///< much of what is seen are shadows
  kNoData = 6,         ///< part of the view lies off the map
  kDatesDisagree = 7,  ///< what the dates show changes
  kOneDate = 8,        ///< nothing to compare with
  kOld = 9,            ///< on the day of flight older than kOldYears: never in a file, set by on_day()
};
inline constexpr size_t kReasons = 10;

/// What is flown over a place.
struct Footprint {
  double template_m = 160;  ///< side of the square view on the ground
  double search_m = 160;    ///< how far from the truth the vehicle may believe itself, to every side
  bool operator==(const Footprint&) const = default;
};

/// A fix is true within this share of template_m of the truth.
inline constexpr double kHitShare = 15.0 / 160;

/// The layer that holds a footprint, "navigability/160/320"; and back, nullopt for the name of another layer.
std::string layer_of(const Footprint& footprint);
std::optional<Footprint> footprint_of(std::string_view layer);

/// "160/320"; nullopt for any other text, and for lengths that are not between a millimetre and 1000 km.
std::optional<Footprint> footprint_named(std::string_view text);

/// Level of the layer of a footprint: one pixel is a node, and they lie at most half a view apart; 64 m from views of
/// 128 m on.
int navigability_level(const Footprint& footprint);
/// How far the nodes of a footprint lie apart.
double node_spacing_m(const Footprint& footprint);

struct Navigability {
  /// Chance of a fix within the tolerance of the truth, from images kTypicalAgeYears old; NaN: not judged.
  std::array<double, kFinders> fix_probability;
  double false_probability = 0;  ///< that a fix passes the standard gate and is false, by Finder::kAuto
  /// Of a true fix: standard deviations along the longer and the shorter axis, and the direction of the longer one,
  /// clockwise from grid north, in [0, pi).
  double major_m = 0, minor_m = 0, direction_rad = 0;
  /// The place within the search that looks most like this one: how far, in which direction clockwise from grid north
  /// in [0, 2 pi), and its score over that of the place (1: cannot be told apart). Distance 0: there is none.
  double rival_m = 0, rival_bearing_rad = 0, rival_strength = 0;
  unsigned landmarks = 0;  ///< in the view; 254 for more
  double diversity = 0;    ///< entropy of their classes over that of all classes alike, 0 to 1 (DeAngelo 2016 ch. 7)
  uint16_t reasons = 0;    ///< bit k: Reason k
  unsigned dates = 0;      ///< that show the place; 254 for more
  /// Of the newest of them, days since 1970-01-01 (what is older counts as that day); nullopt: not known.
  std::optional<int> newest_day;

  bool has(Reason reason) const { return (reasons >> unsigned(reason) & 1) != 0; }
};

/// By how much the log odds of a fix fall with the logarithm of one more than the years since the newest image: 0.5 to
/// 0.7 on real farmland of 2009 to 2018. Chances in a pack are those of images of kTypicalAgeYears.
inline constexpr double kAgeing = 0.6, kTypicalAgeYears = 2, kOldYears = 5;
inline constexpr double kDaysPerYear = 365.25;

/// A chance that holds for images of kTypicalAgeYears, for those of `years`; at least 0 counts.
double aged(double fix_probability, double years);

/// A place as it is on a day of flight, days since 1970-01-01: with its chances of that age, and Reason::kOld where it
/// is. As it was where its date is not known.
Navigability on_day(const Navigability& place, int day);

inline constexpr size_t kNavigabilityChannels = 19;
using NavigabilityPixel = std::array<uint8_t, kNavigabilityChannels>;

/// A pixel of the layer, never all zero (without data). Probabilities keep to ±9.21 in log odds, in steps of 0.073;
/// lengths from 0.1 m to 6 km to 4.4 %.
NavigabilityPixel encode_navigability(const Navigability& place);

/// nullopt where all channels are zero. `pixel` has at least kNavigabilityChannels; what a newer writer adds behind
/// them is not looked at.
std::optional<Navigability> decode_navigability(std::span<const uint8_t> pixel) noexcept;

}  // namespace landfix::tiles

#include "tools/route/navigability_map.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace landfix::route {
namespace {

std::string word(Reason reason, const std::optional<Repeat>& repeat) {
  switch (reason) {
    case kOffMap:
      return "off the map";
    case kNoImage:
      return "no image";
    case kTooLow:
      return "too low";
    case kWater:
      return "water";
    case kUniformField:
      return "uniform field";
    case kForest:
      return "forest";
    case kRepeats: {
      if (!repeat) return "repeats";
      static constexpr std::array kBearings = {"north", "north-east", "east", "south-east",
                                               "south", "south-west", "west", "north-west"};
      const long eighth = std::lround(repeat->bearing_rad / (M_PI / 4));
      return fmt::format("repeats every {:.0f} m {}wards", repeat->distance_m, kBearings[size_t((eighth % 8 + 8) % 8)]);
    }
    case kShadow:
      return "mostly shadow";
    case kStrongRelief:
      return "strong relief";
    case kDatesDisagree:
      return "dates disagree";
    case kOneDate:
      return "one date alone";
    case kOldMap:
      return "old map";
    case kPartlyOffMap:
      return "partly off the map";
  }
  return {};
}

}  // namespace

std::string words(uint32_t reasons, const std::optional<Repeat>& repeat) {
  std::string text;
  for (uint32_t bit = kOffMap; bit <= kPartlyOffMap; bit <<= 1) {
    if (!(reasons & bit)) continue;
    if (!text.empty()) text += ", ";
    text += word(Reason(bit), repeat);
  }
  return text;
}

}  // namespace landfix::route

#include "tools/route/navigability_map.h"

#include "tools/common/navigability_map.h"

namespace landfix::route {
namespace {

std::string word(Reason reason, const std::optional<Repeat>& repeat) {
  const auto as_in_maps = [&](tiles::Reason same) {
    return tools::reason_text(same, repeat ? repeat->distance_m : 0, repeat ? repeat->bearing_rad : 0);
  };
  switch (reason) {
    case kOffMap:
      return "off the map";
    case kNoImage:
      return "no image";
    case kTooLow:
      return "too low";
    case kWater:
      return as_in_maps(tiles::Reason::kWater);
    case kUniformField:
      return as_in_maps(tiles::Reason::kUniform);
    case kForest:
      return as_in_maps(tiles::Reason::kWood);
    case kRepeats:
      return as_in_maps(tiles::Reason::kRepeats);
    case kShadow:
      return as_in_maps(tiles::Reason::kShadow);
    case kStrongRelief:
      return as_in_maps(tiles::Reason::kRelief);
    case kDatesDisagree:
      return as_in_maps(tiles::Reason::kDatesDisagree);
    case kOneDate:
      return as_in_maps(tiles::Reason::kOneDate);
    case kOldMap:
      return as_in_maps(tiles::Reason::kOld);
    case kPartlyOffMap:
      return as_in_maps(tiles::Reason::kNoData);
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

#include "tools/route/navigability_map.h"

#include "tools/common/navigability_map.h"

namespace landfix::route {
namespace {

std::string word(Reason reason, const std::optional<Repeat>& repeat) {
  for (const auto& [in_maps, here] : kReasonsOfMaps)
    if (here == reason)
      return tools::reason_text(in_maps, repeat ? repeat->distance_m : 0, repeat ? repeat->bearing_rad : 0);
  return reason == kOffMap ? "off the map" : reason == kNoImage ? "no image" : "too low";
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

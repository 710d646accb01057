// Fuzz target: whatever the bytes are, nodes of navigability and names of its layers are read without touching memory
// that is not theirs, and what is read keeps the promises of tiles/navigability.h.
//
// The first four bytes are a day of flight; the rest is a pixel of the layer, and a layer's name.
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numbers>

#include "tiles/navigability.h"

namespace {

using landfix::tiles::Navigability;

void require(bool holds) {
  if (!holds) std::abort();
}

bool is_chance(double p) { return std::isnan(p) || (p >= 0 && p <= 1); }

void require_in_range(const Navigability& n) {
  for (const double p : n.fix_probability) require(is_chance(p));
  require(is_chance(n.false_probability));
  for (const double m : {n.major_m, n.minor_m, n.rival_m}) require(m >= 0 && m < 6200);
  for (const double share : {n.rival_strength, n.diversity}) require(share >= 0 && share <= 1);
  require(n.direction_rad >= 0 && n.direction_rad < std::numbers::pi);
  require(n.rival_bearing_rad >= 0 && n.rival_bearing_rad < 2 * std::numbers::pi);
  require(n.landmarks <= 254 && n.dates <= 254 && n.newest_day.value_or(0) >= 0);
}

void read_pixel(std::span<const uint8_t> pixel, int day) {
  const auto place = landfix::tiles::decode_navigability(pixel);
  if (!place) return;
  require_in_range(*place);
  const auto again = landfix::tiles::decode_navigability(landfix::tiles::encode_navigability(*place));
  require(again && again->reasons == place->reasons && again->newest_day == place->newest_day);
  const Navigability then = landfix::tiles::on_day(*place, day), later = landfix::tiles::on_day(*place, day | 1 << 24);
  require_in_range(then);
  for (size_t i = 0; i < landfix::tiles::kFinders; ++i)  // never better with age
    require(std::isnan(then.fix_probability[i]) == std::isnan(place->fix_probability[i]) &&
            !(later.fix_probability[i] > then.fix_probability[i]));
}

void read_name(std::string_view text) {
  landfix::tiles::footprint_of(text);
  const auto footprint = landfix::tiles::footprint_named(text);
  if (footprint) require(landfix::tiles::footprint_of(landfix::tiles::layer_of(*footprint)) == footprint);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  int32_t day = 0;
  if (size < sizeof day) return 0;
  std::memcpy(&day, data, sizeof day);
  const std::span<const uint8_t> rest(data + sizeof day, size - sizeof day);
  read_pixel(rest, day);
  read_name({reinterpret_cast<const char*>(rest.data()), rest.size()});
  return 0;
}

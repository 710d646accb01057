#include "tools/common/navigability_map.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "builder/error.h"

namespace landfix::tools {
namespace {

using tiles::Footprint;
using tiles::Navigability;
using tiles::Reason;

constexpr double kMostNodes = 1 << 24;  // 69 000 km2, and 320 MB

const char* compass_of(double bearing_rad) {
  static constexpr std::array kNames = {"north", "north-east", "east", "south-east",
                                        "south", "south-west", "west", "north-west"};
  return kNames[size_t(std::lround(bearing_rad * 4 / std::numbers::pi)) % kNames.size()];
}

std::string text_of(Reason reason, const Navigability& place) {
  switch (reason) {
    case Reason::kWater:
      return "water";
    case Reason::kUniform:
      return "even ground";
    case Reason::kWood:
      return "closed wood";
    case Reason::kRepeats:
      return fmt::format("looks like the place {:.0f} m to the {}", place.rival_m, compass_of(place.rival_bearing_rad));
    case Reason::kRelief:
      return "strong relief";
    case Reason::kShadow:
      return "mostly shadow";
    case Reason::kNoData:
      return "partly off the map";
    case Reason::kDatesDisagree:
      return "the dates disagree";
    case Reason::kOneDate:
      return "one date only";
    case Reason::kOld:
      return fmt::format("older than {:.0f} years", tiles::kOldYears);
  }
  return {};
}

}  // namespace

std::vector<Footprint> footprints_of(const Pack& pack) {
  std::vector<Footprint> out;
  for (uint32_t i = 0; i < pack.info().layer_count; ++i)
    if (const auto layer = pack.layer(i))
      if (const auto footprint = tiles::footprint_of(layer->name)) out.push_back(*footprint);
  std::ranges::sort(out, {}, [](const Footprint& f) { return std::pair(f.template_m, f.search_m); });
  return out;
}

NavigabilityMap::NavigabilityMap(const Pack& pack, const Footprint& footprint, const std::string& path)
    : footprint_(footprint) {
  const std::string name = tiles::layer_of(footprint);
  const auto index = pack.find_layer(name.c_str());
  if (!index) {
    std::vector<std::string> others;
    for (const Footprint& f : footprints_of(pack)) others.push_back(fmt::format("{}/{}", f.template_m, f.search_m));
    throw Error(ExitCode::kNoData,
                others.empty()
                    ? fmt::format("{}: this pack does not say how navigable it is; build it with --navigability", path)
                    : fmt::format("{}: no navigability for {}/{}; there is {}", path, footprint.template_m,
                                  footprint.search_m, fmt::join(others, ", ")));
  }
  const auto layer = pack.layer(*index);
  const lf_info info = pack.info();
  const auto region = pack.box(*index, info.west_m, info.south_m, info.east_m, info.north_m, tiles::kNavigabilityGsd_m);
  if (!layer || layer->pixel_type != LF_U8 || layer->channels < tiles::kNavigabilityChannels || !region ||
      region->level != tiles::kNavigabilityLevel)
    throw Error(ExitCode::kBadPack, fmt::format("{}: layer {} is not as it should be", path, name));
  if (double(region->width) * region->height > kMostNodes)
    throw Error(ExitCode::kBadPack, fmt::format("{}: layer {} claims {} by {} nodes; expected at most {:.0f}", path,
                                                name, region->width, region->height, kMostNodes));
  nodes_ = cv::Mat::zeros(int(region->height), int(region->width), CV_8UC(layer->channels));
  west_m_ = region->west_m;
  north_m_ = region->north_m;
  Status status = lf_prepare(pack.c_pack(), &*region, 0);
  if (status == LF_OK) status = pack.read(*region, {nodes_.data, nodes_.total() * nodes_.elemSize()}, nodes_.step[0]);
  if (status != LF_OK) throw Error(ExitCode::kBadPack, fmt::format("{}: {}: {}", path, name, lf_status_text(status)));
}

std::optional<Navigability> NavigabilityMap::node(int column, int row) const {
  if (column < 0 || row < 0 || column >= columns() || row >= rows()) return std::nullopt;
  return tiles::decode_navigability({nodes_.ptr(row, column), nodes_.elemSize()});
}

std::optional<Navigability> NavigabilityMap::at(double east_m, double north_m) const {
  const double column = std::floor((east_m - west_m_) / tiles::kNavigabilityGsd_m),
               row = std::floor((north_m_ - north_m) / tiles::kNavigabilityGsd_m);
  if (!(column >= 0 && row >= 0 && column < columns() && row < rows())) return std::nullopt;
  return node(int(column), int(row));
}

std::string reasons_text(const Navigability& place) {
  std::vector<std::string> texts;
  for (size_t k = 0; k < tiles::kReasons; ++k)
    if (place.has(Reason(k))) texts.push_back(text_of(Reason(k), place));
  return fmt::format("{}", fmt::join(texts, ", "));
}

}  // namespace landfix::tools

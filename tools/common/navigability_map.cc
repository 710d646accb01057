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

using tiles::Finder;
using tiles::Footprint;
using tiles::Navigability;
using tiles::Reason;

constexpr std::array<const char*, tiles::kFinders> kFinderNames = {"auto", "orientation", "gray", "edge", "contour"};
constexpr double kMostNodes = 1 << 24;  // 69 000 km2, and 320 MB

const char* compass_of(double bearing_rad) {
  static constexpr std::array kNames = {"north", "north-east", "east", "south-east",
                                        "south", "south-west", "west", "north-west"};
  const long eighth = std::lround(bearing_rad * 4 / std::numbers::pi) % long(kNames.size());
  return kNames[size_t(eighth + long(kNames.size())) % kNames.size()];
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

std::optional<Footprint> nearest_footprint(const std::vector<Footprint>& footprints, const Footprint& asked) {
  const auto distance = [&](const Footprint& f) {
    return std::abs(std::log(f.template_m / asked.template_m)) + std::abs(std::log(f.search_m / asked.search_m));
  };
  const auto best = std::ranges::min_element(footprints, {}, distance);
  return best == footprints.end() ? std::nullopt : std::optional(*best);
}

std::array<double, 4> covariance_of(const Navigability& n) {
  const double s = std::sin(n.direction_rad), c = std::cos(n.direction_rad), major = n.major_m * n.major_m,
               minor = n.minor_m * n.minor_m, mixed = (major - minor) * s * c;
  return {major * s * s + minor * c * c, mixed, mixed, major * c * c + minor * s * s};
}

const char* name_of(Finder finder) { return kFinderNames[size_t(finder)]; }

std::optional<Finder> finder_named(std::string_view name) {
  const auto found = std::ranges::find(kFinderNames, name);
  return found == kFinderNames.end() ? std::nullopt : std::optional(Finder(found - kFinderNames.begin()));
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
  const auto region = pack.box(*index, info.west_m, info.south_m, info.east_m, info.north_m, spacing_m());
  if (!layer || layer->pixel_type != LF_U8 || layer->channels < tiles::kNavigabilityChannels || !region ||
      region->level != tiles::navigability_level(footprint))
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
  const double column = std::floor((east_m - west_m_) / spacing_m()),
               row = std::floor((north_m_ - north_m) / spacing_m());
  if (!(column >= 0 && row >= 0 && column < columns() && row < rows())) return std::nullopt;
  return node(int(column), int(row));
}

std::optional<NavigabilityMap::Expected> NavigabilityMap::between(double east_m, double north_m, Finder finder) const {
  const double column = (east_m - west_m_) / spacing_m() - 0.5,
               row = (north_m_ - north_m) / spacing_m() - 0.5;
  if (!(column >= -1 && row >= -1 && column <= columns() && row <= rows())) return std::nullopt;
  const double west = std::floor(column), north = std::floor(row);
  double total = 0, logit = 0;
  Expected out;
  for (const int x : {0, 1})
    for (const int y : {0, 1}) {
      const double weight = (1 - std::abs(column - west - x)) * (1 - std::abs(row - north - y));
      const std::optional<Navigability> n = node(int(west) + x, int(north) + y);
      if (!n || weight <= 0) continue;
      const double chance = n->fix_probability[size_t(finder)];
      if (std::isnan(chance)) continue;
      total += weight;
      logit += weight * std::log(chance / (1 - chance));
      const std::array<double, 4> covariance_m2 = covariance_of(*n);
      for (size_t i = 0; i < 4; ++i) out.covariance_m2[i] += weight * covariance_m2[i];
    }
  if (total <= 0) return std::nullopt;
  out.fix_probability = 1 / (1 + std::exp(-logit / total));
  for (double& v : out.covariance_m2) v /= total;
  return out;
}

bool NavigabilityMap::judges(Finder finder) const {
  for (int y = 0; y < rows(); ++y)
    for (int x = 0; x < columns(); ++x)
      if (const auto n = node(x, y); n && !std::isnan(n->fix_probability[size_t(finder)])) return true;
  return false;
}

std::string reason_text(Reason reason, double rival_m, double rival_bearing_rad) {
  switch (reason) {
    case Reason::kWater:
      return "water";
    case Reason::kUniform:
      return "uniform field";
    case Reason::kWood:
      return "forest";
    case Reason::kRepeats:
      if (!(rival_m > 0)) return "looks like another place";
      return fmt::format("looks like the place {:.0f} m to the {}", rival_m, compass_of(rival_bearing_rad));
    case Reason::kRelief:
      return "strong relief";
    case Reason::kShadow:
      return "mostly shadow";
    case Reason::kNoData:
      return "partly off the map";
    case Reason::kDatesDisagree:
      return "dates disagree";
    case Reason::kOneDate:
      return "one date only";
    case Reason::kOld:
      return fmt::format("map older than {:.0f} years", tiles::kOldYears);
  }
  return {};
}

std::string reasons_text(const Navigability& place) {
  std::vector<std::string> texts;
  for (size_t k = 0; k < tiles::kReasons; ++k)
    if (place.has(Reason(k))) texts.push_back(reason_text(Reason(k), place.rival_m, place.rival_bearing_rad));
  return fmt::format("{}", fmt::join(texts, ", "));
}

}  // namespace landfix::tools

#include "builder/landmarks/kinds.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>
#include <utility>

namespace landfix::landmarks {
namespace {

constexpr double kLane_m = 3.25, kRoad_m = 6;
constexpr std::array<const char*, 6> kNames = {"building", "field", "tree", "water", "paved", "road"};

// Classes of `highway` that carry vehicles, and the usual width of one carriageway with its shoulders.
const std::map<std::string, double>& highway_widths() {
  static const std::map<std::string, double> kWidths = {
      {"motorway", 11},      {"trunk", 10},        {"primary", 9},       {"secondary", 8},  {"tertiary", 7},
      {"unclassified", 6},   {"residential", 6},   {"motorway_link", 6}, {"trunk_link", 6}, {"primary_link", 6},
      {"secondary_link", 6}, {"tertiary_link", 6}, {"raceway", 10},      {"busway", 7},     {"road", 6},
      {"living_street", 5},  {"pedestrian", 5},    {"service", 4},       {"track", 3}};
  return kWidths;
}

std::string value_of(const ingest::Tags& tags, const std::string& key) {
  const auto found = tags.find(key);
  return found == tags.end() ? std::string() : found->second;
}

bool is_one_of(const ingest::Tags& tags, const std::string& key, const std::set<std::string>& values) {
  return values.contains(value_of(tags, key));
}

bool is_yes(const ingest::Tags& tags, const std::string& key) {
  const std::string value = value_of(tags, key);
  return !value.empty() && value != "no";
}

bool is_below_ground(const ingest::Tags& tags) {
  return (is_yes(tags, "tunnel") && !is_one_of(tags, "tunnel", {"building_passage"})) ||
         is_one_of(tags, "location", {"underground"}) || is_one_of(tags, "parking", {"underground"});
}

std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> words(1);
  for (const char c : name) {
    const char lower = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
    if (lower >= 'a' && lower <= 'z')
      words.back() += lower;
    else if (!words.back().empty())
      words.emplace_back();
  }
  return words;
}

}  // namespace

std::optional<Kind> kind_named(const std::string& name) {
  const auto found = std::ranges::find(kNames, name);
  return found == kNames.end() ? std::nullopt : std::optional(Kind(found - kNames.begin()));
}

const char* name_of(Kind kind) { return kNames[size_t(kind)]; }

std::optional<Kind> kind_of_tags(const ingest::Tags& tags, ingest::Shape shape) {
  if (is_below_ground(tags)) return std::nullopt;
  if (shape == ingest::Shape::kLine) {
    if (highway_widths().contains(value_of(tags, "highway"))) return Kind::kRoad;
    return std::nullopt;
  }
  if (is_one_of(tags, "natural", {"tree"})) return Kind::kTree;
  if (shape == ingest::Shape::kPoint) return std::nullopt;
  if (is_yes(tags, "building")) return Kind::kBuilding;
  if (is_one_of(tags, "natural", {"water"}) || is_one_of(tags, "landuse", {"reservoir", "basin"}) ||
      is_one_of(tags, "waterway", {"riverbank", "dock"}) || is_one_of(tags, "leisure", {"swimming_pool"}))
    return Kind::kWater;
  if (is_one_of(tags, "natural", {"wood"}) || is_one_of(tags, "landuse", {"forest"})) return Kind::kTree;
  if (is_one_of(tags, "landuse", {"farmland", "meadow", "orchard", "vineyard"})) return Kind::kField;
  if (is_one_of(tags, "amenity", {"parking"}) || is_one_of(tags, "aeroway", {"apron", "runway", "helipad"}) ||
      highway_widths().contains(value_of(tags, "highway")))
    return Kind::kPaved;
  return std::nullopt;
}

bool has_known_tags(const ingest::Tags& tags) {
  return std::ranges::any_of(
      std::array{"building", "natural", "landuse", "waterway", "leisure", "amenity", "aeroway", "highway", "tunnel"},
      [&](const char* key) { return tags.contains(key); });
}

std::optional<Kind> kind_of_layer(const std::string& name) {
  static const std::vector<std::pair<std::string, Kind>> kBeginnings = {
      {"building", Kind::kBuilding}, {"road", Kind::kRoad},   {"street", Kind::kRoad},  {"highway", Kind::kRoad},
      {"tree", Kind::kTree},         {"wood", Kind::kTree},   {"forest", Kind::kTree},  {"field", Kind::kField},
      {"farm", Kind::kField},        {"crop", Kind::kField},  {"water", Kind::kWater},  {"lake", Kind::kWater},
      {"pond", Kind::kWater},        {"paved", Kind::kPaved}, {"parking", Kind::kPaved}};
  for (const std::string& word : words_of(name))
    for (const auto& [beginning, kind] : kBeginnings)
      if (word.starts_with(beginning)) return kind;
  return std::nullopt;
}

std::optional<double> metres_of(const ingest::Tags& tags, const std::string& key) {
  const std::string text = value_of(tags, key);
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string unit(end, text.data() + text.size());
  if (failure != std::errc() || !(unit.empty() || unit == "m" || unit == " m")) return std::nullopt;
  return std::isfinite(value) && value > 0 ? std::optional(value) : std::nullopt;
}

double road_width_m(const ingest::Tags& tags) {
  for (const char* key : {"width_m", "width"})
    if (const auto width = metres_of(tags, key)) return *width;
  if (const auto lanes = metres_of(tags, "lanes")) return *lanes * kLane_m;
  const auto usual = highway_widths().find(value_of(tags, "highway"));
  return usual == highway_widths().end() ? kRoad_m : usual->second;
}

int road_layer(const ingest::Tags& tags) {
  const std::string text = value_of(tags, "layer");
  int layer = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), layer);
  if (failure == std::errc() && end == text.data() + text.size()) return layer;
  return is_yes(tags, "bridge") ? 1 : is_yes(tags, "tunnel") ? -1 : 0;
}

}  // namespace landfix::landmarks

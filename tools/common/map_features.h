// Landmarks and roads of a pack as the tools use them: whole, prepared, with names and colours for people.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "landfix/landfix.hpp"

namespace landfix::tools {

/// A class of landmarks as it is called in files, and its colour in pictures and styles (red, green, blue).
struct LandmarkStyle {
  const char* name;
  std::array<uint8_t, 3> colour;
};
inline constexpr std::array<LandmarkStyle, 5> kLandmarkStyles = {{{"building", {225, 55, 50}},
                                                                  {"field", {240, 195, 50}},
                                                                  {"tree", {40, 165, 75}},
                                                                  {"water", {45, 125, 235}},
                                                                  {"paved", {165, 95, 205}}}};
inline constexpr std::array<uint8_t, 3> kRoadColour = {0, 215, 230};

/// What a node at an end of a road is called in files.
const char* name_of(lf_road_node node);

struct RoadSet {
  std::vector<Road> roads;
  std::vector<Point> vertices;
};

/// All features of a layer that a query asks for. Tiles are prepared first. Throw Error with the pack's path where the
/// layer is missing or damaged; a region outside of the map has none.
std::vector<Landmark> find_landmarks(const Pack& pack, const FeatureQuery& query, const std::string& path);
std::vector<Intersection> find_intersections(const Pack& pack, const FeatureQuery& query, const std::string& path);
RoadSet find_roads(const Pack& pack, const FeatureQuery& query, const std::string& path);

/// A query for the whole map.
FeatureQuery everywhere(const Pack& pack);

/// Of a layer of landmarks: how many there are of each class; of roads: kilometres and intersections.
struct FeatureCounts {
  std::array<size_t, kLandmarkStyles.size()> of_class{};
  double roads_km = 0;
  size_t intersections = 0;
};
FeatureCounts count_features(const Pack& pack, const lf_layer_info& layer, const std::string& path);

}  // namespace landfix::tools

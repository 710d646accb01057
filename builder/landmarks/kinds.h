// What a feature of known vector data is: said by the user, by its tags or by the name of its layer.
#pragma once

#include <optional>
#include <string>

#include "builder/ingest/vectors.h"
#include "tiles/landmark.h"

namespace landfix::landmarks {

/// The first are the landmark classes, with their values.
enum class Kind : uint8_t { kBuilding = 0, kField = 1, kTree = 2, kWater = 3, kPaved = 4, kRoad = 5 };

inline constexpr const char* kKindNames = "building, field, tree, water, paved, road";

/// The inverse of name_of(); nullopt for other words.
std::optional<Kind> kind_named(const std::string& name);
const char* name_of(Kind kind);

/// By OpenStreetMap's tags, of a feature with a part of this shape: footways, tunnels and what lies below the ground
/// are nothing that a camera could take for one of the kinds.
std::optional<Kind> kind_of_tags(const ingest::Tags& tags, ingest::Shape shape);

/// Whether it has any of the tags that kind_of_tags() goes by: then its layer's name says nothing of it.
bool has_known_tags(const ingest::Tags& tags);

/// By the words of a layer's name: "gis_osm_buildings_a", "Streets", "tree cover".
std::optional<Kind> kind_of_layer(const std::string& name);

/// Width of a road in metres: `width_m` or `width` in metres; else 3.25 m a lane (`lanes`); else by its `highway` class
/// (docs/command-line.md); else 6 m.
double road_width_m(const ingest::Tags& tags);

/// OpenStreetMap's `layer`: 0 on the ground, 1 and up over what lies below; bridges without one are 1, tunnels -1.
int road_layer(const ingest::Tags& tags);

/// A number with or without " m" behind it, greater than 0; nullopt for anything else.
std::optional<double> metres_of(const ingest::Tags& tags, const std::string& key);

}  // namespace landfix::landmarks

// Where a route may not lead.
#include "tools/route/fences.h"

#include "builder/error.h"
#include "tests/route/missions.h"
#include "tools/route/polygon_file.h"

namespace landfix::route {
namespace {

std::string lon_lat(double x_m, double y_m) {
  const auto place = tiles::geodetic_from_grid(kZone, kEast + x_m, kNorth + y_m);
  return fmt::format("[{:.10f}, {:.10f}]", place->longitude_rad * 180 / M_PI, place->latitude_rad * 180 / M_PI);
}

// A square from 1000 to 2000 m to stay out of, from a GeoJSON feature.
TEST(Fences, FromGeoJson) {
  const std::string ring = lon_lat(1000, 1000) + "," + lon_lat(2000, 1000) + "," + lon_lat(2000, 2000) + "," +
                           lon_lat(1000, 2000) + "," + lon_lat(1000, 1000);
  const Fences fences(parse_polygons(
      R"({"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {}, "geometry":
          {"type": "Polygon", "coordinates": [[)" +
          ring + "]]}}]}",
      "towns.geojson", kZone));
  EXPECT_FALSE(fences.allow(at(0, 1500), at(3000, 1500)));
  EXPECT_FALSE(fences.allow(at(1200, 1500), at(1300, 1500)));  // inside, no edge is crossed
  EXPECT_TRUE(fences.allow(at(0, 2001), at(3000, 2001)));
  EXPECT_FALSE(fences.allow(at(0, 1999), at(3000, 1999)));
}

TEST(Fences, RefusesOtherFiles) {
  for (const char* bad : {"", "[]", "{\"type\": \"FeatureCollection\", \"features\": []}", "{\"type\": \"Polygon\"}",
                          "{\"type\": \"Polygon\", \"coordinates\": [[[8, 47], [9, 47], [8, 47]]]}",
                          "{\"type\": \"Polygon\", \"coordinates\": [[[8, 47], [9, \"x\"], [9, 48], [8, 47]]]}"})
    EXPECT_THROW(parse_polygons(bad, "bad.geojson", kZone), Error) << bad;
}

// A mission that must stay within 0 to 3000 m.
TEST(Fences, OfAMission) {
  const std::string polygon =
      fmt::format(R"({{"inclusion": true, "version": 1, "polygon": [[{}], [{}], [{}], [{}]]}})", degrees_at(0, 0),
                  degrees_at(3000, 0), degrees_at(3000, 3000), degrees_at(0, 3000));
  const Fences fences = fences_of(plan(item(1, 16, 10, "0, 0, 0, null", degrees_at(500, 500), 80), polygon), kZone);
  EXPECT_TRUE(fences.allow(at(100, 100), at(2900, 2900)));
  EXPECT_FALSE(fences.allow(at(100, 100), at(3100, 2900)));
  EXPECT_FALSE(fences.allow(at(4000, 100), at(4100, 100)));
}

}  // namespace
}  // namespace landfix::route

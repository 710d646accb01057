// Areas of interest, zones, and single rasters as one image.
#include "builder/ingest/area.h"

#include <cmath>

#include "builder/ingest/window.h"
#include "builder/ingest/zone.h"
#include "tests/builder/ingest_fixture.h"

namespace landfix::ingest {
namespace {

// -------------------------------------------------------------------------------------------------------------

TEST_F(Ingest, AreaTouchesWhatItCovers) {
  // A triangle, in degrees, over the image: its box's north-eastern corner is outside of it.
  const ImageSet set = images({{write("a.tif", {})}});
  const auto degrees = [](double east, double north) {
    const auto p = tiles::geodetic_from_grid(kZone32, east, north);
    return "[" + std::to_string(p->longitude_rad / kDegree) + "," + std::to_string(p->latitude_rad / kDegree) + "]";
  };
  const auto polygon = [&](const std::string& coordinates) {
    return R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":{"type":"Polygon","coordinates":[[)" +
           coordinates + "]]}}]}";
  };
  const std::string a = degrees(499'000, 5'199'000), b = degrees(501'000, 5'199'000), c = degrees(499'000, 5'201'000);
  const Area area = Area::from_file(write_text("aoi.geojson", polygon(a + "," + b + "," + c + "," + a)), kZone32);
  EXPECT_NEAR(area.bounds().west_m, 499'000, 1);
  EXPECT_NEAR(area.bounds().north_m, 5'201'000, 1);
  EXPECT_TRUE(area.touches(GridBounds{499'100, 5'199'100, 499'200, 5'199'200}));
  EXPECT_FALSE(area.touches(GridBounds{500'800, 5'200'800, 500'900, 5'200'900}));
  EXPECT_FALSE(area.touches(GridBounds{600'000, 5'200'800, 600'100, 5'200'900}));
  area.require_overlap(set);

  const Area all = Area::of_images(set);
  EXPECT_NEAR(all.bounds().east_m, 500'032, 1e-6);
  EXPECT_TRUE(all.touches(tiles::tile_of_pixel(-1, 1'000'010, -10'399'990)));
  EXPECT_FALSE(all.touches(tiles::tile_of_pixel(-1, 1'000'600, -10'399'990)));

  expect_error(ExitCode::kIo, {"none.geojson"}, [&] { Area::from_file(path("none.geojson"), kZone32); });
  expect_error(ExitCode::kBadInput, {"text.geojson", "vector"},
               [&] { Area::from_file(write_text("text.geojson", "hello"), kZone32); });
  expect_error(ExitCode::kBadInput, {"point.geojson", "no polygon"}, [&] {
    Area::from_file(write_text("point.geojson", R"({"type":"Point","coordinates":[9,47]})"), kZone32);
  });
  const std::string d = degrees(501'000, 5'201'000);
  expect_error(ExitCode::kBadInput, {"bow.geojson", "invalid", "makevalid"}, [&] {
    Area::from_file(write_text("bow.geojson", polygon(a + "," + d + "," + b + "," + c + "," + a)), kZone32);
  });
  const std::string far_a = degrees(599'000, 5'199'000), far_b = degrees(601'000, 5'199'000),
                    far_c = degrees(599'000, 5'201'000);
  const Area far =
      Area::from_file(write_text("far.geojson", polygon(far_a + "," + far_b + "," + far_c + "," + far_a)), kZone32);
  expect_error(ExitCode::kNoData, {"does not touch any image"}, [&] { far.require_overlap(set); });
}

TEST_F(Ingest, BoundingBoxOfDegrees) {
  const Area area = Area::from_bbox("8.9,46.9,9.1,47.0", kZone32);
  // Zone 32's central meridian is 9 degrees east: the box is symmetric about easting 500 km.
  EXPECT_NEAR(area.bounds().west_m + area.bounds().east_m, 1'000'000, 1e-3);
  EXPECT_TRUE(area.touches(GridBounds{500'000, 5'200'000, 500'001, 5'200'001}));
  const Area antimeridian = Area::from_bbox("179.9,-17,-179.9,-16.9", tiles::Zone{60, false});
  EXPECT_NEAR(antimeridian.bounds().east_m - antimeridian.bounds().west_m, 0.2 * 111'320 * std::cos(17 * kDegree), 500);
  for (const char* text : {"1,2,3", "a,46,9,47", "8,47,9,46", "8,46,9,95", "8,46,8,47", "8,46,9,47x"}) {
    expect_error(ExitCode::kUsage, {text, "WEST,SOUTH,EAST,NORTH"}, [&] { Area::from_bbox(text, kZone32); });
  }
  expect_error(ExitCode::kUsage, {"zone 32N"}, [&] { Area::from_bbox("170,46,171,47", kZone32); });
}

TEST_F(Ingest, ZonesByNameAndByPlace) {
  EXPECT_EQ(parse_zone("36S"), (tiles::Zone{36, false}));
  EXPECT_EQ(parse_zone("0N"), (tiles::Zone{0, true}));
  EXPECT_EQ(zone_text({7, false}), "7S");
  for (const char* text : {"", "36", "61N", "N", "36N ", "-1N", "36X"}) {
    expect_error(ExitCode::kUsage, {"zone"}, [&] { parse_zone(text); });
  }
  const std::string file = write("a.tif", {});
  EXPECT_EQ(standard_zone_of(file), kZone32);
  // Beyond its edge a zone still serves: the same image on the neighbouring grid.
  const ImageSet neighbour = images({{file}}, tiles::Zone{33, true});
  double x = 500'016, y = 5'199'988;
  transform_point("EPSG:32632", {33, true}, x, y);
  EXPECT_NEAR((neighbour.bounds().west_m + neighbour.bounds().east_m) / 2, x, 0.1);
  EXPECT_EQ(neighbour.read(pixels_covering(neighbour.bounds(), -1)).epochs.size(), 1u);
}

// ---------------------------------------------------------------------------------------------------

TEST_F(Ingest, WindowsForTheScene) {
  Sketch wide;
  wide.width = 2300;  // three blocks of 1024
  const std::string file = write("wide.tif", wide);
  const features::GridImage all = load_image({file}, kZone32);
  EXPECT_EQ(all.pixels.type(), CV_8UC3);
  EXPECT_NEAR(all.gsd_m, 0.5 / 0.9996, 1e-6);
  const features::GridImage part = load_image({file}, kZone32, GridBounds{500'500, 5'199'980, 500'600, 5'199'995}, 0.5);
  EXPECT_EQ(part.pixels.size(), cv::Size(200, 30));
  EXPECT_EQ(part.west_m, 500'500);
  EXPECT_EQ(part.pixels.at<cv::Vec3b>(0, 0),
            cv::Vec3b((17 + 3000 + 50) % 256, (34 + 3000 + 50) % 256, (51 + 3000 + 50) % 256));
  const features::GridImage heights = load_elevation({write("dem.tif", slope()), "", "", "ellipsoid"}, kZone32,
                                                     GridBounds{500'000, 5'199'980, 500'020, 5'200'000}, 0.5);
  EXPECT_FLOAT_EQ(heights.pixels.at<float>(10, 10), 400 + 2.5f - 5);
}

}  // namespace
}  // namespace landfix::ingest

// Ingest of heights: datums, units, gaps, and the geoid grid of a pack.
#include "builder/ingest/elevation.h"

#include <cmath>

#include "builder/ingest/geoid.h"
#include "tests/builder/ingest_fixture.h"

namespace landfix::ingest {
namespace {

// -------------------------------------------------------------------------------------------------------------------

double undulation(double east, double north) {
  const auto place = tiles::geodetic_from_grid(kZone32, east, north);
  OGRSpatialReference source, target;
  source.SetFromUserInput("EPSG:4326+5773");
  target.importFromEPSG(4979);
  source.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  target.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<OGRCoordinateTransformation> t(OGRCreateCoordinateTransformation(&source, &target));
  double x = place->longitude_rad / kDegree, y = place->latitude_rad / kDegree, z = 0;
  EXPECT_TRUE(t->Transform(1, &x, &y, &z));
  return z;
}

TEST_F(Ingest, HeightsComeFromTheirDatum) {
  const std::string file = write("dem.tif", slope());
  const ElevationModel plain({file, "", "", "ellipsoid"}, kZone32);
  const tiles::PixelRect rect = pixels_covering(plain.source().bounds, -1);
  const features::GridImage heights = plain.read(rect);
  EXPECT_EQ(heights.west_m, 500'000);
  EXPECT_EQ(heights.north_m, 5'200'000);
  EXPECT_EQ(cv::countNonZero(heights.valid), 64 * 48);
  EXPECT_FLOAT_EQ(heights.pixels.at<float>(20, 30), 400 + 0.25f * 30 - 0.5f * 20);

  // The geoid lies 47 to 51 m above the ellipsoid in the Alps and their foreland; the shift must be PROJ's to a
  // millimetre.
  const ElevationModel geoid({file, "", "", "EPSG:5773"}, kZone32);
  EXPECT_EQ(geoid.source().vertical_datum, "egm96");
  const float shifted = geoid.read(rect).pixels.at<float>(20, 30);
  const double expected = undulation(500'000 + 30.5 * 0.5, 5'200'000 - 20.5 * 0.5);
  EXPECT_GT(expected, 44);
  EXPECT_LT(expected, 52);
  EXPECT_NEAR(shifted - heights.pixels.at<float>(20, 30), expected, 1e-3);
}

TEST_F(Ingest, VerticalDatumIsReadFromTheFileAndNeverGuessed) {
  expect_error(ExitCode::kBadInput, {"dem.tif", "--dem-datum"},
               [&] { ElevationModel({write("dem.tif", slope())}, kZone32); });

  Sketch compound = slope();
  compound.crs = "EPSG:32632+5773";
  const std::string with_crs = write("compound.tif", compound);
  EXPECT_EQ(ElevationModel({with_crs}, kZone32).source().vertical_datum, "egm96");
  const ElevationModel contradicted({with_crs, "", "", "ellipsoid"}, kZone32);
  EXPECT_EQ(contradicted.source().vertical_datum, "ellipsoid");
  ASSERT_EQ(contradicted.warnings().size(), 1u);
  EXPECT_NE(contradicted.warnings()[0].find("egm96"), std::string::npos);

  Sketch item = slope();
  item.finish = [](GDALDataset& d) { d.SetMetadataItem("LANDFIX_VERTICAL_DATUM", "ellipsoid"); };
  EXPECT_EQ(ElevationModel({write("item.tif", item)}, kZone32).source().vertical_datum, "ellipsoid");

  const std::string file = write("sidecar.tif", slope());
  write_text("sidecar.tif.json", R"({"datum": "egm96"})");
  EXPECT_EQ(ElevationModel({file}, kZone32).source().vertical_datum, "egm96");

  expect_error(ExitCode::kUsage, {"sidecar.tif", "\"sea level\"", "egm96"}, [&] {
    ElevationModel({file, "", "", "sea level"}, kZone32);
  });
  expect_error(ExitCode::kUsage, {"EPSG:32632"}, [&] { ElevationModel({file, "", "", "EPSG:32632"}, kZone32); });
  // Swiss heights need a grid that is not part of Debian's proj-data.
  expect_error(ExitCode::kBadInput, {"LN02", "ch_swisstopo"}, [&] {
    ElevationModel({file, "", "", "EPSG:5728"}, kZone32);
  });
}

TEST_F(Ingest, HeightsWithUnitsGapsAndNoOverlap) {
  Sketch feet = slope();
  feet.finish = [](GDALDataset& d) {
    d.GetRasterBand(1)->SetUnitType("ft");
    d.GetRasterBand(1)->SetNoDataValue(400);
  };
  const ElevationModel model({write("feet.tif", feet), "", "", "ellipsoid"}, kZone32);
  const features::GridImage heights = model.read(pixels_covering(model.source().bounds, -1));
  EXPECT_NEAR(heights.pixels.at<float>(20, 30), 397.5 * 0.3048, 1e-4);
  EXPECT_EQ(heights.valid.at<uchar>(0, 0), 0);  // 400 ft is "no data"
  EXPECT_EQ(heights.valid.at<uchar>(0, 1), 255);
  model.require_overlap({500'010, 5'199'980, 500'500, 5'200'500});
  expect_error(ExitCode::kNoData, {"feet.tif", "do not overlap"}, [&] {
    model.require_overlap({600'000, 5'199'980, 600'500, 5'200'500});
  });

  Sketch furlongs = slope();
  furlongs.finish = [](GDALDataset& d) { d.GetRasterBand(1)->SetUnitType("furlong"); };
  expect_error(ExitCode::kBadInput, {"furlong"}, [&] {
    ElevationModel({write("f.tif", furlongs), "", "", "ellipsoid"}, kZone32);
  });
  expect_error(ExitCode::kBadInput, {"3 bands"}, [&] {
    ElevationModel({write("rgb.tif", {}), "", "", "ellipsoid"}, kZone32);
  });
}

TEST(Geoid, GridReproducesProj) {
  const GeoidResult result = make_geoid_grid(kZone32, {480'000, 5'190'000, 545'000, 5'230'000});
  ASSERT_TRUE(result.grid) << result.warning;
  const GeoidGrid& g = *result.grid;
  EXPECT_EQ(g.model, "egm96");
  EXPECT_EQ(g.spacing_m, 4000);
  EXPECT_EQ(g.west_m, 480'000);
  EXPECT_EQ(g.south_m, 5'188'000);
  EXPECT_EQ(g.columns, 18);                                                     // 480 to 548 km
  EXPECT_EQ(g.rows, 12);                                                        // 5188 to 5232 km
  EXPECT_NEAR(g.at(500'000, 5'200'000), undulation(500'000, 5'200'000), 1e-4);  // a node
  EXPECT_NEAR(g.at(513'700, 5'211'100), undulation(513'700, 5'211'100), 0.03);  // between nodes
  EXPECT_TRUE(std::isnan(g.at(470'000, 5'200'000)));
  EXPECT_LE(make_geoid_grid(kZone32, {0, 4e6, 2.5e6, 6e6}).grid->columns, 256);
}

}  // namespace
}  // namespace landfix::ingest

// What the runtime says of a pack's manifest is what was written.
#include <gtest/gtest.h>

#include <cstring>

#include "tests/pack/small_map.h"

namespace landfix::tests {
namespace {

Drawing described() {
  DrawnLayer height;
  height.name = "height";
  height.format = {tiles::PixelType::kI16, 1, -32768};
  height.levels = {{3, kWestX >> 3, kSouthY >> 3, "h"}};
  height.pixel = [](const PixelOf&) { return 7; };
  height.value_step = 1;
  Drawing d{.layers = {small_gray(), height}};
  d.layers[0].description = "luma";
  exporter::PackDescription& p = d.description;
  p.zone = {33, false};
  p.plane_height_m = 432.5;
  p.georegistration_error_m = 0.75;
  p.parameters = {{"gsd_m", "1"}, {"seed", "42"}};
  exporter::PackSource photo;
  photo.source.name = "photo.tif";
  photo.source.sha256 = std::string(62, '0') + "a5";
  photo.source.date = "2009-08-18";
  photo.source.licence = "CC-BY-4.0";
  photo.source.attribution = "someone";
  photo.source.crs = "EPSG:3857";
  photo.source.bands = {ingest::BandRole::kRed, ingest::BandRole::kNir};
  photo.source.gsd_m = 0.26;
  exporter::PackSource dem;
  dem.role = exporter::SourceRole::kElevation;
  dem.source.name = "dem.tif";
  dem.source.sha256 = std::string(64, 'f');
  dem.source.vertical_datum = "egm96";
  p.sources = {photo, dem};
  return d;
}

TEST(Manifest, InfoIsWhatWasWritten) {
  const OpenPack pack(draw(described()));
  const lf_info i = pack->info();
  EXPECT_EQ(i.version_major, 1);
  EXPECT_EQ(i.version_minor, 3);
  EXPECT_EQ(i.zone, 33);
  EXPECT_EQ(i.north, 0);
  EXPECT_EQ(i.is_signed, 0);
  EXPECT_EQ(i.has_heights, 1);
  EXPECT_EQ(i.layer_count, 2u);
  EXPECT_EQ(i.source_count, 2u);
  EXPECT_EQ(i.parameter_count, 2u);
  EXPECT_EQ(i.epoch_count, 0u);
  // The height tile of 2048 m and the pixels of level 1 around the map of 768 m.
  EXPECT_EQ(i.west_m, (kWestX >> 3) * 2048.0);
  EXPECT_EQ(i.south_m, (kSouthY >> 3) * 2048.0);
  EXPECT_EQ(i.east_m, i.west_m + 2048);
  EXPECT_EQ(i.north_m, std::max(i.south_m + 2048, ((kSouthY >> 1) + 2) * 512.0));
  EXPECT_EQ(i.plane_height_m, 432.5);
  EXPECT_EQ(i.georegistration_error_m, 0.75);
  EXPECT_EQ(i.file_length, pack.bytes().size());
  EXPECT_STREQ(i.builder, "a drawing");
  EXPECT_EQ(std::memcmp(i.root, pack.bytes().data() + 128, 32), 0);
}

TEST(Manifest, LayersLevelsAndTheirCounts) {
  const OpenPack pack(draw(described()));
  const uint32_t gray = pack.layer("gray"), height = pack.layer("height");
  const lf_layer_info g = *pack->layer(gray), h = *pack->layer(height);
  EXPECT_STREQ(g.name, "gray");
  EXPECT_STREQ(g.description, "luma");
  EXPECT_EQ(g.pixel_type, LF_U8);
  EXPECT_EQ(g.level_count, 2u);
  EXPECT_EQ(pack->level(gray, 0)->tile_count, 5u);
  EXPECT_EQ(pack->level(gray, 1)->level, 1);
  EXPECT_EQ(pack->level(gray, 1)->gsd_m, 2);
  EXPECT_EQ(pack->level(gray, 1)->tile_count, 4u);
  EXPECT_EQ(h.pixel_type, LF_I16);
  EXPECT_EQ(h.nodata, -32768);
  EXPECT_STREQ(h.description, "");
  EXPECT_EQ(pack->find_layer("roads").status(), LF_NO_SUCH_LAYER);
  EXPECT_EQ(pack->layer(2).status(), LF_INVALID_ARGUMENT);
  EXPECT_EQ(pack->level(gray, 2).status(), LF_INVALID_ARGUMENT);
  EXPECT_EQ(pack->level(2, 0).status(), LF_INVALID_ARGUMENT);
}

TEST(Manifest, SourcesAndParameters) {
  const OpenPack pack(draw(described()));
  const lf_source_info photo = *pack->source(0), dem = *pack->source(1);
  EXPECT_STREQ(photo.name, "photo.tif");
  EXPECT_STREQ(photo.capture_date, "2009-08-18");
  EXPECT_STREQ(photo.licence, "CC-BY-4.0");
  EXPECT_STREQ(photo.attribution, "someone");
  EXPECT_STREQ(photo.crs, "EPSG:3857");
  EXPECT_STREQ(photo.vertical_datum, "");
  EXPECT_EQ(photo.role, 0);
  EXPECT_EQ(photo.gsd_m, 0.26);
  EXPECT_EQ(photo.sha256[30], 0);
  EXPECT_EQ(photo.sha256[31], 0xA5);
  EXPECT_EQ(dem.role, 1);
  EXPECT_STREQ(dem.capture_date, "");
  EXPECT_STREQ(dem.vertical_datum, "egm96");
  EXPECT_EQ(pack->source(2).status(), LF_INVALID_ARGUMENT);
  ASSERT_TRUE(pack->parameter(1));
  EXPECT_EQ(pack->parameter(1)->first, "seed");
  EXPECT_EQ(pack->parameter(1)->second, "42");
  EXPECT_EQ(pack->parameter(2).status(), LF_INVALID_ARGUMENT);
}

TEST(Manifest, APackOfOneLayerSaysNothingOfTheRest) {
  const OpenPack pack(small_pack());
  EXPECT_EQ(pack->info().source_count, 0u);
  EXPECT_EQ(pack->info().georegistration_error_m, -1);  // not stated
  EXPECT_EQ(*pack->verify(true), 9u);
}

}  // namespace
}  // namespace landfix::tests

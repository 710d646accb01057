// `landfix export navigability` as a user runs it, on a drawn pack of 4 x 4 nodes.
#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogrsf_frmts.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/tools/command.h"
#include "tests/tools/navigability_world.h"

namespace landfix {
namespace {

using nlohmann::json;
using tests::kJudgedChances;
using tests::kJudgedNorth;
using tests::kJudgedWest;

constexpr int kDone = 0, kUsage = 2, kNoData = 6, kIo = 7;

class ExportNavigability : public testing::Test {
 protected:
  ExportNavigability() {
    save("map.lfpack", tests::judged_drawing());
    GDALAllRegister();
  }
  void save(const std::string& name, const tests::Drawing& drawing) const {
    tests::write_file(path(name), tests::draw(drawing));
  }
  std::string path(const std::string& name) const { return folder_.file(name); }
  tests::Outcome run(const std::string& arguments) const {
    return tests::run_landfix(folder_.file(""), "export navigability " + arguments);
  }
  void expect_done(const std::string& arguments) const {
    const tests::Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, kDone) << outcome.out;
  }
  void expect_refusal(const std::string& arguments, int code, const std::vector<std::string>& words) const {
    tests::expect_refusal(run(arguments), code, words);
  }
  GDALDatasetUniquePtr open(const std::string& name, unsigned kind) const {
    return GDALDatasetUniquePtr(GDALDataset::Open(path(name).c_str(), kind));
  }
  /// Of a band of a file, north-western pixel first.
  std::vector<float> values(const std::string& name, const std::string& band) const {
    const GDALDatasetUniquePtr file = open(name, GDAL_OF_RASTER);
    std::vector<float> out(16);
    for (auto* b : file->GetBands())
      if (band == b->GetDescription()) {
        EXPECT_EQ(b->RasterIO(GF_Read, 0, 0, 4, 4, out.data(), 4, 4, GDT_Float32, 0, 0, nullptr), CE_None);
      }
    return out;
  }

 private:
  tests::TemporaryFolder folder_;
};

// Half of a step of 0.0725 in log odds changes a chance by at most 0.0091.
constexpr double kStep = 0.0092;

TEST_F(ExportNavigability, RasterIsCloudOptimisedOnTheGridWithItsStyle) {
  expect_done("map.lfpack -o out.tif");
  const GDALDatasetUniquePtr file = open("out.tif", GDAL_OF_RASTER);
  ASSERT_TRUE(file);
  EXPECT_STREQ(file->GetMetadataItem("LAYOUT", "IMAGE_STRUCTURE"), "COG");
  EXPECT_STREQ(file->GetSpatialRef()->GetAuthorityCode(nullptr), "32632");
  double transform[6];
  file->GetGeoTransform(transform);
  EXPECT_EQ(std::vector<double>(transform, transform + 6),
            (std::vector<double>{kJudgedWest, 64, 0, kJudgedNorth, 0, -64}));
  EXPECT_STREQ(file->GetRasterBand(1)->GetDescription(), "fix_auto");
  const std::vector<float> chances = values("out.tif", "fix_auto"), landmarks = values("out.tif", "landmarks"),
                           rival = values("out.tif", "rival_m");
  for (size_t i = 0; i < 12; ++i) {
    EXPECT_NEAR(chances[i], kJudgedChances[i % 4], kStep) << i;
    EXPECT_EQ(landmarks[i], float(i / 4)) << "rows run from north to south";
    EXPECT_EQ(std::isnan(rival[i]), i % 4 != 0) << "no other place looks like it";
  }
  for (size_t i = 12; i < 16; ++i) EXPECT_TRUE(std::isnan(chances[i])) << "nothing is said of the last row";
  EXPECT_NEAR(values("out.tif", "direction_deg")[0], 90, 0.4);
  const std::vector<uint8_t> style = tests::read_file(path("out.qml"));
  const std::string qml(style.begin(), style.end());
  EXPECT_NE(qml.find("singlebandpseudocolor\" band=\"1\""), std::string::npos);
  for (const char* label : {"below 0.2", "0.2 to 0.5", "0.5 to 0.8", "0.8 to 0.95", "0.95 and more"})
    EXPECT_NE(qml.find("label=\"" + std::string(label) + "\""), std::string::npos) << label;
}

TEST_F(ExportNavigability, SquaresHaveReasonsInWords) {
  expect_done("map.lfpack -o out.gpkg");
  const GDALDatasetUniquePtr file = open("out.gpkg", GDAL_OF_VECTOR);
  ASSERT_TRUE(file);
  OGRLayer* layer = file->GetLayerByName("navigability");
  ASSERT_TRUE(layer);
  ASSERT_EQ(layer->GetFeatureCount(), 12);
  const OGRFeatureUniquePtr first(layer->GetNextFeature()), second(layer->GetNextFeature());
  OGREnvelope box;
  second->GetGeometryRef()->getEnvelope(&box);
  EXPECT_EQ(box.MinX, kJudgedWest + 64);
  EXPECT_EQ(box.MaxX, kJudgedWest + 128);
  EXPECT_EQ(box.MaxY, kJudgedNorth);
  EXPECT_EQ(box.MinY, kJudgedNorth - 64);
  EXPECT_NEAR(second->GetFieldAsDouble("fix_auto"), 0.3, kStep);
  EXPECT_EQ(second->GetFieldAsDouble("fix_orientation"), 0.5);
  EXPECT_EQ(second->GetFieldIndex("fix_gray"), -1) << "not judged";
  EXPECT_STREQ(second->GetFieldAsString("reasons"), "");
  EXPECT_TRUE(second->IsFieldNull(second->GetFieldIndex("rival_m")));
  EXPECT_EQ(std::string(first->GetFieldAsString("reasons")).rfind("uniform field, looks like the place 1", 0), 0u)
      << first->GetFieldAsString("reasons");
  EXPECT_NE(std::string(first->GetFieldAsString("reasons")).find("m to the north-east"), std::string::npos);
  OGRLayer* styles = file->GetLayerByName("layer_styles");
  ASSERT_TRUE(styles);
  const OGRFeatureUniquePtr style(styles->GetNextFeature());
  EXPECT_STREQ(style->GetFieldAsString("f_table_name"), "navigability");
  EXPECT_NE(std::string(style->GetFieldAsString("styleQML")).find("graduatedSymbol\" attr=\"fix_auto\""),
            std::string::npos);
}

TEST_F(ExportNavigability, PictureHasTheColoursOverTheMapAndALegend) {
  expect_done("map.lfpack -o out.png");
  const cv::Mat picture = cv::imread(path("out.png"));
  ASSERT_EQ(picture.cols, 1200);
  EXPECT_GT(picture.rows, 1230) << "1200 pixels of map, and the legend";
  // In the middle of every node the class's colour (blue, green, red), darker by the map's gray of 100: 0.5 + 0.5 · 100
  // / 255.
  const std::array<cv::Vec3b, 4> classes = {
      {{28, 25, 215}, {97, 174, 253}, {191, 255, 255}, {182, 123, 44}}};  // 0.1, 0.3, 0.6 and 0.97
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row) {
      const cv::Vec3b seen = picture.at<cv::Vec3b>(150 + 300 * row, 150 + 300 * column);
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(seen[k], classes[size_t(column)][k] * 0.696, 1.2) << column << " " << k;
    }
  EXPECT_EQ(picture.at<cv::Vec3b>(1050, 150), cv::Vec3b(100, 100, 100)) << "nothing is said of it: the map as it is";
}

TEST_F(ExportNavigability, SameBytesAgain) {
  for (const std::string extension : {"tif", "gpkg", "png"}) {
    expect_done("map.lfpack -o a." + extension);
    expect_done("map.lfpack -o b." + extension);
    EXPECT_TRUE(tests::read_file(path("a." + extension)) == tests::read_file(path("b." + extension))) << extension;
  }
}

TEST_F(ExportNavigability, ChancesFallWithTheAgeOfTheMap) {
  expect_done("map.lfpack -o usual.tif");
  expect_done("map.lfpack -o fresh.tif --date 2016-07-16");
  expect_done("map.lfpack -o old.tif --date 2026-07-16");
  const float usual = values("usual.tif", "fix_auto")[2], fresh = values("fresh.tif", "fix_auto")[2],
              old = values("old.tif", "fix_auto")[2];
  const auto logit = [](double p) { return std::log(p / (1 - p)); };
  // 0.6 of the logarithm of one more than the years; as they are they hold for two years.
  EXPECT_NEAR(logit(fresh) - logit(usual), 0.6 * std::log(3.0), 1e-4);
  EXPECT_NEAR(logit(usual) - logit(old), 0.6 * std::log(11.0 / 3), 1e-3);
  expect_done("map.lfpack -o old.gpkg --date 2026-07-16");
  const GDALDatasetUniquePtr file = open("old.gpkg", GDAL_OF_VECTOR);
  OGRLayer* layer = file->GetLayerByName("navigability");
  const OGRFeatureUniquePtr first(layer->GetNextFeature()), second(layer->GetNextFeature());
  EXPECT_STREQ(second->GetFieldAsString("reasons"), "map older than 5 years");
}

TEST_F(ExportNavigability, SaysWhatIsWrong) {
  expect_refusal("map.lfpack", kUsage, {"--output"});
  expect_refusal("map.lfpack -o out.jpg", kUsage, {"out.jpg", ".tif", ".gpkg", ".png"});
  expect_refusal("map.lfpack -o out.tif --footprint wide", kUsage, {"--footprint wide", "160/320"});
  expect_refusal("map.lfpack -o out.tif --footprint 320/160", kNoData, {"320/160", "there is 160/160"});
  expect_refusal("map.lfpack -o out.tif --matcher gray", kNoData, {"map.lfpack", "gray"});
  expect_refusal("map.lfpack -o out.tif --matcher colour", kUsage, {"colour", "orientation"});
  expect_refusal("map.lfpack -o out.tif --date yesterday", kUsage, {"--date yesterday", "2018-07-16"});
  for (const std::string extension : {"tif", "gpkg", "png"})
    expect_refusal("map.lfpack -o nowhere/out." + extension, kIo, {"nowhere/out." + extension});
  tests::Drawing drawing = tests::judged_drawing();
  drawing.layers[1].pixel = [dated = drawing.layers[1].pixel](const tests::PixelOf& p) {
    return p.channel < 17 ? dated(p) : 0;  // without the day, its last two channels
  };
  save("undated.lfpack", drawing);
  expect_refusal("undated.lfpack -o out.tif --date 2020-01-01", kNoData, {"undated.lfpack", "--date"});
  drawing.layers.pop_back();
  save("bare.lfpack", drawing);
  expect_refusal("bare.lfpack -o out.tif", kNoData, {"bare.lfpack", "--navigability"});
  EXPECT_FALSE(std::filesystem::exists(path("out.tif")));
}

}  // namespace
}  // namespace landfix

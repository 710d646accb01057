// Training on drawn ground whose classes are plain to see.
#include "builder/training/training.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>

#include "builder/error.h"
#include "builder/ingest/gdal.h"
#include "builder/training/cover.h"
#include "builder/training/k_means.h"
#include "builder/training/platt.h"

namespace landfix::landmarks {
namespace {

using features::LandmarkLabel;

/// Roofs on gray ground, or crowns on green, or bare brown ground.
cv::Mat drawn(LandmarkLabel label, cv::RNG& random) {
  cv::Mat patch(kPatchPx, kPatchPx, CV_8UC3);
  const bool tree = label == LandmarkLabel::kTree;
  patch.setTo(tree ? cv::Scalar(60, 110, 50) : cv::Scalar(140, 120, 90));
  if (label == LandmarkLabel::kBuilding)
    cv::rectangle(patch, cv::Rect(20 + random.uniform(-3, 3), 21, 16, 12), cv::Scalar(200, 90, 70), cv::FILLED);
  for (int i = 0; tree && i < 40; ++i)
    cv::circle(patch, {random.uniform(0, kPatchPx), random.uniform(0, kPatchPx)}, 3, cv::Scalar(25, 60, 20),
               cv::FILLED);
  cv::Mat noise(patch.size(), CV_8UC3);
  random.fill(noise, cv::RNG::UNIFORM, 0, 12);
  return patch + noise;
}

std::vector<Sample> drawn_samples(int places) {
  cv::RNG random(7);
  std::vector<Sample> samples;
  for (int place = 0; place < places; ++place)
    for (const LandmarkLabel label : {LandmarkLabel::kBuilding, LandmarkLabel::kField, LandmarkLabel::kTree})
      samples.push_back({drawn(label, random), label, place, true});
  return samples;
}

TrainingOptions quick() {
  TrainingOptions options;
  options.words = 16, options.descriptors = 1500;
  return options;
}

TEST(Training, LearnsWhatIsPlainAndGivesTheSameBytesAgain) {
  const std::vector<Sample> samples = drawn_samples(12);
  HeldOut held_out, again;
  const features::LandmarkModel model = train(samples, quick(), held_out);
  for (size_t k = 0; k < 3; ++k) EXPECT_EQ(held_out.colour.confusion[k][k], 12) << k;
  EXPECT_EQ(encode_model(train(samples, quick(), again)), encode_model(model));
  EXPECT_EQ(again.colour.confusion, held_out.colour.confusion);
}

TEST(Training, AModelKnowsUnseenChipsInColourAndInGray) {
  HeldOut held_out;
  const features::LandmarkModel model = train(drawn_samples(12), quick(), held_out);
  cv::RNG random(99);
  features::LandmarkClassifier classifier(model);
  for (const LandmarkLabel label : {LandmarkLabel::kBuilding, LandmarkLabel::kField, LandmarkLabel::kTree}) {
    cv::Mat patch = drawn(label, random), gray;
    cv::cvtColor(patch, gray, cv::COLOR_RGB2GRAY);
    for (const cv::Mat& image : {patch, gray}) {
      features::LandmarkAnswer answer;
      ASSERT_EQ(classifier.prepare(image, {}, false), features::ClassifierStatus::kOk);
      ASSERT_EQ(classifier.classify(14, 14, answer), features::ClassifierStatus::kOk);
      EXPECT_EQ(answer.label, label) << image.channels() << " channels";
    }
  }
}

TEST(Training, TurnedAndMirroredChipsAreOfTheSameClass) {
  HeldOut held_out;
  const features::LandmarkModel model = train(drawn_samples(12), quick(), held_out);
  cv::RNG random(3);
  features::LandmarkClassifier classifier(model);
  for (const LandmarkLabel label : {LandmarkLabel::kBuilding, LandmarkLabel::kField, LandmarkLabel::kTree}) {
    cv::Mat patch = drawn(label, random);
    for (int turn = 0; turn < 8; ++turn) {
      if (turn == 4) cv::flip(patch, patch, 1);
      cv::rotate(patch, patch, cv::ROTATE_90_CLOCKWISE);
      features::LandmarkAnswer answer;
      ASSERT_EQ(classifier.prepare(patch, {}, false), features::ClassifierStatus::kOk);
      ASSERT_EQ(classifier.classify(14, 14, answer), features::ClassifierStatus::kOk);
      EXPECT_EQ(answer.label, label) << turn;
    }
  }
}

TEST(Training, AllAtOnePlaceIsRefused) {
  std::vector<Sample> samples = drawn_samples(4);
  for (Sample& s : samples) s.place = 3;
  HeldOut held_out;
  EXPECT_THROW(train(samples, quick(), held_out), Error);
}

TEST(Training, OneClassIsRefused) {
  std::vector<Sample> samples = drawn_samples(4);
  for (Sample& s : samples) s.label = LandmarkLabel::kField;
  HeldOut held_out;
  EXPECT_THROW(train(samples, quick(), held_out), Error);
}

TEST(KMeans, FindsTheCentresThatPointsWereDrawnAround) {
  cv::RNG random(8);
  cv::Mat points(300, 2, CV_32FC1);
  for (int i = 0; i < points.rows; ++i)
    for (int d = 0; d < 2; ++d)
      points.at<float>(i, d) = float(10 * (d == 0 ? i % 3 : i % 3 == 1) + random.uniform(-1.0, 1.0));
  cv::Mat centres = k_means(points, 3, 1);
  EXPECT_EQ(cv::norm(centres, k_means(points, 3, 1), cv::NORM_INF), 0);
  cv::sort(centres.col(0).clone(), centres, cv::SORT_EVERY_COLUMN | cv::SORT_ASCENDING);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(centres.at<float>(i), 10 * i, 0.3);
}

TEST(Judgement, CalibrationErrorIsWhatTheAnswersAreOffBy) {
  Judgement judgement;
  features::LandmarkAnswer answer;
  answer.label = LandmarkLabel::kTree, answer.confidence = 0.95f;
  for (int i = 0; i < 4; ++i) judgement.add(i < 3 ? LandmarkLabel::kTree : LandmarkLabel::kField, answer);
  answer.confidence = 0.55f;
  judgement.add(LandmarkLabel::kField, answer);
  // 4 answers of 0.95 of which 3 are right: 0.8 too much; one of 0.55 that is wrong: 0.55; of 5.
  EXPECT_NEAR(judgement.calibration_error(), (0.8 + 0.55) / 5, 1e-6);
  EXPECT_EQ(judgement.confusion[2][2], 3);
  EXPECT_EQ(judgement.confusion[1][2], 2);
  EXPECT_TRUE(std::isnan(Judgement{}.calibration_error()));
}

/// 400 m x 400 m at (500 km, 5400 km), nothing in it.
features::GridImage blank() {
  return {cv::Mat(400, 400, CV_8UC3, cv::Scalar::all(99)), cv::Mat(400, 400, CV_8UC1, cv::Scalar(255)), 500'000,
          5'400'400, 1};
}

ingest::VectorPart square(double east_m, double north_m, double side_m) {
  const double h = side_m / 2;
  return {ingest::Shape::kPolygon,
          {{east_m - h, north_m - h}, {east_m + h, north_m - h}, {east_m + h, north_m + h}, {east_m - h, north_m + h}},
          {east_m, north_m}};
}

TEST(Cover, DrawsPlacesOfWhatTheVectorsShow) {
  const features::GridImage image = blank();
  Cover cover(image);
  cover.add(Kind::kBuilding, square(500'100, 5'400'300, 20), 0);
  cover.add(Kind::kWater, square(500'300, 5'400'300, 120), 0);
  cover.add(Kind::kTree, square(500'300, 5'400'100, 100), 0);
  cover.open_elsewhere();
  std::array<int, features::kLandmarkLabels> counts{};
  for (const Chip& chip : cover.draw({1, 10})) {
    ++counts[size_t(chip.label)];
    const auto away = [&](double east_m, double north_m) {
      return std::max(std::abs(chip.east_m - east_m), std::abs(chip.north_m - north_m));
    };
    if (chip.label == LandmarkLabel::kBuilding) {
      EXPECT_LE(away(500'100, 5'400'300), 5);
    }
    if (chip.label == LandmarkLabel::kWater) {
      EXPECT_LE(away(500'300, 5'400'300), 45);
    }
    if (chip.label == LandmarkLabel::kTree) {
      EXPECT_LE(away(500'300, 5'400'100), 60);
    }
    if (chip.label == LandmarkLabel::kField) {
      EXPECT_GE(away(500'100, 5'400'300), 19);  // 10 m of building and 10 m of the window, less a pixel
      EXPECT_GE(away(500'300, 5'400'100), 50);
    }
  }
  EXPECT_EQ(counts, (std::array<int, 6>{10, 10, 10, 10, 0, 0}));
}

TEST(Cover, NothingIsDrawnWhereTheImageHasNoData) {
  features::GridImage image = blank();
  image.valid.setTo(0);
  Cover cover(image);
  cover.add(Kind::kBuilding, square(500'100, 5'400'300, 20), 0);
  cover.open_elsewhere();
  EXPECT_TRUE(cover.draw({1, 10}).empty());
}

TEST(Platt, FindsTheSigmoidThatValuesWereDrawnFrom) {
  cv::RNG random(5);
  std::vector<double> values;
  std::vector<bool> yes;
  for (int i = 0; i < 20000; ++i) {
    values.push_back(random.uniform(-3.0, 3.0));
    yes.push_back(random.uniform(0.0, 1.0) < 1 / (1 + std::exp(-2 * values.back() + 0.5)));
  }
  const Sigmoid found = fit_sigmoid(values, yes);
  EXPECT_NEAR(found.a, -2, 0.1);
  EXPECT_NEAR(found.b, 0.5, 0.1);
}

class Chips : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// A raster of `pixels` metres of Web Mercator at 60 degrees north: a pixel is half a metre on the ground.
  std::string mercator_image(int pixels) const {
    const std::string path = folder_ + "/image.tif";
    ingest::setup_gdal();
    const GDALDatasetUniquePtr file(
        GetGDALDriverManager()->GetDriverByName("GTiff")->Create(path.c_str(), pixels, pixels, 3, GDT_Byte, nullptr));
    double transform[6] = {kWest, 1, 0, kNorth, 0, -1};
    OGRSpatialReference crs;
    crs.importFromEPSG(3857);
    file->SetGeoTransform(transform);
    file->SetSpatialRef(&crs);
    for (int band = 1; band <= 3; ++band) file->GetRasterBand(band)->Fill(50 * band);
    return path;
  }
  std::string csv(const std::string& text) const {
    const std::string path = folder_ + "/chips.csv";
    std::ofstream(path) << text;
    return path;
  }
  /// What reading a CSV of one row is refused with.
  std::string refusal(const std::string& row) const {
    try {
      read_chips(csv("id,x,y,size_m,label\n" + row), image_);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  }

  static constexpr double kWest = 1'000'000, kNorth = 8'399'738;
  const std::string folder_ =
      (std::filesystem::temp_directory_path() / ("landfix_chips_" + std::to_string(::getpid()))).string();
  const std::string image_ = (std::filesystem::create_directories(folder_), mercator_image(300));
};

TEST_F(Chips, SizesAreMetresOnTheGroundWhateverTheCrs) {
  // 40 m on the ground are 80 units here. Squares 70 units apart overlap: one place; the third, 90 from the second,
  // does not.
  const LabelledImage read = read_chips(csv("id,x,y,size_m,label\n"
                                            "a,1000060,8399678,40,tree\nb,1000130,8399678,40,field\n"
                                            "c,1000220,8399678,40,water\nd,1000220,8399500,40,mixed\n"),
                                        image_);
  ASSERT_EQ(read.chips.size(), 3u);
  EXPECT_NEAR(std::hypot(read.chips[1].east_m - read.chips[0].east_m, read.chips[1].north_m - read.chips[0].north_m),
              35, 0.3);
  EXPECT_EQ(read.chips[0].place, read.chips[1].place);
  EXPECT_NE(read.chips[1].place, read.chips[2].place);
  EXPECT_EQ(read.chips[2].label, LandmarkLabel::kWater);
}

TEST_F(Chips, RefusalsSayWhereAndWhat) {
  EXPECT_NE(refusal("1,2000000,8399678,40,tree\n").find("coordinates in the CRS"), std::string::npos);
  // 30 units from the edge are 15 m: too near for half of 40 m.
  EXPECT_NE(refusal("1,1000030,8399600,40,tree\n").find("not inside"), std::string::npos);
  EXPECT_EQ(refusal("1,1000050,8399600,40,tree\n"), "");
  EXPECT_NE(refusal("1,1000050,8399600,40,house\n").find("'house'"), std::string::npos);
  EXPECT_NE(refusal("1,1000050,8399600,40,tree\n2,10000").find("line 3"), std::string::npos);  // cut off
  EXPECT_NE(refusal("1,1000050,8399600,40\n").find("line 2"), std::string::npos);
  EXPECT_NE(refusal("1,here,8399600,40,tree\n").find("'here'"), std::string::npos);
  EXPECT_NE(refusal("1,1000050,8399600,-4,tree\n").find("positive"), std::string::npos);
  EXPECT_NE(refusal("1,1000050,8399600,40,mixed\n").find("no labelled chip"), std::string::npos);
  EXPECT_THROW(read_chips(csv("id,x,y\n"), image_), Error);
  EXPECT_THROW(read_chips(folder_ + "/none.csv", image_), Error);
}

}  // namespace
}  // namespace landfix::landmarks

// Oblique views of a ramp, a hill and a building: marks lie where they are, hidden ground does not vote.
#include "runtime/nav/terrain.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "runtime/nav/rectify.h"
#include "tests/nav/relief_scene.h"

namespace landfix::nav {
namespace {

using features::GridImage;
using testing::ReliefScene;

constexpr double kDegree = 0.017453292519943295;
constexpr double kEast = 678'000, kNorth = 3'467'000;  ///< where floats alone would lose decimetres
constexpr double kMarkSpacing = 24;                    ///< metres between the marks

/// Dark ground with a bright mark of 1.2 m (one sigma) every 24 m.
double marks(double east, double north) {
  const double de = std::remainder(east - kEast, kMarkSpacing), dn = std::remainder(north - kNorth, kMarkSpacing);
  return 20 + 220 * std::exp(-(de * de + dn * dn) / (2 * 1.2 * 1.2));
}

const ReliefScene kRamp{[](double e, double n) { return 250 + 0.3 * (e - kEast) + 0.1 * (n - kNorth); }, marks, 400};
const ReliefScene kHill{[](double e, double n) {
                          const double de = e - kEast, dn = n - kNorth - 90;
                          return 250 + 60 * std::exp(-(de * de + dn * dn) / (2 * 35 * 35));
                        },
                        marks, 310};
/// 24 m × 24 m and 15 m high, a mark on its roof and one behind it.
const ReliefScene kBuilding{
    [](double e, double n) { return std::abs(e - kEast) < 12 && std::abs(n - kNorth - 96) < 12 ? 265.0 : 250.0; },
    marks, 265};

struct Look {
  Camera camera;
  Attitude attitude;
  Position position;
};

/// From 120 m above the plane, `pitch_deg` up from straight down, northwards.
Look look(double pitch_deg, const Distortion& lens = {}) {
  Look l{camera_from_field_of_view(400, 300, 60 * kDegree), {0.05, pitch_deg * kDegree, 0.2}, {kEast, kNorth, 370}};
  l.camera.distortion = lens;
  return l;
}

/// Distance in patch pixels between a mark's true place and its centre of light; negative if any of its surroundings
/// was not seen.
double mark_error_px(const GridImage& patch, double east, double north) {
  const int column = int(std::lround(patch.column_of(east))), row = int(std::lround(patch.row_of(north)));
  const int reach = int(std::ceil(4 / patch.gsd_m));
  const cv::Rect around(column - reach, row - reach, 2 * reach + 1, 2 * reach + 1);
  if ((around & cv::Rect({0, 0}, patch.valid.size())) != around) return -1;
  if (cv::countNonZero(patch.valid(around)) < around.area()) return -1;
  double sum = 0, x = 0, y = 0;
  for (int r = around.y; r < around.br().y; ++r)
    for (int c = around.x; c < around.br().x; ++c) {
      const double light = std::max(patch.pixels.at<uint8_t>(r, c) - 30, 0);
      sum += light, x += light * c, y += light * r;
    }
  return std::hypot(x / sum - patch.column_of(east), y / sum - patch.row_of(north));
}

struct Marks {
  int seen = 0;
  double worst_px = 0;
};

Marks find_marks(const GridImage& patch) {
  Marks m;
  // Farther than two heights away an image pixel covers more than two metres along the line of sight.
  for (int i = -10; i <= 10; ++i)
    for (int j = -10; j <= 10; ++j) {
      const double error = mark_error_px(patch, i * kMarkSpacing, j * kMarkSpacing);
      if (error < 0) continue;
      ++m.seen;
      m.worst_px = std::max(m.worst_px, error);
    }
  return m;
}

TEST(RectifyTerrain, PutsMarksOfARampAndAHillInTheirPlaces) {
  for (const ReliefScene* scene : {&kRamp, &kHill}) {
    for (const Look& l : {look(0), look(30, {-0.25, 0.06, 0.001, -0.001}), look(45)}) {
      const cv::Mat image = scene->take_picture(l.camera, l.attitude, l.position);
      const Terrain terrain{scene->heights(kEast, kNorth, 400, 2), 250};
      GridImage patch;
      TerrainUse use;
      ASSERT_EQ(rectify(image, l.camera, l.attitude, l.position, terrain, 0.5, patch, &use), Status::kOk);
      EXPECT_EQ(use.known, 1);
      const Marks m = find_marks(patch);
      EXPECT_GE(m.seen, 12);
      EXPECT_LT(m.worst_px, 0.5) << "pitch " << l.attitude.pitch << " k1 " << l.camera.distortion.k1;
      // What it is for: the plane alone puts the same marks metres away.
      GridImage plane;
      ASSERT_EQ(rectify(image, l.camera, l.attitude, 120, 0.5, plane), Status::kOk);
      EXPECT_GT(find_marks(plane).worst_px, 4);
    }
  }
}

TEST(RectifyTerrain, PutsTheMarkOnARoofInItsPlace) {
  for (double pitch_deg : {30.0, 45.0}) {
    const Look l = look(pitch_deg);
    const cv::Mat image = kBuilding.take_picture(l.camera, l.attitude, l.position);
    const Terrain terrain{kBuilding.heights(kEast, kNorth, 400, 0.5), 250};
    GridImage patch;
    ASSERT_EQ(rectify(image, l.camera, l.attitude, l.position, terrain, 0.5, patch), Status::kOk);
    EXPECT_GE(mark_error_px(patch, 0, 96), 0);
    EXPECT_LT(mark_error_px(patch, 0, 96), 0.5);
    EXPECT_LT(find_marks(patch).worst_px, 0.5);
  }
}

/// What the scene's own formula says of each patch pixel within the camera's image.
struct Sight {
  cv::Mat asked, visible, hidden;  ///< 255; hidden by more than 0.3 m, a grazing line of sight is neither
};

Sight lines_of_sight(const ReliefScene& scene, const Look& l, const GridImage& patch) {
  const Lens lens(l.camera);
  const Eigen::Matrix3d cam_from_enu = enu_from_camera(l.attitude).transpose();
  Sight s{cv::Mat::zeros(patch.valid.size(), CV_8UC1), cv::Mat::zeros(patch.valid.size(), CV_8UC1),
          cv::Mat::zeros(patch.valid.size(), CV_8UC1)};
  for (int y = 0; y < patch.valid.rows; ++y)
    for (int x = 0; x < patch.valid.cols; ++x) {
      const double e = patch.west_m + (x + 0.5) * patch.gsd_m, n = patch.north_m - (y + 0.5) * patch.gsd_m;
      const double up = scene.height_m(kEast + e, kNorth + n) - l.position.height_m;
      Eigen::Vector2d pixel;
      // The outline of the picture is not the question.
      if (!lens.pixel_of(cam_from_enu * Eigen::Vector3d(e, n, up), pixel) || pixel.x() < 4 || pixel.y() < 4 ||
          pixel.x() > l.camera.width - 5 || pixel.y() > l.camera.height - 5)
        continue;
      s.asked.at<uint8_t>(y, x) = 255;
      if (scene.visible(kEast + e, kNorth + n, l.position)) s.visible.at<uint8_t>(y, x) = 255;
      if (!scene.visible(kEast + e, kNorth + n, l.position, 0.3)) s.hidden.at<uint8_t>(y, x) = 255;
    }
  return s;
}

TEST(RectifyTerrain, LeavesOutWhatIsHidden) {
  struct Case {
    const ReliefScene& scene;
    double pitch_deg, heights_gsd_m, gsd_m;
  };
  for (const Case& c :
       {Case{kHill, 45, 2, 1}, Case{kHill, 30, 2, 1}, Case{kBuilding, 45, 0.5, 0.5}, Case{kBuilding, 30, 0.5, 0.5}}) {
    const Look l = look(c.pitch_deg);
    const cv::Mat image(l.camera.height, l.camera.width, CV_8UC1, cv::Scalar(9));
    const Terrain terrain{c.scene.heights(kEast, kNorth, 400, c.heights_gsd_m), 250};
    GridImage patch;
    TerrainUse use;
    ASSERT_EQ(rectify(image, l.camera, l.attitude, l.position, terrain, c.gsd_m, patch, &use), Status::kOk);
    const Sight sight = lines_of_sight(c.scene, l, patch);
    const int hidden = cv::countNonZero(sight.hidden);
    const cv::Mat missed = sight.hidden & patch.valid, invented = sight.visible & ~patch.valid;
    std::printf("pitch %.0f: %d pixels hidden, %d of them missed, %d others left out\n", c.pitch_deg, hidden,
                cv::countNonZero(missed), cv::countNonZero(invented));
    EXPECT_GT(hidden, 300);
    // Walls between heights half a metre apart lean: three pixels on each side of an edge may differ.
    cv::Mat surely_hidden, surely_visible;
    const cv::Mat kernel = cv::getStructuringElement(cv::MORPH_RECT, {7, 7});
    cv::erode(sight.hidden, surely_hidden, kernel);
    cv::erode(sight.visible, surely_visible, kernel);
    EXPECT_EQ(cv::countNonZero(surely_hidden & patch.valid), 0);
    EXPECT_EQ(cv::countNonZero(surely_visible & ~patch.valid & sight.asked), 0);
    EXPECT_NEAR(use.hidden, double(hidden) / cv::countNonZero(sight.asked), 0.02);
  }
}

TEST(RectifyTerrain, OnFlatGroundIsThePlane) {
  const Look l = look(30, {-0.1, 0.02});
  const ReliefScene flat{[](double, double) { return 250.0; }, marks, 250};
  const cv::Mat image = flat.take_picture(l.camera, l.attitude, l.position);
  const Terrain terrain{flat.heights(kEast, kNorth, 400, 1), 250};
  for (const Distortion& lens : {Distortion{}, l.camera.distortion}) {
    Camera camera = l.camera;
    camera.distortion = lens;
    for (double gsd_m : {0.5, 2.0}) {
      GridImage by_heights, by_plane;
      ASSERT_EQ(rectify(image, camera, l.attitude, l.position, terrain, gsd_m, by_heights), Status::kOk);
      ASSERT_EQ(rectify(image, camera, l.attitude, 120, gsd_m, by_plane), Status::kOk);
      ASSERT_EQ(by_heights.pixels.size(), by_plane.pixels.size());
      EXPECT_EQ(by_heights.west_m, by_plane.west_m);
      EXPECT_EQ(by_heights.north_m, by_plane.north_m);
      EXPECT_EQ(cv::countNonZero(by_heights.valid != by_plane.valid), 0);
      cv::Mat difference;
      cv::absdiff(by_heights.pixels, by_plane.pixels, difference);
      double worst;
      cv::minMaxLoc(difference, nullptr, &worst, nullptr, nullptr, by_plane.valid);
      // Both round image coordinates to 1/32 of a pixel; the marks rise by up to 40 levels per pixel.
      EXPECT_LE(worst, 2) << gsd_m;
    }
  }
}

TEST(RectifyTerrain, SaysWhereOnlyThePlaneServed) {
  const Look l = look(0);
  const cv::Mat image = kRamp.take_picture(l.camera, l.attitude, l.position);
  GridImage known = kRamp.heights(kEast, kNorth, 400, 2);
  known.valid = cv::Mat(known.pixels.size(), CV_8UC1, cv::Scalar(255));
  known.valid.colRange(0, 200).setTo(0);                                         // the west by the mask,
  known.pixels.rowRange(0, 200).setTo(std::numeric_limits<float>::quiet_NaN());  // the north by NaN
  GridImage patch;
  TerrainUse use;
  ASSERT_EQ(rectify(image, l.camera, l.attitude, l.position, {known, 250}, 0.5, patch, &use), Status::kOk);
  EXPECT_NEAR(use.known, 0.25, 0.08);  // the south-eastern quarter, a little of it behind the footprint's tilt
  int seen = 0;
  for (int i = 0; i <= 4; ++i)
    for (int j = -4; j <= 0; ++j)
      if (const double e = mark_error_px(patch, i * kMarkSpacing, j * kMarkSpacing); e >= 0 && i > 0 && j < 0) {
        EXPECT_LT(e, 0.5);
        ++seen;
      }
  EXPECT_GE(seen, 2);
  ASSERT_EQ(rectify(image, l.camera, l.attitude, l.position, {{}, 250}, 0.5, patch, &use), Status::kOk);
  EXPECT_EQ(use.known, 0);
  EXPECT_EQ(use.hidden, 0);
}

TEST(RectifyTerrain, RefusesWhatItCannotUse) {
  const Look l = look(0);
  const cv::Mat image(l.camera.height, l.camera.width, CV_8UC1, cv::Scalar(9));
  const auto status = [&](const Position& position, const Terrain& terrain) {
    GridImage patch;
    return rectify(image, l.camera, l.attitude, position, terrain, 0.5, patch);
  };
  const Terrain ramp{kRamp.heights(kEast, kNorth, 100, 2), 250};
  EXPECT_EQ(status(l.position, ramp), Status::kOk);
  EXPECT_EQ(status({kEast, kNorth, 250}, ramp), Status::kBelowGround);
  EXPECT_EQ(status({kEast + 95, kNorth, 270}, ramp), Status::kBelowGround);  // the ramp is at 278 m there
  EXPECT_EQ(status({std::nan(""), kNorth, 370}, ramp), Status::kNotFinite);
  EXPECT_EQ(status(l.position, {{}, std::nan("")}), Status::kNotFinite);
  Terrain bad = ramp;
  bad.heights.gsd_m = 0;
  EXPECT_EQ(status(l.position, bad), Status::kBadValue);
  bad = ramp;
  bad.heights.pixels.convertTo(bad.heights.pixels, CV_64F);
  EXPECT_EQ(status(l.position, bad), Status::kBadImage);
  bad = ramp;
  bad.heights.valid = cv::Mat::ones(3, 3, CV_8UC1);
  EXPECT_EQ(status(l.position, bad), Status::kBadImage);
}

TEST(GroundPoint, IsWhereTheProjectionOfThePointSaysItIs) {
  for (const ReliefScene* scene : {&kRamp, &kHill}) {
    const Terrain terrain{scene->heights(kEast, kNorth, 400, 1), 250};
    const Look l = look(30, {-0.2, 0.05});
    const Eigen::Matrix3d cam_from_enu = enu_from_camera(l.attitude).transpose();
    for (double y : {-0.5, 70.0, 149.5, 299.5})
      for (double x : {-0.5, 200.0, 399.5}) {
        GroundPoint p;
        ASSERT_EQ(ground_point(l.camera, l.attitude, l.position, {x, y}, terrain, p), Status::kOk);
        EXPECT_TRUE(p.known);
        EXPECT_NEAR(p.height_m, scene->height_m(p.east_m, p.north_m), 0.02);  // 1 m spacing on the hill's curvature
        Eigen::Vector2d back;
        ASSERT_TRUE(Lens(l.camera).pixel_of(
            cam_from_enu * Eigen::Vector3d(p.east_m - kEast, p.north_m - kNorth, p.height_m - 370), back));
        EXPECT_NEAR(back.x(), x, 1e-4);
        EXPECT_NEAR(back.y(), y, 1e-4);
        EXPECT_TRUE(scene->visible(p.east_m, p.north_m, l.position));
      }
  }
}

TEST(GroundPoint, OnAPlaneIsGeometry) {
  Look l = look(30);
  l.attitude = {0, 30 * kDegree, 0};
  GroundPoint p;
  ASSERT_EQ(ground_point(l.camera, l.attitude, l.position, {199.5, 149.5}, {{}, 250}, p), Status::kOk);
  EXPECT_NEAR(p.east_m, kEast, 1e-6);
  EXPECT_NEAR(p.north_m, kNorth + 120 * std::tan(30 * kDegree), 1e-6);
  EXPECT_NEAR(p.height_m, 250, 1e-6);
  EXPECT_FALSE(p.known);
  l.attitude.pitch = 80 * kDegree;  // 120 · tan 80° = 680 m, beyond three heights; above that the sky
  EXPECT_EQ(ground_point(l.camera, l.attitude, l.position, {199.5, 149.5}, {{}, 250}, p), Status::kNothingVisible);
  EXPECT_EQ(ground_point(l.camera, l.attitude, l.position, {199.5, -0.5}, {{}, 250}, p), Status::kNothingVisible);
  EXPECT_EQ(ground_point(l.camera, l.attitude, {0, 0, 200}, {0, 0}, {{}, 250}, p), Status::kBelowGround);
}

}  // namespace
}  // namespace landfix::nav

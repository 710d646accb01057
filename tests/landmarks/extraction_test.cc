// Landmarks of drawn worlds that no model has seen, and of scenes that have none.
#include "builder/landmarks/extraction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "builder/error.h"
#include "tools/eval/points.h"
#include "tools/synth/world.h"

namespace landfix::landmarks {
namespace {

using tiles::LandmarkClass;

constexpr double kWest_m = 500000, kNorth_m = 5400000;

features::GridImage grid_image(cv::Mat pixels) {
  features::GridImage image;
  image.pixels = std::move(pixels);
  image.west_m = kWest_m;
  image.north_m = kNorth_m;
  return image;
}

// A village of a world that the model that comes with landfix was not trained on.
struct Village {
  features::GridImage image;
  std::vector<eval::KnownPoint> buildings;
  ingest::GridBounds bounds;
};

Village village(synth::Season season, double sun_azimuth_deg, int year) {
  synth::WorldOptions options;
  options.seed = 1;
  options.season = season;
  options.sun_azimuth_deg = sun_azimuth_deg;
  options.year = year;
  const synth::World world(options);
  const synth::Window window = {500850, 5401800, 420, 420, 1};
  Village out;
  out.image = world.ortho(window);
  const synth::Rectangle area = {window.west_m, window.north_m - window.height, window.west_m + window.width,
                                 window.north_m};
  out.bounds = {area.west_m + 12, area.south_m + 12, area.east_m - 12, area.north_m - 12};
  for (const synth::Building& b : world.labels(area).buildings)
    if (area.contains(b.centre)) out.buildings.push_back({{b.centre.x, b.centre.y}, true, 0, ""});
  return out;
}

const Village& summer_village() {
  static const Village kVillage = village(synth::Season::kSummer, 150, 2020);
  return kVillage;
}

std::vector<eval::FoundPoint> buildings_of(const std::vector<Extracted>& all, double confidence) {
  std::vector<eval::FoundPoint> out;
  for (const Extracted& e : all)
    if (e.landmark.cls == LandmarkClass::kBuilding && e.landmark.confidence >= confidence)
      out.push_back({{e.landmark.east_m, e.landmark.north_m}, e.landmark.confidence});
  return out;
}

std::vector<Extracted> find_all(const features::GridImage& image) {
  return find_landmarks(image, cv::Rect({}, image.pixels.size()), default_object_model());
}

size_t confident(const std::vector<Extracted>& all, LandmarkClass cls) {
  return size_t(std::count_if(all.begin(), all.end(), [cls](const Extracted& e) {
    return e.landmark.cls == cls && e.landmark.confidence > 0.5;
  }));
}

TEST(FindLandmarks, FindsTheBuildingsOfAnUnseenVillage) {
  const Village& v = summer_village();
  ASSERT_GT(v.buildings.size(), 40u);
  const eval::PointMatch m = match_points(buildings_of(find_all(v.image), kLeastConfidence), v.buildings, v.bounds, 3);
  EXPECT_GE(m.recall(), 0.9);
  EXPECT_GE(m.precision(), 0.9);
}

TEST(FindLandmarks, WithoutColourToo) {
  features::GridImage gray = summer_village().image;
  cv::cvtColor(gray.pixels, gray.pixels, cv::COLOR_RGB2GRAY);
  const eval::PointMatch m = match_points(buildings_of(find_all(gray), kLeastConfidence), summer_village().buildings,
                                          summer_village().bounds, 3);
  EXPECT_GE(m.recall(), 0.3);  // a third is what shape and shadow alone tell with confidence
  EXPECT_GE(m.precision(), 0.8);
}

TEST(FindLandmarks, FindsMostBuildingsAgainInAutumn) {
  const Village autumn = village(synth::Season::kAutumn, 235, 2022);
  const std::vector<eval::FoundPoint> a = buildings_of(find_all(summer_village().image), 0.5),
                                      b = buildings_of(find_all(autumn.image), 0.5);
  ASSERT_GT(a.size(), 40u);
  EXPECT_GE(double(eval::found_again(a, b, 5)), 0.7 * double(std::max(a.size(), b.size())));
}

TEST(FindLandmarks, KnowsSizeAndDirection) {
  const Village& v = summer_village();
  synth::WorldOptions options;
  options.seed = 1;
  const synth::World world(options);
  const auto labels = world.labels({v.bounds.west_m, v.bounds.south_m, v.bounds.east_m, v.bounds.north_m});
  size_t matched = 0, size_right = 0, direction_right = 0, oblong = 0;
  for (const Extracted& e : find_all(v.image)) {
    if (e.landmark.cls != LandmarkClass::kBuilding || e.landmark.confidence < 0.5) continue;
    for (const synth::Building& b : labels.buildings) {
      if (std::hypot(b.centre.x - e.landmark.east_m, b.centre.y - e.landmark.north_m) > 2) continue;
      std::vector<cv::Point2f> outline;
      for (const synth::Point& p : b.outline()) outline.emplace_back(cv::Point2d(p) - cv::Point2d(b.centre));
      const cv::RotatedRect rect = cv::minAreaRect(outline);
      const double length = double(std::max(rect.size.width, rect.size.height)),
                   width = double(std::min(rect.size.width, rect.size.height));
      ++matched;
      size_right += std::abs(e.landmark.length_m - length) < 3 && std::abs(e.landmark.width_m - width) < 3;
      if (length < 1.25 * width) continue;
      ++oblong;
      const double angle =
          double(rect.angle) * std::numbers::pi / 180 + (rect.size.width < rect.size.height ? std::numbers::pi / 2 : 0);
      const double heading = std::numbers::pi / 2 - angle;  // y points north here
      direction_right += std::abs(std::remainder(heading - e.landmark.orientation_rad, std::numbers::pi)) < 0.17;
    }
  }
  ASSERT_GT(matched, 35u);
  EXPECT_GE(double(size_right), 0.8 * double(matched));
  EXPECT_GE(double(direction_right), 0.8 * double(oblong));  // within 10 degrees
}

TEST(FindLandmarks, OutlinesHaveTheAreaOfTheirRectangleAtMost) {
  for (const Extracted& e : find_all(summer_village().image)) {
    if (e.landmark.cls != LandmarkClass::kBuilding) {
      EXPECT_TRUE(e.outline.empty());
      continue;
    }
    ASSERT_GE(e.outline.size(), 4u);
    std::vector<cv::Point2f> near;
    for (const cv::Point2d& p : e.outline) near.emplace_back(p - cv::Point2d(e.landmark.east_m, e.landmark.north_m));
    EXPECT_LE(cv::contourArea(near), e.landmark.length_m * e.landmark.width_m * 1.01);  // rounded to 1/64 m
    EXPECT_GE(cv::contourArea(near), e.landmark.length_m * e.landmark.width_m * 0.3);
  }
}

auto key(const Extracted& e) {
  const tiles::Landmark& m = e.landmark;
  return std::tuple(m.cls, m.east_m, m.north_m, m.length_m, m.width_m, m.confidence, e.outline.size());
}

std::vector<decltype(key(Extracted()))> keys_of(const std::vector<Extracted>& all) {
  std::vector<decltype(key(Extracted()))> out;
  for (const Extracted& e : all) out.push_back(key(e));
  std::sort(out.begin(), out.end());
  return out;
}

TEST(FindLandmarks, OfBlocksAreThoseOfTheWholeImage) {
  const features::GridImage& image = summer_village().image;
  std::vector<Extracted> joined;
  for (const cv::Rect& core : {cv::Rect(0, 0, 190, 230), cv::Rect(190, 0, 230, 230), cv::Rect(0, 230, 190, 190),
                               cv::Rect(190, 230, 230, 190)}) {
    // A block is read alone, with its halo and no more.
    const cv::Rect seen = cv::Rect(core.x - kLandmarkHalo_px, core.y - kLandmarkHalo_px,
                                   core.width + 2 * kLandmarkHalo_px, core.height + 2 * kLandmarkHalo_px) &
                          cv::Rect({}, image.pixels.size());
    features::GridImage block = image;
    block.pixels = image.pixels(seen).clone();
    block.west_m += seen.x;
    block.north_m -= seen.y;
    for (Extracted& e : find_landmarks(block, core - seen.tl(), default_object_model())) joined.push_back(std::move(e));
  }
  const auto whole = keys_of(find_all(image));
  EXPECT_GT(whole.size(), 60u);
  const auto parts = keys_of(joined);
  decltype(keys_of({})) differ;
  std::set_symmetric_difference(parts.begin(), parts.end(), whole.begin(), whole.end(), std::back_inserter(differ));
  for (const auto& k : differ)
    ADD_FAILURE() << "class " << int(std::get<0>(k)) << " at " << std::get<1>(k) - image.west_m << " "
                  << image.north_m - std::get<2>(k) << " size " << std::get<3>(k) << " " << std::get<4>(k)
                  << " confidence " << std::get<5>(k)
                  << (std::binary_search(parts.begin(), parts.end(), k) ? " in blocks only" : " in the whole only");
}

TEST(FindLandmarks, AreTheSameWhateverTheThreads) {
  const features::GridImage& image = summer_village().image;
  EXPECT_EQ(keys_of(extract_landmarks(image, default_object_model(), 1)),
            keys_of(extract_landmarks(image, default_object_model(), 2)));
}

TEST(FindLandmarks, TurnAndMirrorWithTheImage) {
  const features::GridImage& image = summer_village().image;
  const std::vector<eval::FoundPoint> plain = buildings_of(find_all(image), 0.5);
  features::GridImage mirrored = image, turned = image;
  mirrored.pixels = cv::Mat();
  turned.pixels = cv::Mat();
  cv::flip(image.pixels, mirrored.pixels, 1);
  cv::rotate(image.pixels, turned.pixels, cv::ROTATE_90_CLOCKWISE);
  const double side = image.pixels.cols;
  std::vector<eval::FoundPoint> of_mirrored = buildings_of(find_all(mirrored), 0.5),
                                of_turned = buildings_of(find_all(turned), 0.5);
  for (eval::FoundPoint& p : of_mirrored) p.at.x = 2 * image.west_m + side - p.at.x;
  for (eval::FoundPoint& p : of_turned) {  // back: what was on top lies on the right now
    const double right = p.at.x - image.west_m, down = image.north_m - p.at.y;
    p.at = {image.west_m + down, image.north_m - (side - right)};
  }
  EXPECT_GE(double(eval::found_again(plain, of_mirrored, 1)), 0.95 * double(plain.size()));
  EXPECT_GE(double(eval::found_again(plain, of_turned, 1)), 0.95 * double(plain.size()));
}

uint32_t noise_at(int x, int y) {
  uint32_t h = uint32_t(x) * 73856093u ^ uint32_t(y) * 19349663u;
  h = (h ^ (h >> 13)) * 2654435761u;
  return h ^ (h >> 16);
}

cv::Mat noise(const cv::Size& size, const cv::Scalar& mean, double spread, double blur) {
  cv::Mat f(size, CV_32FC3);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const float n = float(noise_at(x, y)) / 4294967296.0f - 0.5f;
      for (int k = 0; k < 3; ++k) f.at<cv::Vec3f>(y, x)[k] = n;
    }
  if (blur > 0) {
    cv::GaussianBlur(f, f, {0, 0}, blur);
    f *= 2 * blur;
  }
  cv::Mat out;
  cv::Mat shifted = f * spread + mean;
  shifted.convertTo(out, CV_8U);
  return out;
}

TEST(FindLandmarks, NoConfidentNonsense) {
  const cv::Size size(500, 500);
  const std::pair<const char*, cv::Mat> scenes[] = {
      {"even", cv::Mat(size, CV_8UC3, cv::Scalar(120, 130, 90))},
      {"sea", noise(size, {40, 70, 90}, 12, 2.5)},
      {"field", noise(size, {150, 130, 90}, 25, 1.5)},
      {"forest", noise(size, {45, 65, 35}, 90, 1.8)},
      {"noise", noise(size, {128, 128, 128}, 120, 0)},
      {"black", cv::Mat::zeros(size, CV_8UC3)},
  };
  for (const auto& [name, pixels] : scenes) {
    for (const bool gray : {false, true}) {
      cv::Mat seen = pixels;
      if (gray) cv::cvtColor(pixels, seen, cv::COLOR_RGB2GRAY);
      const std::vector<Extracted> all = find_all(grid_image(seen));
      // Without colours bright crowns in dark gaps may pass for huts.
      EXPECT_LE(confident(all, LandmarkClass::kBuilding), gray && name == std::string("forest") ? 4u : 0u)
          << name << (gray ? " gray" : "");
      EXPECT_LE(all.size(), 25u) << name << (gray ? " gray" : "");  // a quarter of a square kilometre
    }
  }
}

// All bands alike, of a tone per pixel.
cv::Mat drawn(const cv::Size& size, const std::function<double(int x, int y)>& tone) {
  cv::Mat out(size, CV_8UC3);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      out.at<cv::Vec3b>(y, x) = cv::Vec3b::all(cv::saturate_cast<uint8_t>(tone(x, y)));
  return out;
}

// Of what repeats: a weave, waves, tiles and squares as large as houses. Images with three bands, of one tone each.
TEST(FindLandmarks, PatternsAreNoLandmarks) {
  const cv::Size size(500, 500);
  const std::pair<const char*, cv::Mat> scenes[] = {
      {"clouds", noise(size, {120, 120, 120}, 120, 4)},
      {"plaid",
       drawn(size, [](int x, int y) { return (uint32_t(x) * 2654435761u ^ uint32_t(y) * 2246822519u) >> 24; })},
      {"waves", drawn(size, [](int x, int y) { return 128 + 90 * std::sin(x / 3.1) * std::sin(y / 4.3); })},
      {"mosaic", drawn(size, [](int x, int y) { return noise_at(x / 7, y / 7) >> 24; })},
      {"checkers", drawn(size, [](int x, int y) { return (x / 12 + y / 12) % 2 == 0 ? 60 : 190; })},
  };
  for (const auto& [name, pixels] : scenes) {
    const std::vector<Extracted> all = find_all(grid_image(pixels));
    EXPECT_EQ(confident(all, LandmarkClass::kBuilding), 0u) << name;
    EXPECT_LE(all.size(), 25u) << name;  // a quarter of a square kilometre
  }
}

TEST(FindLandmarks, NothingWithoutData) {
  features::GridImage image = summer_village().image;
  image.valid = cv::Mat::zeros(image.pixels.size(), CV_8U);
  EXPECT_TRUE(find_all(image).empty());
}

TEST(FindLandmarks, WhatTouchesMissingDataIsLeftOut) {
  features::GridImage image = summer_village().image;
  image.valid = cv::Mat(image.pixels.size(), CV_8U, cv::Scalar(255));
  image.valid.colRange(0, 210).setTo(0);
  const std::vector<Extracted> half = find_all(image);
  EXPECT_GT(buildings_of(half, 0.5).size(), 10u);
  for (const Extracted& e : half) EXPECT_GT(e.landmark.east_m, image.west_m + 210);
}

TEST(FindLandmarks, TinyImagesAndEmptyCores) {
  for (const int side : {1, 2, 7, 40})
    EXPECT_NO_THROW(find_all(grid_image(cv::Mat(side, side, CV_8UC3, cv::Scalar(90, 90, 90)))));
  const features::GridImage image = grid_image(cv::Mat(60, 60, CV_8UC1, cv::Scalar(90)));
  EXPECT_TRUE(find_landmarks(image, {}, default_object_model()).empty());
  EXPECT_TRUE(find_landmarks(image, {100, 100, 10, 10}, default_object_model()).empty());
  EXPECT_THROW(find_all(grid_image(cv::Mat(60, 60, CV_16UC1, cv::Scalar(90)))), Error);
}

TEST(FindLandmarks, TensOfThousandsInATile) {
  // White huts of 6 m every 9 m on dark ground: 3136 in a quarter of a square kilometre, 50 000 in a tile of 2 km.
  cv::Mat pixels = noise({512, 512}, {70, 85, 55}, 20, 1.2);
  size_t count = 0;
  for (int y = 4; y + 10 < 512; y += 9)
    for (int x = 4; x + 10 < 512; x += 9, ++count)
      cv::rectangle(pixels, {x, y, 6, 6}, cv::Scalar(200, 195, 190), cv::FILLED);
  const std::vector<Extracted> all = find_all(grid_image(pixels));
  EXPECT_LE(all.size(), 2 * count);  // none is found in several ways
}

}  // namespace
}  // namespace landfix::landmarks

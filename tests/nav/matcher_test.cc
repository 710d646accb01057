// Every matcher against its definition, and what must neither attract nor repel it.
#include "runtime/nav/matcher.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "runtime/features/contour.h"
#include "runtime/features/edge.h"
#include "runtime/features/gray.h"
#include "runtime/features/orientation.h"
#include "runtime/features/shade.h"
#include "runtime/nav/likelihood.h"
#include "runtime/nav/ncc.h"
#include "tests/nav/scene.h"

namespace landfix::nav {
namespace {

using features::GridImage;
using testing::View;

constexpr double kDegree = 0.017453292519943295;

/// 300 m of countryside at 0.25 m.
const GridImage& ground() {
  static const GridImage g = testing::ground_of(testing::countryside(1200, 5));
  return g;
}

const ImageMap& map() {
  static const ImageMap m(testing::coarser(ground(), 4), 2);
  return m;
}

GridImage window_of(const MapSource& source, Method method, double half_side_m, double gsd_m = 1) {
  GridImage window;
  EXPECT_EQ(source.read(layer_of(method), -half_side_m, -half_side_m, half_side_m, half_side_m, gsd_m, window),
            Status::kOk);
  return window;
}

GridImage gray(GridImage image) {
  image.pixels = features::gray_from_rgb(image.pixels);
  return image;
}

/// A square of this side, turned by 30°, inside of a canvas: the footprint of a camera.
cv::Mat footprint(int canvas_px, double side_px) {
  cv::Mat mask = cv::Mat::zeros(canvas_px, canvas_px, CV_8U);
  cv::Point2f corners[4];
  const auto middle = float(0.5 * (canvas_px - 1));
  cv::RotatedRect({middle, middle}, {float(side_px), float(side_px)}, 30).points(corners);
  const std::vector<cv::Point> outline(corners, corners + 4);
  cv::fillConvexPoly(mask, outline, 255);
  return mask;
}

cv::Mat garbage(cv::Size size, int type, uint64_t seed) {
  cv::Mat out(size, type);
  cv::RNG(seed).fill(out, cv::RNG::UNIFORM, type == CV_8SC2 ? -2 : 0, type == CV_8SC2 ? 3 : 256);
  return out;
}

Peak peak_of(Matcher& matcher, const Similarity& similarity = {}) {
  GridImage surface;
  Peak peak;
  EXPECT_EQ(matcher.match(similarity, surface), Status::kOk);
  EXPECT_EQ(find_peak(surface, 8, peak), Status::kOk);
  return peak;
}

double apart(const Peak& peak, double east_m, double north_m) {
  return std::hypot(peak.east_m - east_m, peak.north_m - north_m);
}

/// What a matcher may be off on clean ground, in pixels: whole distances of the chamfer match tell less.
double tolerance(Method method) { return method == Method::kContour ? 0.4 : 0.2; }

class EveryMatcher : public ::testing::TestWithParam<Method> {
 protected:
  std::unique_ptr<Matcher> matcher = make_matcher(GetParam());
};

std::string name_of_case(const ::testing::TestParamInfo<Method>& info) { return name_of(info.param); }
INSTANTIATE_TEST_SUITE_P(Methods, EveryMatcher, ::testing::ValuesIn(kMethods), name_of_case);

TEST_P(EveryMatcher, FindsATemplateBetweenPixels) {
  const GridImage window = window_of(map(), GetParam(), 100);
  ASSERT_EQ(matcher->set_window(window), Status::kOk);
  for (const cv::Point2d at : {cv::Point2d(0, 0), {17.25, -23.5}, {-31.75, 8.25}, {5.5, 29.75}}) {
    const GridImage colour = testing::look_down(ground(), {at.x, at.y});
    for (const GridImage& patch : {colour, gray(colour)}) {
      ASSERT_EQ(matcher->set_patch(patch), Status::kOk);
      const Peak peak = peak_of(*matcher);
      EXPECT_LT(apart(peak, at.x, at.y), tolerance(GetParam())) << at << patch.pixels.channels();
      EXPECT_GT(peak.value, 0.5);
      EXPECT_GT(peak.gap, 0.2);
    }
  }
}

TEST_P(EveryMatcher, LooksAtTheFootprintOnly) {
  // The corners beside a turned footprint hold noise.
  GridImage patch = testing::look_down(ground(), {12.25, 20.5});
  patch.valid = footprint(128, 85);
  garbage(patch.pixels.size(), CV_8UC3, 1).copyTo(patch.pixels, patch.valid == 0);
  ASSERT_EQ(matcher->set_patch(patch), Status::kOk);
  ASSERT_EQ(matcher->set_window(window_of(map(), GetParam(), 100)), Status::kOk);
  EXPECT_LT(apart(peak_of(*matcher), 12.25, 20.5), 1.5 * tolerance(GetParam()));
}

TEST_P(EveryMatcher, LetsHolesOfTheMapNeitherAttractNorRepel) {
  // Whatever stands in pixels without data: noise beside and in the middle of the true place, and, far from it, a copy
  // of what the template shows, under a hole that leaves less than half of it.
  const cv::Point2d at(20, -15);
  ASSERT_EQ(matcher->set_patch(testing::look_down(ground(), {at.x, at.y})), Status::kOk);
  const GridImage clean = window_of(map(), GetParam(), 130);
  const cv::Point middle(int(130 + at.x), int(130 - at.y));
  for (const cv::Point offset : {cv::Point(-10, 15), {45, 0}, {0, -60}}) {
    GridImage window = clean;
    window.pixels = clean.pixels.clone();
    window.valid = cv::Mat(clean.pixels.size(), CV_8U, cv::Scalar(255));
    cv::circle(window.valid, middle + offset, 30, 0, cv::FILLED);
    garbage(clean.pixels.size(), clean.pixels.type(), 3).copyTo(window.pixels, window.valid == 0);
    ASSERT_EQ(matcher->set_window(window), Status::kOk);
    const Peak peak = peak_of(*matcher);
    EXPECT_LT(apart(peak, at.x, at.y), tolerance(GetParam()) + 0.1) << offset;
    EXPECT_GT(peak.value, 0.5);
  }
  GridImage window = clean;
  window.pixels = clean.pixels.clone();
  window.valid = cv::Mat(clean.pixels.size(), CV_8U, cv::Scalar(255));
  const cv::Rect true_place(middle - cv::Point(50, 50), cv::Size(100, 100)), copy({5, 5}, true_place.size());
  clean.pixels(true_place).copyTo(window.pixels(copy));
  window.valid(copy).setTo(0);
  ASSERT_EQ(matcher->set_window(window), Status::kOk);
  GridImage surface;
  ASSERT_EQ(matcher->match({}, surface), Status::kOk);
  const cv::Point there(int(surface.column_of(-130 + 55)), int(surface.row_of(130 - 55)));
  for (int y = 0; y <= 2 && there.y + y >= 0; ++y) EXPECT_EQ(surface.valid.at<uint8_t>(there.y + y, there.x + y), 0);
  EXPECT_LT(apart(peak_of(*matcher), at.x, at.y), tolerance(GetParam()) + 0.1);
}

TEST_P(EveryMatcher, FindsNothingInAMapWithoutData) {
  GridImage window = window_of(map(), GetParam(), 100);
  window.valid = cv::Mat::zeros(window.pixels.size(), CV_8U);
  ASSERT_EQ(matcher->set_patch(testing::look_down(ground(), {})), Status::kOk);
  ASSERT_EQ(matcher->set_window(window), Status::kOk);
  GridImage surface;
  const Status status = matcher->match({}, surface);
  EXPECT_TRUE(status == Status::kOutsideMap || status == Status::kNoTexture) << to_text(status);
}

TEST_P(EveryMatcher, ARimServesTheOperatorsAndDoesNotVote) {
  // With 21 pixels around it, the template is computed as on the whole image: where the camera saw the very pixels of
  // the map, gray and edges are those of the map, and the coefficient is 1. The peak stays where the origin is.
  const int rim = 21, side = 90;
  GridImage image = testing::coarser(ground(), 4);
  const cv::Rect place(80, 95, side + 2 * rim, side + 2 * rim);
  image.pixels = image.pixels(place).clone();
  image.west_m = -0.5 * place.width, image.north_m = 0.5 * place.height;
  ASSERT_EQ(matcher->set_patch(image, rim), Status::kOk);
  ASSERT_EQ(matcher->set_window(window_of(map(), GetParam(), 130)), Status::kOk);
  GridImage surface;
  ASSERT_EQ(matcher->match({}, surface), Status::kOk);
  EXPECT_EQ(surface.pixels.size(), cv::Size(260 - side + 1, 260 - side + 1));
  const Peak peak = peak_of(*matcher);
  EXPECT_LT(apart(peak, -150 + 80 + 0.5 * place.width, 150 - 95 - 0.5 * place.height), 0.05);
  if (GetParam() == Method::kGray || GetParam() == Method::kEdge) {
    EXPECT_NEAR(peak.value, 1, 2e-3);
  }
  EXPECT_EQ(matcher->set_patch(image, 70), Status::kBadImage) << "nothing but rim";
}

TEST_P(EveryMatcher, TurnsAndStretchesAsTheSimilaritySays) {
  // The heading was assumed 6° too small, the height 5 % too small. Told so, the matcher sees the same as without
  // error; told the opposite, next to nothing.
  const Similarity error{6 * kDegree, 1.05};
  const GridImage window = window_of(map(), GetParam(), 110);
  ASSERT_EQ(matcher->set_window(window), Status::kOk);
  ASSERT_EQ(matcher->set_patch(testing::look_down(ground(), {10, 10})), Status::kOk);
  const double without_error = peak_of(*matcher).value;
  ASSERT_EQ(matcher->set_patch(testing::look_down(ground(), {10, 10, error})), Status::kOk);
  const Peak right = peak_of(*matcher, error);
  EXPECT_LT(apart(right, 10, 10), 2 * tolerance(GetParam()));
  EXPECT_GT(right.value, 0.6 * without_error);
  EXPECT_LT(peak_of(*matcher, {-error.rotation_rad, 1 / error.scale}).value, 0.6 * right.value);
  EXPECT_LT(peak_of(*matcher).value, right.value);
}

TEST_P(EveryMatcher, ServesChangingSizesAsANewOneDoes) {
  for (const int side : {120, 72, 96, 73, 120}) {
    GridImage patch = testing::look_down(ground(), {3, 4, {}, side}), expected, surface;
    if (side % 2 == 0) patch.valid = footprint(side, 0.8 * side);
    GridImage window = window_of(map(), GetParam(), 75 + side % 7);
    if (side != 96)
      window.valid.release();
    else
      cv::circle(window.valid = cv::Mat(window.pixels.size(), CV_8U, cv::Scalar(255)), {60, 60}, 20, 0, cv::FILLED);
    const std::unique_ptr<Matcher> fresh = make_matcher(GetParam());
    for (Matcher* m : {fresh.get(), matcher.get()}) {
      ASSERT_EQ(m->set_patch(patch), Status::kOk);
      ASSERT_EQ(m->set_window(window), Status::kOk);
    }
    for (const Similarity& similarity : {Similarity{}, Similarity{0.1, 0.97}}) {
      ASSERT_EQ(fresh->match(similarity, expected), Status::kOk);
      ASSERT_EQ(matcher->match(similarity, surface), Status::kOk);
      EXPECT_EQ(cv::norm(surface.pixels, expected.pixels, cv::NORM_INF), 0) << side;
      EXPECT_EQ(cv::norm(surface.valid, expected.valid, cv::NORM_INF), 0) << side;
      EXPECT_EQ(matcher->independent_pixels(), fresh->independent_pixels());
      ASSERT_EQ(fresh->match_fast(similarity, expected), Status::kOk);
      ASSERT_EQ(matcher->match_fast(similarity, surface), Status::kOk);
      EXPECT_EQ(cv::norm(surface.pixels, expected.pixels, cv::NORM_INF), 0) << side;
    }
  }
}

TEST_P(EveryMatcher, AnotherPatchInTheSameWindow) {
  ASSERT_EQ(matcher->set_patch(testing::look_down(ground(), {0, 0, {}, 120})), Status::kOk);
  ASSERT_EQ(matcher->set_window(window_of(map(), GetParam(), 100)), Status::kOk);
  GridImage surface;
  ASSERT_EQ(matcher->match({}, surface), Status::kOk);
  ASSERT_EQ(matcher->set_patch(testing::look_down(ground(), {50, -50, {}, 80})), Status::kOk);
  EXPECT_LT(apart(peak_of(*matcher), 50, -50), tolerance(GetParam()));
}

TEST_P(EveryMatcher, CountsIndependentPixelsByWhatUnrelatedContentScores) {
  // The variance of scores at unrelated places is one over their number, within a factor of two.
  const GridImage elsewhere = testing::ground_of(testing::countryside(1200, 77));
  ASSERT_EQ(matcher->set_patch(testing::look_down(elsewhere, {})), Status::kOk);
  ASSERT_EQ(matcher->set_window(window_of(map(), GetParam(), 140)), Status::kOk);
  GridImage surface;
  ASSERT_EQ(matcher->match({}, surface), Status::kOk);
  cv::Scalar mean, deviation;
  cv::meanStdDev(surface.pixels, mean, deviation);
  EXPECT_LT(std::abs(mean[0]), 0.1);
  EXPECT_GT(matcher->independent_pixels() * deviation[0] * deviation[0], 0.5);
  EXPECT_LT(matcher->independent_pixels() * deviation[0] * deviation[0], 2);
}

TEST_P(EveryMatcher, RefusesWhatItCannotUse) {
  GridImage surface;
  EXPECT_NE(matcher->match({}, surface), Status::kOk) << "nothing was set";
  const GridImage patch = testing::look_down(ground(), {}), window = window_of(map(), GetParam(), 100);
  EXPECT_EQ(matcher->set_patch({}), Status::kBadImage);
  EXPECT_EQ(matcher->set_patch({cv::Mat(50, 50, CV_32FC1, cv::Scalar(1)), {}, 0, 0, 1}), Status::kBadImage);
  EXPECT_EQ(matcher->set_patch({cv::Mat(50, 50, CV_8UC2, cv::Scalar(1)), {}, 0, 0, 1}), Status::kBadImage);
  GridImage other_mask = patch;
  other_mask.valid = cv::Mat(20, 20, CV_8U, cv::Scalar(255));
  EXPECT_EQ(matcher->set_patch(other_mask), Status::kBadImage);
  ASSERT_EQ(matcher->set_patch(patch), Status::kOk);
  GridImage wrong = window;
  window.pixels.convertTo(wrong.pixels, CV_16S);
  const Status at_once = matcher->set_window(wrong);
  EXPECT_EQ(at_once == Status::kOk ? matcher->match({}, surface) : at_once, Status::kBadImage);
  ASSERT_EQ(matcher->set_window(window_of(map(), GetParam(), 60)), Status::kOk);
  EXPECT_EQ(matcher->match({}, surface), Status::kTemplateTooLarge);
  EXPECT_EQ(matcher->match_fast({}, surface), Status::kTemplateTooLarge);
  for (const double shade : {0., 128., 255.}) {
    const GridImage blank{cv::Mat(128, 128, CV_8UC3, cv::Scalar::all(shade)), {}, -64, 64, 1};
    Status status = matcher->set_patch(blank);
    if (status == Status::kOk) status = matcher->set_window(window);
    if (status == Status::kOk) status = matcher->match({}, surface);
    EXPECT_EQ(status, Status::kNoTexture) << shade;
  }
}

TEST(Matchers, GrayAndEdgeAreTheCoefficientOfWhatMapAndCameraComputeAlike) {
  const GridImage patch = gray(testing::look_down(ground(), {7.5, 3}));
  GridImage lifted = patch, edges = patch;
  lifted.pixels = patch.pixels.clone();
  features::lift_shade(lifted);
  edges.pixels = cv::Mat();
  features::edge(patch.pixels, {}, edges.pixels);
  edges.valid = edges.pixels != 0;
  for (const Method method : {Method::kGray, Method::kEdge}) {
    GridImage window = window_of(map(), method, 90), expected, surface;
    const std::unique_ptr<Matcher> matcher = make_matcher(method, 0.7);
    ASSERT_EQ(matcher->set_patch(patch), Status::kOk);
    ASSERT_EQ(matcher->set_window(window), Status::kOk);
    ASSERT_EQ(matcher->match({}, surface), Status::kOk);
    window.pixels = window.pixels.clone();
    if (method == Method::kGray) features::lift_shade(window);
    ASSERT_EQ(Ncc(0.7).match(method == Method::kGray ? lifted : edges, window, expected), Status::kOk);
    EXPECT_EQ(cv::norm(surface.pixels, expected.pixels, cv::NORM_INF), 0);
    EXPECT_EQ(surface.west_m, expected.west_m);
    EXPECT_EQ(surface.north_m, expected.north_m);
  }
}

/// Barrow's score by its definition: mean distance at the contours against that of the window.
TEST(ContourMatcher, EqualsItsDefinitionUnderMasks) {
  GridImage patch = testing::look_down(ground(), {6, 9, {}, 72});
  patch.valid = footprint(72, 52);
  GridImage window = window_of(map(), Method::kContour, 50), surface;
  window.valid = cv::Mat(window.pixels.size(), CV_8U, cv::Scalar(255));
  window.valid(cv::Rect(0, 0, 30, 100)).setTo(0);
  cv::circle(window.valid, {70, 40}, 12, 0, cv::FILLED);
  const std::unique_ptr<Matcher> matcher = make_matcher(Method::kContour, 0.6);
  ASSERT_EQ(matcher->set_patch(patch), Status::kOk);
  ASSERT_EQ(matcher->set_window(window), Status::kOk);
  ASSERT_EQ(matcher->match({}, surface), Status::kOk);

  cv::Mat mask, known;
  features::contours(features::gray_from_rgb(patch.pixels), patch.valid, {}, mask, known);
  double everywhere = 0, places = 0;
  for (int y = 0; y < window.pixels.rows; ++y)
    for (int x = 0; x < window.pixels.cols; ++x)
      if (window.valid.at<uint8_t>(y, x)) everywhere += window.pixels.at<uint8_t>(y, x) - 1, places += 1;
  int valid = 0;
  for (int v = 0; v < surface.pixels.rows; ++v)
    for (int u = 0; u < surface.pixels.cols; ++u) {
      double all = 0, met = 0, sum = 0;
      for (int y = 0; y < mask.rows; ++y)
        for (int x = 0; x < mask.cols; ++x) {
          if (!mask.at<uint8_t>(y, x)) continue;
          all += 1;
          if (!window.valid.at<uint8_t>(v + y, u + x)) continue;
          met += 1, sum += window.pixels.at<uint8_t>(v + y, u + x) - 1;
        }
      const bool covered = met >= 0.6 * all;
      ASSERT_EQ(surface.valid.at<uint8_t>(v, u) != 0, covered) << u << " " << v;
      ASSERT_NEAR(surface.pixels.at<float>(v, u), covered ? 1 - sum / met / (everywhere / places) : 0, 1e-4);
      valid += covered;
    }
  EXPECT_GT(valid, 100);
  EXPECT_LT(valid, int(surface.valid.total()));
}

/// What the camera's side of an orientation match is, by plain loops in doubles: the mean of what is near goes on where
/// there is no image, lengths to the power of 3/4, 0 beyond the image, less half of their mean around (sigma 4 pixels).
cv::Mat_<cv::Vec2d> sharpened_orientation(const GridImage& patch) {
  const int margin = 5, rows = patch.pixels.rows + 2 * margin, columns = patch.pixels.cols + 2 * margin;
  const auto known = [&](int y, int x) {
    y -= margin, x -= margin;
    return y >= 0 && x >= 0 && y < patch.pixels.rows && x < patch.pixels.cols &&
           (patch.valid.empty() || patch.valid.at<uint8_t>(y, x));
  };
  cv::Mat_<cv::Vec3b> whole(rows, columns, cv::Vec3b());
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      cv::Vec3d sum(0, 0, 0);
      int count = 0;
      if (known(y, x)) {
        whole(y, x) = patch.pixels.at<cv::Vec3b>(y - margin, x - margin);
        continue;
      }
      for (int dy = -margin; dy <= margin; ++dy)
        for (int dx = -margin; dx <= margin; ++dx)
          if (known(y + dy, x + dx)) sum += patch.pixels.at<cv::Vec3b>(y + dy - margin, x + dx - margin), ++count;
      // Halves go down: in floats the counts come out a little above whole numbers.
      for (int c = 0; c < 3; ++c) whole(y, x)[c] = uint8_t(std::lrint(sum[c] / std::max(count, 1) - 1e-6));
    }
  cv::Mat ab, ab_valid;
  features::orientation(whole, {}, {}, ab, ab_valid);
  cv::Mat_<cv::Vec2d> compressed(patch.pixels.size()), out(patch.pixels.size());
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x) {
      const cv::Vec2f v = ab.at<cv::Vec2f>(y + margin, x + margin);
      const double length = std::hypot(v[0], v[1]);
      const bool counts = known(y + margin, x + margin) && length > 0;
      compressed(y, x) = counts ? cv::Vec2d(v) * std::pow(length, -0.25) : cv::Vec2d();
    }
  const int radius = 16;
  std::vector<double> weights;
  double total = 0;
  for (int d = -radius; d <= radius; ++d) weights.push_back(std::exp(-d * d / 32.0)), total += weights.back();
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x) {
      cv::Vec2d low(0, 0);
      for (int dy = -radius; dy <= radius; ++dy)
        for (int dx = -radius; dx <= radius; ++dx)
          if (y + dy >= 0 && x + dx >= 0 && y + dy < out.rows && x + dx < out.cols)
            low += weights[size_t(dy + radius)] * weights[size_t(dx + radius)] / (total * total) *
                   compressed(y + dy, x + dx);
      const bool valid = patch.valid.empty() || patch.valid.at<uint8_t>(y, x);
      out(y, x) = valid ? compressed(y, x) - 0.5 * low : cv::Vec2d(0, 0);
    }
  return out;
}

struct OrientationCase {
  GridImage patch, window;
  double min_coverage;
};

OrientationCase masked_case() {
  OrientationCase c{testing::look_down(ground(), {6, 9, {}, 48}), window_of(map(), Method::kOrientation, 36), 0.6};
  c.patch.valid = footprint(48, 36);
  c.window.valid = cv::Mat(c.window.pixels.size(), CV_8U, cv::Scalar(255));
  c.window.valid(cv::Rect(0, 0, 22, 72)).setTo(0);
  cv::circle(c.window.valid, {52, 30}, 9, 0, cv::FILLED);
  return c;
}

TEST(OrientationMatcher, EqualsItsDefinitionUnderMasks) {
  OrientationCase masked = masked_case(), plain = masked;
  plain.patch.valid.release();
  plain.window.valid.release();
  for (const OrientationCase& c : {masked, plain}) {
    const std::unique_ptr<Matcher> matcher = make_matcher(Method::kOrientation, c.min_coverage);
    GridImage surface;
    ASSERT_EQ(matcher->set_patch(c.patch), Status::kOk);
    ASSERT_EQ(matcher->set_window(c.window), Status::kOk);
    ASSERT_EQ(matcher->match({}, surface), Status::kOk);
    const cv::Mat_<cv::Vec2d> camera = sharpened_orientation(c.patch);
    const double all = c.patch.valid.empty() ? double(camera.total()) : cv::countNonZero(c.patch.valid);
    for (int v = 0; v < surface.pixels.rows; ++v)
      for (int u = 0; u < surface.pixels.cols; ++u) {
        double met = 0, product = 0, energy = 0, own = 0;
        for (int y = 0; y < camera.rows; ++y)
          for (int x = 0; x < camera.cols; ++x) {
            if (!c.patch.valid.empty() && !c.patch.valid.at<uint8_t>(y, x)) continue;
            if (!c.window.valid.empty() && !c.window.valid.at<uint8_t>(v + y, u + x)) continue;
            const auto level = c.window.pixels.at<cv::Vec<int8_t, 2>>(v + y, u + x);
            met += 1;
            product += level[0] * camera(y, x)[0] + level[1] * camera(y, x)[1];
            energy += level[0] * level[0] + level[1] * level[1];
            own += camera(y, x).dot(camera(y, x));
          }
        const bool covered = met >= c.min_coverage * all;
        ASSERT_EQ(surface.valid.at<uint8_t>(v, u) != 0, covered) << u << " " << v;
        ASSERT_NEAR(surface.pixels.at<float>(v, u), covered ? product / std::sqrt(energy * own) : 0, 1e-4);
      }
  }
}

TEST(OrientationMatcher, AnswersForFewPositionsAsForMany) {
  // 49 positions around a place are summed one by one, 8000 by Fourier transform.
  for (const bool masked : {false, true}) {
    GridImage patch = testing::look_down(ground(), {6, 9, {}, 90}), many = window_of(map(), Method::kOrientation, 90);
    if (masked) {
      patch.valid = footprint(90, 70);
      many.valid = cv::Mat(many.pixels.size(), CV_8U, cv::Scalar(255));
      cv::circle(many.valid, {90, 100}, 30, 0, cv::FILLED);
    }
    const cv::Rect part(43, 31, 96, 96);
    GridImage few{many.pixels(part), masked ? many.valid(part) : cv::Mat(), many.west_m + part.x, many.north_m - part.y,
                  1};
    const std::unique_ptr<Matcher> matcher = make_matcher(Method::kOrientation);
    for (const Similarity& similarity : {Similarity{}, Similarity{0.05, 1.02}}) {
      GridImage all, some;
      ASSERT_EQ(matcher->set_patch(patch), Status::kOk);
      ASSERT_EQ(matcher->set_window(few), Status::kOk);
      ASSERT_EQ(matcher->match(similarity, some), Status::kOk);
      const double independent = matcher->independent_pixels();
      ASSERT_EQ(matcher->set_window(many), Status::kOk);
      ASSERT_EQ(matcher->match(similarity, all), Status::kOk);
      ASSERT_EQ(some.pixels.size(), cv::Size(7, 7));
      const cv::Rect there(part.tl(), some.pixels.size());
      EXPECT_LT(cv::norm(some.pixels, all.pixels(there), cv::NORM_INF), 1e-4);
      EXPECT_EQ(cv::norm(some.valid, all.valid(there), cv::NORM_INF), 0);
      EXPECT_EQ(some.west_m, all.west_m + there.x);
      EXPECT_EQ(some.north_m, all.north_m - there.y);
      EXPECT_NEAR(independent, matcher->independent_pixels(), 0.2 * independent);
    }
  }
}

TEST(OrientationMatcher, IsFastByExactTernarySums) {
  // Signs of the map, the camera beyond ±0.15, counted in whole numbers; energies over the canvas, of which the
  // footprint is the share.
  const OrientationCase c = masked_case();
  const std::unique_ptr<Matcher> matcher = make_matcher(Method::kOrientation, c.min_coverage);
  GridImage surface;
  ASSERT_EQ(matcher->set_patch(c.patch), Status::kOk);
  ASSERT_EQ(matcher->set_window(c.window), Status::kOk);
  ASSERT_EQ(matcher->match_fast({}, surface), Status::kOk);
  const cv::Mat_<cv::Vec2d> camera = sharpened_orientation(c.patch);
  const double share = double(cv::countNonZero(c.patch.valid)) / double(camera.total());
  const auto sign = [](double value, double least) { return int(value > least) - int(value < -least); };
  for (int v = 0; v < surface.pixels.rows; ++v)
    for (int u = 0; u < surface.pixels.cols; ++u) {
      int product = 0, energy = 0, own = 0;
      for (int y = 0; y < camera.rows; ++y)
        for (int x = 0; x < camera.cols; ++x)
          for (int k = 0; k < 2; ++k) {
            const int there = c.window.valid.at<uint8_t>(v + y, u + x)
                                  ? sign(c.window.pixels.at<cv::Vec<int8_t, 2>>(v + y, u + x)[k], 0)
                                  : 0,
                      here = sign(camera(y, x)[k], 0.15);
            product += here * there, energy += there != 0, own += here != 0;
          }
      const double least = 0.02 * double(camera.total());
      ASSERT_NEAR(surface.pixels.at<float>(v, u), product / std::sqrt(std::max(double(energy), least) * share * own),
                  1e-6)
          << u << " " << v;
    }
}

TEST(OrientationMatcher, IsFastAndChoosesTheSameSimilarity) {
  // Errors of heading and height on a grid of 3° and 5 %; 12 places.
  const GridImage window = window_of(map(), Method::kOrientation, 110);
  const std::unique_ptr<Matcher> matcher = make_matcher(Method::kOrientation);
  ASSERT_EQ(matcher->set_window(window), Status::kOk);
  std::vector<Similarity> all;
  for (int r = -2; r <= 2; ++r)
    for (int k = -1; k <= 1; ++k) all.push_back({3 * r * kDegree, 1 + 0.05 * k});
  testing::Random random(8);
  int same = 0, right = 0;
  for (int i = 0; i < 12; ++i) {
    const size_t truth = size_t(random.uniform(0, 14.99));
    ASSERT_EQ(matcher->set_patch(
                  testing::look_down(ground(), {random.uniform(-40, 40), random.uniform(-40, 40), all[truth], 96})),
              Status::kOk);
    const auto best = [&](auto match) {
      double highest = -2;
      size_t index = 0;
      for (size_t k = 0; k < all.size(); ++k) {
        GridImage surface;
        double value;
        EXPECT_EQ((matcher.get()->*match)(all[k], surface), Status::kOk);
        cv::minMaxLoc(surface.pixels, nullptr, &value);
        if (value > highest) highest = value, index = k;
      }
      return index;
    };
    const size_t precise = best(&Matcher::match), fast = best(&Matcher::match_fast);
    same += precise == fast;
    right += fast == truth;
  }
  EXPECT_GE(same, 11);
  EXPECT_GE(right, 11);
}

TEST(OrientationMatcher, SurvivesOtherShadesAndInvertedContrastWhereGrayFails) {
  // Another season recolours every field and adds some; the negative turns every edge round.
  const GridImage season = testing::ground_of(testing::countryside(1200, 5, 1));
  const GridImage negative = testing::ground_of(255 - ground().pixels);
  const auto hits = [&](Method method, const GridImage& scene) {
    const std::unique_ptr<Matcher> matcher = make_matcher(method);
    EXPECT_EQ(matcher->set_window(window_of(map(), method, 140)), Status::kOk);
    testing::Random random(9);
    int count = 0;
    for (int i = 0; i < 20; ++i) {
      const double east = random.uniform(-70, 70), north = random.uniform(-70, 70);
      EXPECT_EQ(matcher->set_patch(testing::look_down(scene, {east, north})), Status::kOk);
      count += apart(peak_of(*matcher), east, north) < 2;
    }
    return count;
  };
  EXPECT_GE(hits(Method::kOrientation, season), 19);
  EXPECT_LE(hits(Method::kGray, season), 14);
  EXPECT_EQ(hits(Method::kOrientation, negative), 20);
  EXPECT_EQ(hits(Method::kGray, negative), 0);
}

TEST(OrientationMatcher, SeesMoreInTwoDatesThanInOne) {
  // What is there in one season only cancels: the gap to the best rival grows.
  std::vector<GridImage> dates;
  for (const uint64_t season : {1, 2})
    dates.push_back(testing::coarser(testing::ground_of(testing::countryside(1200, 5, season)), 4));
  const GridImage today = testing::ground_of(testing::countryside(1200, 5, 3));
  const auto gaps = [&](const ImageMap& m) {
    const std::unique_ptr<Matcher> matcher = make_matcher(Method::kOrientation);
    EXPECT_EQ(matcher->set_window(window_of(m, Method::kOrientation, 140)), Status::kOk);
    testing::Random random(9);
    double sum = 0;
    for (int i = 0; i < 20; ++i) {
      const double east = random.uniform(-70, 70), north = random.uniform(-70, 70);
      EXPECT_EQ(matcher->set_patch(testing::look_down(today, {east, north, {}, 80})), Status::kOk);
      const Peak peak = peak_of(*matcher);
      sum += apart(peak, east, north) < 2 ? peak.gap : -peak.gap;
    }
    return sum / 20;
  };
  const double both = gaps(ImageMap(dates, 1, 0)), first = gaps(ImageMap(dates[0])), second = gaps(ImageMap(dates[1]));
  EXPECT_GT(both, 1.3 * std::max(first, second));  // 0.168 against 0.108 and 0.103
}

}  // namespace
}  // namespace landfix::nav

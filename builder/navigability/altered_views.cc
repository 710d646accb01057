#include "builder/navigability/altered_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "builder/landmarks/region_merging.h"
#include "runtime/features/gray.h"

namespace landfix::navigability {
namespace {

using features::GridImage;

// Fields: regions of one tone, large and wide enough.
constexpr double kMostCost = 1500;  // of a merge: hundredths of the logarithm of the value, squared, times pixels
constexpr int kLeastField_px = 200, kFieldWidth_px = 5;
constexpr double kLeastCore = 0.25;  // of a field, that lies farther than half of that width from its rim

// What a day changes; standard deviations unless said otherwise.
constexpr double kTone = 0.25, kColour = 0.1, kExposure = 0.2;  // logarithms
constexpr double kNearest_px = 40, kFarthest_px = 100;          // where a field's texture comes from
constexpr double kTurn = 0.02, kScale = 0.015, kNoise = 4;
constexpr double kShadow = 0.25, kDarkest = 0.9;  // of the light around that is missing, least and most
constexpr double kSurroundings_m = 15;            // that it is compared with
constexpr double kShadowMoves_m = 12;             // at most

cv::Mat shadow_of(const GridImage& image) {
  const cv::Mat gray = features::gray_from_rgb(image.pixels);
  const int side = 2 * int(std::lround(kSurroundings_m / image.gsd_m)) + 1;
  cv::Mat around, share(gray.size(), CV_32F);
  cv::blur(gray, around, {side, side});
  for (int y = 0; y < gray.rows; ++y)
    for (int x = 0; x < gray.cols; ++x) {
      const double missing = 1 - gray.at<uint8_t>(y, x) / std::max<double>(around.at<uint8_t>(y, x), 1);
      share.at<float>(y, x) = float(missing >= kShadow ? std::min(missing, kDarkest) : 0);
    }
  return share;
}

int mirrored(int i, int size) {
  if (size == 1) return 0;
  i = std::abs(i) % (2 * size - 2);
  return i < size ? i : 2 * size - 2 - i;
}

}  // namespace

struct AlteredViews::Change {
  std::array<double, 3> tone{};  // factors
  cv::Point texture;             // from where
};

struct AlteredViews::Day {
  std::vector<Change> fields;  // by number; the first is none
  cv::Point shadow;            // from where
  double exposure = 1;         // factor
};

AlteredViews::AlteredViews(const GridImage& image, const GridImage& heights) : image_(image), heights_(heights) {
  const cv::Size size = image.pixels.size();
  if (image_.valid.empty()) image_.valid = cv::Mat(size, CV_8U, cv::Scalar(255));
  image.pixels.convertTo(means_, CV_32F);
  shadow_ = shadow_of(image);
  fields_ = cv::Mat::zeros(size, CV_32S);
  const landmarks::MergeTree tree = landmarks::merge_regions(landmarks::log_colours(image.pixels), image_.valid,
                                                             kMostCost, int(image.pixels.total()));
  cv::Mat mask = cv::Mat::zeros(size, CV_8U), core;
  for (const landmarks::MergeTree::Node& node : tree.nodes) {
    if (node.parent >= 0 || node.count < kLeastField_px) continue;
    cv::Mat field = mask(node.box);
    field.setTo(0);
    for (int i = 0; i < node.count; ++i) {
      const int at = tree.pixels[size_t(node.first + i)];
      mask.at<uint8_t>(at / size.width, at % size.width) = 255;
    }
    cv::erode(field, core, cv::Mat::ones(kFieldWidth_px, kFieldWidth_px, CV_8U), {-1, -1}, 1, cv::BORDER_CONSTANT, 0);
    if (cv::countNonZero(core) < kLeastCore * node.count) continue;
    fields_(node.box).setTo(++field_count_, field);
    means_(node.box).setTo(cv::mean(image.pixels(node.box), field), field);
  }
}

AlteredViews::Day AlteredViews::day_of(Random& random) const {
  const auto towards = [&](double far) {
    const double angle = random.between(0, 2 * std::numbers::pi);
    return cv::Point(int(std::lround(far * std::cos(angle))), int(std::lround(far * std::sin(angle))));
  };
  Day day;
  day.fields.resize(size_t(field_count_) + 1);
  for (Change& change : day.fields) {
    const double tone = kTone * random.normal();
    for (double& factor : change.tone) factor = std::exp(tone + kColour * random.normal());
    change.texture = towards(random.between(kNearest_px, kFarthest_px));
  }
  day.shadow = towards(random.between(0, kShadowMoves_m / image_.gsd_m));
  day.exposure = std::exp(kExposure * random.normal());
  return day;
}

// A pixel as it is on a day.
cv::Vec3f AlteredViews::on_day(const cv::Point& at, const Day& day) const {
  const cv::Rect all({0, 0}, image_.pixels.size());
  const uint8_t* now = image_.pixels.ptr(at.y, at.x);
  const int bands = image_.pixels.channels(), field = fields_.at<int>(at);
  cv::Vec3f out;
  if (field == 0) {
    const cv::Point from = at + day.shadow;
    const float next = all.contains(from) && fields_.at<int>(from) == 0 ? shadow_.at<float>(from) : 0;
    for (int k = 0; k < bands; ++k) out[k] = float(now[k]) * (1 - next) / (1 - shadow_.at<float>(at));
    return out;
  }
  const Change& change = day.fields[size_t(field)];
  const cv::Point from(mirrored(at.x + change.texture.x, all.width), mirrored(at.y + change.texture.y, all.height));
  const bool textured = fields_.at<int>(from) != 0 && image_.valid.at<uint8_t>(from) != 0;
  const uint8_t* there = image_.pixels.ptr(from.y, from.x);
  const float *mean = means_.ptr<float>(at.y, at.x), *mean_there = means_.ptr<float>(from.y, from.x);
  for (int k = 0; k < bands; ++k)
    out[k] = float(change.tone[size_t(k)]) * (mean[k] + (textured ? float(there[k]) - mean_there[k] : 0));
  return out;
}

// Above the ellipsoid; nothing where it is not known.
std::optional<double> AlteredViews::height_at(const cv::Point2d& at) const {
  const cv::Point pixel(int(std::floor(at.x)), int(std::floor(at.y)));
  if (!cv::Rect({0, 0}, heights_.pixels.size()).contains(pixel)) return std::nullopt;
  if (!heights_.valid.empty() && heights_.valid.at<uint8_t>(pixel) == 0) return std::nullopt;
  return double(heights_.pixels.at<float>(pixel));
}

// A point of the image, in pixels whose middles are whole numbers, bilinear; nothing where one of the four has no data.
std::optional<cv::Vec3f> AlteredViews::between(const cv::Point2d& at, const Day& day) const {
  const cv::Point first(int(std::floor(at.x)), int(std::floor(at.y)));
  if (first.x < 0 || first.y < 0 || first.x + 1 >= image_.valid.cols || first.y + 1 >= image_.valid.rows)
    return std::nullopt;
  const uint8_t *upper = image_.valid.ptr(first.y, first.x), *lower = image_.valid.ptr(first.y + 1, first.x);
  if (!(upper[0] && upper[1] && lower[0] && lower[1])) return std::nullopt;
  const float x = float(at.x - first.x), y = float(at.y - first.y);
  const auto row = [&](const cv::Point& west) {
    return on_day(west, day) * (1 - x) + on_day(west + cv::Point(1, 0), day) * x;
  };
  return row(first) * (1 - y) + row(first + cv::Point(0, 1)) * y;
}

GridImage AlteredViews::draw(const View& view, uint64_t seed) const {
  Random fate(seed);
  const Day day = day_of(fate);
  // The camera has other errors wherever it is.
  Random random(seed << 56 | uint64_t(uint32_t(view.corner.x)) << 28 | uint64_t(uint32_t(view.corner.y)));
  const double turn = kTurn * random.normal(), scale = 1 + kScale * random.normal();
  const double cosine = scale * std::cos(turn), sine = scale * std::sin(turn);
  const double sigma_px = view.place_sigma_m / image_.gsd_m;
  const cv::Point2d middle = view.corner, believed(sigma_px * random.normal(), sigma_px * random.normal());
  const auto shift_of = [&](const cv::Point2d& from_middle) {
    const auto true_m = height_at(middle + from_middle), believed_m = height_at(middle + from_middle + believed);
    return true_m && believed_m ? from_middle * ((*true_m - *believed_m) / view.altitude_m) : cv::Point2d();
  };
  const int side = 2 * view.half_px;
  const double half_m = view.half_px * image_.gsd_m;
  GridImage out{cv::Mat::zeros(side, side, image_.pixels.type()), cv::Mat::zeros(side, side, CV_8U), -half_m, half_m,
                image_.gsd_m};
  for (int v = 0; v < side; ++v)
    for (int u = 0; u < side; ++u) {
      const double x = u + 0.5 - view.half_px, y = v + 0.5 - view.half_px;
      const cv::Point2d turned(cosine * x - sine * y, sine * x + cosine * y);
      const auto seen = between(middle + turned - shift_of(turned) - cv::Point2d(0.5, 0.5), day);
      if (!seen) continue;
      out.valid.at<uint8_t>(v, u) = 255;
      for (int k = 0; k < out.pixels.channels(); ++k) {
        const double value = day.exposure * double((*seen)[k]) + kNoise * random.normal();
        out.pixels.ptr(v, u)[k] = uint8_t(std::clamp(std::lround(value), 0L, 255L));
      }
    }
  return out;
}

}  // namespace landfix::navigability

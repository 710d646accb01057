#include "builder/landmarks/broad_regions.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "builder/landmarks/orientation.h"
#include "builder/landmarks/outline.h"
#include "builder/landmarks/preference.h"
#include "builder/landmarks/region_merging.h"

namespace landfix::landmarks {
namespace {

using tiles::Landmark;
using tiles::LandmarkClass;

constexpr int kValid = 0, kGround = 1, kWater = 2, kColours = 3;  // channels of a view
constexpr int kMost_px = int(kBroadMost_m / kBroadGsd_m), kLeast_px = int(kBroadLeast_m / kBroadGsd_m);
constexpr int kLeastWidth_px = 10;
constexpr int kLeastNode_px = 150;  // before holes are filled: half of the least rectangle
constexpr double kLasts = 1.1;      // times the strength at which a region came to be, that it outlasts at least
constexpr double kSolid = 0.7, kOblong = 0.5;  // least share of the hull and of the rectangle
constexpr double kMostCost = 1e6;              // of a merge
constexpr double kTolerance_px = 2;            // of outlines

// Logistic regression over BroadNumbers (landfix_fit_fields fit).
constexpr BroadNumbers kFieldWeights = {-7.0958, -0.9306, 5.0018, 13.5579, -4.0665, 0.3742, 0.2577};
constexpr BroadNumbers kWaterWeights = {0, 0, 0, 0, 0, 0, 0};  // too few lakes to learn from: one half

const cv::Mat& square() {
  static const cv::Mat kSquare = cv::Mat::ones(3, 3, CV_8U);
  return kSquare;
}

cv::Mat channel(const cv::Mat& view, int index) {
  cv::Mat out;
  cv::extractChannel(view, out, index);
  return out;
}

cv::Mat colours_of(const cv::Mat& view) {
  std::vector<cv::Mat> colours;
  for (int k = kColours; k < view.channels(); ++k) colours.push_back(channel(view, k));
  cv::Mat merged;
  cv::merge(colours, merged);
  return log_colours(merged);
}

// The largest part of a mask without whiskers and holes, in its own box; false where it is of no size or shape.
bool tidy(const cv::Mat& mask, const cv::Point& corner, BroadRegion& out) {
  cv::Mat padded;
  cv::copyMakeBorder(mask, padded, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0);
  cv::morphologyEx(padded, padded, cv::MORPH_OPEN, square());
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(padded, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  const auto area = [](const std::vector<cv::Point>& c) { return cv::contourArea(c); };
  const auto largest = std::ranges::max_element(contours, {}, area);
  if (largest == contours.end()) return false;
  Region& r = out.region;
  const cv::Rect box = cv::boundingRect(*largest);
  cv::Mat filled = cv::Mat::zeros(padded.size(), CV_8U);
  cv::drawContours(filled, contours, int(largest - contours.begin()), 1, cv::FILLED);
  r.mask = filled(box).clone();
  r.box = box + corner - cv::Point(1, 1);
  r.area_px = cv::countNonZero(r.mask);
  const cv::Size2f size = rectangle_of(r).size;
  const double length = double(std::max(size.width, size.height)), width = double(std::min(size.width, size.height));
  return width >= kLeastWidth_px && length >= kLeast_px && length <= kMost_px;
}

// The numbers of shape; false where it is far from any field's.
bool measure_shape(BroadRegion& b, int drawn_px) {
  const Region& r = b.region;
  const cv::RotatedRect rect = rectangle_of(r);
  std::vector<cv::Point> hull;
  cv::convexHull(boundary_of(r, 0), hull);
  const double area = r.area_px, solid = area / cv::contourArea(hull),
               oblong = area / (double(rect.size.width) * double(rect.size.height));
  if (solid < kSolid || oblong < kOblong) return false;
  b.numbers = {1, std::log(area), solid, oblong, double(drawn_px) / area, 0, 0};
  return true;
}

double probability_of(const BroadNumbers& numbers, const BroadNumbers& weights) {
  double sum = 0;
  for (size_t i = 0; i < numbers.size(); ++i) sum += numbers[i] * weights[i];
  return 1 / (1 + std::exp(-sum));
}

bool reaches_rim(const cv::Mat& mask, const cv::Rect& box, const cv::Mat& whole) {
  cv::Mat outside = mask & (whole(box) == 0);
  return cv::countNonZero(outside) > 0;
}

cv::Mat whole_of(const cv::Mat& view) {
  cv::Mat whole = channel(view, kValid) == 255;
  cv::erode(whole, whole, square(), {-1, -1}, 1, cv::BORDER_CONSTANT, 0);
  return whole;
}

std::vector<BroadRegion> fields_of(const cv::Mat& view) {
  const cv::Mat whole = whole_of(view);
  const cv::Mat ground = (channel(view, kGround) >= 128) & (channel(view, kValid) == 255);
  const MergeTree tree = merge_regions(colours_of(view), ground, kMostCost, kMost_px * kMost_px);
  std::vector<BroadRegion> out;
  for (const MergeTree::Node& node : tree.nodes) {
    if (node.count < kLeastNode_px || std::max(node.box.width, node.box.height) > kMost_px) continue;
    const double ends = node.parent < 0 ? kMostCost : double(tree.nodes[size_t(node.parent)].strength);
    if (ends < kLasts * double(node.strength)) continue;
    cv::Mat mask = cv::Mat::zeros(node.box.size(), CV_8U);
    for (int i = node.first; i < node.first + node.count; ++i) {
      const int p = tree.pixels[size_t(i)];
      mask.at<uint8_t>(p / view.cols - node.box.y, p % view.cols - node.box.x) = 1;
    }
    BroadRegion b;
    b.region.cls = LandmarkClass::kField;
    b.first = node.first, b.count = node.count;
    if (reaches_rim(mask, node.box, whole) || !tidy(mask, node.box.tl(), b) || !measure_shape(b, node.count)) continue;
    b.numbers[5] = std::min(std::log(ends / double(node.strength)), 3.0);
    b.numbers[6] = std::log(double(node.strength));
    b.confidence = probability_of(b.numbers, kFieldWeights);
    out.push_back(std::move(b));
  }
  return out;
}

std::vector<BroadRegion> lakes_of(const cv::Mat& view) {
  const cv::Mat whole = whole_of(view), water = channel(view, kWater);
  cv::Mat wet = water >= 128, labels, stats, centres;
  cv::morphologyEx(wet, wet, cv::MORPH_OPEN, square(), {-1, -1}, 1, cv::BORDER_CONSTANT, 0);
  const int count = cv::connectedComponentsWithStats(wet, labels, stats, centres, 4, CV_32S);
  std::vector<BroadRegion> out;
  int first = 0;
  for (int i = 1; i < count; ++i) {
    const int* s = stats.ptr<int>(i);
    const cv::Rect box(s[cv::CC_STAT_LEFT], s[cv::CC_STAT_TOP], s[cv::CC_STAT_WIDTH], s[cv::CC_STAT_HEIGHT]);
    BroadRegion b;
    b.region.cls = LandmarkClass::kWater;
    b.first = first, b.count = s[cv::CC_STAT_AREA];
    first += b.count;
    if (std::max(box.width, box.height) > kMost_px || b.count < kLeastNode_px) continue;
    const cv::Mat mask = (labels(box) == i) / 255;
    if (reaches_rim(mask, box, whole) || !tidy(mask, box.tl(), b) || !measure_shape(b, b.count)) continue;
    b.numbers[5] = cv::mean(water(box), mask)[0] / 255;
    b.confidence = probability_of(b.numbers, kWaterWeights);
    out.push_back(std::move(b));
  }
  return out;
}

Extracted landmark_of(const BroadRegion& b, const features::GridImage& view) {
  const auto grid = [&](const cv::Point2d& p) {
    return cv::Point2d(view.west_m + p.x * view.gsd_m, view.north_m - p.y * view.gsd_m);
  };
  const Shape shape = shape_of(b.region, {});
  const cv::Point2d centre = grid(shape.centre);
  Extracted out;
  Landmark& m = out.landmark;
  m.cls = b.region.cls;
  m.east_m = centre.x, m.north_m = centre.y;
  m.length_m = shape.length * view.gsd_m, m.width_m = shape.width * view.gsd_m;
  if (m.length_m > kElongated * m.width_m) m.orientation_rad = orientation_of(shape.along.x, -shape.along.y);
  m.confidence = b.confidence;
  for (const cv::Point& p : boundary_of(b.region, kTolerance_px)) out.outline.push_back(grid(p + b.region.box.tl()));
  return out;
}

}  // namespace

cv::Mat broad_view(const ObjectScene& scene, const cv::Mat& image, const cv::Rect& core) {
  std::vector<cv::Mat> planes = {scene.valid, scene.covers[size_t(Cover::kGround)],
                                 scene.covers[size_t(Cover::kWater)]};
  for (int k = 0; k < image.channels(); ++k) planes.push_back(channel(image, k));
  for (cv::Mat& plane : planes) {
    cv::Mat small;
    const cv::Size size = core.size() / kBroadStep_px;
    if (size.empty()) return {};
    cv::resize(plane(cv::Rect(core.tl(), size * kBroadStep_px)), small, size, 0, 0, cv::INTER_AREA);
    plane = small;
  }
  cv::Mat out;
  cv::merge(planes, out);
  return out;
}

std::vector<BroadRegion> broad_candidates(const cv::Mat& view, LandmarkClass cls) {
  return cls == LandmarkClass::kWater ? lakes_of(view) : fields_of(view);
}

std::vector<BroadRegion> chosen_regions(const cv::Mat& view, LandmarkClass cls) {
  std::vector<BroadRegion> regions = broad_candidates(view, cls), out;
  std::ranges::sort(regions, {}, [](const BroadRegion& b) { return std::tuple(-b.confidence, b.first, b.count); });
  std::vector<bool> taken(view.total(), false);
  for (BroadRegion& b : regions) {
    const auto begin = taken.begin() + b.first, end = begin + b.count;
    if (b.confidence < kLeastConfidence || std::find(begin, end, true) != end) continue;
    std::fill(begin, end, true);
    out.push_back(std::move(b));
  }
  return out;
}

std::vector<Extracted> find_broad(const features::GridImage& view, const cv::Rect& core) {
  std::vector<Extracted> out;
  for (const LandmarkClass cls : {LandmarkClass::kField, LandmarkClass::kWater})
    for (const BroadRegion& b : chosen_regions(view.pixels, cls))
      if (core.contains(b.region.middle())) out.push_back(landmark_of(b, view));
  return out;
}

std::vector<Extracted> find_all_broad(const features::GridImage& view) {
  std::vector<Extracted> out;
  const cv::Rect all({}, view.pixels.size());
  for (int y = 0; y < all.height; y += kBroadWindow_px) {
    for (int x = 0; x < all.width; x += kBroadWindow_px) {
      const cv::Rect core(x, y, kBroadWindow_px, kBroadWindow_px);
      const cv::Rect seen = cv::Rect(x - kBroadHalo_px, y - kBroadHalo_px, kBroadWindow_px + 2 * kBroadHalo_px,
                                     kBroadWindow_px + 2 * kBroadHalo_px) &
                            all;
      const features::GridImage part{
          view.pixels(seen), {}, view.west_m + seen.x * view.gsd_m, view.north_m - seen.y * view.gsd_m, view.gsd_m};
      out = with_broad(std::move(out), find_broad(part, core - seen.tl()));
    }
  }
  return out;
}

std::vector<Extracted> with_broad(std::vector<Extracted> broad, std::vector<Extracted> found) {
  const size_t before = broad.size();
  for (Extracted& e : found) {
    const bool is_in = std::any_of(broad.begin(), broad.begin() + std::ptrdiff_t(before), [&](const Extracted& b) {
      return b.landmark.cls == e.landmark.cls && covers(b.landmark, e.landmark);
    });
    if (!is_in) broad.push_back(std::move(e));
  }
  return broad;
}

}  // namespace landfix::landmarks

#include "builder/landmarks/object_regions.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <set>
#include <span>
#include <tuple>

namespace landfix::landmarks {
namespace {

using tiles::LandmarkClass;

// How regions of a class are cut out, and how large they may be.
struct Cut {
  std::vector<int> levels;    // of probability, of 255
  std::vector<int> openings;  // pixels: radius of the square that must fit in
  int least_px = 0, most_px = 0, reach_px = 0;
  std::vector<int> edges;  // of fields: strongest gradient inside (plane of 5 x 5 pixels)
};

const Cut& cut_of(LandmarkClass cls) {
  static const Cut kBuilding = {{70, 105, 140, 180, 215}, {0, 1, 2}, 12, 5000, 42, {}};
  static const Cut kField = {{128}, {1, 3}, 600, 15000, 62, {10, 18, 28}};
  static const Cut kTree = {{90, 128, 165, 205}, {0, 1}, 8, 5000, 42, {}};
  static const Cut kWater = {{128, 190}, {0, 2}, 80, 15000, 62, {}};
  static const Cut kPaved = {{115, 165}, {5}, 250, 15000, 62, {}};
  switch (cls) {
    case LandmarkClass::kBuilding:
      return kBuilding;
    case LandmarkClass::kField:
      return kField;
    case LandmarkClass::kTree:
      return kTree;
    case LandmarkClass::kWater:
      return kWater;
    case LandmarkClass::kPaved:
      break;
  }
  return kPaved;
}

cv::Mat square(int radius) { return cv::Mat::ones(2 * radius + 1, 2 * radius + 1, CV_8U); }

cv::Mat opened(const cv::Mat& mask, int radius) {
  if (radius == 0) return mask;
  cv::Mat out;
  cv::morphologyEx(mask, out, cv::MORPH_OPEN, square(radius), {-1, -1}, 1, cv::BORDER_CONSTANT, 0);
  return out;
}

// Whether a pixel of the region lies at the rim of the image or beside one without data.
bool cut_off(const Region& r, const cv::Mat& whole) {
  for (int y = 0; y < r.box.height; ++y) {
    const uint8_t *m = r.mask.ptr(y), *w = whole.ptr(r.box.y + y) + r.box.x;
    for (int x = 0; x < r.box.width; ++x)
      if (m[x] && !w[x]) return true;
  }
  return false;
}

// Adds the connected parts of a mask.
void add_parts(const cv::Mat& mask, const cv::Mat& whole, const cv::Rect& core, const Cut& cut, const Region& like,
               std::set<std::tuple<int, int, int, int, int>>& known, std::vector<Region>& out) {
  cv::Mat labels, stats, centres;
  const int count = cv::connectedComponentsWithStats(mask, labels, stats, centres, 4, CV_32S);
  for (int i = 1; i < count; ++i) {
    const int* s = stats.ptr<int>(i);
    const cv::Rect box(s[cv::CC_STAT_LEFT], s[cv::CC_STAT_TOP], s[cv::CC_STAT_WIDTH], s[cv::CC_STAT_HEIGHT]);
    const int area = s[cv::CC_STAT_AREA];
    if (area < cut.least_px || area > cut.most_px || std::max(box.width, box.height) > 2 * cut.reach_px) continue;
    Region r = like;
    r.box = box;
    if (!core.contains(r.middle()) || !known.insert({box.x, box.y, box.width, box.height, area}).second) continue;
    r.area_px = area;
    r.mask = (labels(box) == i) / 255;
    if (!cut_off(r, whole)) out.push_back(std::move(r));
  }
}

// Sums over the pixels of a mask.
class Mean {
 public:
  void add(double value) { sum_ += value, squares_ += value * value, ++count_; }
  double value() const { return count_ > 0 ? sum_ / count_ : 0; }
  double deviation() const { return count_ > 0 ? std::sqrt(std::max(squares_ / count_ - value() * value(), 0.0)) : 0; }

 private:
  double sum_ = 0, squares_ = 0;
  int count_ = 0;
};

constexpr int kMargin = 6;  // pixels around a region that are looked at

// The region and its surroundings, cut to the image: 3 well inside, 2 at the boundary, 1 within two pixels of it
// outside, 0 further off within the margin, 255 beyond.
struct Zones {
  cv::Rect box;
  cv::Mat zone;
};

Zones zones_of(const Region& r, const cv::Size& size) {
  const cv::Rect wide(r.box.x - kMargin, r.box.y - kMargin, r.box.width + 2 * kMargin, r.box.height + 2 * kMargin);
  cv::Mat padded, inner, near, far;
  cv::copyMakeBorder(r.mask, padded, kMargin, kMargin, kMargin, kMargin, cv::BORDER_CONSTANT, 0);
  cv::erode(padded, inner, square(1));
  cv::dilate(padded, near, square(2));
  cv::dilate(padded, far, square(kMargin));
  Zones out;
  out.box = wide & cv::Rect({}, size);
  cv::Mat zone(padded.size(), CV_8U, cv::Scalar(255));
  zone.setTo(0, far);
  zone.setTo(1, near);
  zone.setTo(2, padded);
  zone.setTo(3, inner);
  out.zone = zone(out.box - wide.tl());
  return out;
}

struct Statistics {
  Mean in, boundary, near, far;
  void add(uint8_t zone, double value) {
    if (zone >= 2) in.add(value);
    if (zone == 2) boundary.add(value);
    if (zone == 1) near.add(value);
    if (zone == 0) far.add(value);
  }
};

Statistics statistics_of(const cv::Mat& plane, const Zones& z) {
  Statistics out;
  for (int y = 0; y < z.box.height; ++y) {
    const uint8_t *zone = z.zone.ptr(y), *value = plane.ptr(z.box.y + y) + z.box.x;
    for (int x = 0; x < z.box.width; ++x)
      if (zone[x] != 255) out.add(zone[x], value[x]);
  }
  return out;
}

// Mean tone around the region in eight directions from its middle: lowest, mean of the lowest three, highest, and how
// one-sided it is. Shadows lie on one side.
std::array<double, 4> sides_of(const cv::Mat& tone, const Zones& z, const Region& r, const cv::Point2f& middle) {
  std::array<Mean, 8> side;
  for (int y = 0; y < z.box.height; ++y) {
    for (int x = 0; x < z.box.width; ++x) {
      if (z.zone.at<uint8_t>(y, x) > 1) continue;
      const cv::Point p = z.box.tl() + cv::Point(x, y) - r.box.tl();
      const double angle = std::atan2(p.y + 0.5 - double(middle.y), p.x + 0.5 - double(middle.x));
      side[size_t(std::lround(angle * 4 / std::numbers::pi) + 8) % 8].add(tone.at<uint8_t>(z.box.y + y, z.box.x + x));
    }
  }
  std::array<double, 8> sorted;
  double c = 0, s = 0;
  for (size_t k = 0; k < 8; ++k) {
    sorted[k] = side[k].value();
    c += sorted[k] * std::cos(double(k) * std::numbers::pi / 4) / 8;
    s += sorted[k] * std::sin(double(k) * std::numbers::pi / 4) / 8;
  }
  std::sort(sorted.begin(), sorted.end());
  return {sorted[0], (sorted[0] + sorted[1] + sorted[2]) / 3, sorted[7], std::hypot(c, s)};
}

// How far the gradients along the boundary stand at right angles to the rectangle's sides, and to each other at all:
// -1 to 1, 0 to 1; and their mean length.
std::array<double, 3> alignment_of(const features::FourfoldGradient& g, const Zones& z, double angle_rad) {
  double c = 0, s = 0, length = 0;
  int count = 0;
  for (int y = 0; y < z.box.height; ++y) {
    for (int x = 0; x < z.box.width; ++x) {
      const uint8_t zone = z.zone.at<uint8_t>(y, x);
      if (zone != 1 && zone != 2) continue;
      const cv::Point p(z.box.x + x, z.box.y + y);
      c += g.cosine.at<int16_t>(p), s += g.sine.at<int16_t>(p), length += g.length.at<int16_t>(p);
      ++count;
    }
  }
  if (length <= 0) return {};
  return {(c * std::cos(4 * angle_rad) + s * std::sin(4 * angle_rad)) / length, std::hypot(c, s) / length,
          length / count};
}

class Numbers {
 public:
  void add(double value) { out_[count_++] = float(value); }
  const RegionNumbers& get() const { return out_; }

 private:
  RegionNumbers out_{};
  size_t count_ = 0;
};

void add_shape(const Region& r, const cv::RotatedRect& rect, Numbers& out) {
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(r.mask, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  std::vector<cv::Point> hull;
  cv::convexHull(contours.front(), hull);
  const double length = double(std::max(rect.size.width, rect.size.height)),
               width = double(std::min(rect.size.width, rect.size.height)), area = r.area_px;
  const double outline = double(contours.front().size());
  out.add(r.level);
  out.add(r.opening);
  out.add(std::log(area));
  out.add(length);
  out.add(width);
  out.add(area / (length * width));
  out.add(outline * outline / area);
  out.add(area / (cv::contourArea(hull) + outline / 2));
}

}  // namespace

int reach_of(LandmarkClass cls) { return cut_of(cls).reach_px; }

ObjectScene look_at(const cv::Mat& image, const cv::Mat& valid, const features::BoostedTrees& trees) {
  ObjectScene scene;
  scene.valid = valid.empty() ? cv::Mat(image.size(), CV_8U, cv::Scalar(255)) : valid;
  features::object_planes(image, valid, scene.planes, scene.gradient);
  std::array<cv::Mat, kCovers> raw;
  for (cv::Mat& m : raw) m.create(image.size(), CV_8U);
  std::vector<float> numbers(scene.planes.size());
  std::array<float, kCovers> scores;
  for (int y = 0; y < image.rows; ++y) {
    std::vector<const uint8_t*> rows;
    for (const cv::Mat& plane : scene.planes) rows.push_back(plane.ptr(y));
    const uint8_t* known = scene.valid.ptr(y);
    for (int x = 0; x < image.cols; ++x) {
      if (!known[x]) {
        for (cv::Mat& m : raw) m.at<uint8_t>(y, x) = 0;
        continue;
      }
      for (size_t k = 0; k < rows.size(); ++k) numbers[k] = rows[k][x];
      trees.measure(numbers, scores);
      const float top = *std::max_element(scores.begin(), scores.end());
      float sum = 0;
      for (float& s : scores) sum += s = std::exp(s - top);
      for (size_t k = 0; k < kCovers; ++k) raw[k].at<uint8_t>(y, x) = uint8_t(scores[k] / sum * 255 + 0.5f);
    }
  }
  for (size_t k = 0; k < kCovers; ++k) cv::blur(raw[k], scene.covers[k], {3, 3}, {-1, -1}, cv::BORDER_REPLICATE);
  return scene;
}

std::vector<Region> regions_of(const ObjectScene& scene, LandmarkClass cls, const cv::Rect& core) {
  const Cut& cut = cut_of(cls);
  const cv::Mat& cover = scene.covers[size_t(cover_of(cls))];
  cv::Mat whole;
  cv::erode(scene.valid, whole, square(1), {-1, -1}, 1, cv::BORDER_CONSTANT, 0);
  std::vector<Region> out;
  std::set<std::tuple<int, int, int, int, int>> known;
  const std::vector<int> edges = cut.edges.empty() ? std::vector<int>{255} : cut.edges;
  for (const int level : cut.levels) {
    for (const int edge : edges) {
      cv::Mat mask = cover >= level;
      if (edge < 255) mask &= scene.planes[features::kPlaneGradient + 1] <= edge;
      for (const int opening : cut.openings) {
        const Region like{cls, {}, {}, 0, edge < 255 ? edge : level, opening};
        add_parts(opened(mask, opening), whole, core, cut, like, known, out);
      }
    }
  }
  return out;
}

cv::RotatedRect rectangle_of(const Region& r) {
  // Of the pixels' corners, not their middles.
  cv::Mat corners = cv::Mat::zeros(r.box.height + 1, r.box.width + 1, CV_8U);
  for (const cv::Point shift : {cv::Point(0, 0), cv::Point(1, 0), cv::Point(0, 1), cv::Point(1, 1)})
    corners(cv::Rect(shift, r.box.size())) |= r.mask;
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(corners, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  return cv::minAreaRect(contours.front());
}

RegionNumbers numbers_of(const ObjectScene& scene, const Region& r) {
  const cv::RotatedRect rect = rectangle_of(r);
  const Zones z = zones_of(r, scene.valid.size());
  Numbers out;
  add_shape(r, rect, out);
  for (const cv::Mat& cover : scene.covers) {
    const Statistics s = statistics_of(cover, z);
    out.add(s.in.value());
    out.add(s.near.value());
    out.add(s.far.value());
    if (&cover == &scene.covers[size_t(cover_of(r.cls))]) {
      out.add(s.in.deviation());
      out.add(s.boundary.value());
    }
  }
  const Statistics tone = statistics_of(scene.planes[features::kPlaneTone], z);
  out.add(tone.in.value());
  out.add(tone.near.value() - tone.in.value());
  out.add(tone.far.value() - tone.in.value());
  out.add(tone.in.deviation());
  out.add(tone.near.deviation());
  const Statistics edge = statistics_of(scene.planes[features::kPlaneGradient], z);
  out.add(edge.in.value());
  out.add(edge.boundary.value());
  out.add(edge.near.value());
  out.add(edge.far.value());
  out.add(edge.boundary.deviation());
  const Statistics dark = statistics_of(scene.planes[features::kPlaneDark], z);
  out.add(dark.in.value());
  out.add(dark.near.value());
  out.add(dark.far.value());
  for (const double side : sides_of(scene.planes[features::kPlaneTone3], z, r, rect.center)) out.add(side);
  for (const double value : alignment_of(scene.gradient, z, double(rect.angle) * std::numbers::pi / 180))
    out.add(value);
  if (scene.planes.size() > features::kObjectPlanesGray) {
    for (const int first : {features::kPlaneRedGreen, features::kPlaneBlueYellow}) {
      const Statistics s = statistics_of(scene.planes[size_t(first)], z);
      out.add(s.in.value());
      out.add(s.near.value() - s.in.value());
      out.add(s.far.value() - s.in.value());
      out.add(s.in.deviation());
    }
  }
  return out.get();
}

int common_px(const Region& a, const Region& b) {
  const cv::Rect common = a.box & b.box;
  int both = 0;
  for (int y = common.y; y < common.y + common.height; ++y) {
    const uint8_t *p = a.mask.ptr(y - a.box.y), *q = b.mask.ptr(y - b.box.y);
    for (int x = common.x; x < common.x + common.width; ++x) both += p[x - a.box.x] & q[x - b.box.x];
  }
  return both;
}

}  // namespace landfix::landmarks

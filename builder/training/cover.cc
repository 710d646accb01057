#include "builder/training/cover.h"

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace landfix::landmarks {
namespace {

using features::LandmarkLabel;

constexpr int kWide = 40, kNarrow = 20;  // pixels a side of the squares that are looked at
constexpr int kNearBuildingPx = 91;      // side of the square around a building that counts as near
constexpr int kTriesPerPlace = 120;
constexpr double kBuildingOffset = 4;  // pixels

/// Share of the squares around every pixel.
struct Share {
  explicit Share(const cv::Mat& mask) {
    cv::Mat f;
    mask.convertTo(f, CV_32F);
    cv::blur(f, wide, {kWide, kWide});
    cv::blur(f, narrow, {kNarrow, kNarrow});
  }
  cv::Mat wide, narrow;
};

struct Shares {
  Share building, tree, paved, water, field;
  cv::Mat near_building;
};

/// The class of a place that shows one clearly, buildings apart; kNone of others. Fields only where `near` a building,
/// or only elsewhere.
LandmarkLabel label_at(const Shares& s, const cv::Point& p, bool near, double field_share) {
  const auto at = [&p](const cv::Mat& share) { return share.at<float>(p); };
  if (at(s.water.wide) > 0.92f) return LandmarkLabel::kWater;
  if (at(s.tree.wide) > 0.3f && at(s.tree.narrow) > 0.4f && at(s.building.wide) < 0.02f && at(s.paved.wide) < 0.15f)
    return LandmarkLabel::kTree;
  if (at(s.field.wide) > field_share && at(s.field.narrow) > 0.92f && at(s.tree.narrow) < 0.06f &&
      at(s.building.narrow) < 0.002f && at(s.building.wide) < 0.12f && (s.near_building.at<uint8_t>(p) > 0) == near)
    return LandmarkLabel::kField;
  if (at(s.paved.wide) > 0.28f && at(s.paved.narrow) > 0.4f && at(s.building.wide) < 0.03f && at(s.tree.wide) < 0.08f)
    return LandmarkLabel::kPaved;
  return LandmarkLabel::kNone;
}

}  // namespace

Cover::Cover(const features::GridImage& image) : image_(image) {
  for (cv::Mat* mask : {&building_, &tree_, &paved_, &water_, &field_})
    *mask = cv::Mat::zeros(image.pixels.size(), CV_8UC1);
}

void Cover::add(Kind kind, const ingest::VectorPart& part, double size_m) {
  const auto pixel = [&](const cv::Point2d& p) { return cv::Point2d(image_.column_of(p.x), image_.row_of(p.y)); };
  std::vector<cv::Point> points;
  for (const cv::Point2d& p : part.points) points.emplace_back(cvRound(pixel(p).x), cvRound(pixel(p).y));
  if (points.empty()) return;
  cv::Mat& mask = kind == Kind::kBuilding ? building_
                  : kind == Kind::kTree   ? tree_
                  : kind == Kind::kWater  ? water_
                  : kind == Kind::kField  ? field_
                                          : paved_;
  const int size_px = std::max(1, cvRound(size_m / image_.gsd_m));
  if (part.shape == ingest::Shape::kPolygon) {
    cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{points}, cv::Scalar(1));
    if (kind == Kind::kBuilding) centres_.push_back(pixel(part.centroid));
  } else if (part.shape == ingest::Shape::kLine) {
    cv::polylines(mask, points, false, cv::Scalar(1), size_px);
  } else {
    cv::circle(mask, points.front(), size_px, cv::Scalar(1), cv::FILLED);
    if (kind == Kind::kBuilding) centres_.push_back(pixel(part.points.front()));
  }
}

void Cover::open_elsewhere() { field_ = ((building_ | tree_ | paved_ | water_) == 0) / 255; }

std::vector<Chip> Cover::draw(const PlaceOptions& options) const {
  std::vector<Chip> chips;
  const int margin = kPatchPx / 2 + 2, width = building_.cols, height = building_.rows;
  if (width <= 2 * margin || height <= 2 * margin) return chips;
  const cv::Rect inner(margin, margin, width - 2 * margin, height - 2 * margin);
  Shares shares{Share(building_), Share(tree_), Share(paved_), Share(water_), Share(field_), {}};
  cv::dilate(building_, shares.near_building, cv::Mat::ones(kNearBuildingPx, kNearBuildingPx, CV_8UC1));
  cv::Mat known;
  cv::erode(image_.valid, known, cv::Mat::ones(kNarrow, kNarrow, CV_8UC1));
  cv::RNG random(options.seed);
  const auto add = [&](const cv::Point& p, LandmarkLabel label) {
    chips.push_back({std::to_string(chips.size() + 1), image_.west_m + (p.x + 0.5) * image_.gsd_m,
                     image_.north_m - (p.y + 0.5) * image_.gsd_m, label, 0});
  };
  for (int i = 0; i < options.per_class && !centres_.empty(); ++i) {
    const cv::Point2d centre = centres_[size_t(random.uniform(0, int(centres_.size())))];
    const cv::Point p(cvRound(centre.x + random.uniform(-kBuildingOffset, kBuildingOffset)),
                      cvRound(centre.y + random.uniform(-kBuildingOffset, kBuildingOffset)));
    if (inner.contains(p) && known.at<uint8_t>(p) && shares.building.narrow.at<float>(p) > 0.2f)
      add(p, LandmarkLabel::kBuilding);
  }
  std::array<int, features::kLandmarkLabels> count{};
  for (int i = 0; i < options.per_class * kTriesPerPlace; ++i) {
    const cv::Point p(random.uniform(inner.x, inner.x + inner.width), random.uniform(inner.y, inner.y + inner.height));
    const bool near = !centres_.empty() && count[size_t(LandmarkLabel::kField)] % 2 == 0;
    const LandmarkLabel label = label_at(shares, p, near, random.uniform(0.0, 1.0) < 0.7 ? 0.55 : 0.85);
    if (label == LandmarkLabel::kNone || !known.at<uint8_t>(p) || count[size_t(label)] >= options.per_class) continue;
    ++count[size_t(label)];
    add(p, label);
  }
  return chips;
}

}  // namespace landfix::landmarks

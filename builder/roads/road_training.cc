#include "builder/roads/road_training.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "builder/point_grid.h"
#include "builder/training/random.h"
#include "runtime/features/road_filter.h"

namespace landfix::landmarks {
namespace {

constexpr int kSidePx = 620;
constexpr size_t kRoadsPerImage = 1200, kOthersPerRoad = 4;

struct Samples {
  PointGrid grid{4};
  std::vector<double> theta;
};

// Lines as points every half pixel.
Samples sampled(std::span<const Line> roads) {
  Samples out;
  for (const Line& line : roads) {
    for (size_t i = 1; i < line.points.size(); ++i) {
      const cv::Point2d a = line.points[i - 1], d = line.points[i] - a;
      const int steps = std::max(1, int(std::ceil(2 * std::hypot(d.x, d.y))));
      for (int s = 0; s < steps; ++s) {
        out.grid.add(a + d * (double(s) / steps), int(out.theta.size()));
        out.theta.push_back(std::atan2(d.y, d.x));
      }
    }
  }
  return out;
}

// Whether a candidate is a road; nullopt: too near to be said not to be one.
std::optional<bool> class_of(const features::RoadCandidate& c, const Samples& truth, double scale) {
  const double close = scale < 1.3 ? 1.25 : (scale < 2 ? 1.5 : 1.8), far = 2.5 * std::sqrt(std::max(1.0, scale));
  const cv::Point2d at(c.x + 0.5, c.y + 0.5);
  const int far_one = truth.grid.nearest(at, far);
  if (far_one < 0) return false;
  const int near_one = truth.grid.nearest(at, close);
  if (near_one < 0) return std::nullopt;
  const double turn = std::abs(std::remainder(truth.theta[size_t(near_one)] - double(c.theta_rad), std::numbers::pi));
  if (turn < 0.349) return true;
  if (turn > 0.611) return false;
  return std::nullopt;
}

using Classes = std::vector<std::optional<bool>>;

Classes classes_by_exact(const std::vector<features::RoadCandidate>& all, std::span<const Line> roads, double scale) {
  const Samples truth = sampled(roads);
  Classes classes;
  for (const features::RoadCandidate& c : all) classes.push_back(class_of(c, truth, scale));
  return classes;
}

// Of the candidates beside each point of a line the likeliest, and its neighbours across.
Classes classes_by_drawn(const std::vector<features::RoadCandidate>& all, std::span<const Line> roads, double scale) {
  const double near = std::max(2.3, 4 * scale), far = std::max(4.5, 7 * scale);
  const Samples truth = sampled(roads);
  PointGrid grid(4);
  Classes classes;
  for (size_t i = 0; i < all.size(); ++i) {
    const cv::Point2d at(all[i].x + 0.5, all[i].y + 0.5);
    grid.add(at, int(i));
    classes.push_back(truth.grid.nearest(at, far) < 0 ? std::optional(false) : std::nullopt);
  }
  truth.grid.for_each([&](const cv::Point2d& on_line, int sample) {
    int best = -1;
    double most = -1e9;
    grid.within(on_line, near, [&](const cv::Point2d& at, int id) {
      const features::RoadCandidate& c = all[size_t(id)];
      const double turn = std::remainder(truth.theta[size_t(sample)] - double(c.theta_rad), std::numbers::pi);
      const double worth = double(c.response) - 0.3 * cv::norm(at - on_line);
      if (std::abs(turn) >= 0.314 || worth <= most) return;
      most = worth;
      best = id;
    });
    if (best < 0) return;
    const cv::Point2d middle(all[size_t(best)].x + 0.5, all[size_t(best)].y + 0.5);
    grid.within(middle, 1.2, [&](const cv::Point2d&, int id) {
      const double turn =
          std::remainder(truth.theta[size_t(sample)] - double(all[size_t(id)].theta_rad), std::numbers::pi);
      if (std::abs(turn) < 0.314) classes[size_t(id)] = true;
    });
  });
  return classes;
}

void keep_some(std::vector<features::RoadCandidate>& all, size_t count, Random& random) {
  for (size_t i = 0; i < std::min(count, all.size()); ++i)
    std::swap(all[i], all[i + size_t(random.below(int(all.size() - i)))]);
  if (all.size() > count) all.resize(count);
}

size_t road_inside(std::span<const Line> roads, const cv::Rect& rect) {
  size_t count = 0;
  for (const Line& line : roads)
    for (const cv::Point2d& p : line.points) count += rect.contains(cv::Point(int(p.x), int(p.y)));
  return count;
}

cv::Rect place_with_road(const cv::Size& size, std::span<const Line> roads, Random& random) {
  const cv::Size side(std::min(kSidePx, size.width), std::min(kSidePx, size.height));
  cv::Rect best;
  size_t most = 0;
  for (int i = 0; i < 6; ++i) {
    const cv::Point corner(random.below(size.width - side.width + 1), random.below(size.height - side.height + 1));
    const size_t count = road_inside(roads, {corner, side});
    if (i > 0 && count <= most) continue;
    best = {corner, side};
    most = count;
  }
  return best;
}

// Another camera, soil or season: paler or of other colours, tinted, of other contrast, with noise.
void vary_colours(cv::Mat& image, Random& random) {
  static constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  const double paleness = random.between(0, 1) < 0.7 ? random.between(-0.4, 1) : 1;
  const int* order = kOrders[random.between(0, 1) < 0.5 ? random.below(6) : 0];
  const double contrast = random.between(0.5, 1.2), level = random.between(90, 140);
  const double tint[3] = {random.between(0.85, 1.15), 1, random.between(0.8, 1.2)};
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      cv::Vec3b& c = image.at<cv::Vec3b>(y, x);
      const double mean = (c[0] + c[1] + c[2]) / 3.0;
      cv::Vec3b out;
      for (int k = 0; k < 3; ++k) {
        const double noise = 3 * (random.between(-0.5, 0.5) + random.between(-0.5, 0.5) + random.between(-0.5, 0.5));
        const double value = (mean - 110) * contrast + level + (c[order[k]] - mean) * paleness * contrast;
        out[k] = cv::saturate_cast<uint8_t>(value * tint[k] + noise);
      }
      c = out;
    }
  }
}

}  // namespace

features::BoostedTrees boost(const TrainingSet& set, const BoostingOptions& options) {
  std::vector<float> values;
  for (const features::RoadProfile& row : set.rows) values.insert(values.end(), row.begin(), row.end());
  return boost(values, features::kRoadProfileFeatures, set.is_road, options);
}

void add_examples(const cv::Mat& image, std::span<const Line> roads, Truth truth, double px_per_m, uint64_t seed,
                  TrainingSet& set) {
  cv::Mat bands;
  features::road_bands(image, bands);
  const std::vector<features::RoadCandidate> all = features::road_candidates(bands, {});
  const Classes classes =
      truth == Truth::kExact ? classes_by_exact(all, roads, px_per_m) : classes_by_drawn(all, roads, px_per_m);
  std::vector<features::RoadCandidate> road, other;
  for (size_t i = 0; i < all.size(); ++i)
    if (classes[i]) (*classes[i] ? road : other).push_back(all[i]);
  Random random(seed);
  keep_some(road, kRoadsPerImage, random);
  keep_some(other, kOthersPerRoad * road.size(), random);
  for (const auto* group : {&road, &other}) {
    for (const features::RoadCandidate& c : *group) {
      set.rows.emplace_back();
      features::road_profile(bands, c.x, c.y, c.theta_rad, set.rows.back());
      set.is_road.push_back(group == &road);
    }
  }
}

Example varied(const cv::Mat& image, std::span<const Line> roads, uint64_t seed) {
  Random random(seed);
  const cv::Rect rect = place_with_road(image.size(), roads, random);
  Example out;
  cv::GaussianBlur(image(rect), out.image, {7, 7}, random.between(0.35, 1.1));
  vary_colours(out.image, random);
  for (const Line& line : roads) {
    out.roads.push_back(line);
    for (cv::Point2d& p : out.roads.back().points) p -= cv::Point2d(rect.tl());
  }
  return out;
}

}  // namespace landfix::landmarks

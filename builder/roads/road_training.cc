#include "builder/roads/road_training.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <tuple>

#include "builder/point_grid.h"
#include "builder/random.h"
#include "builder/roads/road_candidates.h"
#include "runtime/features/road_filter.h"

namespace landfix::landmarks {
namespace {

constexpr int kSidePx = 620;
constexpr size_t kRoadsPerImage = 1200, kOthersPerRoad = 4;
constexpr size_t kSecondRoads = 700;     // per image and scale, as the rows of the second judge are twice as long
constexpr double kCoarseClose_px = 1.5;  // places at 2 m lie no closer to the line

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

// A candidate in the pixels of the lines.
struct Seen {
  cv::Point2d at;
  double theta_rad, response;
};

// Of pixels as large as `size_px` of those of the lines.
std::vector<Seen> seen_in(const std::vector<features::RoadCandidate>& all, double size_px) {
  std::vector<Seen> out;
  for (const features::RoadCandidate& c : all)
    out.push_back({cv::Point2d(c.x + 0.5, c.y + 0.5) * size_px, double(c.theta_rad), double(c.response)});
  return out;
}

// Whether a candidate is a road; nullopt: too near to be said not to be one.
std::optional<bool> class_of(const Seen& c, const Samples& truth, double scale, double least_close) {
  const double close = std::max(least_close, scale < 1.3 ? 1.25 : (scale < 2 ? 1.5 : 1.8));
  const double far = 2.5 * std::sqrt(std::max(1.0, scale));
  const int far_one = truth.grid.nearest(c.at, far);
  if (far_one < 0) return false;
  const int near_one = truth.grid.nearest(c.at, close);
  if (near_one < 0) return std::nullopt;
  const double turn = std::abs(std::remainder(truth.theta[size_t(near_one)] - c.theta_rad, std::numbers::pi));
  if (turn < 0.349) return true;
  if (turn > 0.611) return false;
  return std::nullopt;
}

using Classes = std::vector<std::optional<bool>>;

Classes classes_by_exact(const std::vector<Seen>& all, const Samples& truth, double scale, double least_close) {
  Classes classes;
  for (const Seen& c : all) classes.push_back(class_of(c, truth, scale, least_close));
  return classes;
}

// Of the candidates beside each point of a line the likeliest, and its neighbours across.
Classes classes_by_drawn(const std::vector<Seen>& all, const Samples& truth, double scale) {
  const double near = std::max(2.3, 4 * scale), far = std::max(4.5, 7 * scale);
  PointGrid grid(4);
  Classes classes;
  for (size_t i = 0; i < all.size(); ++i) {
    grid.add(all[i].at, int(i));
    classes.push_back(truth.grid.nearest(all[i].at, far) < 0 ? std::optional(false) : std::nullopt);
  }
  truth.grid.for_each([&](const cv::Point2d& on_line, int sample) {
    int best = -1;
    double most = -1e9;
    grid.within(on_line, near, [&](const cv::Point2d& at, int id) {
      const Seen& c = all[size_t(id)];
      const double turn = std::remainder(truth.theta[size_t(sample)] - c.theta_rad, std::numbers::pi);
      const double worth = c.response - 0.3 * cv::norm(at - on_line);
      if (std::abs(turn) >= 0.314 || worth <= most) return;
      most = worth;
      best = id;
    });
    if (best < 0) return;
    grid.within(all[size_t(best)].at, 1.2, [&](const cv::Point2d&, int id) {
      const double turn = std::remainder(truth.theta[size_t(sample)] - all[size_t(id)].theta_rad, std::numbers::pi);
      if (std::abs(turn) < 0.314) classes[size_t(id)] = true;
    });
  });
  return classes;
}

// The candidates of both classes, of each as many as are wanted.
struct Chosen {
  std::vector<features::RoadCandidate> road, other;
};

Chosen choose(const std::vector<features::RoadCandidate>& all, const Classes& classes, size_t most, Random& random) {
  Chosen out;
  for (size_t i = 0; i < all.size(); ++i)
    if (classes[i]) (*classes[i] ? out.road : out.other).push_back(all[i]);
  keep_some(out.road, most, random);
  keep_some(out.other, kOthersPerRoad * out.road.size(), random);
  return out;
}

template <typename Row>
features::BoostedTrees boost_rows(const Examples<Row>& set, const BoostingOptions& options) {
  std::vector<float> values;
  for (const Row& row : set.rows) values.insert(values.end(), row.begin(), row.end());
  return boost(values, std::tuple_size_v<Row>, set.is_road, options);
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
        const double noise = 1.5 * random.normal();
        const double value = (mean - 110) * contrast + level + (c[order[k]] - mean) * paleness * contrast;
        out[k] = cv::saturate_cast<uint8_t>(value * tint[k] + noise);
      }
      c = out;
    }
  }
}

}  // namespace

features::BoostedTrees boost(const TrainingSet& set, const BoostingOptions& options) {
  return boost_rows(set, options);
}

features::BoostedTrees boost(const SecondTrainingSet& set, const BoostingOptions& options) {
  return boost_rows(set, options);
}

void add_examples(const cv::Mat& image, std::span<const Line> roads, Truth truth, double px_per_m, uint64_t seed,
                  TrainingSet& set) {
  cv::Mat bands;
  features::road_bands(image, bands);
  const std::vector<features::RoadCandidate> all = features::road_candidates(bands, {});
  const std::vector<Seen> seen = seen_in(all, 1);
  const Samples lines = sampled(roads);
  Random random(seed);
  const Chosen chosen = choose(
      all,
      truth == Truth::kExact ? classes_by_exact(seen, lines, px_per_m, 0) : classes_by_drawn(seen, lines, px_per_m),
      kRoadsPerImage, random);
  for (const auto* group : {&chosen.road, &chosen.other}) {
    for (const features::RoadCandidate& c : *group) {
      set.rows.emplace_back();
      features::road_profile(bands, c.x, c.y, c.theta_rad, set.rows.back());
      set.is_road.push_back(group == &chosen.road);
    }
  }
}

void add_examples(const cv::Mat& image, std::span<const Line> roads, Truth truth, double px_per_m, uint64_t seed,
                  const features::BoostedTrees& first, SecondTrainingSet& set) {
  const RoadScales scales(image, {});
  const Samples lines = sampled(roads);
  Random random(seed);
  features::RoadProfile profile;
  for (int level = 0; level < RoadScales::kLevels; ++level) {
    std::vector<features::RoadCandidate> left;
    for (const features::RoadCandidate& c : scales.candidates(level)) {
      scales.describe(c, level, profile);
      if (first.probability(profile) >= kLeastOfFirst) left.push_back(c);
    }
    const std::vector<Seen> seen = seen_in(left, 1 << level);
    const Chosen chosen =
        choose(left,
               truth == Truth::kExact ? classes_by_exact(seen, lines, px_per_m, level == 0 ? 0 : kCoarseClose_px)
                                      : classes_by_drawn(seen, lines, px_per_m),
               kSecondRoads, random);
    for (const auto* group : {&chosen.road, &chosen.other}) {
      for (const features::RoadCandidate& c : *group) {
        set.rows.emplace_back();
        scales.describe(c, level, profile);
        scales.describe(c, level, profile, set.rows.back());
        set.is_road.push_back(group == &chosen.road);
      }
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

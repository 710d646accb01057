#include "builder/landmarks/extraction.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "builder/error.h"
#include "builder/landmarks/broad_regions.h"
#include "builder/landmarks/orientation.h"
#include "builder/landmarks/outline.h"

namespace landfix::landmarks {
namespace {

using tiles::Landmark;
using tiles::LandmarkClass;

constexpr int kBlock_px = 1024;
constexpr int kWood_px = 61;         // side of the square around a tree that tells a wood
constexpr double kWoodShare = 0.25;  // of it that other crowns cover
// A region stays where it is better than all that share much with it and have their middle near by: within what the
// halo shows whole.
constexpr double kCovered = 0.25;  // share of the smaller one

int rival_px(LandmarkClass cls) { return kLandmarkHalo_px - kRegionSight_px - reach_of(cls); }

bool better(const Chosen& a, const Chosen& b) {
  const auto key = [](const Chosen& c) {
    return std::tuple(-c.score, -c.region.area_px, c.region.box.y, c.region.box.x, c.region.box.height,
                      c.region.box.width);
  };
  return key(a) < key(b);
}

bool rivals(const Region& a, const Region& b, int reach) {
  const cv::Point d = a.middle() - b.middle();
  return std::max(std::abs(d.x), std::abs(d.y)) <= reach && common_px(a, b) > kCovered * std::min(a.area_px, b.area_px);
}

// `all`: best first. Whether each stays.
std::vector<bool> compete(const std::vector<Chosen>& all, int reach) {
  std::vector<size_t> by_row(all.size());
  for (size_t i = 0; i < by_row.size(); ++i) by_row[i] = i;
  const auto row = [&](size_t i) { return all[i].region.middle().y; };
  std::sort(by_row.begin(), by_row.end(),
            [&](size_t i, size_t j) { return std::pair(row(i), i) < std::pair(row(j), j); });
  std::vector<bool> stays(all.size(), true);
  for (size_t a = 0; a < by_row.size(); ++a)
    for (size_t b = a + 1; b < by_row.size() && row(by_row[b]) - row(by_row[a]) <= reach; ++b)
      if (rivals(all[by_row[a]].region, all[by_row[b]].region, reach)) stays[std::max(by_row[a], by_row[b])] = false;
  return stays;
}

double probability_of(const Sigmoid& s, float score) { return 1 / (1 + std::exp(s.a * double(score) + s.b)); }

// The image around the core, without data where there is no image.
features::GridImage around(const features::GridImage& image, const cv::Rect& core) {
  const cv::Rect wide(core.x - kLandmarkHalo_px, core.y - kLandmarkHalo_px, core.width + 2 * kLandmarkHalo_px,
                      core.height + 2 * kLandmarkHalo_px);
  const cv::Rect part = wide & cv::Rect({}, image.pixels.size());
  const cv::Point first = part.tl() - wide.tl(), last = wide.br() - part.br();
  features::GridImage out;
  cv::copyMakeBorder(image.pixels(part), out.pixels, first.y, last.y, first.x, last.x,
                     cv::BORDER_CONSTANT | cv::BORDER_ISOLATED);
  const cv::Mat valid =
      image.valid.empty() ? cv::Mat(part.size(), CV_8U, cv::Scalar(255)) : cv::Mat(image.valid(part) != 0);
  cv::copyMakeBorder(valid, out.valid, first.y, last.y, first.x, last.x, cv::BORDER_CONSTANT | cv::BORDER_ISOLATED, 0);
  out.gsd_m = image.gsd_m;
  out.west_m = image.west_m + wide.x * image.gsd_m;
  out.north_m = image.north_m - wide.y * image.gsd_m;
  return out;
}

// Crowns inside of a closed wood are no landmarks: none can be told from its neighbours.
bool in_a_wood(const ObjectScene& scene, const Region& r) {
  const cv::Point middle = r.middle();
  const cv::Rect around =
      cv::Rect(middle.x - kWood_px / 2, middle.y - kWood_px / 2, kWood_px, kWood_px) & cv::Rect({}, scene.valid.size());
  const cv::Mat trees = scene.covers[size_t(Cover::kTree)](around) >= 128;
  return cv::countNonZero(trees) - r.area_px > kWoodShare * kWood_px * kWood_px;
}

Extracted landmark_of(const Chosen& chosen, const features::GridImage& image,
                      const features::FourfoldGradient& gradient, double confidence) {
  const Region& r = chosen.region;
  const bool building = r.cls == LandmarkClass::kBuilding;
  Extracted out;
  const Shape shape = shape_of(r, gradient);
  const auto grid = [&](const cv::Point2d& p) {
    return cv::Point2d(image.west_m + p.x * image.gsd_m, image.north_m - p.y * image.gsd_m);
  };
  const cv::Point2d centre = grid(shape.centre);
  Landmark& m = out.landmark;
  m.cls = r.cls;
  m.east_m = centre.x;
  m.north_m = centre.y;
  m.length_m = shape.length * image.gsd_m;
  m.width_m = shape.width * image.gsd_m;
  if (building || m.length_m > kElongated * m.width_m)
    m.orientation_rad = orientation_of(shape.along.x, -shape.along.y);
  m.confidence = confidence;
  for (const cv::Point2d& p : shape.outline) out.outline.push_back(grid(p));
  return out;
}

// The cover that has the highest probability, the first of several.
cv::Mat likeliest_covers(const ObjectScene& scene, const cv::Rect& region) {
  cv::Mat best = cv::Mat::zeros(region.size(), CV_8U), highest = scene.covers[0](region).clone();
  for (size_t k = 1; k < kCovers; ++k) {
    const cv::Mat higher = scene.covers[k](region) > highest;
    best.setTo(double(k), higher);
    scene.covers[k](region).copyTo(highest, higher);
  }
  return best;
}

}  // namespace

std::vector<Chosen> choose_regions(const ObjectScene& scene, LandmarkClass cls, const cv::Rect& core,
                                   const features::BoostedTrees& whole) {
  const int reach = rival_px(cls);
  std::vector<Chosen> all;
  for (Region& region :
       regions_of(scene, cls, {core.x - reach, core.y - reach, core.width + 2 * reach, core.height + 2 * reach})) {
    const RegionNumbers numbers = numbers_of(scene, region);
    float score = 0;
    whole.measure(numbers, {&score, 1});
    all.push_back({std::move(region), numbers, score});
  }
  std::sort(all.begin(), all.end(), better);
  const std::vector<bool> stays = compete(all, reach);
  std::vector<Chosen> out;
  for (size_t i = 0; i < all.size(); ++i)
    if (stays[i] && core.contains(all[i].region.middle())) out.push_back(std::move(all[i]));
  return out;
}

std::vector<Extracted> find_landmarks(const features::GridImage& image, const cv::Rect& core, const ObjectModel& model,
                                      cv::Mat* view, cv::Mat* covers) {
  if (covers) *covers = cv::Mat(core.size(), CV_8U, cv::Scalar(kNoCover));
  if (image.pixels.type() != CV_8UC1 && image.pixels.type() != CV_8UC3)
    throw Error(ExitCode::kInternal, "landmarks are found in images of 8 bits, gray or red, green, blue");
  const cv::Rect inside = core & cv::Rect({}, image.pixels.size());
  if (inside.empty()) return {};
  const features::GridImage seen = around(image, inside);
  if (cv::countNonZero(seen.valid) == 0) return {};
  const ObjectModel::Part& part = image.pixels.channels() == 3 ? model.colour : model.gray;
  const ObjectScene scene = look_at(seen.pixels, seen.valid, part.covers);
  const cv::Rect middle(kLandmarkHalo_px, kLandmarkHalo_px, inside.width, inside.height);
  if (view) *view = broad_view(scene, seen.pixels, middle);
  if (covers) {
    cv::Mat known = (*covers)(inside - core.tl());
    likeliest_covers(scene, middle).copyTo(known, scene.valid(middle));
  }
  std::vector<Extracted> out;
  for (size_t k = 0; k < tiles::kLandmarkClasses; ++k) {
    if (part.whole[k].size() == 0) continue;  // nothing was learnt of this class
    std::vector<Chosen> chosen = choose_regions(scene, LandmarkClass(k), middle, part.whole[k]);
    std::sort(chosen.begin(), chosen.end(), [](const Chosen& a, const Chosen& b) {
      const auto key = [](const Chosen& c) {
        return std::tuple(c.region.middle().y, c.region.middle().x, -c.score, c.region.area_px);
      };
      return key(a) < key(b);
    });
    for (const Chosen& c : chosen)
      if (const double p = probability_of(part.probability[k], c.score);
          p >= kLeastConfidence && !(LandmarkClass(k) == LandmarkClass::kTree && in_a_wood(scene, c.region)))
        out.push_back(landmark_of(c, seen, scene.gradient, p));
  }
  return out;
}

std::vector<Extracted> extract_landmarks(const features::GridImage& image, const ObjectModel& model, int threads) {
  std::vector<cv::Rect> blocks;
  for (int y = 0; y < image.pixels.rows; y += kBlock_px)
    for (int x = 0; x < image.pixels.cols; x += kBlock_px) blocks.emplace_back(x, y, kBlock_px, kBlock_px);
  std::vector<std::vector<Extracted>> found(blocks.size());
  features::GridImage broad{{}, {}, image.west_m, image.north_m, kBroadGsd_m};
  broad.pixels = cv::Mat::zeros(image.pixels.size() / kBroadStep_px, CV_8UC(broad_channels(image.pixels.channels())));
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(size_t(0), blocks.size(), [&](size_t i) {
      cv::Mat view;
      found[i] = find_landmarks(image, blocks[i], model, &view);
      if (!view.empty()) view.copyTo(broad.pixels(cv::Rect(blocks[i].tl() / kBroadStep_px, view.size())));
    });
  });
  std::vector<Extracted> all;
  for (std::vector<Extracted>& some : found)
    for (Extracted& e : some) all.push_back(std::move(e));
  std::vector<Extracted> out = with_broad(find_all_broad(broad), std::move(all));
  std::vector<Landmark> landmarks;
  for (const Extracted& e : out) landmarks.push_back(e.landmark);
  tiles::measure_distinctiveness(landmarks, tiles::kDistinctRadius_m);
  for (size_t i = 0; i < out.size(); ++i) out[i].landmark = landmarks[i];
  return out;
}

}  // namespace landfix::landmarks

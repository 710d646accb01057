#include "builder/training/object_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "builder/error.h"
#include "builder/landmarks/extraction.h"
#include "builder/random.h"
#include "builder/training/boosting.h"

namespace landfix::landmarks {
namespace {

constexpr int kSide_px = 640;
constexpr int kMoreOfSmall = 4;
constexpr int kOthersPerWhole = 8, kLeastOthers = 100;
constexpr BoostingOptions kCoverTrees = {.trees = 40, .leaves = 40, .rate = 0.25, .least_rows = 40, .l2 = 2};
constexpr BoostingOptions kWholeTrees = {.trees = 80, .leaves = 12, .rate = 0.12, .least_rows = 25, .l2 = 4};

struct Rows {
  std::vector<float> values;
  std::vector<uint8_t> classes;  // bits of covers, or 1 for whole
  void append(const Rows& other) {
    values.insert(values.end(), other.values.begin(), other.values.end());
    classes.insert(classes.end(), other.classes.begin(), other.classes.end());
  }
};
using RegionRows = std::array<Rows, tiles::kLandmarkClasses>;

/// Scores of chosen regions and whether they were whole.
struct Trials {
  std::vector<double> scores;
  std::vector<bool> whole;
};

// How many pixels of a scene are learnt from, by what they may be and whether they lie near a building.
size_t wanted(uint8_t allowed, bool near) {
  switch (allowed) {
    case 1 << int(Cover::kBuilding):
      return 900;
    case 1 << int(Cover::kGround):
      return near ? 700 : 500;
    case 1 << int(Cover::kTree):
      return 400;
    case 1 << int(Cover::kWater):
      return 200;
    case 1 << int(Cover::kPaved):
      return near ? 400 : 300;
    default:
      return 1200;
  }
}

void add_pixels(const KnownScene& scene, const cv::Mat& image, uint64_t seed, Rows& rows) {
  Random random(seed);
  std::vector<cv::Mat> planes;
  features::FourfoldGradient gradient;
  features::object_planes(image, scene.image.valid, planes, gradient);
  cv::Mat building = (scene.allowed == (1 << int(Cover::kBuilding))), near;
  cv::dilate(building, near, cv::Mat::ones(31, 31, CV_8U));
  std::map<std::pair<uint8_t, bool>, std::vector<cv::Point>> groups;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      if (const uint8_t a = scene.allowed.at<uint8_t>(y, x))
        if (scene.image.valid.empty() || scene.image.valid.at<uint8_t>(y, x))
          groups[{a, near.at<uint8_t>(y, x) != 0}].push_back({x, y});
  // Of a chip there is no more than its middle.
  const bool chip = image.rows < 200;
  for (auto& [key, points] : groups) {
    keep_some(points, chip ? 40 : wanted(key.first, key.second), random);
    for (const cv::Point& p : points) {
      for (const cv::Mat& plane : planes) rows.values.push_back(plane.at<uint8_t>(p));
      rows.classes.push_back(key.first);
    }
  }
}

void add_regions(const KnownScene& known, const ObjectScene& seen, uint64_t seed, RegionRows& rows) {
  Random random(seed);
  for (size_t k = 0; k < tiles::kLandmarkClasses; ++k) {
    std::vector<RegionNumbers> whole, other;
    for (const Region& r : regions_of(seen, tiles::LandmarkClass(k), cv::Rect({}, seen.valid.size()))) {
      if (const std::optional<bool> is = is_whole(known, r)) (*is ? whole : other).push_back(numbers_of(seen, r));
    }
    keep_some(other, std::max<size_t>(kLeastOthers, kOthersPerWhole * whole.size()), random);
    for (const auto* group : {&whole, &other}) {
      for (const RegionNumbers& n : *group) {
        rows[k].values.insert(rows[k].values.end(), n.begin(), n.end());
        rows[k].classes.push_back(group == &whole);
      }
    }
  }
}

features::BoostedTrees learn_covers(const Rows& rows, size_t planes) {
  return boost_classes(rows.values, planes, rows.classes, kCovers, kCoverTrees);
}

using WholeTrees = std::array<features::BoostedTrees, tiles::kLandmarkClasses>;

// Classes without any whole region have no trees.
WholeTrees learn_wholes(const RegionRows& rows) {
  constexpr int kLeast = 20;
  WholeTrees out;
  for (size_t k = 0; k < out.size(); ++k) {
    out[k] = features::BoostedTrees(kRegionNumbers, {0}, {});
    if (std::accumulate(rows[k].classes.begin(), rows[k].classes.end(), 0) >= kLeast)
      out[k] = boost(rows[k].values, kRegionNumbers, rows[k].classes, kWholeTrees);
  }
  return out;
}

/// Learns one part of the model: for colour, or for gray.
class PartTraining {
 public:
  PartTraining(std::span<const KnownScene> scenes, const ObjectTrainingOptions& options, bool colour)
      : scenes_(scenes), options_(options), colour_(colour) {}

  ObjectModel::Part run() {
    const size_t planes = size_t(colour_ ? features::kObjectPlanesColour : features::kObjectPlanesGray);
    std::array<Rows, 2> pixels;
    each(false,
         [&](const KnownScene& s, size_t group, uint64_t seed) { add_pixels(s, image_of(s), seed, pixels[group]); });
    std::array<features::BoostedTrees, 2> covers = {learn_covers(pixels[1], planes), learn_covers(pixels[0], planes)};
    report(fmt::format("{} and {} pixels", pixels[0].classes.size(), pixels[1].classes.size()));
    std::array<RegionRows, 2> regions;
    each(true, [&](const KnownScene& s, size_t group, uint64_t seed) {
      add_regions(s, look_at(image_of(s), s.image.valid, covers[group]), seed, regions[group]);
    });
    report_regions(regions);
    const std::array<WholeTrees, 2> wholes = {learn_wholes(regions[1]), learn_wholes(regions[0])};
    ObjectModel::Part part;
    part.probability = probabilities(covers, wholes);
    pixels[0].append(pixels[1]);
    part.covers = learn_covers(pixels[0], planes);
    for (size_t k = 0; k < tiles::kLandmarkClasses; ++k) regions[0][k].append(regions[1][k]);
    part.whole = learn_wholes(regions[0]);
    return part;
  }

 private:
  static bool has_objects(const KnownScene& s) {
    return !s.spotted.empty() ||
           std::any_of(s.objects.begin(), s.objects.end(), [](const cv::Mat& m) { return !m.empty(); });
  }

  cv::Mat image_of(const KnownScene& s) const {
    if (colour_) return s.image.pixels;
    cv::Mat gray;
    cv::cvtColor(s.image.pixels, gray, cv::COLOR_RGB2GRAY);
    return gray;
  }

  // Every scene as it is, where it is small, and varied; group: which half it belongs to. Small ones are labelled by
  // hand: there are few of them, and they tell more of the world than drawn ones do.
  template <typename Visit>
  void each(bool with_objects, Visit visit) const {
    for (size_t i = 0; i < scenes_.size(); ++i) {
      if ((with_objects && !has_objects(scenes_[i])) || (scenes_[i].only_colour && !colour_)) continue;
      const bool small = scenes_[i].image.pixels.rows <= kSide_px;
      const int count = options_.variations * (small ? kMoreOfSmall : 1);
      for (int v = 0; v <= count; ++v) {
        const uint64_t seed = options_.seed * 1000003 + i * 101 + uint64_t(v);
        if (v == 0 && small)
          visit(scenes_[i], i % 2, seed);
        else
          visit(varied(scenes_[i], kSide_px, seed), i % 2, seed);
      }
    }
  }

  std::array<Sigmoid, tiles::kLandmarkClasses> probabilities(const std::array<features::BoostedTrees, 2>& covers,
                                                             const std::array<WholeTrees, 2>& wholes) const {
    std::array<Trials, tiles::kLandmarkClasses> trials;
    each(true, [&](const KnownScene& s, size_t group, uint64_t) {
      const ObjectScene seen = look_at(image_of(s), s.image.valid, covers[group]);
      for (size_t k = 0; k < tiles::kLandmarkClasses; ++k) {
        if (wholes[group][k].size() == 0) continue;
        for (const Chosen& c :
             choose_regions(seen, tiles::LandmarkClass(k), cv::Rect({}, seen.valid.size()), wholes[group][k])) {
          const std::optional<bool> is = is_whole(s, c.region);
          if (!is) continue;
          trials[k].scores.push_back(double(c.score));
          trials[k].whole.push_back(*is);
        }
      }
    });
    std::array<Sigmoid, tiles::kLandmarkClasses> out;
    for (size_t k = 0; k < out.size(); ++k) {
      out[k] = fit_sigmoid(trials[k].scores, trials[k].whole);
      out[k].a = std::min(out[k].a, 0.0);
      report(fmt::format("class {}: {} trials, {} whole", k, trials[k].scores.size(),
                         std::count(trials[k].whole.begin(), trials[k].whole.end(), true)));
    }
    return out;
  }

  void report_regions(const std::array<RegionRows, 2>& regions) const {
    for (size_t k = 0; k < tiles::kLandmarkClasses; ++k) {
      size_t whole = 0, all = 0;
      for (const RegionRows& rows : regions) {
        all += rows[k].classes.size();
        whole += std::accumulate(rows[k].classes.begin(), rows[k].classes.end(), size_t(0));
      }
      report(fmt::format("class {}: {} regions, {} whole", k, all, whole));
    }
  }

  void report(const std::string& text) const {
    if (options_.on_progress) options_.on_progress((colour_ ? "colour: " : "gray: ") + text);
  }

  const std::span<const KnownScene> scenes_;
  const ObjectTrainingOptions& options_;
  const bool colour_;
};

}  // namespace

ObjectModel train_objects(std::span<const KnownScene> scenes, const ObjectTrainingOptions& options) {
  if (scenes.size() < 2) throw Error(ExitCode::kBadInput, "objects are learnt from two scenes at least");
  ObjectModel model;
  model.colour = PartTraining(scenes, options, true).run();
  model.gray = PartTraining(scenes, options, false).run();
  return model;
}

}  // namespace landfix::landmarks

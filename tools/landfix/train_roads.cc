// `landfix train-roads`: learns what roads look like from images with known roads.
#include <fmt/format.h>

#include <functional>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <span>

#include "builder/error.h"
#include "builder/ingest/window.h"
#include "builder/roads/road_candidates.h"
#include "builder/roads/road_training.h"
#include "tools/common/files.h"
#include "tools/eval/roads.h"
#include "tools/landfix/commands.h"

namespace landfix::tools {
namespace {

struct Arguments {
  std::vector<std::string> worlds, drawn;
  std::string output;
  uint64_t seed = 1;
  int variations = 6;
};

template <typename Set>
struct Sets {
  Set colour, gray;
};

/// Takes an image with its lines at so many pixels per metre, and a seed.
using Learner = std::function<void(const landmarks::Example&, landmarks::Truth, double, uint64_t)>;

cv::Mat gray_of(const cv::Mat& image) {
  cv::Mat gray;
  cv::cvtColor(image, gray, cv::COLOR_RGB2GRAY);
  return gray;
}

std::vector<landmarks::Line> in_pixels(const std::vector<eval::RoadLine>& lines, const features::GridImage& image) {
  std::vector<landmarks::Line> out;
  for (const eval::RoadLine& line : lines) {
    out.emplace_back();
    for (const tiles::RoadPoint& p : line)
      out.back().points.push_back({image.column_of(p.east_m) + 0.5, image.row_of(p.north_m) + 0.5});
  }
  return out;
}

// Pixels per metre. Wide roads at 2 m look as these do when enlarged less; narrow ones as when enlarged more. The
// second judge sees 2 m as well; enlarged most, streets and lanes are wide roads of one carriageway to it.
constexpr double kScales[] = {1.0, 1.5, 2.2, 0.5}, kSecondScales[] = {1.0, 1.5, 2.2, 3.3};

void learn_from(const std::string& world, const Arguments& a, uint64_t number, std::span<const double> scales,
                const Learner& learn) {
  const std::string path = world + "/ortho.tif";
  const tiles::Zone zone = ingest::standard_zone_of(path);
  const std::vector<eval::RoadLine> roads = eval::read_road_lines(world + "/roads.geojson", zone);
  for (const double px_per_m : scales) {
    const int count = px_per_m < 1 ? std::min(a.variations, 2) : a.variations / 3;
    if (count == 0 && px_per_m != 1) continue;
    const features::GridImage image =
        ingest::load_image({.path = path}, zone, std::nullopt, landmarks::kRoadGsd_m / px_per_m);
    if (image.pixels.channels() != 3) throw Error(ExitCode::kBadInput, path + ": expected red, green and blue");
    const std::vector<landmarks::Line> lines = in_pixels(roads, image);
    const uint64_t seed = a.seed * 1000003 + number * 101 + uint64_t(px_per_m * 10);
    if (px_per_m == 1) learn({image.pixels, lines}, landmarks::Truth::kExact, px_per_m, seed);
    for (int i = 0; i < count; ++i)
      learn(landmarks::varied(image.pixels, lines, seed + uint64_t(i) * 7), landmarks::Truth::kExact, px_per_m, seed);
  }
}

// Windows of an image in which somebody drew all roads: as they are, at half the scale, and varied.
void learn_from_drawn(const std::string& option, const Arguments& a, uint64_t number, const Learner& learn) {
  const std::string path = option.substr(0, option.find('=')), lines_path = option.substr(option.find('=') + 1);
  const tiles::Zone zone = ingest::standard_zone_of(path);
  const std::vector<eval::RoadLine> roads = eval::read_road_lines(lines_path, zone);
  const std::vector<ingest::GridBounds> windows = eval::read_windows(lines_path, zone);
  for (size_t w = 0; w < windows.size(); ++w) {
    for (const double px_per_m : {1.0, 0.5}) {
      const features::GridImage image =
          ingest::load_image({.path = path}, zone, windows[w], landmarks::kRoadGsd_m / px_per_m);
      if (image.pixels.channels() != 3) throw Error(ExitCode::kBadInput, path + ": expected red, green and blue");
      const landmarks::Example plain = {image.pixels, in_pixels(roads, image)};
      const uint64_t seed = a.seed * 1000003 + number * 10007 + w * 101 + uint64_t(px_per_m * 10);
      learn(plain, landmarks::Truth::kDrawn, px_per_m, seed);
      for (int i = 0; i < a.variations / 3; ++i)
        learn(landmarks::varied(plain.image, plain.roads, seed + uint64_t(i) * 7), landmarks::Truth::kDrawn, px_per_m,
              seed);
    }
  }
}

void learn_from_all(const Arguments& a, std::span<const double> scales, const Learner& learn) {
  for (size_t i = 0; i < a.worlds.size(); ++i) learn_from(a.worlds[i], a, i, scales, learn);
  for (size_t i = 0; i < a.drawn.size(); ++i) learn_from_drawn(a.drawn[i], a, i, learn);
}

// Each judge learns in colour and in gray from the same places.
void learn_first(const Arguments& a, landmarks::RoadModel& model) {
  Sets<landmarks::TrainingSet> sets;
  learn_from_all(a, kScales, [&](const landmarks::Example& e, landmarks::Truth truth, double px_per_m, uint64_t seed) {
    landmarks::add_examples(e.image, e.roads, truth, px_per_m, seed, sets.colour);
    landmarks::add_examples(gray_of(e.image), e.roads, truth, px_per_m, seed, sets.gray);
  });
  fmt::print("first judge: {} examples in colour and {} in gray\n", sets.colour.rows.size(), sets.gray.rows.size());
  model.colour.first = landmarks::boost(sets.colour, {});
  model.gray.first = landmarks::boost(sets.gray, {});
}

void learn_second(const Arguments& a, landmarks::RoadModel& model) {
  Sets<landmarks::SecondTrainingSet> sets;
  constexpr landmarks::BoostingOptions kOptions = {.trees = 100};
  learn_from_all(
      a, kSecondScales, [&](const landmarks::Example& e, landmarks::Truth truth, double px_per_m, uint64_t seed) {
        if (px_per_m < 1) return;  // windows that were drawn in are seen at 2 m too, which it does by itself
        landmarks::add_examples(e.image, e.roads, truth, px_per_m, seed, model.colour.first, sets.colour);
        landmarks::add_examples(gray_of(e.image), e.roads, truth, px_per_m, seed, model.gray.first, sets.gray);
      });
  fmt::print("second judge: {} examples in colour and {} in gray\n", sets.colour.rows.size(), sets.gray.rows.size());
  model.colour.second = landmarks::boost(sets.colour, kOptions);
  model.gray.second = landmarks::boost(sets.gray, kOptions);
}

void run(const Arguments& a) {
  for (const std::string& option : a.drawn)
    if (option.find('=') == std::string::npos)
      throw Error(ExitCode::kUsage, "--drawn " + option + ": expected IMAGE=LINES, with an equals sign between them");
  landmarks::RoadModel model;
  learn_first(a, model);
  learn_second(a, model);
  const std::vector<uint8_t> bytes = model.serialise();
  write_bytes(a.output, bytes);
  fmt::print("{}: {} bytes\n", a.output, bytes.size());
}

}  // namespace

void add_train_roads(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  CLI::App* sub = app.add_subcommand("train-roads", "Learn what roads look like from images with known roads");
  sub->add_option("world", a.worlds, "Directories with ortho.tif and roads.geojson, as `landfix synth` writes them")
      ->required()
      ->type_name("DIRECTORY");
  sub->add_option("--drawn", a.drawn,
                  "An image and a vector file: polygons around parts of it, and all centrelines in these, drawn by eye")
      ->type_name("IMAGE=LINES");
  sub->add_option("-o,--output", a.output, "The model")->required()->type_name("FILE");
  sub->add_option("--seed", a.seed, "Which examples and variations are drawn")->capture_default_str();
  sub->add_option("--variations", a.variations, "Varied parts of each image to learn from")
      ->check(CLI::Range(0, 60))
      ->capture_default_str();
  sub->footer(R"(
Example:
  for s in 101 102 103; do landfix synth -o world$s --seed $s --size-m 1500; done
  landfix train-roads world101 world102 world103 -o roads.model
)");
  sub->callback([arguments] { run(*arguments); });
}

}  // namespace landfix::tools

// `landfix train-roads`: learns what roads look like from images with known roads.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <opencv2/imgproc.hpp>

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

struct Sets {
  landmarks::TrainingSet colour, gray;
};

cv::Mat gray_of(const cv::Mat& image) {
  cv::Mat gray;
  cv::cvtColor(image, gray, cv::COLOR_RGB2GRAY);
  return gray;
}

// Both sets learn from the same place.
void add_both(const landmarks::Example& e, landmarks::Truth truth, double px_per_m, uint64_t seed, Sets& sets) {
  landmarks::add_examples(e.image, e.roads, truth, px_per_m, seed, sets.colour);
  landmarks::add_examples(gray_of(e.image), e.roads, truth, px_per_m, seed, sets.gray);
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

void report(const std::string& source, const Sets& sets) {
  fmt::print(stderr, "{}: {} examples in colour and {} in gray so far\n", source, sets.colour.rows.size(),
             sets.gray.rows.size());
}

void learn_from(const std::string& world, const Arguments& a, uint64_t number, Sets& sets) {
  const std::string path = world + "/ortho.tif";
  const tiles::Zone zone = ingest::standard_zone_of(path);
  const std::vector<eval::RoadLine> roads = eval::read_road_lines(world + "/roads.geojson", zone);
  // Wide roads at 2 m look as these do when enlarged less; narrow ones as when enlarged more.
  for (const double px_per_m : {1.0, 1.5, 2.2, 0.5}) {
    const int count = px_per_m < 1 ? std::min(a.variations, 2) : a.variations / 3;
    if (count == 0 && px_per_m != 1) continue;
    const features::GridImage image =
        ingest::load_image({.path = path}, zone, std::nullopt, landmarks::kRoadGsd_m / px_per_m);
    if (image.pixels.channels() != 3) throw Error(ExitCode::kBadInput, path + ": expected red, green and blue");
    const std::vector<landmarks::Line> lines = in_pixels(roads, image);
    const uint64_t seed = a.seed * 1000003 + number * 101 + uint64_t(px_per_m * 10);
    if (px_per_m == 1) add_both({image.pixels, lines}, landmarks::Truth::kExact, px_per_m, seed, sets);
    for (int i = 0; i < count; ++i)
      add_both(landmarks::varied(image.pixels, lines, seed + uint64_t(i) * 7), landmarks::Truth::kExact, px_per_m, seed,
               sets);
  }
  report(world, sets);
}

// Windows of an image in which somebody drew all roads: as they are, at half the scale, and varied.
void learn_from_drawn(const std::string& option, const Arguments& a, uint64_t number, Sets& sets) {
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
      add_both(plain, landmarks::Truth::kDrawn, px_per_m, seed, sets);
      for (int i = 0; i < a.variations / 3; ++i)
        add_both(landmarks::varied(plain.image, plain.roads, seed + uint64_t(i) * 7), landmarks::Truth::kDrawn,
                 px_per_m, seed, sets);
    }
  }
  report(path, sets);
}

void run(const Arguments& a) {
  for (const std::string& option : a.drawn)
    if (option.find('=') == std::string::npos)
      throw Error(ExitCode::kUsage, "--drawn " + option + ": expected IMAGE=LINES, with an equals sign between them");
  Sets sets;
  for (size_t i = 0; i < a.worlds.size(); ++i) learn_from(a.worlds[i], a, i, sets);
  for (size_t i = 0; i < a.drawn.size(); ++i) learn_from_drawn(a.drawn[i], a, i, sets);
  const landmarks::RoadModel model = {landmarks::boost(sets.colour, {}), landmarks::boost(sets.gray, {})};
  const std::vector<uint8_t> bytes = model.serialise();
  write_text(a.output, std::string(bytes.begin(), bytes.end()));
  fmt::print("{}: {} bytes, from {} examples in colour and {} in gray\n", a.output, bytes.size(),
             sets.colour.rows.size(), sets.gray.rows.size());
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

// `landfix train-objects`: learns what buildings, fields, trees, water and paved areas look like.
#include <fmt/format.h>

#include <memory>

#include "builder/error.h"
#include "builder/training/object_training.h"
#include "tools/common/files.h"
#include "tools/landfix/commands.h"

namespace landfix::tools {
namespace {

constexpr double kAway_m = 80;  // from what is held out: nothing that a pixel's numbers depend on is shared

// Without any landmark, so that rough ground and what repeats are not taken for them.
constexpr int kBareScenes = 24, kPatternScenes = 72;

struct Arguments {
  std::vector<std::string> worlds, chips, areas, away_from;
  std::string output;
  landmarks::ObjectTrainingOptions training;
};

void run(const Arguments& a) {
  std::vector<landmarks::KnownScene> scenes;
  for (const std::string& world : a.worlds) scenes.push_back(landmarks::read_known_world(world));
  for (size_t i = 0; i + 2 < a.areas.size(); i += 3)
    scenes.push_back(landmarks::read_known_area(a.areas[i], a.areas[i + 1], a.areas[i + 2]));
  for (size_t i = 0; i + 1 < a.chips.size(); i += 2) {
    std::vector<std::string> away_from;
    for (size_t k = 0; k + 1 < a.away_from.size(); k += 2)
      if (a.away_from[k] == a.chips[i]) away_from.push_back(a.away_from[k + 1]);
    for (landmarks::KnownScene& s : landmarks::read_known_chips(a.chips[i + 1], a.chips[i], away_from, kAway_m))
      scenes.push_back(std::move(s));
  }
  for (int i = 0; i < kBareScenes; ++i) scenes.push_back(landmarks::bare_scene(a.training.seed * 1000 + uint64_t(i)));
  for (int i = 0; i < kPatternScenes; ++i)
    scenes.push_back(landmarks::pattern_scene(a.training.seed * 1000 + uint64_t(i)));
  landmarks::ObjectTrainingOptions options = a.training;
  options.on_progress = [](const std::string& text) { fmt::print(stderr, "{}\n", text); };
  const std::vector<uint8_t> bytes = landmarks::train_objects(scenes, options).serialise();
  write_bytes(a.output, bytes);
  fmt::print("{}: {} bytes, from {} scenes\n", a.output, bytes.size(), scenes.size());
}

}  // namespace

void add_train_objects(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  CLI::App* sub = app.add_subcommand("train-objects", "Learn what landmarks look like from images with known objects");
  sub->add_option("world", a.worlds, "Directories as `landfix synth` writes them")->type_name("DIRECTORY");
  sub->add_option("--area", a.areas, "Image, points of all its buildings in a square, and the square; repeatable")
      ->type_size(3)
      ->expected(0, 99)
      ->type_name("IMAGE POINTS EXTENT");
  sub->add_option("--chips", a.chips, "Image and labelled chips of it; repeatable")
      ->type_size(2)
      ->expected(0, 99)
      ->type_name("IMAGE CSV");
  sub->add_option(
         "--away-from", a.away_from,
         fmt::format("Leave out chips of an image within {:g} m of a square that is held out; repeatable", kAway_m))
      ->type_size(2)
      ->expected(0, 99)
      ->type_name("IMAGE EXTENT");
  sub->add_option("-o,--output", a.output, "The model")->required()->type_name("FILE");
  sub->add_option("--seed", a.training.seed, "Which examples and variations are drawn")->capture_default_str();
  sub->add_option("--variations", a.training.variations, "Varied views of each image to learn from")
      ->check(CLI::Range(0, 60))
      ->capture_default_str();
  sub->footer(R"(
Example:
  for s in 101 102 103; do landfix synth -o world$s --seed $s --size-m 1500; done
  landfix train-objects world101 world102 world103 -o objects.model
)");
  sub->callback([arguments] { run(*arguments); });
}

}  // namespace landfix::tools

// `landfix train` and `landfix eval landmarks`: the classifier of landmarks, learned and judged.
#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "builder/error.h"
#include "builder/landmarks/landmark_model.h"
#include "builder/training/training.h"
#include "builder/training/truth.h"
#include "tools/common/files.h"
#include "tools/eval/confusion.h"
#include "tools/landfix/commands.h"
#include "tools/landfix/landmarks.h"

namespace landfix::tools {
namespace {

struct TrainArguments {
  std::vector<std::string> chips, vectors, worlds;
  std::string image, output;
  landmarks::TrainingOptions options;
  int per_class = landmarks::PlaceOptions{}.per_class;
  bool json = false;
};

/// "CSV=IMAGE".
std::pair<std::string, std::string> chips_and_image(const std::string& text) {
  const size_t at = text.find('=');
  if (at == std::string::npos || at == 0 || at + 1 == text.size())
    throw Error(ExitCode::kUsage, fmt::format("--chips: expected CSV=IMAGE, found '{}'", text));
  return {text.substr(0, at), text.substr(at + 1)};
}

std::vector<landmarks::LabelledImage> read_images(const TrainArguments& a) {
  std::vector<landmarks::LabelledImage> images;
  for (const std::string& text : a.chips) {
    const auto [csv, image] = chips_and_image(text);
    images.push_back(landmarks::read_chips(csv, image));
  }
  if (a.vectors.empty() != a.image.empty())
    throw Error(ExitCode::kUsage,
                "train: --vectors and --image belong together: layers, and the image that they label");
  std::vector<landmarks::VectorInput> inputs;
  for (const std::string& text : a.vectors) inputs.push_back(landmarks::parse_input(text));
  if (!inputs.empty()) images.push_back(landmarks::read_mapped(a.image, inputs, {a.options.seed, a.per_class}));
  for (size_t i = 0; i < a.worlds.size(); ++i)
    images.push_back(landmarks::read_world(a.worlds[i], {a.options.seed + i, a.per_class}));
  if (images.empty())
    throw Error(ExitCode::kUsage, "train: nothing to learn from; give --chips, --vectors with --image, or --synthetic");
  return images;
}

void run_train(const TrainArguments& a) {
  const std::vector<landmarks::Sample> samples = landmarks::samples_of(read_images(a), a.options);
  landmarks::HeldOut held_out;
  const std::vector<uint8_t> bytes = encode_model(landmarks::train(samples, a.options, held_out));
  write_bytes(a.output, bytes);
  if (a.json) {
    const nlohmann::ordered_json json = {{"colour", eval::to_json(held_out.colour)},
                                         {"gray", eval::to_json(held_out.gray)}};
    return fmt::print("{}\n", json.dump(2));
  }
  fmt::print("Places held out, in colour:\n{}\nand in gray:\n{}\n{}: {} bytes\n", eval::to_text(held_out.colour),
             eval::to_text(held_out.gray), a.output, bytes.size());
}

struct EvalArguments {
  std::string model, image, chips;
  bool json = false;
  PointArguments points;
};

void run_eval(const EvalArguments& a) {
  if (a.chips.empty() && !a.points.asked())
    throw Error(ExitCode::kUsage, "eval landmarks: expected --chips, --points or --again: what to compare with");
  nlohmann::ordered_json json;
  std::string text;
  if (!a.chips.empty()) {
    const landmarks::Judgement judgement =
        landmarks::judge(landmark_model(a.model), landmarks::read_chips(a.chips, a.image));
    json = eval::to_json(judgement);
    text = eval::to_text(judgement);
  }
  if (a.points.asked()) text += judge_points(a.points, a.image, json);
  fmt::print("{}", a.json ? json.dump(2) + "\n" : text);
}

}  // namespace

const features::LandmarkModel& landmark_model(const std::string& path) {
  if (path.empty()) return landmarks::default_landmark_model();
  static const features::LandmarkModel kModel = landmarks::read_landmark_model(path);  // one a run of the program
  return kModel;
}

void add_train(CLI::App& app) {
  auto arguments = std::make_shared<TrainArguments>();
  TrainArguments& a = *arguments;
  CLI::App* sub = app.add_subcommand("train", "Learn to recognise landmarks from labelled places");
  sub->add_option("--chips", a.chips, "Labelled places over an image: id,x,y,size_m,label (may be repeated)")
      ->allow_extra_args(false)
      ->type_name("CSV=IMAGE");
  sub->add_option("--vectors", a.vectors,
                  "Layers that say what --image shows: building, field, tree, water, paved, road (may be repeated)")
      ->allow_extra_args(false)
      ->type_name("FILE[:LAYER][=KIND]");
  sub->add_option("--image", a.image, "Georeferenced image of the --vectors")->type_name("IMAGE");
  sub->add_option("--synthetic", a.worlds, "Folder that `landfix synth` wrote (may be repeated)")
      ->allow_extra_args(false)
      ->type_name("DIR");
  sub->add_option("-o,--output", a.output, "The model")->required()->type_name("FILE");
  sub->add_option("--seed", a.options.seed, "Of everything that is drawn at random")->capture_default_str();
  sub->add_option("--per-class", a.per_class,
                  "Places of every class that are drawn from a synthetic world or from vector layers")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  sub->add_option("--variants", a.options.variants, "Of every place: turned, in other light, through another lens")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  sub->add_option("--penalty", a.options.penalty, "Of errors in training (C of the support vector machines)")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub->add_flag("--json", a.json, "The tables as JSON");
  sub->footer(R"(
Labels are building, field, tree, water, paved and none; rows labelled mixed are left out; x and y are the centre in the CRS of the
image, size_m is the side on the ground. Places are split by ground, not by label: of squares that overlap, all are in one half. The
tables show what machines trained on one half say of the other. The same input and seed give the same bytes.

Example:
  landfix synth -o world --seed 7
  landfix train --chips chips.csv=area.tif --synthetic world -o landmarks.model
  landfix train --image area.tif --vectors osm.gpkg --vectors crops.shp=field -o landmarks.model
)");
  sub->callback([arguments] { run_train(*arguments); });
}

void add_eval_landmarks(CLI::App& eval_command) {
  auto arguments = std::make_shared<EvalArguments>();
  EvalArguments& a = *arguments;
  CLI::App* sub = eval_command.add_subcommand(
      "landmarks", "Ask a model about labelled places, or compare landmarks with known ones");
  sub->add_option("--model", a.model, "Model of `landfix train` [that which comes with landfix]")->type_name("FILE");
  sub->add_option("--image", a.image, "Georeferenced image")->required()->type_name("IMAGE");
  sub->add_option("--chips", a.chips, "Labelled places: id,x,y,size_m,label")->type_name("CSV");
  add_point_options(*sub, a.points);
  sub->add_flag("--json", a.json, "As JSON");
  sub->footer(R"(
Example:
  landfix eval landmarks --model share/landmarks.model --image area.tif --chips chips.csv --json
  landfix eval landmarks --image area.tif --points houses.geojson --extent surveyed.geojson
  landfix eval landmarks --image world/ortho.tif --truth world/buildings.geojson --distance-m 3
  landfix eval landmarks --image summer.tif --again winter.tif --distance-m 5
)");
  sub->callback([arguments] { run_eval(*arguments); });
}

}  // namespace landfix::tools

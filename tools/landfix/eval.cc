// `landfix eval`: how well a map serves registration, against georeferenced images, image pairs and photographs.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/core.hpp>

#include "builder/error.h"
#include "runtime/nav/pack_map.h"
#include "tools/common/camera_model.h"
#include "tools/common/drawing.h"
#include "tools/common/files.h"
#include "tools/common/open_pack.h"
#include "tools/eval/map_picture.h"
#include "tools/eval/pairs.h"
#include "tools/eval/photos.h"
#include "tools/eval/register.h"
#include "tools/eval/register_picture.h"
#include "tools/landfix/commands.h"
#include "tools/landfix/eval_shared.h"

namespace landfix::tools {
namespace {

using nlohmann::ordered_json;
constexpr double kRadians = std::numbers::pi / 180;

nav::Gate gate_named(const std::string& name) {
  if (name == "none") return nav::Gate::kNone;
  return name == "strict" ? nav::Gate::kStrict : nav::Gate::kStandard;
}

struct RegisterArguments {
  std::string map;
  std::vector<std::string> cameras, key_files, matchers = {"auto"};
  eval::RegisterOptions options;
  double rotate_deg = 0;
  std::string gate = "standard";
  EvalOutput output;
};

ordered_json options_json(const RegisterArguments& a) {
  const eval::RegisterOptions& o = a.options;
  return {{"template_m", o.template_m},
          {"search_m", o.search_m},
          {"hit_m", o.hit_m},
          {"samples", o.samples},
          {"seed", o.seed},
          {"seeds", o.seeds},
          {"rotate_deg", a.rotate_deg},
          {"scale", o.scale_sigma},
          {"rim_px", o.rim_px},
          {"gate", a.gate}};
}

void run_register(RegisterArguments a) {
  a.options.matchers = eval::matchers_named(a.matchers);
  a.options.rotation_sigma_rad = a.rotate_deg * kRadians;
  a.options.gate = gate_named(a.gate);
  check(a.options);
  cv::setNumThreads(1);  // every call is timed on its own thread
  const Pack pack = open_pack(a.map, a.key_files);
  const eval::MapFrame frame = frame_of(pack, a.map);
  prepare_layers(pack, a.map);
  const eval::OpenMap open_map = [&] { return std::make_unique<nav::PackMap>(pack); };
  std::vector<eval::CameraTrials> trials;
  ordered_json cameras = ordered_json::array();
  for (size_t i = 0; i < a.cameras.size(); ++i) {
    const eval::CameraImage camera(a.cameras[i], frame);
    fmt::print(stderr, "{} ({} of {}): {} templates of {:.0f} m at {:g} m per pixel\n", camera.name(), i + 1,
               a.cameras.size(), a.options.samples * a.options.seeds, a.options.template_m, camera.gsd_m());
    trials.push_back(register_camera(camera, int(i), frame, open_map, a.options));
    cameras.push_back({{"name", camera.name()},
                       {"gsd_m", camera.gsd_m()},
                       {"native_gsd_m", camera.native_gsd_m()},
                       {"bands", camera.image().pixels.channels()}});
  }
  const std::vector<eval::MatcherReport> reports = eval::report(trials);
  if (!a.output.samples_csv.empty()) write_text(a.output.samples_csv, eval::to_csv(trials));
  if (!a.output.picture.empty()) write_picture(a.output.picture, draw_registration(trials, nav::PackMap(pack)));
  write_results(a.output, eval::to_text(reports),
                {{"map", std::filesystem::path(a.map).filename().string()},
                 {"cameras", cameras},
                 {"options", options_json(a)},
                 {"matchers", to_json(reports)}});
}

struct PairsArguments {
  std::string a, b;
  std::vector<std::string> matchers = {"all"};
  eval::PairsOptions options;
  std::string gate = "standard";
  EvalOutput output;
};

void run_pairs(PairsArguments a) {
  a.options.matchers = eval::matchers_named(a.matchers);
  a.options.gate = gate_named(a.gate);
  cv::setNumThreads(1);
  const std::vector<eval::CameraTrials> trials = eval::register_pairs(a.a, a.b, a.options);
  const std::vector<eval::MatcherReport> reports = eval::report(trials);
  if (!a.output.samples_csv.empty()) write_text(a.output.samples_csv, eval::to_csv(trials));
  write_results(a.output, eval::to_text(reports),
                {{"options",
                  {{"gsd_m", a.options.gsd_m},
                   {"template_px", a.options.template_px},
                   {"hit_px", a.options.hit_px},
                   {"placements", a.options.placements},
                   {"rim_px", a.options.rim_px},
                   {"gate", a.gate}}},
                 {"matchers", to_json(reports)}});
}

struct PhotosArguments {
  std::string map, camera_model;
  std::vector<std::string> photos, key_files;
  eval::PhotoOptions options;
  double heading_sigma_deg = 5;
  std::vector<double> prior_offset = {0, 0};
  std::string matcher = "auto", gate = "standard";
  EvalOutput output;
};

void run_photos(PhotosArguments a) {
  a.options.matcher = eval::matchers_named({a.matcher})[0];
  a.options.gate = gate_named(a.gate);
  a.options.heading_sigma_rad = a.heading_sigma_deg * kRadians;
  a.options.prior_offset_m = {a.prior_offset[0], a.prior_offset[1]};
  if (!a.camera_model.empty()) a.options.camera = read_camera_model(a.camera_model);
  cv::setNumThreads(1);
  const Pack pack = open_pack(a.map, a.key_files);
  const eval::MapFrame frame = frame_of(pack, a.map);
  prepare_layers(pack, a.map);
  const std::vector<eval::PhotoResult> photos = eval::register_photos(pack, a.map, a.photos, a.options);
  if (!a.output.picture.empty()) write_picture(a.output.picture, draw_photos(photos, nav::PackMap(pack)));
  ordered_json json = {{"map", std::filesystem::path(a.map).filename().string()},
                       {"options",
                        {{"prior_sigma_m", a.options.prior_sigma_m},
                         {"prior_offset_m", a.prior_offset},
                         {"heading_sigma_deg", a.heading_sigma_deg},
                         {"height_sigma", a.options.height_sigma},
                         {"matcher", a.matcher},
                         {"gate", a.gate}}}};
  json.update(eval::to_json(photos, frame.zone));
  write_results(a.output, eval::to_text(photos), json);
}

void add_matcher(CLI::App& command, std::vector<std::string>& matchers, std::string& gate) {
  command.add_option("--matcher", matchers, "all, auto, gray, edge, contour or orientation (may be repeated)")
      ->allow_extra_args(false)
      ->capture_default_str();
  command
      .add_option("--gate", gate,
                  "What counts as accepted in picture and samples: none, standard or strict; the "
                  "table and JSON show standard and strict in any case")
      ->check(CLI::IsMember({"none", "standard", "strict"}))
      ->capture_default_str();
}

constexpr const char* kRegisterFooter = R"(
Templates are cut from the camera images at random places and searched in the square of +-search around the truth. The camera
image is any georeferenced image that did not go into the map; its near infrared is not looked at. Two runs with the same seed
differ in nothing but the times.

Examples:
  landfix eval register --map area.lfpack --camera 2016.tif --camera 2018.tif
      320 m templates over +-320 m, five times 1000 samples per image
  landfix eval register --map area.lfpack --camera 2018.tif --template-m 160 --search-m 160 --rotate-deg 3 --scale 0.03 \
                        --matcher all --json=figures.json --picture places.png
      smaller templates with heading and height in error, all matchers

Table: hits with their 95 % interval (block bootstrap), median and 95 % error of hits, acc1 and acc.1: oracle accept rate at 1 %
and 0.1 % false by the stated probability, AUC of probability and gap, accept and false-fix rate at the shipped gates, expected
calibration error (ECE), hits inside their stated 95 % ellipse, median milliseconds. docs/evaluation.md has the definitions.
)";

void add_register(CLI::App& eval_command) {
  auto arguments = std::make_shared<RegisterArguments>();
  RegisterArguments& a = *arguments;
  CLI::App* sub = eval_command.add_subcommand("register", "Register templates of georeferenced images with a map");
  sub->add_option("--map", a.map, "The map pack")->required()->type_name("PACK");
  sub->add_option("--camera", a.cameras, "Georeferenced image that serves as the camera (may be repeated)")
      ->required()
      ->type_name("IMAGE");
  sub->add_option("--key", a.key_files, "Trusted public key file of the map (may be repeated)")
      ->allow_extra_args(false);
  eval::RegisterOptions& o = a.options;
  add_sampling(*sub, o);
  sub->add_option("--rotate-deg", a.rotate_deg, "Heading error of the templates (sigma), known to the registrar")
      ->capture_default_str();
  sub->add_option("--scale", o.scale_sigma, "Relative scale error of the templates (sigma), known to the registrar")
      ->capture_default_str();
  sub->add_option("--rim-px", o.rim_px, "Pixels around the template that serve the operators and do not vote")
      ->capture_default_str();
  add_threads(*sub, o.threads);
  add_matcher(*sub, a.matchers, a.gate);
  add_samples(*sub, a.output);
  sub->add_option("--picture", a.output.picture, "Draw where templates were found and refused")->type_name("FILE.png");
  add_output(*sub, a.output);
  sub->footer(kRegisterFooter);
  sub->callback([arguments] { run_register(*arguments); });
}

void add_pairs(CLI::App& eval_command) {
  auto arguments = std::make_shared<PairsArguments>();
  PairsArguments& a = *arguments;
  CLI::App* sub = eval_command.add_subcommand("pairs", "Register images of one place with each other, without a map");
  sub->add_option("--a", a.a, "Folder of images")->required()->type_name("DIR");
  sub->add_option("--b", a.b, "Folder of images of the same names, places and sizes, at other dates")
      ->required()
      ->type_name("DIR");
  eval::PairsOptions& o = a.options;
  sub->add_option("--gsd-m", o.gsd_m, "Ground sample distance of the images, m")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub->add_option("--template-px", o.template_px, "Side of the templates, pixels")
      ->check(CLI::Range(16, 4096))
      ->capture_default_str();
  sub->add_option("--hit-px", o.hit_px, "An answer this near to the truth is true, pixels")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub->add_option("--placements", o.placements, "Templates per row and column")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--rim-px", o.rim_px, "Pixels around the template that serve the operators and do not vote")
      ->check(CLI::Range(0, 256))
      ->capture_default_str();
  add_threads(*sub, o.threads);
  add_matcher(*sub, a.matchers, a.gate);
  add_samples(*sub, a.output);
  add_output(*sub, a.output);
  sub->footer(R"(
Every template is searched in the whole image of the same name, both ways.

Example:
  landfix eval pairs --a spring --b autumn --gsd-m 2 --template-px 128 --hit-px 3
)");
  sub->callback([arguments] { run_pairs(*arguments); });
}

void add_photos(CLI::App& eval_command) {
  auto arguments = std::make_shared<PhotosArguments>();
  PhotosArguments& a = *arguments;
  CLI::App* sub = eval_command.add_subcommand("photos", "Register photographs that know roughly where they were taken");
  sub->add_option("--map", a.map, "The map pack")->required()->type_name("PACK");
  sub->add_option("photos", a.photos, "Photographs with position, relative altitude and gimbal angles in EXIF and XMP")
      ->required()
      ->type_name("PHOTO");
  sub->add_option("--key", a.key_files, "Trusted public key file of the map (may be repeated)")
      ->allow_extra_args(false);
  sub->add_option("--camera-model", a.camera_model, "Calibration of the camera (YAML of OpenCV or ROS) [by the tags]")
      ->type_name("FILE");
  eval::PhotoOptions& o = a.options;
  const auto number = [&](const char* name, double& value, const char* text) {
    return sub->add_option(name, value, text)->capture_default_str();
  };
  number("--prior-sigma", o.prior_sigma_m, "Of the position that is believed, per axis, m")->check(CLI::PositiveNumber);
  number("--heading-sigma-deg", a.heading_sigma_deg, "Of the heading by the tags")->check(CLI::Range(0.0, 90.0));
  number("--height-sigma", o.height_sigma, "Of the height above ground, relative")->check(CLI::Range(0.0, 0.5));
  sub->add_option("--prior-offset", a.prior_offset, "Metres east and north by which the belief differs from the tags")
      ->delimiter(',')
      ->expected(2)
      ->type_name("E,N");
  sub->add_option("--matcher", a.matcher, "auto, gray, edge, contour or orientation")
      ->check(CLI::IsMember({"auto", "gray", "edge", "contour", "orientation"}))
      ->capture_default_str();
  sub->add_option("--gate", a.gate, "none, standard or strict")
      ->check(CLI::IsMember({"none", "standard", "strict"}))
      ->capture_default_str();
  add_threads(*sub, o.threads);
  sub->add_option("--picture", a.output.picture, "Draw the photographs over the map")->type_name("FILE.png");
  add_output(*sub, a.output);
  sub->footer(R"(
Each photograph is rectified with the attitude of its gimbal and its height above the take-off point, through the map's heights
where it has them, and searched around its tagged position. The table shows how far from the tags it was found and how far that
is from the offset common to all fixes: tags and map may lie apart, photographs among themselves should not.

Examples:
  landfix eval photos --map park.lfpack DJI_*.JPG --picture park.png
  landfix eval photos --map park.lfpack DJI_0018.JPG --camera-model phantom.yaml --prior-sigma 100 --prior-offset 80,-40 --json
)");
  sub->callback([arguments] { run_photos(*arguments); });
}

}  // namespace

void add_eval(CLI::App& app) {
  CLI::App* sub =
      app.add_subcommand("eval", "Measure how well images register with a map, and landmarks are recognised");
  sub->require_subcommand(1);
  sub->footer(R"(
Examples:
  landfix eval register --map area.lfpack --camera 2018.tif
      parts of an orthophoto that did not go into the map, as the camera
  landfix eval pairs --a spring --b autumn --gsd-m 2
      images of the same places at two dates, without a map
  landfix eval photos --map park.lfpack DJI_*.JPG --picture park.png
      photographs with position and attitude in their tags
  landfix eval navigability --map area.lfpack --camera 2018.tif
      how well the map says beforehand where that will succeed
  landfix eval route --map area.lfpack --scene 2018.tif --agl 160
      what is predicted of routes, against simulated flights

'landfix eval COMMAND --help' shows a command's options.
)");
  add_register(*sub);
  add_pairs(*sub);
  add_photos(*sub);
  add_eval_roads(*sub);
  add_eval_route(*sub);
  add_eval_landmarks(*sub);
  add_eval_navigability(*sub);
}

}  // namespace landfix::tools

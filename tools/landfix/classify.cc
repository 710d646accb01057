// `landfix classify`: what stands where in a georeferenced image, or in a photograph that knows how it was taken.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "builder/error.h"
#include "builder/ingest/window.h"
#include "runtime/nav/rectify.h"
#include "tools/common/camera_model.h"
#include "tools/common/drawing.h"
#include "tools/common/grid_image_io.h"
#include "tools/common/map_features.h"
#include "tools/common/photo.h"
#include "tools/landfix/commands.h"
#include "tools/landfix/landmarks.h"

namespace landfix::tools {
namespace {

struct Arguments {
  std::string image, bands, model, output, confidence, picture, camera_model;
  double step_m = 4;
  bool json = false;
};

/// What is to be classified, at features::kWordGsdM.
struct View {
  features::GridImage image;
  tiles::Zone zone;
};

bool is_photo(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](char c) { return char(std::tolower(c)); });
  return extension == ".jpg" || extension == ".jpeg";
}

/// The photograph as the vehicle sees the ground: rectified with its attitude on a plane at its height over take-off.
View read_photo(const std::string& path, const std::string& camera_model) {
  const PhotoTags tags = read_photo_tags(path);
  std::optional<nav::Camera> calibration;
  if (!camera_model.empty()) calibration = read_camera_model(camera_model);
  require_placeable(tags, calibration.has_value());
  const std::optional<tiles::Zone> zone = tiles::standard_zone(*tags.place);
  if (!zone) throw Error(ExitCode::kBadInput, path + ": the tagged position is not on the Earth");
  const cv::Mat pixels = read_photo_pixels(path);
  const nav::Camera camera =
      calibration ? fitted(*calibration, pixels.size(), path) : camera_from_tags(tags, pixels.cols, pixels.rows);
  const PhotoPose pose = pose_from_tags(tags, *zone);
  View view{{}, *zone};
  if (const nav::Status s =
          nav::rectify(pixels, camera, pose.attitude, *tags.relative_altitude_m, features::kWordGsdM, view.image);
      s != nav::Status::kOk)
    throw Error(ExitCode::kBadInput, fmt::format("{}: cannot be rectified with the attitude and height in its tags: {}",
                                                 path, nav::to_text(s)));
  view.image.west_m += pose.east_m, view.image.north_m += pose.north_m;
  return view;
}

View read_view(const Arguments& a) {
  if (is_photo(a.image) && !a.bands.empty())
    throw Error(ExitCode::kUsage, "--bands is for georeferenced images, photographs (.jpg) show red, green and blue");
  if (is_photo(a.image)) return read_photo(a.image, a.camera_model);
  if (!a.camera_model.empty()) throw Error(ExitCode::kUsage, "--camera-model is for photographs (.jpg)");
  const tiles::Zone zone = ingest::standard_zone_of(a.image);
  return {ingest::load_image({.path = a.image, .bands = a.bands}, zone, std::nullopt, features::kWordGsdM), zone};
}

const Palette& class_colours() {
  static const Palette kPalette = [] {
    Palette palette;
    for (const LandmarkStyle& style : kLandmarkStyles) palette.push_back(style.colour);
    palette.push_back({128, 128, 128});
    return palette;
  }();
  return kPalette;
}

/// The image with its classes laid over it, the stronger the surer.
void draw(const std::string& path, const features::GridImage& image, const cv::Mat& labels, const cv::Mat& confidence) {
  cv::Mat picture = picture_of(image), classes, sure;
  cv::resize(labels, classes, picture.size(), 0, 0, cv::INTER_NEAREST);
  cv::resize(confidence, sure, picture.size(), 0, 0, cv::INTER_NEAREST);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const size_t label = classes.at<uint8_t>(y, x);
      if (label >= class_colours().size()) continue;
      const double strength = 0.6 * sure.at<uint8_t>(y, x) / 255;
      cv::Vec4b& pixel = picture.at<cv::Vec4b>(y, x);
      for (int c = 0; c < 3; ++c)
        pixel[c] = uint8_t(std::lround((1 - strength) * pixel[c] + strength * class_colours()[label][size_t(2 - c)]));
    }
  }
  write_picture(path, picture);
}

nlohmann::ordered_json areas_of(const cv::Mat& labels, double step_m) {
  nlohmann::ordered_json areas;
  for (size_t k = 0; k < features::kLandmarkLabels; ++k)
    areas[features::kLandmarkLabelNames[k]] = double(cv::countNonZero(labels == int(k))) * step_m * step_m / 1e6;
  return areas;
}

void run(const Arguments& a) {
  const int nodes = int(std::lround(a.step_m / (features::kWordGsdM * features::kWordStepPx)));
  if (nodes < 1 || nodes * features::kWordGsdM * features::kWordStepPx != a.step_m)
    throw Error(ExitCode::kUsage, fmt::format("--step-m: expected 2, 4, 6, ..., found {:g}", a.step_m));
  const features::LandmarkModel& model = landmark_model(a.model);
  const View view = read_view(a);
  features::LandmarkClassifier classifier(model);
  cv::Mat labels, confidence;
  auto status = classifier.prepare(view.image.pixels, view.image.valid);
  if (status == features::ClassifierStatus::kOk) status = classifier.scan(nodes, labels, confidence);
  if (status != features::ClassifierStatus::kOk)
    throw Error(ExitCode::kBadInput, fmt::format("{}: {}", a.image, features::to_text(status)));
  if (labels.empty() || cv::countNonZero(labels != features::kNoWord) == 0)
    throw Error(ExitCode::kBadInput, a.image + ": no window of 24 m has data; expected an image of at least that size");
  features::GridImage out{labels, labels != features::kNoWord, view.image.west_m, view.image.north_m, a.step_m};
  if (!a.output.empty()) write_class_map(a.output, out, class_colours(), view.zone);
  out.pixels = confidence;
  if (!a.confidence.empty()) write_grid_image(a.confidence, out, view.zone);
  if (!a.picture.empty()) draw(a.picture, view.image, labels, confidence);
  const nlohmann::ordered_json areas = areas_of(labels, a.step_m);
  if (a.json) {
    const nlohmann::ordered_json json = {{"image", std::filesystem::path(a.image).filename().string()},
                                         {"colour", view.image.pixels.channels() == 3},
                                         {"step_m", a.step_m},
                                         {"square_km", areas}};
    return fmt::print("{}\n", json.dump(2));
  }
  for (const auto& [name, area] : areas.items()) fmt::print("{:10}{:8.4f} km²\n", name, area.get<double>());
}

}  // namespace

void add_classify(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  CLI::App* sub = app.add_subcommand("classify", "Tell buildings, fields, trees, water and paved ground in an image");
  sub->add_option("image", a.image,
                  "Georeferenced image, or a photograph (.jpg) with position and attitude in its tags")
      ->required()
      ->type_name("IMAGE");
  add_bands(*sub, a.bands);
  sub->add_option("--model", a.model, "Model of `landfix train` [that which comes with landfix]")->type_name("FILE");
  sub->add_option("-o,--output", a.output, "The classes as GeoTIFF with colours")->type_name("FILE.tif");
  sub->add_option("--confidence", a.confidence, "How sure they are, 255 is certain")->type_name("FILE.tif");
  sub->add_option("--picture", a.picture, "The image with its classes laid over it")->type_name("FILE.png");
  sub->add_option("--camera-model", a.camera_model, "Calibration of the camera (YAML of OpenCV or ROS) [by the tags]")
      ->type_name("FILE");
  sub->add_option("--step-m", a.step_m, "Between windows: 2, 4, 6, ... m")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub->add_flag("--json", a.json, "Areas as JSON");
  sub->footer(R"(
Each pixel is what the windows of 12 m and 24 m around its middle show: 0 building, 1 field, 2 tree, 3 water, 4 paved, 5 none of
these. Photographs are rectified with the attitude of their gimbal on a plane at their height above the take-off point.

Examples:
  landfix classify area.tif -o classes.tif --picture classes.png
  landfix classify DJI_0018.JPG --picture seen.png --json
)");
  sub->callback([arguments] { run(*arguments); });
}

}  // namespace landfix::tools

#include "tools/common/camera_model.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <initializer_list>
#include <opencv2/core/persistence.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <sstream>
#include <vector>

#include "builder/error.h"

namespace landfix::tools {
namespace {

/// The keys of one file; errors name both.
class Model {
 public:
  explicit Model(const std::string& path) : path_(path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    if (!(file && text << file.rdbuf()))
      throw Error(ExitCode::kIo, path + ": the camera model cannot be read: no such file, no permission, or empty");
    // OpenCV takes YAML only with its directive, which ROS does not write.
    std::string yaml = text.str();
    if (!yaml.starts_with("%YAML")) yaml = "%YAML:1.0\n" + std::string(yaml.starts_with("---") ? "" : "---\n") + yaml;
    try {
      storage_.open(yaml, cv::FileStorage::READ | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML);
    } catch (const cv::Exception& e) {
      refuse("is no YAML that OpenCV reads: " + e.err);
    }
    if (!storage_.isOpened() || !storage_.root().isMap()) refuse("is no YAML map of keys and values");
  }

  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(ExitCode::kBadInput,
                path_ + ": the camera model " + what +
                    "; expected image_width, image_height, camera_matrix and distortion_coefficients as OpenCV's or "
                    "ROS's calibration writes them");
  }

  double number(std::initializer_list<const char*> names) const {
    const cv::FileNode node = find(names);
    if (node.empty()) refuse(fmt::format("has no '{}'", *names.begin()));
    if (!node.isInt() && !node.isReal()) refuse(fmt::format("has a '{}' that is no number", node.name()));
    return node.real();
  }

  /// The numbers of a matrix or list; nothing where there is none of these keys.
  std::optional<std::vector<double>> numbers(std::initializer_list<const char*> names) const {
    cv::FileNode node = find(names);
    if (node.empty()) return std::nullopt;
    const std::string name = node.name();
    if (node.isMap()) node = node["data"];
    if (!node.isSeq()) refuse(fmt::format("has a '{}' that is neither a list nor a matrix with 'data'", name));
    std::vector<double> values;
    for (const cv::FileNode& item : node) {
      if (!item.isInt() && !item.isReal()) refuse(fmt::format("has a '{}' with an item that is no number", name));
      values.push_back(item.real());
    }
    return values;
  }

  std::string text(const char* name) const {
    const cv::FileNode node = storage_[name];
    return node.isString() ? node.string() : "";
  }

 private:
  cv::FileNode find(std::initializer_list<const char*> names) const {
    for (const char* name : names)
      if (const cv::FileNode node = storage_[name]; !node.empty()) return node;
    return {};
  }

  std::string path_;
  cv::FileStorage storage_;
};

nav::Distortion distortion_of(const Model& model) {
  const std::string kind = model.text("distortion_model");
  if (!kind.empty() && kind != "plumb_bob" && kind != "rational_polynomial")
    model.refuse("has distortion_model '" + kind + "'; plumb_bob and rational_polynomial are known");
  std::vector<double> d = model.numbers({"distortion_coefficients", "D", "d"}).value_or(std::vector<double>());
  if (d.size() != 0 && d.size() != 4 && d.size() != 5 && d.size() != 8 && d.size() != 12 && d.size() != 14)
    model.refuse(fmt::format("has {} distortion coefficients where 0, 4, 5 or 8 are known", d.size()));
  for (size_t i = 8; i < d.size(); ++i)
    if (d[i] != 0) model.refuse("has thin-prism or tilt coefficients, which are not known");
  d.resize(8, 0.0);
  return {d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]};
}

}  // namespace

nav::Camera read_camera_model(const std::string& path) {
  const Model model(path);
  const std::optional<std::vector<double>> matrix = model.numbers({"camera_matrix", "K", "k"});
  if (!matrix) model.refuse("has no 'camera_matrix'");
  if (matrix->size() != 9) model.refuse(fmt::format("has a camera_matrix of {} numbers instead of 9", matrix->size()));
  const std::vector<double>& m = *matrix;
  if (m[1] != 0 || m[3] != 0 || m[6] != 0 || m[7] != 0 || m[8] != 1)
    model.refuse("has a camera_matrix that is not [fx, 0, cx, 0, fy, cy, 0, 0, 1]");
  const double width = model.number({"image_width", "width"}), height = model.number({"image_height", "height"});
  if (!(width >= 1 && width <= 1e6 && height >= 1 && height <= 1e6) || width != std::floor(width) ||
      height != std::floor(height))
    model.refuse(fmt::format("has an image of {}x{} pixels", width, height));
  const nav::Camera camera{int(width), int(height), m[0], m[4], m[2], m[5], distortion_of(model)};
  if (nav::check(camera) != nav::Status::kOk)
    model.refuse("has a focal length that is not positive or a number that is not finite");
  return camera;
}

nav::Camera fitted(const nav::Camera& camera, cv::Size size, const std::string& path) {
  const double ratio = double(size.width) / camera.width;
  if (std::abs(camera.height * ratio - size.height) > 1)
    throw Error(
        ExitCode::kBadInput,
        fmt::format("{}: expected the camera model's {}x{} pixels or that shrunk, found {}x{}; give the model of "
                    "the camera that took it",
                    path, camera.width, camera.height, size.width, size.height));
  nav::Camera out = camera;
  out.width = size.width, out.height = size.height;
  out.fx *= ratio, out.fy *= ratio;
  out.cx = (camera.cx + 0.5) * ratio - 0.5, out.cy = (camera.cy + 0.5) * ratio - 0.5;
  if (!camera.mask.empty()) cv::resize(camera.mask, out.mask, size, 0, 0, cv::INTER_NEAREST);
  return out;
}

}  // namespace landfix::tools

#include "builder/landmarks/landmark_model.h"

#include <fmt/format.h>

#include <span>
#include <vector>

#include "builder/error.h"
#include "builder/file_bytes.h"
#include "builder/landmarks/landmark_model_bytes.h"

namespace landfix::landmarks {
namespace {

features::LandmarkModel decoded(std::span<const uint8_t> bytes, const std::string& name) {
  features::LandmarkModel model;
  if (const auto status = decode_model(bytes, model); status != features::ClassifierStatus::kOk)
    throw Error(ExitCode::kBadInput, fmt::format("{}: {}", name, features::to_text(status)));
  return model;
}

}  // namespace

features::LandmarkModel read_landmark_model(const std::string& path) {
  return decoded(bytes_of_file(path, "a model that `landfix train` wrote"), path);
}

const features::LandmarkModel& default_landmark_model() {
  static const features::LandmarkModel kModel =
      decoded(kLandmarkModelBytes, "the model of landmarks that comes with landfix");
  return kModel;
}

}  // namespace landfix::landmarks

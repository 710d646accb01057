// The model of landmarks that comes with landfix, and models in files.
#pragma once

#include <string>

#include "runtime/features/landmark_classifier.h"

namespace landfix::landmarks {

/// Reads a model of `landfix train`. Throws Error: kIo where it cannot be read, kBadInput for what is no model, one of
/// another version or a damaged one.
features::LandmarkModel read_landmark_model(const std::string& path);

/// The model that comes with landfix (share/landmarks.model; tools/landmarks/train_landmarks.sh made it).
const features::LandmarkModel& default_landmark_model();

}  // namespace landfix::landmarks

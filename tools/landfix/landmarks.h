// What the commands about landmarks share.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "runtime/features/landmark_classifier.h"
#include "tiles/landmark.h"

namespace landfix::tools {

/// The model in a file, or that which comes with landfix where `path` is empty; read once. Throws Error as
/// landmarks::read_landmark_model.
const features::LandmarkModel& landmark_model(const std::string& path);

/// `landfix eval landmarks` of landmarks that are found, not of labelled places.
struct PointArguments {
  std::string points, extent, again, objects;
  tiles::LandmarkClass cls = tiles::LandmarkClass::kBuilding;
  double reach_m = 6, confidence = 0.5;
  bool gray = false;

  bool asked() const { return !points.empty() || !again.empty(); }
};
void add_point_options(CLI::App& sub, PointArguments& a);
/// The table; the same is added to `json`: `landmarks`, `intersections`, `again`.
std::string judge_points(const PointArguments& a, const std::string& image, nlohmann::ordered_json& json);

}  // namespace landfix::tools

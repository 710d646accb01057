// What the evaluations of registration with a pack have in common.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "landfix/landfix.hpp"
#include "tools/eval/camera_image.h"
#include "tools/eval/register.h"

namespace landfix::tools {

/// Throws Error (kNoData) where the pack has no layer that a matcher uses.
eval::MapFrame frame_of(const Pack& pack, const std::string& path);

/// Where results go.
struct EvalOutput {
  std::string json_file, samples_csv, picture;
};

/// Text for people on standard output; JSON there instead where it is asked for as "-".
void write_results(const EvalOutput& output, const std::string& text, const nlohmann::ordered_json& json);

/// Which templates of the cameras are cut and searched.
void add_sampling(CLI::App& command, eval::RegisterOptions& options);
void add_threads(CLI::App& command, int& threads);
void add_output(CLI::App& command, EvalOutput& output);
void add_samples(CLI::App& command, EvalOutput& output);

}  // namespace landfix::tools

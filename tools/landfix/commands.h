// The subcommands of `landfix`. Each adds itself to the application with its options, help and examples; its callback
// does the work and throws landfix::Error, which main() turns into a message and an exit code.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace landfix::tools {

void add_build(CLI::App& app);
void add_info(CLI::App& app);
void add_verify(CLI::App& app);
void add_query(CLI::App& app);
void add_export(CLI::App& app);
void add_export_navigability(CLI::App& export_command);
void add_keygen(CLI::App& app);
void add_sign(CLI::App& app);
void add_synth(CLI::App& app);
void add_fly(CLI::App& app);
void add_route(CLI::App& app);
void add_eval(CLI::App& app);
void add_eval_roads(CLI::App& eval);
void add_eval_route(CLI::App& eval);
void add_roads(CLI::App& app);
void add_train_roads(CLI::App& app);
void add_train_objects(CLI::App& app);
void add_landmarks(CLI::App& app);
void add_eval_landmarks(CLI::App& eval_command);
void add_eval_navigability(CLI::App& eval_command);
void add_train(CLI::App& app);
void add_classify(CLI::App& app);

/// `--bands` of the commands that look at one image: ingest::SourceOptions::bands.
void add_bands(CLI::App& command, std::string& bands);

}  // namespace landfix::tools

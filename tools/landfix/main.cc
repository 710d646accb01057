// landfix: one program of subcommands. Errors become one line on stderr and a documented exit code.
#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <system_error>

#include "builder/error.h"
#include "tools/landfix/commands.h"

namespace {

using landfix::ExitCode;

int report(ExitCode code, const std::string& message) {
  fmt::print(stderr, "landfix: {}\n", message);
  return int(code);
}

void add_all(CLI::App& app) {
  landfix::tools::add_build(app);
  landfix::tools::add_info(app);
  landfix::tools::add_verify(app);
  landfix::tools::add_query(app);
  landfix::tools::add_export(app);
  landfix::tools::add_keygen(app);
  landfix::tools::add_sign(app);
  landfix::tools::add_synth(app);
  landfix::tools::add_fly(app);
  landfix::tools::add_route(app);
  landfix::tools::add_eval(app);
  landfix::tools::add_roads(app);
  landfix::tools::add_train_roads(app);
  landfix::tools::add_landmarks(app);
  landfix::tools::add_train_objects(app);
  landfix::tools::add_train(app);
  landfix::tools::add_classify(app);
}

/// Options as `--json[=FILE]` where a value may follow; CLI11 shows the value that stands for none instead.
struct HelpFormatter : CLI::Formatter {
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override {
    const std::string name = CLI::Formatter::make_option_name(option, is_positional);
    return has_default(name) ? fmt::format("{}[={}]", name.substr(0, name.find('{')), option->get_type_name()) : name;
  }
  std::string make_option_opts(const CLI::Option* option) const override {
    return has_default(option->get_name(false, true)) ? "" : CLI::Formatter::make_option_opts(option);
  }

 private:
  static bool has_default(const std::string& name) { return name.find('{') != std::string::npos; }
};

std::string usage_message(const CLI::App* app, const CLI::Error& e) {
  std::string command = "landfix";
  for (const CLI::App* at = app; !at->get_subcommands().empty();) {
    at = at->get_subcommands().front();
    command += " " + at->get_name();
  }
  return fmt::format("landfix: {}; '{} --help' shows how to use it\n", e.what(), command);
}

// What is printed goes through a buffer: that it arrived shows at the end only.
int flush_output() {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return 0;
  return report(ExitCode::kIo, fmt::format("standard output: cannot be written: {}", std::strerror(errno)));
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file size limit is an error of the write then, as a full disk is
  // Output is for people and programs alike: results on stdout, everything else on stderr.
  spdlog::set_default_logger(spdlog::stderr_color_mt("landfix"));
  spdlog::set_pattern("%^%l%$: %v");

  CLI::App app{"Map packs for navigation without GNSS: build, inspect, sign, fly, evaluate."};
  app.name("landfix");
  app.formatter(std::make_shared<HelpFormatter>());
  app.set_version_flag("--version", "landfix " LANDFIX_VERSION);
  app.failure_message(usage_message);
  app.footer(
      "'landfix COMMAND --help' shows a command's options with examples.\n"
      "Exit codes: 0 done, 1 internal error, 2 wrong command line, 3 input that cannot be used, 4 damaged or unknown "
      "pack,\n"
      "5 missing or untrusted signature, 6 no data there, 7 reading or writing failed.");
  add_all(app);
  try {
    app.parse(argc, argv);
    if (app.get_subcommands().empty()) throw CLI::RequiredError("A command");
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? flush_output() : int(ExitCode::kUsage);
  } catch (const landfix::Error& e) {
    return report(e.code(), e.what());
  } catch (const std::bad_alloc&) {
    return report(ExitCode::kInternal, "out of memory");
  } catch (const std::system_error& e) {  // of the file system's calls, or of printing
    return report(ExitCode::kIo, e.what());
  } catch (const std::exception& e) {
    return report(ExitCode::kInternal, fmt::format("internal error: {}", e.what()));
  }
  return flush_output();
}

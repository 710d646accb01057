// One registration against the truth: what was asked, what came out, and how far off it was.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/nav/registration.h"
#include "tools/eval/statistics.h"

namespace landfix::eval {

/// A matcher by its name: "auto", or one of nav::kMethods.
struct MatcherChoice {
  std::string name = "auto";
  std::optional<nav::Method> method;
};

/// Names to choices; "all" stands for auto and every method. Throws Error(kUsage) for an unknown name.
std::vector<MatcherChoice> matchers_named(const std::vector<std::string>& names);

/// Where a template was taken, and what the registrar was told.
struct Question {
  std::string camera;              ///< image it was cut from, for people
  int seed_index = 0;              ///< which of the seeds drew it
  double east_m = 0, north_m = 0;  ///< true position of the template's middle
  nav::Similarity similarity;      ///< what the template has wrong, and the registrar is to find
  nav::RegistrationPrior prior;
  double hit_m = 15;   ///< an answer this near to the truth is a hit
  uint64_t block = 0;  ///< ground that it shares with others
};

/// The answer of one matcher.
struct Trial {
  Question question;
  nav::Status status = nav::Status::kInternal;
  nav::Method method = nav::Method::kGray;  ///< that gave the answer
  double east_m = 0, north_m = 0;           ///< found
  std::array<double, 4> covariance_m2{};    ///< stated for it
  double probability = 0;
  nav::Evidence evidence;
  nav::Similarity similarity;  ///< found
  double milliseconds = 0;

  /// A match was found, whether or not the gate lets it through.
  bool answered() const { return status == nav::Status::kOk || status == nav::Status::kImprobable; }
  bool accepted() const { return status == nav::Status::kOk; }
  double error_m() const;
  bool hit() const { return answered() && error_m() <= question.hit_m; }
};

/// Asks, and takes the time. `found` is all that the registrar said.
Trial answer(nav::Registrar& registrar, const features::GridImage& patch, const Question& question,
             nav::Registration& found);

/// What counts of it in the statistics.
Sample sample_of(const Trial& trial);

/// A status as one word for tables and files: "ok", "no_texture", ….
std::string_view word_of(nav::Status status);

/// Names of the columns, and one line per trial, both with their end of line.
std::string trial_csv_header();
std::string trial_csv_line(const std::string& matcher, const Trial& trial);

}  // namespace landfix::eval

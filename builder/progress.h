// The one place that shows how far a long job is: a bar on a terminal, plain lines elsewhere.
#pragma once

#include <chrono>
#include <cstdio>
#include <string>

namespace landfix {

/// Rates and times of one stage after another. Used by one thread at a time.
class Progress {
 public:
  enum class Style {
    kSilent,
    kBar,    ///< one line, rewritten
    kLines,  ///< a line every 10 % or 10 s, at most one a second
  };

  Progress() = default;  ///< silent
  Progress(std::FILE* out, Style style) : out_(out), style_(style) {}
  /// A bar where `out` is a terminal, else lines.
  static Progress to(std::FILE* out);

  /// Starts a stage of `total` units; `unit` goes with rates.
  void begin(const std::string& stage, const std::string& unit, double total);
  void advance(double amount);
  void skip(double amount);  ///< done by an earlier run: counts for the bar and not for the rate
  void end();

  /// A line of its own, that does not tear the bar.
  void say(const std::string& line);

 private:
  using Clock = std::chrono::steady_clock;
  std::string describe(double seconds) const;
  void show_bar(double seconds);
  void clear_bar();

  std::FILE* out_ = nullptr;
  Style style_ = Style::kSilent;
  std::string stage_, unit_;
  double total_ = 0, done_ = 0, skipped_ = 0;
  Clock::time_point start_;
  double shown_seconds_ = 0, shown_done_ = 0;
  bool bar_visible_ = false;
};

}  // namespace landfix

#include "builder/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace landfix {
namespace {

constexpr int kBarWidth = 30;

std::string clock_text(double seconds) {
  const auto s = int64_t(std::ceil(seconds));
  return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60)
                  : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

}  // namespace

Progress Progress::to(std::FILE* out) { return Progress(out, ::isatty(::fileno(out)) ? Style::kBar : Style::kLines); }

void Progress::begin(const std::string& stage, const std::string& unit, double total) {
  stage_ = stage;
  unit_ = unit;
  total_ = total;
  done_ = skipped_ = shown_done_ = 0;
  start_ = Clock::now();
  shown_seconds_ = 0;
}

// "tiles    42 %, 31.7 Mpx/s, 0:12 left"
std::string Progress::describe(double seconds) const {
  const double rate = seconds > 0 ? (done_ - skipped_) / seconds : 0;
  std::string text =
      fmt::format("{:.0f} %, {:.1f} {}/s", total_ > 0 ? 100 * std::min(1.0, done_ / total_) : 100.0, rate, unit_);
  if (rate > 0 && done_ < total_) text += fmt::format(", {} left", clock_text((total_ - done_) / rate));
  return text;
}

void Progress::advance(double amount) {
  done_ += amount;
  if (style_ == Style::kSilent) return;
  const double seconds = std::chrono::duration<double>(Clock::now() - start_).count(), since = seconds - shown_seconds_;
  if (style_ == Style::kBar) {
    if (since < 0.1 && bar_visible_) return;
    show_bar(seconds);
  } else {
    if (since < 1 || (since < 10 && done_ - shown_done_ < 0.1 * total_)) return;
    std::fputs(fmt::format("{}: {}\n", stage_, describe(seconds)).c_str(), out_);
    std::fflush(out_);
  }
  shown_seconds_ = seconds;
  shown_done_ = done_;
}

void Progress::skip(double amount) {
  done_ += amount;
  skipped_ += amount;
  shown_done_ += amount;
}

void Progress::end() {
  if (style_ == Style::kSilent) return;
  const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  done_ = total_;
  clear_bar();
  std::fputs(fmt::format("{}: {}, {:.1f} s\n", stage_, describe(seconds), seconds).c_str(), out_);
  std::fflush(out_);
}

void Progress::say(const std::string& line) {
  if (style_ == Style::kSilent) return;
  clear_bar();
  std::fputs((line + "\n").c_str(), out_);
  std::fflush(out_);
}

void Progress::show_bar(double seconds) {
  const int filled = total_ > 0 ? int(kBarWidth * std::min(1.0, done_ / total_)) : kBarWidth;
  const std::string bar = std::string(size_t(filled), '#') + std::string(size_t(kBarWidth - filled), '.');
  std::fputs(fmt::format("\r\033[K{} [{}] {}", stage_, bar, describe(seconds)).c_str(), out_);
  std::fflush(out_);
  bar_visible_ = true;
}

void Progress::clear_bar() {
  if (bar_visible_) std::fputs("\r\033[K", out_);
  bar_visible_ = false;
}

}  // namespace landfix

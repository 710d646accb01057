#include "tiles/navigability.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>

#include "tiles/grid.h"

namespace landfix::tiles {
namespace {

constexpr std::string_view kPrefix = "navigability/";
constexpr double kLargestLogit = 9.210340371976184;  // ln 10 000: nearer to certainty no sample could tell
constexpr int kMiddle = 128;                         // code of even odds
constexpr double kShortest_m = 0.1;
constexpr int kStepsPerOctave = 16;
constexpr int kCircle = 254;  // codes 1 to 254; 0 would be "without data"

uint8_t code_of(double steps) { return uint8_t(std::clamp(std::lround(steps), 1L, 255L)); }

// 0 where it is not known.
uint8_t code_of_probability(double p) {
  if (std::isnan(p)) return 0;
  const double logit = p <= 0 ? -kLargestLogit : p >= 1 ? kLargestLogit : std::log(p / (1 - p));
  return code_of(kMiddle + std::clamp(logit / kLargestLogit, -1.0, 1.0) * (kMiddle - 1));
}

double probability_of_code(uint8_t code) {
  if (code == 0) return std::numeric_limits<double>::quiet_NaN();
  return 1 / (1 + std::exp(-kLargestLogit * (code - kMiddle) / (kMiddle - 1)));
}

// 0 for no length.
uint8_t code_of_length(double m) {
  return m > 0 ? code_of(1 + kStepsPerOctave * std::log2(std::max(m, kShortest_m) / kShortest_m)) : uint8_t(0);
}

double length_of_code(uint8_t code) {
  return code == 0 ? 0 : kShortest_m * std::exp2(double(code - 1) / kStepsPerOctave);
}

uint8_t code_of_angle(double rad, double circle_rad) {
  const double turns = rad / circle_rad - std::floor(rad / circle_rad);
  return uint8_t(1 + std::lround(turns * kCircle) % kCircle);
}

double angle_of_code(uint8_t code, double circle_rad) {
  return code == 0 ? 0 : (code - 1) % kCircle * circle_rad / kCircle;
}

uint8_t code_of_share(double share) { return code_of(1 + std::clamp(share, 0.0, 1.0) * 254); }
double share_of_code(uint8_t code) { return code == 0 ? 0 : (code - 1) / 254.0; }

uint8_t code_of_count(unsigned count) { return uint8_t(1 + std::min(count, 254U)); }
unsigned count_of_code(uint8_t code) { return code == 0 ? 0U : code - 1U; }

constexpr int kFinestLevel = 0, kCoarsestLevel = 6;
constexpr int kLastDay = 65534;  // in 2149

constexpr double kLeastMetres = 0.001, kMostMetres = 1e6;

// "160" or "12.5": as layer_of writes it, and nothing else.
std::optional<double> metres_of(std::string_view text) {
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  if (failure != std::errc() || end != text.data() + text.size() || !(value >= kLeastMetres && value <= kMostMetres))
    return std::nullopt;
  return value;
}

std::string text_of(double metres) {
  std::array<char, 64> text;
  const auto [end, failure] = std::to_chars(text.data(), text.data() + text.size(), metres, std::chars_format::fixed);
  return {text.data(), failure == std::errc() ? end : text.data()};
}

}  // namespace

std::string layer_of(const Footprint& footprint) {
  return std::string(kPrefix) + text_of(footprint.template_m) + "/" + text_of(footprint.search_m);
}

std::optional<Footprint> footprint_of(std::string_view layer) {
  if (!layer.starts_with(kPrefix)) return std::nullopt;
  return footprint_named(layer.substr(kPrefix.size()));
}

std::optional<Footprint> footprint_named(std::string_view text) {
  const size_t cut = text.find('/');
  if (cut == std::string_view::npos) return std::nullopt;
  const std::optional<double> view = metres_of(text.substr(0, cut)), search = metres_of(text.substr(cut + 1));
  if (!view || !search) return std::nullopt;
  return Footprint{*view, *search};
}

int navigability_level(const Footprint& f) {
  return std::clamp(int(std::floor(std::log2(f.template_m / 2))), kFinestLevel, kCoarsestLevel);
}

double node_spacing_m(const Footprint& f) { return gsd_of(navigability_level(f)); }

double aged(double fix_probability, double years) {
  const double change = kAgeing * (std::log1p(std::max(years, 0.0)) - std::log1p(kTypicalAgeYears));
  const double odds = fix_probability / (1 - fix_probability) * std::exp(-change);
  return std::isinf(odds) ? 1 : odds / (1 + odds);
}

Navigability on_day(const Navigability& place, int day) {
  Navigability out = place;
  if (!place.newest_day) return out;
  const double years = (double(day) - *place.newest_day) / kDaysPerYear;
  for (double& p : out.fix_probability) p = aged(p, years);
  if (years > kOldYears) out.reasons = uint16_t(out.reasons | 1U << unsigned(Reason::kOld));
  return out;
}

NavigabilityPixel encode_navigability(const Navigability& n) {
  constexpr double pi = std::numbers::pi;
  NavigabilityPixel out{};
  uint8_t* next = out.data();
  for (const double p : n.fix_probability) *next++ = code_of_probability(p);
  *next++ = code_of_probability(n.false_probability);
  *next++ = code_of_length(n.major_m);
  *next++ = code_of_length(n.minor_m);
  *next++ = code_of_angle(n.direction_rad, pi);
  *next++ = code_of_length(n.rival_m);
  *next++ = code_of_angle(n.rival_bearing_rad, 2 * pi);
  *next++ = code_of_share(n.rival_strength);
  *next++ = code_of_count(n.landmarks);
  *next++ = code_of_share(n.diversity);
  *next++ = uint8_t(n.reasons & 255);
  *next++ = uint8_t(n.reasons >> 8);
  *next++ = code_of_count(n.dates);
  const int day = n.newest_day ? 1 + std::clamp(*n.newest_day, 0, kLastDay) : 0;
  *next++ = uint8_t(day & 255);
  *next++ = uint8_t(day >> 8);
  return out;
}

std::optional<Navigability> decode_navigability(std::span<const uint8_t> pixel) noexcept {
  if (pixel.size() < kNavigabilityChannels || std::ranges::all_of(pixel, [](uint8_t c) { return c == 0; }))
    return std::nullopt;
  constexpr double pi = std::numbers::pi;
  Navigability n;
  const uint8_t* next = pixel.data();
  for (double& p : n.fix_probability) p = probability_of_code(*next++);
  n.false_probability = probability_of_code(*next++);
  n.major_m = length_of_code(*next++);
  n.minor_m = length_of_code(*next++);
  n.direction_rad = angle_of_code(*next++, pi);
  n.rival_m = length_of_code(*next++);
  n.rival_bearing_rad = angle_of_code(*next++, 2 * pi);
  n.rival_strength = share_of_code(*next++);
  n.landmarks = count_of_code(*next++);
  n.diversity = share_of_code(*next++);
  n.reasons = *next++;
  n.reasons = uint16_t(n.reasons | *next++ << 8);
  n.dates = count_of_code(*next++);
  const int day = next[0] | next[1] << 8;
  if (day > 0) n.newest_day = day - 1;
  return n;
}

}  // namespace landfix::tiles

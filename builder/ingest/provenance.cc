#include "builder/ingest/provenance.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "builder/error.h"

namespace landfix::ingest {
namespace {

constexpr const char* kKeys = "date, licence, attribution, bands, datum, nodata, georegistration_error_m";

[[noreturn]] void refuse(const std::string& file, const std::string& why) {
  throw Error(ExitCode::kBadInput,
              fmt::format("{}: {}. A sidecar is a JSON object with any of the keys {}, for instance "
                          "{{\"date\": \"2009-08-18\", \"licence\": \"CC-BY-4.0\"}}",
                          file, why, kKeys));
}

std::string text_of(const std::string& file, const std::string& key, const nlohmann::json& value) {
  if (!value.is_string()) refuse(file, fmt::format("\"{}\" must be a text, not {}", key, value.dump()));
  return value.get<std::string>();
}

double number_of(const std::string& file, const std::string& key, const nlohmann::json& value) {
  if (!value.is_number()) refuse(file, fmt::format("\"{}\" must be a number, not {}", key, value.dump()));
  return value.get<double>();
}

}  // namespace

bool is_date(const std::string& t) {
  if (t.size() != 10 || t[4] != '-' || t[7] != '-') return false;
  const auto number = [&](size_t begin, size_t count) {
    int n = 0;
    for (size_t i = begin; i < begin + count; ++i)
      n = (t[i] >= '0' && t[i] <= '9') ? n * 10 + (t[i] - '0') : -1'000'000;
    return n;
  };
  const int year = number(0, 4), month = number(5, 2), day = number(8, 2);
  if (year < 1 || month < 1 || day < 1) return false;
  return std::chrono::year_month_day(std::chrono::year(year), std::chrono::month(unsigned(month)),
                                     std::chrono::day(unsigned(day)))
      .ok();
}

Sidecar read_sidecar(const std::string& path) {
  const std::string file = path + ".json";
  if (!std::filesystem::exists(file)) return {};
  std::ifstream stream(file);
  const nlohmann::json json = nlohmann::json::parse(stream, nullptr, false);
  if (json.is_discarded()) refuse(file, "is not valid JSON");
  if (!json.is_object()) refuse(file, "is not a JSON object");
  Sidecar s;
  for (const auto& [key, value] : json.items()) {
    if (key == "nodata" || key == "georegistration_error_m") {
      (key == "nodata" ? s.nodata : s.georegistration_error_m) = number_of(file, key, value);
      continue;
    }
    std::string* const text = key == "date"          ? &s.date
                              : key == "licence"     ? &s.licence
                              : key == "attribution" ? &s.attribution
                              : key == "bands"       ? &s.bands
                              : key == "datum"       ? &s.datum
                                                     : nullptr;
    if (!text) refuse(file, fmt::format("unknown key \"{}\"", key));
    *text = text_of(file, key, value);
  }
  if (!s.date.empty() && !is_date(s.date))
    refuse(file, fmt::format("\"{}\" is no date; expected a day as 2009-08-18", s.date));
  if (s.georegistration_error_m && *s.georegistration_error_m < 0)
    refuse(file, "\"georegistration_error_m\" must not be negative");
  return s;
}

}  // namespace landfix::ingest

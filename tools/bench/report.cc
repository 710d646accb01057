#include "tools/bench/report.h"

#include <fmt/format.h>

#include "tools/common/files.h"

namespace landfix::bench {
namespace {

/// Four significant digits, as far as a benchmark can be trusted at most.
std::string number(double value) { return fmt::format("{:.4g}", value); }

}  // namespace

void Report::setup(const std::string& name, const nlohmann::ordered_json& value) {
  fmt::print("{:<22} {}\n", name, value.is_string() ? value.get<std::string>() : value.dump());
  setup_[name] = value;
}

void Report::section(const std::string& name, const std::string& method) {
  fmt::print("\n{}: {}\n", name, method);
  section_ = name;
  methods_[name] = method;
}

void Report::measured(const std::string& name, double value, const std::string& unit) {
  add({section_, name, value, unit, "", {}});
}

void Report::at_least(const std::string& name, double value, const std::string& unit, double target) {
  add({section_, name, value, unit, ">= " + number(target), value >= target});
}

void Report::at_most(const std::string& name, double value, const std::string& unit, double target) {
  add({section_, name, value, unit, "<= " + number(target), value <= target});
}

void Report::equal(const std::string& name, double difference, const std::string& unit, double allowed) {
  const bool agree = difference <= allowed;
  results_agree_ &= agree;
  add({section_, name, difference, unit, "must be <= " + number(allowed), agree});
}

void Report::add(Row row) {
  const char* verdict = !row.met ? "" : *row.met ? "met" : "missed";
  fmt::print("  {:<52} {:>10} {:<10} {:<16} {}\n", row.name, number(row.value), row.unit, row.target, verdict);
  std::fflush(stdout);
  rows_.push_back(std::move(row));
}

void Report::summarize() const {
  size_t targets = 0, met = 0;
  for (const Row& row : rows_) targets += row.met.has_value(), met += row.met.value_or(false);
  fmt::print("\n{} of {} targets met\n", met, targets);
  for (const Row& row : rows_) {
    if (!row.met.value_or(true))
      fmt::print("  missed: {}: {}: {} {}, target {}\n", row.section, row.name, number(row.value), row.unit,
                 row.target);
  }
}

void Report::write(const std::filesystem::path& file) const {
  nlohmann::ordered_json out = {{"setup", setup_}, {"methods", methods_}, {"results", nlohmann::ordered_json::array()}};
  for (const Row& row : rows_) {
    nlohmann::ordered_json item = {
        {"section", row.section}, {"name", row.name}, {"value", row.value}, {"unit", row.unit}};
    if (row.met) item["target"] = row.target, item["met"] = *row.met;
    out["results"].push_back(item);
  }
  tools::write_text(file.string(), out.dump(2) + "\n");
}

}  // namespace landfix::bench

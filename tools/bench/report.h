// What the benchmark found: a table for people, bench.json for programs.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace landfix::bench {

/// Rows are printed as they come in. Ratios say how many times landfix is faster, unless their name says otherwise.
class Report {
 public:
  /// One fact about machine, data or method.
  void setup(const std::string& name, const nlohmann::ordered_json& value);
  /// A section of the table, with a line on how it is measured.
  void section(const std::string& name, const std::string& method);
  void measured(const std::string& name, double value, const std::string& unit);
  void at_least(const std::string& name, double value, const std::string& unit, double target);
  void at_most(const std::string& name, double value, const std::string& unit, double target);
  /// Two results that must agree: `difference` above `allowed` makes the benchmark fail.
  void equal(const std::string& name, double difference, const std::string& unit, double allowed);

  bool results_agree() const { return results_agree_; }
  /// Prints which targets were missed.
  void summarize() const;
  /// Throws Error(kIo).
  void write(const std::filesystem::path& file) const;

 private:
  struct Row {
    std::string section, name;
    double value = 0;
    std::string unit, target;
    std::optional<bool> met;
  };
  void add(Row row);

  nlohmann::ordered_json setup_ = nlohmann::ordered_json::object();
  nlohmann::ordered_json methods_ = nlohmann::ordered_json::object();
  std::string section_;
  std::vector<Row> rows_;
  bool results_agree_ = true;
};

}  // namespace landfix::bench

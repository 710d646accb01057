// JSON whose every access is checked: what is missing or of another type is an Error that names file and place.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace landfix::mission {

/// Keeps the order of keys, so that what is written back reads as it did.
using Json = nlohmann::ordered_json;

/// A value in a document, and where it is ("mission.items[3].params"). Valid as long as the document.
class JsonNode {
 public:
  JsonNode(const Json& value, std::string path, const std::string& file)
      : value_(&value), path_(std::move(path)), file_(&file) {}

  /// Of an object: the member, which must exist (at), or may (find; a null counts as missing).
  JsonNode at(const std::string& key) const;
  std::optional<JsonNode> find(const std::string& key) const;

  /// Of an array.
  size_t size() const;
  JsonNode at(size_t index) const;

  bool is_text() const { return value_->is_string(); }
  double number() const;
  double number_or_nan() const;  ///< null is not a number
  long integer() const;
  bool flag() const;
  const std::string& text() const;

  /// Throws Error (kBadInput): "FILE: PATH: expected EXPECTED, found FOUND; ADVICE".
  [[noreturn]] void refuse(const std::string& expected, const std::string& found, const std::string& advice) const;
  /// The same; `found` is the value itself.
  [[noreturn]] void refuse(const std::string& expected) const;

  const std::string& file() const { return *file_; }
  const std::string& path() const { return path_; }

 private:
  const Json* value_;
  std::string path_;
  const std::string* file_;
};

/// Parses a text; throws Error (kBadInput) where it is no JSON, or nested deeper than 64 levels.
Json parse_json(const std::string& text, const std::string& file);

class JsonDocument {
 public:
  JsonDocument(const std::string& text, const std::string& file) : value_(parse_json(text, file)), file_(file) {}
  JsonNode root() const { return {value_, "", file_}; }

 private:
  Json value_;
  std::string file_;
};

}  // namespace landfix::mission

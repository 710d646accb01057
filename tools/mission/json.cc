#include "tools/mission/json.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "builder/error.h"

namespace landfix::mission {
namespace {

// Plans are 9 levels deep. Writing recurses, so depth is stack.
constexpr int kMaxDepth = 64;
constexpr const char* kAdvice = "the file is damaged or was edited by hand: save it again in its program";

}  // namespace

Json parse_json(const std::string& text, const std::string& file) {
  const auto limit_depth = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > kMaxDepth) {
      throw Error(ExitCode::kBadInput,
                  fmt::format("{}: expected JSON of at most {} levels, found more; {}", file, kMaxDepth, kAdvice));
    }
    return true;
  };
  try {
    return Json::parse(text, limit_depth);
  } catch (const nlohmann::json::parse_error& e) {
    throw Error(ExitCode::kBadInput, fmt::format("{}: expected JSON, found an error at byte {} of {}; the file is cut "
                                                 "off or damaged: copy it again or save it again in its program",
                                                 file, e.byte, text.size()));
  } catch (const nlohmann::json::exception& e) {
    throw Error(ExitCode::kBadInput, fmt::format("{}: expected JSON, found: {}; {}", file, e.what(), kAdvice));
  }
}

void JsonNode::refuse(const std::string& expected, const std::string& found, const std::string& advice) const {
  throw Error(ExitCode::kBadInput, fmt::format("{}: {}{}expected {}, found {}; {}", *file_, path_,
                                               path_.empty() ? "" : ": ", expected, found, advice));
}

void JsonNode::refuse(const std::string& expected) const {
  const bool small = value_->is_primitive();
  refuse(expected, small ? value_->dump().substr(0, 40) : std::string("an ") + value_->type_name(), kAdvice);
}

JsonNode JsonNode::at(const std::string& key) const {
  if (!value_->is_object()) refuse("an object");
  const auto member = value_->find(key);
  if (member == value_->end()) refuse(fmt::format("\"{}\"", key), "none", kAdvice);
  return {*member, path_.empty() ? key : path_ + "." + key, *file_};
}

std::optional<JsonNode> JsonNode::find(const std::string& key) const {
  if (!value_->is_object()) refuse("an object");
  const auto member = value_->find(key);
  if (member == value_->end() || member->is_null()) return std::nullopt;
  return JsonNode(*member, path_.empty() ? key : path_ + "." + key, *file_);
}

size_t JsonNode::size() const {
  if (!value_->is_array()) refuse("a list");
  return value_->size();
}

JsonNode JsonNode::at(size_t index) const {
  if (index >= size()) refuse(fmt::format("at least {} values", index + 1), std::to_string(size()), kAdvice);
  return {(*value_)[index], fmt::format("{}[{}]", path_, index), *file_};
}

double JsonNode::number() const {
  if (!value_->is_number()) refuse("a number");
  return value_->get<double>();
}

double JsonNode::number_or_nan() const {
  if (value_->is_null()) return std::numeric_limits<double>::quiet_NaN();
  if (!value_->is_number()) refuse("a number or null");
  return value_->get<double>();
}

long JsonNode::integer() const {
  const double value = value_->is_number() ? value_->get<double>() : 0.5;
  if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max()) refuse("a whole number");
  return static_cast<long>(value);
}

bool JsonNode::flag() const {
  if (!value_->is_boolean()) refuse("true or false");
  return value_->get<bool>();
}

const std::string& JsonNode::text() const {
  if (!value_->is_string()) refuse("a text");
  return value_->get_ref<const std::string&>();
}

}  // namespace landfix::mission

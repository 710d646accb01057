// Damaged files of every format: each is read or refused by an Error, never anything else.
#include <functional>

#include "tests/mission/files.h"
#include "tools/mission/write.h"

namespace landfix::mission {
namespace {

/// Reads, follows the jumps and writes back, as commands do; an exception of another type fails the test.
void survive(const std::string& text) {
  try {
    const Mission mission = parse_mission(text, "mission file");
    flown(mission);
    if (mission.format == Format::kPlan || mission.format == Format::kWaypoints) changed_mission(mission, {});
  } catch (const Error& e) {
    EXPECT_TRUE(says(e.what(), "mission file"));
  }
}

class Damaged : public testing::TestWithParam<const std::string*> {};

TEST_P(Damaged, CutOffAtEachByte) {
  const std::string& text = *GetParam();
  for (size_t length = 0; length < text.size(); ++length) survive(text.substr(0, length));
}

TEST_P(Damaged, EachByteFlipped) {
  std::string text = *GetParam();
  // The lowest bit makes neighbouring digits and letters, bit 4 other punctuation, the highest bytes that are no UTF-8.
  for (const unsigned char mask : {0x01, 0x10, 0x80}) {
    for (char& byte : text) {
      byte = static_cast<char>(byte ^ mask);
      survive(text);
      byte = static_cast<char>(byte ^ mask);
    }
  }
}

TEST_P(Damaged, EachByteLostOrDoubled) {
  const std::string& text = *GetParam();
  for (size_t at = 0; at < text.size(); ++at) {
    survive(text.substr(0, at) + text.substr(at + 1));
    survive(text.substr(0, at + 1) + text.substr(at));
  }
}

/// What holds a number holds an enormous one, null, a text, a list or an object.
TEST_P(Damaged, NumbersBecomeOtherThings) {
  const std::string& text = *GetParam();
  for (size_t at = 0; at < text.size();) {
    const size_t begin = text.find_first_of("-0123456789", at);
    if (begin == std::string::npos) break;
    const size_t end = std::min(text.find_first_not_of("-+.eE0123456789", begin), text.size());
    for (const char* other : {"1e308", "-1e308", "null", "\"x\"", "[]", "{}", "4294967296", "-1", "nan", ""}) {
      survive(text.substr(0, begin) + other + text.substr(end));
    }
    at = end;
  }
}

std::string format_name(const testing::TestParamInfo<const std::string*>& tested) {
  const char* const names[] = {"Plan", "Waypoints", "Gpx", "Kml", "GeoJson"};
  return names[tested.index];
}

INSTANTIATE_TEST_SUITE_P(Formats, Damaged,
                         testing::Values(&kPlanText, &kWaypointsText, &kGpxText, &kKmlText, &kGeoJsonText),
                         format_name);

}  // namespace
}  // namespace landfix::mission

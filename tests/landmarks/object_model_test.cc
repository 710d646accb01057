// The model of objects as bytes, and how trees learn several classes.
#include "builder/landmarks/object_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "builder/error.h"
#include "builder/landmarks/object_regions.h"
#include "builder/training/boosting.h"
#include "runtime/features/object_planes.h"

namespace landfix::landmarks {
namespace {

TEST(ObjectModel, ComesWithLandfix) {
  const ObjectModel& model = default_object_model();
  EXPECT_EQ(model.colour.covers.outputs(), kCovers);
  EXPECT_EQ(model.gray.covers.features(), features::kObjectPlanesGray);
  EXPECT_GT(model.colour.whole[size_t(tiles::LandmarkClass::kBuilding)].size(), 0u);
  EXPECT_GT(model.gray.whole[size_t(tiles::LandmarkClass::kTree)].size(), 0u);
}

TEST(ObjectModel, IsReadAsItWasWritten) {
  const std::vector<uint8_t> bytes = default_object_model().serialise();
  EXPECT_EQ(parse_object_model(bytes, "copy").serialise(), bytes);
}

// What parse_object_model says of bytes; empty where it takes them.
std::string complaint(std::span<const uint8_t> bytes) {
  try {
    parse_object_model(bytes, "the.model");
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kBadInput);
    return e.what();
  }
  return {};
}

TEST(ObjectModel, SaysWhatIsWrong) {
  std::vector<uint8_t> bytes = default_object_model().serialise();
  EXPECT_NE(complaint({}).find("the.model: expected a model of objects, found the file ends early"), std::string::npos);
  std::vector<uint8_t> longer = bytes;
  longer.push_back(0);
  EXPECT_NE(complaint(longer).find("bytes behind its end"), std::string::npos);
  std::vector<uint8_t> other = bytes;
  other[0] ^= 1;
  EXPECT_NE(complaint(other).find("another kind of file"), std::string::npos);
  std::vector<uint8_t> newer = bytes;
  newer[4] = 9;
  EXPECT_NE(complaint(newer).find("version 9 where this landfix knows 1"), std::string::npos);
}

TEST(ObjectModel, RefusesEveryTruncation) {
  const std::vector<uint8_t> bytes = default_object_model().serialise();
  for (size_t n = 0; n < bytes.size(); n += 1 + n / 40)
    EXPECT_FALSE(complaint(std::span(bytes).first(n)).empty()) << n << " bytes";
}

TEST(ObjectModel, SurvivesFlippedBits) {
  const std::vector<uint8_t> bytes = default_object_model().serialise();
  const std::vector<float> planes(features::kObjectPlanesColour, 100), region(kRegionNumbers, 100);
  for (size_t i = 0; i < 4000; ++i) {
    std::vector<uint8_t> damaged = bytes;
    const size_t bit = i < 800 ? i : (i * 2654435761u) % (bytes.size() * 8);
    damaged[bit / 8] ^= uint8_t(1u << (bit % 8));
    try {
      // What is taken for a model can be asked without reading outside of it.
      const ObjectModel model = parse_object_model(damaged, "damaged");
      std::array<float, kCovers> scores;
      model.colour.covers.measure(planes, scores);
      model.colour.whole[0].probability(region);
    } catch (const Error&) {
    }
  }
}

TEST(ObjectModel, NamesTheFileThatIsMissing) {
  try {
    read_object_model("/nowhere/x.model");
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::kIo);
    EXPECT_NE(std::string(e.what()).find("/nowhere/x.model"), std::string::npos);
  }
}

float noise_at(uint32_t i, uint32_t k) {
  uint32_t h = (i * 73856093u ^ k * 19349663u) * 2654435761u;
  h = (h ^ (h >> 15)) * 2246822519u;
  return float(h >> 8) / float(1 << 24);
}

TEST(Boosting, LearnsSeveralClassesAndFromDoubtfulRows) {
  // Three classes by the thirds of number 1 of 4. Of every fourth row it is known only that it is not of class 2.
  std::vector<float> values;
  std::vector<uint8_t> allowed;
  std::vector<size_t> truth;
  for (uint32_t i = 0; i < 3000; ++i) {
    for (uint32_t k = 0; k < 4; ++k) values.push_back(noise_at(i, k));
    truth.push_back(std::min<size_t>(size_t(values[4 * i + 1] * 3), 2));
    allowed.push_back(i % 4 == 0 && truth.back() < 2 ? 3 : uint8_t(1u << truth.back()));
  }
  const features::BoostedTrees trees =
      boost_classes(values, 4, allowed, 3, {.trees = 20, .leaves = 4, .rate = 0.4, .least_rows = 20});
  ASSERT_EQ(trees.outputs(), 3u);
  size_t right = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    std::array<float, 3> scores;
    trees.measure(std::span(values).subspan(4 * i, 4), scores);
    right += size_t(std::max_element(scores.begin(), scores.end()) - scores.begin()) == truth[i];
  }
  EXPECT_GT(right, 2940u);  // 98 %: limits lie at quantiles
  size_t used = 0;
  const std::vector<uint8_t> bytes = trees.serialise();
  features::BoostedTrees copy;
  ASSERT_EQ(copy.parse(bytes, used), features::TreesError::kNone);
  EXPECT_EQ(used, bytes.size());
  EXPECT_EQ(copy.serialise(), bytes);
}

TEST(Boosting, NeedsEveryClass) {
  const std::vector<float> values(20, 1);
  EXPECT_THROW(boost_classes(values, 2, std::vector<uint8_t>(10, 1), 2, {}), Error);
}

}  // namespace
}  // namespace landfix::landmarks

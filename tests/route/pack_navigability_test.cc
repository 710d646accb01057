// What routes are told by the navigability layers of a pack: a small one is written by the pack writer and read back.
#include "tools/route/pack_navigability.h"

#include <fstream>

#include "builder/error.h"
#include "tests/route/packs.h"

namespace landfix::route {
namespace {

class PackNavigabilityTest : public NavigablePack {
 protected:
  /// One thing as far as 2 km east of at(0, 0), another from there on, and nothing known beyond 4 km.
  void add(const tiles::Footprint& footprint, const tiles::Navigability& west, const tiles::Navigability& east) {
    NavigablePack::add(footprint, [&](double x_m, double) {
      return x_m > 4000 ? std::nullopt : std::optional(x_m < 2000 ? west : east);
    });
  }
  static Navigability seen(const NavigabilityMap& map, double view_m, double search_m, bool west = true) {
    return map.at(kEast + (west ? 1000 : 3000), kNorth, view_m, search_m).value();
  }
};

// The chance of `auto`, the long axis along its direction (north: variance 16 there, 4 eastwards), reasons and
// repeats; codes are exact to 4.4 % of a length and 0.073 in log odds.
TEST_F(PackNavigabilityTest, SaysWhatTheNodeSays) {
  tiles::Navigability lake = place(0.1);
  lake.reasons = 1u << unsigned(tiles::Reason::kWater) | 1u << unsigned(tiles::Reason::kRepeats);
  lake.rival_m = 100;
  lake.rival_bearing_rad = M_PI / 2;
  add({160, 40}, place(0.9), lake);
  const Pack pack = written();
  const auto map = open_navigability(pack, path_);
  const Navigability west = seen(*map, 160, 20), east = seen(*map, 160, 20, false);
  EXPECT_NEAR(west.fix_probability, 0.9, 0.005);
  EXPECT_NEAR(west.false_probability, 0.02, 0.001);
  EXPECT_NEAR(west.covariance_m2(0, 0), 4, 0.4);
  EXPECT_NEAR(west.covariance_m2(1, 1), 16, 1.5);
  EXPECT_EQ(west.reasons, 0u);
  EXPECT_NEAR(east.fix_probability, 0.1, 0.005);
  EXPECT_EQ(east.reasons, uint32_t(kWater | kRepeats));
  ASSERT_TRUE(east.repeat);
  EXPECT_NEAR(east.repeat->distance_m, 100, 5);
  EXPECT_NEAR(east.repeat->bearing_rad, M_PI / 2, 0.02);
  EXPECT_FALSE(map->at(kEast + 5000, kNorth, 160, 20));                                  // nothing known
  EXPECT_FALSE(map->at(kTile.x * tiles::tile_side(kTile.level) - 10, kNorth, 160, 20));  // off the map
}

// Between two views by the logarithm: 160 is half way from 80 to 320. Smaller than all: its share of the ground. A
// search is answered by the next wider one; beyond the widest one, half as wide, P(|x| < 1.86 σ) = 0.937 per axis is
// left.
TEST_F(PackNavigabilityTest, BetweenViewsAndSearches) {
  add({80, 40}, place(0.5), place(0.5));
  add({80, 160}, place(0.3), place(0.3));
  add({320, 160}, place(0.9), place(0.9));
  const Pack pack = written();
  const auto map = open_navigability(pack, path_);
  EXPECT_NEAR(seen(*map, 80, 40).fix_probability, 0.5, 0.01);
  EXPECT_NEAR(seen(*map, 80, 41).fix_probability, 0.3, 0.01);
  EXPECT_NEAR(seen(*map, 80, 320).fix_probability, 0.3 * 0.937 * 0.937, 0.01);
  EXPECT_NEAR(seen(*map, 160, 160).fix_probability, 0.6, 0.01);
  EXPECT_NEAR(seen(*map, 999, 160).fix_probability, 0.9, 0.01);
  EXPECT_NEAR(seen(*map, 40, 160).fix_probability, 0.3 / 4, 0.01);
}

// Ten years instead of two: the log odds of 0.8 fall by 0.6 · ln(11 / 3), to 0.647; the map is old then.
TEST_F(PackNavigabilityTest, AgesToTheDayOfFlight) {
  tiles::Navigability dated = place(0.8);
  dated.newest_day = 14000;
  add({160, 160}, dated, place(0.8));
  const Pack pack = written();
  const auto map = open_navigability(pack, path_, 14000 + 3653);
  EXPECT_NEAR(seen(*map, 160, 100).fix_probability, 0.647, 0.01);
  EXPECT_EQ(seen(*map, 160, 100).reasons, uint32_t(kOldMap));
  EXPECT_NEAR(seen(*map, 160, 100, false).fix_probability, 0.8, 0.01);  // its date is not known
  EXPECT_NEAR(seen(*open_navigability(pack, path_), 160, 100).fix_probability, 0.8, 0.01);
}

TEST_F(PackNavigabilityTest, RefusesPacksThatDoNotSay) {
  const Pack pack = written();
  try {
    open_navigability(pack, path_);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(int(error.code()), int(ExitCode::kNoData));
    EXPECT_NE(std::string(error.what()).find("--navigability"), std::string::npos) << error.what();
  }
}

// Any byte of the tile's data that is not as written is a damaged pack, not other chances.
TEST_F(PackNavigabilityTest, RefusesDamage) {
  add({160, 40}, place(0.9), place(0.2));
  { const Pack pack = written(); }
  std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
  const std::vector<uint8_t>& tile = data_.at(0);
  std::string bytes(std::istreambuf_iterator<char>(file), {});
  const size_t where = bytes.find(std::string(tile.begin(), tile.end()));
  ASSERT_NE(where, std::string::npos);
  file.seekp(long(where + tile.size() / 2));
  file.put(char(~bytes[where + tile.size() / 2]));
  file.close();
  const Pack pack = tools::open_pack(path_);
  try {
    open_navigability(pack, path_);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(int(error.code()), int(ExitCode::kBadPack)) << error.what();
  }
}

}  // namespace
}  // namespace landfix::route

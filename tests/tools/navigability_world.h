// A drawn pack of 4 x 4 nodes with navigability: chances of a fix rise from west to east, and the southernmost nodes
// say nothing.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "tests/pack/draw.h"
#include "tiles/navigability.h"

namespace landfix::tests {

inline constexpr int kJudgedX = 30, kJudgedY = 305;  // the tile of the layer, zone 32 north
inline constexpr double kJudgedWest = kJudgedX * 16384.0, kJudgedNorth = (kJudgedY + 1) * 16384.0;
/// By column of nodes; the truth up to a step of 0.0725 in log odds.
inline constexpr std::array<double, 4> kJudgedChances = {0.1, 0.3, 0.6, 0.97};

/// What the node of a column and row says; auto and orientation are judged.
inline tiles::Navigability judged_node(int64_t column, int64_t row) {
  tiles::Navigability n;
  n.fix_probability = {kJudgedChances[size_t(column)], 0.5, std::nan(""), std::nan(""), std::nan("")};
  n.false_probability = 0.01;
  n.major_m = 8, n.minor_m = 4, n.direction_rad = std::numbers::pi / 2;  // long from west to east
  if (column == 0) {
    n.rival_m = 140, n.rival_bearing_rad = std::numbers::pi / 4, n.rival_strength = 0.9;
    n.reasons = 1u << unsigned(tiles::Reason::kRepeats) | 1u << unsigned(tiles::Reason::kUniform);
  }
  n.landmarks = unsigned(row);
  n.dates = 2;
  n.newest_day = 16998;  // 2016-07-16
  return n;
}

/// 256 m of even gray, taken on 2016-07-16, and the layer navigability/160/160.
inline Drawing judged_drawing() {
  DrawnLayer gray;
  gray.levels = {{0, kJudgedX * 64, kJudgedY * 64 + 63, "x"}};
  gray.pixel = [](const PixelOf&) { return 100; };
  gray.epochs = [](char) { return catalog::EpochSet{0}; };
  DrawnLayer nodes;
  nodes.name = tiles::layer_of({160, 160});
  nodes.format = {tiles::PixelType::kU8, uint8_t(tiles::kNavigabilityChannels), 0};
  nodes.levels = {{6, kJudgedX, kJudgedY, "x"}};
  nodes.pixel = [](const PixelOf& p) -> int {
    const int64_t column = p.column - kJudgedX * 256, row = p.row + (kJudgedY + 1) * 256;
    if (column >= 4 || row >= 3) return 0;
    return tiles::encode_navigability(judged_node(column, row))[size_t(p.channel)];
  };
  Drawing d{.layers = {gray, nodes}};
  d.description.epochs = {{"2016-07-16", {}}};
  d.description.bounds = {kJudgedWest, kJudgedNorth - 256, kJudgedWest + 256, kJudgedNorth};
  return d;
}

}  // namespace landfix::tests

// What covers the ground, for the reasons why a place can be navigated by or not: shares of water, closed wood and
// shadow in squares as large as a node of the navigability layers.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "builder/catalog/catalog.h"
#include "builder/ingest/image_set.h"
#include "builder/plan.h"

namespace landfix {

enum class Ground : uint8_t { kWater = 0, kWood = 1, kShadow = 2 };
inline constexpr size_t kGrounds = 3;

/// The level at which images are looked at for it: kFeatureLevel, or theirs where they are coarser.
int ground_level(const Plan& plan);

/// Pixels of it that are wanted around a block.
int ground_halo_px(const Plan& plan);

/// What the newest images show in a block of ground_level(), for the journal: water where there is near infrared, by
/// the normalised difference of green and near infrared (McFeeters 1996), and shadow where pixels are fine enough.
catalog::FinishedTile describe_ground(const Plan& plan, const ingest::Stack& images, const tiles::TileIndex& block);

/// The same from what landmarks::find_landmarks takes the pixels of the block for, date by date: water and wood.
catalog::FinishedTile describe_covers(const tiles::TileIndex& block, std::span<const cv::Mat> covers);

/// What the journal says of the whole map.
class GroundMap {
 public:
  GroundMap(const Plan& plan, const catalog::Catalog& catalog);
  ~GroundMap();

  /// Share of the ground around a place, 0 to 1, in the whole nodes that are about `side_m` a side; nothing where it is
  /// not known.
  std::optional<double> share(Ground ground, double east_m, double north_m, double side_m) const;

 private:
  struct Sums;  ///< of one kind of ground, over nodes from the north-western corner
  std::vector<Sums> sums_;
  tiles::PixelRect nodes_;  ///< of the map
};

}  // namespace landfix

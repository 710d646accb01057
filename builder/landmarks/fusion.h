// One landmark from several views of it: what the capture dates show.
#pragma once

#include <cstdint>
#include <vector>

#include "builder/landmarks/extraction.h"
#include "tiles/landmark.h"
#include "tiles/road.h"

namespace landfix::landmarks {

/// Views of one object, or of a known one, are this near to each other, or a quarter of its length.
inline constexpr double kSamePlace_m = 5;

/// A landmark as one capture date shows it.
struct Sighting {
  tiles::Landmark landmark;
  uint16_t epoch = 0;      ///< index among the dates, newest first
  uint16_t chances = 1;    ///< dates that show anything at its centre
  bool is_newest = false;  ///< the newest of them is this one
};

/// Joins what the dates show of one object: of the same class, of a size within a factor of 2, nearest of all and no
/// farther apart than kSamePlace_m or a quarter of the length. Position is the mean by confidence; size and orientation
/// are those of the surest view; `epochs_seen` counts the views. Confidence is the mean over all dates that had the
/// chance to see it, 0 where they do not, or that of the newest if it is greater: a house may be new
/// (not of fields: they are laid out anew every year, and what one date alone shows is weak). Those below
/// kLeastConfidence are dropped. The same landmarks whatever the order of the sightings, ordered by place.
std::vector<tiles::Landmark> fuse_epochs(std::vector<Sighting> sightings);

/// Leaves out what has its centre in the rectangle of one before it, of the same date and class: broad landmarks on the
/// seam of two windows.
std::vector<Sighting> without_covered(const std::vector<Sighting>& sightings);

/// Removes buildings that stand in the middle of a likely road (confidence 0.5 or more), nearer to its centreline than
/// a third of its width: between the shadows of trees a piece of road looks like a roof.
void drop_on_roads(std::vector<tiles::Landmark>& landmarks, const tiles::RoadGraph& roads);

}  // namespace landfix::landmarks

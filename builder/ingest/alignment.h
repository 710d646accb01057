// How far images lie off each other: a constant shift between sources that show the same place, measured by correlation
// of gradient orientation, which survives other dates, seasons and sensors.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "builder/ingest/image_set.h"

namespace landfix::ingest {

struct AlignmentOptions {
  int patch_px = 128;        ///< side of the squares of a source that are looked for
  int search_px = 24;        ///< largest shift, along either axis
  int windows_per_side = 4;  ///< of the overlap, at most
  double agree_px = 1;       ///< largest distance from the median, along either axis
  int min_agreeing = 3;      ///< and more than half of the windows that show enough
  int coarser_levels = 2;    ///< to try where they do not agree: larger patches survive more change
};

/// Where a source lies.
struct Alignment {
  std::optional<size_t> reference;  ///< the source it was compared with; absent: itself one, or it overlaps none
  bool measured = false;            ///< enough windows agree
  /// How far it lies east and north of where it would have to for its group of overlapping sources to fit on the
  /// group's first; 0 where not measured.
  double east_m = 0, north_m = 0;
  double gsd_m = 0;     ///< of the pixels that were compared
  int windows = 0;      ///< that show enough of both sources
  int agreeing = 0;     ///< of them
  double spread_m = 0;  ///< root mean square distance of the agreeing ones from their mean
};

/// One for each source of `images`, at the pixels of `level` (or somewhat coarser ones). Sources are taken in the order
/// of stated georegistration error, then date (newest first), then as listed: each is compared with the first before it
/// that overlaps it at least half as much as any. Windows are spread over the overlap; their shifts are found to a
/// fraction of a pixel by a parabola through the correlation's peak. The same on every machine and with any number of
/// threads.
std::vector<Alignment> measure_alignment(const ImageSet& images, int level, const AlignmentOptions& options = {});

/// "lies 1.52 m east, 0.47 m south by comparison with b.tif (14 of 16 windows at 0.5 m agree, spread 0.08 m)", or why
/// that is not known; empty for a source without reference. `names`: what to call each source.
std::string text_of(const Alignment& alignment, const std::vector<std::string>& names);

}  // namespace landfix::ingest

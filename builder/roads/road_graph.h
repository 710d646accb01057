// The one pass over the whole map that makes a graph of roads from places on their centrelines.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "builder/point_grid.h"
#include "builder/roads/road_candidates.h"
#include "builder/roads/road_skeleton.h"
#include "tiles/road.h"

namespace landfix::landmarks {

struct RoadGraphOptions {
  float low = 0.06f, high = 0.25f;  ///< hysteresis: a chain has places above `low`, some above `high`
  double least_chain = 2.5;         ///< sum of probabilities above `low`, and number of places above `high`
  double spur_px = 12;              ///< shorter twigs are dropped
  double through_gap_px = 60;       ///< longest gap between two ends in line
  double through_budget_px = 31;    ///< length times doubt of such a gap
  double side_gap_px = 30;          ///< longest gap from an end to the road that it points at
  double side_budget_px = 17.5;
  double least_dead_end_px = 7;  ///< length times probability
  double least_component_px = 16.5;
  double junction_px = 6;     ///< branches closer than this are one intersection
  double simplify_px = 0.7;   ///< error of the simplified line
  double roundabout_px = 50;  ///< diameter of the largest roundabout that is one intersection
};

/// Probability that a road runs through a place in a direction; RoadEvidence is one.
using Evidence = std::function<double(double x, double y, double theta_rad)>;

/// Where pixels lie on the grid: the outer corner of the first, and the side of one.
struct PixelFrame {
  double west_m = 0, north_m = 0, gsd_m = kRoadGsd_m;
};

/// Leaves out places among three parallel lines on one side or five on both within 60 pixels (furrows, waves), links
/// the others to chains, thins them to lines, closes gaps where ends point at each other or at a road (Wiedemann and
/// Ebner 2000) and the image supports it, drops what is short and unlikely, and sets each intersection to the
/// least-squares meeting point of its roads. Lines do not cross but at nodes. `size`: of the whole map in pixels, of
/// which `places` are. The same graph for the same set of places.
tiles::RoadGraph link_roads(std::span<const RoadPlace> places, const cv::Size& size, const Evidence& evidence,
                            const PixelFrame& frame, const RoadGraphOptions& options = {});

/// The likely places, found by position.
class PlaceIndex {
 public:
  PlaceIndex(std::span<const RoadPlace> places, float low);
  const std::vector<RoadPlace>& places() const { return places_; }
  const RoadPlace* nearest(const cv::Point2d& p, double radius) const;
  /// Mean along a path of the nearest place's probability, 0 where there is none within 2.5 pixels.
  double mean_probability(const Path& path) const;
  /// Median of the widths along it; 0 where there is no place.
  double width_px(const Path& path) const;

 private:
  std::vector<RoadPlace> places_;
  PointGrid grid_{4};
};

/// Draws lines over gaps into a mask (CV_8UC1) of the map's size. `share` of the budgets is spent.
void close_gaps(const std::vector<Path>& paths, const PlaceIndex& index, const Evidence& evidence,
                const RoadGraphOptions& options, double share, cv::Mat& mask);

}  // namespace landfix::landmarks

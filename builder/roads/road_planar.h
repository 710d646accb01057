// Lines of roads as a planar graph: wherever two of them cross or touch there is a node.
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace landfix::landmarks {

/// A part of a road, in pixels.
struct RoadLine {
  std::vector<cv::Point2d> points;  ///< two or more
  double width_px = 0, probability = 0;
};

/// Lines whose ends alone they share. Nodes are in the order in which the edges name them.
struct PlanarRoads {
  struct Edge {
    size_t from = 0, to = 0;  ///< nodes; equal: a ring
    RoadLine line;            ///< from node to node
  };
  std::vector<cv::Point2d> nodes;
  std::vector<Edge> edges;
};

/// The arrangement of the lines (CGAL's sweep in exact arithmetic over points rounded to 1/64 pixel): cut where they
/// cross, joined where two ends meet alone. Twigs below 4 pixels are left out, and faces become a node at their centre
/// where they are slivers (below 20 pixels squared) or roundabouts: below `roundabout_px` in diameter, with three roads
/// or more, and as round as 4 pi area / perimeter^2 > 0.86 (0.6 below 650 pixels squared). The same for any order of
/// the lines.
PlanarRoads planar_roads(std::span<const RoadLine> lines, double roundabout_px);

}  // namespace landfix::landmarks

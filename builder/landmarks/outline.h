// The shape of a region: the rectangle around it and, of buildings, an outline of straight walls.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "builder/landmarks/object_regions.h"

namespace landfix::landmarks {

/// In pixels; (0.5, 0.5) is the middle of the first.
struct Shape {
  cv::Point2d centre;                ///< of buildings that of the rectangle, of others that of the area
  cv::Point2d along;                 ///< unit vector of its length
  double length = 0, width = 0;      ///< length >= width
  std::vector<cv::Point2d> outline;  ///< of buildings; empty of others
};

/// Walls of buildings run along the edges that the image shows at the region's boundary, or at right angles to them
/// (CGAL's regularisation of closed contours); where that leads astray the outline is the smallest rectangle.
/// `gradient`: of the scene.
Shape shape_of(const Region& region, const features::FourfoldGradient& gradient);

/// The boundary of a region along pixel edges, in pixels of its box, simplified to within a tolerance.
std::vector<cv::Point> boundary_of(const Region& region, double tolerance_px);

}  // namespace landfix::landmarks

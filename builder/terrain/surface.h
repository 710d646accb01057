// A height raster as a surface that rays can be shot at (Embree).
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>

#include "runtime/features/grid_image.h"

namespace landfix::terrain {

/// The surface through the pixel centres of a height raster, two triangles per cell. Coordinates are grid east, grid
/// north and ellipsoidal height in metres; inside they are floats from a local origin, so that large grid coordinates
/// cost no precision. Safe to query from many threads.
class Surface {
 public:
  /// `heights`: CV_32FC1, metres; cells that touch a pixel without data (mask or NaN) are holes.
  /// Throws Error (kBadInput) for another type, fewer than 2×2 pixels or no valid cell.
  explicit Surface(const features::GridImage& heights);
  ~Surface();
  Surface(Surface&&) noexcept;
  Surface& operator=(Surface&&) noexcept;

  static constexpr int kPacket = 16;
  using Directions = std::array<Eigen::Vector3f, kPacket>;
  using Distances = std::array<float, kPacket>;

  /// Shoots the first `count` of 16 rays of one origin; rays that lie close together are fastest. The distance of a hit
  /// is in units of the length of its direction; negative: no hit.
  Distances intersect(const Eigen::Vector3d& origin, const Directions& directions, int count) const;

  double lowest_m() const;
  double highest_m() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace landfix::terrain

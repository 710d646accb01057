#include "builder/terrain/surface.h"

#if LANDFIX_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "builder/error.h"

namespace landfix::terrain {
namespace {

using features::GridImage;

/// Cells along the side of the blocks that are handed to Embree as one grid.
constexpr int kBlockCells = 32;

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
template <typename Handle>
using Owner = std::unique_ptr<std::remove_pointer_t<Handle>, Release>;

/// 255 where a height is there and finite.
cv::Mat valid_heights(const GridImage& heights) {
  cv::Mat finite;
  cv::inRange(heights.pixels, -1e5, 1e5, finite);  // NaN lies in no range
  if (!heights.valid.empty()) cv::bitwise_and(finite, heights.valid, finite);
  return finite;
}

bool cell_valid(const cv::Mat& valid, int x, int y) {
  return valid.at<uchar>(y, x) && valid.at<uchar>(y, x + 1) && valid.at<uchar>(y + 1, x) &&
         valid.at<uchar>(y + 1, x + 1);
}

/// Covers all valid cells with grids: whole blocks where a block has no hole, else runs of cells row by row.
std::vector<RTCGrid> grids_over(const cv::Mat& valid) {
  std::vector<RTCGrid> grids;
  const int columns = valid.cols - 1, rows = valid.rows - 1;
  const auto add = [&](int x, int y, int width, int height) {
    grids.push_back({unsigned(y) * unsigned(valid.cols) + unsigned(x), unsigned(valid.cols),
                     static_cast<unsigned short>(width + 1), static_cast<unsigned short>(height + 1)});
  };
  for (int y = 0; y < rows; y += kBlockCells) {
    for (int x = 0; x < columns; x += kBlockCells) {
      const int width = std::min(kBlockCells, columns - x), height = std::min(kBlockCells, rows - y);
      const cv::Rect vertices(x, y, width + 1, height + 1);
      if (cv::countNonZero(valid(vertices)) == vertices.area()) {
        add(x, y, width, height);
        continue;
      }
      for (int row = y; row < y + height; ++row) {
        for (int begin = x, end; begin < x + width; begin = end + 1) {
          for (end = begin; end < x + width && cell_valid(valid, end, row);) ++end;
          if (end > begin) add(begin, row, end - begin, 1);
        }
      }
    }
  }
  return grids;
}

void intersect16(const int* active, RTCScene scene, RTCRayHit16* rays) {
#if LANDFIX_EMBREE_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect16(active, scene, rays, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(active, scene, &context, rays);
#endif
}

}  // namespace

struct Surface::Impl {
  Owner<RTCDevice> device;
  Owner<RTCScene> scene;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double lowest_m = 0, highest_m = 0;

  void fill(RTCGeometry geometry, const GridImage& heights, const cv::Mat& valid, const std::vector<RTCGrid>& grids);
};

void Surface::Impl::fill(RTCGeometry geometry, const GridImage& heights, const cv::Mat& valid,
                         const std::vector<RTCGrid>& grids) {
  const cv::Mat& raster = heights.pixels;
  auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                             3 * sizeof(float), raster.total()));
  auto* grid = static_cast<RTCGrid*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(RTCGrid), grids.size()));
  if (!vertex || !grid) throw Error(ExitCode::kInternal, "scene surface: Embree has no memory for the height raster");
  for (int y = 0; y < raster.rows; ++y) {
    for (int x = 0; x < raster.cols; ++x, vertex += 3) {
      vertex[0] = float(heights.west_m + (x + 0.5) * heights.gsd_m - origin.x());
      vertex[1] = float(heights.north_m - (y + 0.5) * heights.gsd_m - origin.y());
      vertex[2] = valid.at<uchar>(y, x) ? float(raster.at<float>(y, x) - origin.z()) : 0.0f;
    }
  }
  std::copy(grids.begin(), grids.end(), grid);
}

Surface::Surface(const GridImage& heights) : impl_(std::make_unique<Impl>()) {
  const cv::Mat& raster = heights.pixels;
  if (raster.type() != CV_32FC1 || raster.cols < 2 || raster.rows < 2) {
    throw Error(ExitCode::kBadInput, "scene surface: expected a raster of at least 2x2 heights in 32-bit floats");
  }
  const cv::Mat valid = valid_heights(heights);
  const std::vector<RTCGrid> grids = grids_over(valid);
  if (grids.empty()) throw Error(ExitCode::kBadInput, "scene surface: the height raster holds no data here");
  cv::minMaxLoc(raster, &impl_->lowest_m, &impl_->highest_m, nullptr, nullptr, valid);
  impl_->origin = {heights.west_m + 0.5 * raster.cols * heights.gsd_m,
                   heights.north_m - 0.5 * raster.rows * heights.gsd_m, 0.5 * (impl_->lowest_m + impl_->highest_m)};

  impl_->device.reset(rtcNewDevice(nullptr));
  if (!impl_->device) throw Error(ExitCode::kInternal, "scene surface: Embree does not start on this machine");
  impl_->scene.reset(rtcNewScene(impl_->device.get()));
  rtcSetSceneFlags(impl_->scene.get(), RTC_SCENE_FLAG_ROBUST);  // no ray slips through between two triangles
  const Owner<RTCGeometry> geometry(rtcNewGeometry(impl_->device.get(), RTC_GEOMETRY_TYPE_GRID));
  impl_->fill(geometry.get(), heights, valid, grids);
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometry(impl_->scene.get(), geometry.get());
  rtcCommitScene(impl_->scene.get());
  if (const RTCError error = rtcGetDeviceError(impl_->device.get()); error != RTC_ERROR_NONE) {
    throw Error(ExitCode::kInternal, "scene surface: Embree reports error " + std::to_string(int(error)));
  }
}

Surface::~Surface() = default;
Surface::Surface(Surface&&) noexcept = default;
Surface& Surface::operator=(Surface&&) noexcept = default;

double Surface::lowest_m() const { return impl_->lowest_m; }
double Surface::highest_m() const { return impl_->highest_m; }

Surface::Distances Surface::intersect(const Eigen::Vector3d& origin, const Directions& directions, int count) const {
  const Eigen::Vector3f local = (origin - impl_->origin).cast<float>();
  alignas(64) RTCRayHit16 rays = {};
  alignas(64) int active[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    active[i] = i < count ? -1 : 0;
    rays.ray.org_x[i] = local.x();
    rays.ray.org_y[i] = local.y();
    rays.ray.org_z[i] = local.z();
    rays.ray.dir_x[i] = directions[size_t(i)].x();
    rays.ray.dir_y[i] = directions[size_t(i)].y();
    rays.ray.dir_z[i] = directions[size_t(i)].z();
    rays.ray.tfar[i] = std::numeric_limits<float>::infinity();
    rays.ray.mask[i] = ~0u;
    rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
  }
  intersect16(active, impl_->scene.get(), &rays);
  Distances distances;
  for (int i = 0; i < kPacket; ++i) {
    const bool hit = i < count && rays.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    distances[size_t(i)] = hit ? rays.ray.tfar[i] : -1.0f;
  }
  return distances;
}

}  // namespace landfix::terrain

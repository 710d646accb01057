#include "tools/eval/photos.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "builder/error.h"
#include "runtime/nav/pack_map.h"
#include "runtime/nav/rectify.h"
#include "tools/common/camera_model.h"
#include "tools/common/manifest_json.h"
#include "tools/common/open_pack.h"
#include "tools/common/photo.h"
#include "tools/eval/camera_image.h"

namespace landfix::eval {
namespace {

constexpr int kMaxPatchPx = 800;     ///< a larger footprint is registered at a coarser level
constexpr double kTerrainReach = 3;  ///< heights around the camera that are read, in heights above ground
constexpr double kLeastOutlierM = 5, kOutlierFactor = 3;  ///< distances from the median, in medians of them
constexpr double kSigmas = 3;                             ///< of the prior that the search region is

double median(std::vector<double> values) {
  if (values.empty()) return NAN;
  const auto middle = values.begin() + ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double distance(const Place& a, const Place& b) { return std::hypot(a.east_m - b.east_m, a.north_m - b.north_m); }

/// The mean, without what lies far from the median: one false fix must not move it.
std::optional<Place> common_offset(const std::vector<Place>& offsets) {
  if (offsets.empty()) return std::nullopt;
  std::vector<double> east, north, from_middle;
  for (const Place& o : offsets) east.push_back(o.east_m), north.push_back(o.north_m);
  const Place middle{median(east), median(north)};
  for (const Place& o : offsets) from_middle.push_back(distance(o, middle));
  const double reach = std::max(kLeastOutlierM, kOutlierFactor * median(from_middle));
  Place mean;
  int count = 0;
  for (const Place& o : offsets) {
    if (distance(o, middle) > reach) continue;
    mean.east_m += o.east_m, mean.north_m += o.north_m;
    ++count;
  }
  return Place{mean.east_m / count, mean.north_m / count};
}

/// Heights of the map around a place. The plane is the median height: beyond the map's edge the ground goes on.
nav::Terrain terrain_around(const Pack& pack, const std::string& path, const Place& place, double reach_m) {
  nav::Terrain terrain;
  const lf_info info = pack.info();
  terrain.plane_height_m = info.plane_height_m;
  const Result<uint32_t> layer = pack.find_layer("height");
  if (!info.has_heights || !layer) return terrain;
  const double west = std::max(place.east_m - reach_m, info.west_m),
               east = std::min(place.east_m + reach_m, info.east_m),
               south = std::max(place.north_m - reach_m, info.south_m),
               north = std::min(place.north_m + reach_m, info.north_m);
  if (!(west < east && south < north)) return terrain;
  const Result<lf_level_info> finest = pack.level(*layer, 0);
  tools::check(finest.status(), path);
  const Result<Region> region = pack.box(*layer, west, south, east, north, finest->gsd_m);
  if (region.status() == LF_OUTSIDE_MAP) return terrain;
  tools::check(region.status(), path);
  terrain.heights = tools::read_region(pack, *region, path);
  std::vector<double> known;
  for (int y = 0; y < terrain.heights.pixels.rows; ++y)
    for (int x = 0; x < terrain.heights.pixels.cols; ++x)
      if (terrain.heights.valid.at<uint8_t>(y, x)) known.push_back(terrain.heights.pixels.at<float>(y, x));
  if (!known.empty()) terrain.plane_height_m = median(known);
  return terrain;
}

nav::Status rectify_photo(const cv::Mat& image, const nav::Camera& camera, const nav::Terrain& terrain,
                          const std::pair<double, double>& gsd_range_m, PhotoResult& r) {
  const double camera_gsd_m = r.height_above_ground_m / std::max(camera.fx, camera.fy);
  cv::Point2d reach_m;
  if (const nav::Status s = nav::footprint_reach(camera, r.attitude, r.height_above_ground_m, reach_m);
      s != nav::Status::kOk)
    return s;
  r.gsd_m = level_for(gsd_range_m, camera_gsd_m);
  while (2 * std::max(reach_m.x, reach_m.y) > kMaxPatchPx * r.gsd_m && 2 * r.gsd_m <= gsd_range_m.second) r.gsd_m *= 2;
  const nav::Position position{r.tag.east_m, r.tag.north_m, terrain.plane_height_m + r.height_above_ground_m};
  nav::TerrainUse use;
  if (const nav::Status s = nav::rectify(image, camera, r.attitude, position, terrain, r.gsd_m, r.patch, &use);
      s != nav::Status::kOk)
    return s;
  r.known_heights = use.known;
  nav::GroundPoint centre;
  const Eigen::Vector2d middle(0.5 * (camera.width - 1), 0.5 * (camera.height - 1));
  if (const nav::Status s = nav::ground_point(camera, r.attitude, position, middle, terrain, centre);
      s != nav::Status::kOk)
    return s;
  r.view = {centre.east_m - r.tag.east_m, centre.north_m - r.tag.north_m};
  return nav::Status::kOk;
}

void take(const Trial& trial, const nav::Registration& found, PhotoResult& r) {
  r.milliseconds = trial.milliseconds;
  r.matched = trial.answered();
  if (!r.matched) return;
  r.method = trial.method;
  r.probability = trial.probability;
  r.evidence = trial.evidence;
  r.camera = {trial.east_m, trial.north_m};
  r.covariance_m2 = trial.covariance_m2;
  r.similarity = trial.similarity;
  r.rotation_sigma_rad = found.rotation_sigma_rad;
  r.scale_sigma = found.scale_sigma;
}

/// Why there is no fix.
void refuse(nav::Status status, PhotoResult& r) {
  r.word = word_of(status);
  if (status != nav::Status::kOk) r.reason = nav::to_text(status);
}

/// What the tags say. Throws Error(kBadInput) where they do not say enough.
nav::Camera place_by_tags(const tools::PhotoTags& tags, const tiles::Zone& zone, const PhotoOptions& o, cv::Size size,
                          PhotoResult& r) {
  tools::require_placeable(tags, o.camera.has_value());
  const tools::PhotoPose pose = tools::pose_from_tags(tags, zone);
  const nav::Camera camera = o.camera ? tools::fitted(*o.camera, size, tags.file)
                                      : tools::camera_from_tags(tags, size.width, size.height, &r.camera_source);
  if (o.camera) r.camera_source = "camera model";
  r.tag_place = *tags.place;
  r.convergence_rad = tiles::grid_from_geodetic(zone, *tags.place)->convergence_rad;
  r.tag = {pose.east_m, pose.north_m};
  r.attitude = pose.attitude;
  r.height_above_ground_m = *tags.relative_altitude_m;
  r.placed = true;
  return camera;
}

/// The photograph as it is, or upside down.
void register_picture(const Pack& pack, const nav::Terrain& terrain, const cv::Mat& image, const nav::Camera& camera,
                      const PhotoOptions& o, PhotoResult& r) {
  const nav::PackMap map(pack);
  if (const nav::Status s = rectify_photo(image, camera, terrain, raster_levels(map), r); s != nav::Status::kOk)
    return refuse(s, r);
  Question question;
  const double variance = o.prior_sigma_m * o.prior_sigma_m;
  question.prior.east_m = r.tag.east_m + o.prior_offset_m.x;
  question.prior.north_m = r.tag.north_m + o.prior_offset_m.y;
  question.prior.covariance_m2 = {variance, 0, 0, variance};
  question.prior.sigmas = kSigmas;
  question.prior.heading_sigma_rad = o.heading_sigma_rad;
  question.prior.scale_sigma = o.height_sigma;
  nav::RegistrationOptions options;
  options.method = o.matcher.method;
  options.gate = nav::Gate::kNone;
  nav::Registrar registrar(map, options);
  nav::Registration found;
  take(answer(registrar, r.patch, question, found), found, r);
  refuse(found.status, r);
}

/// Of two answers that exclude each other, the more probable one; each casts doubt on the other. By Bayes' rule from
/// what either says alone.
PhotoResult better(PhotoResult upright, PhotoResult turned) {
  const double p = upright.probability, q = turned.probability;
  const double first = p * (1 - q), second = q * (1 - p), either = first + second + (1 - p) * (1 - q);
  PhotoResult& best = second > first ? turned : upright;
  best.milliseconds = upright.milliseconds + turned.milliseconds;
  if (either > 0) best.probability = std::max(first, second) / either;
  return best;
}

/// Lets a match through, or not.
void pass(nav::Gate gate, PhotoResult& r) {
  r.accepted = r.matched && r.probability >= nav::threshold_of(gate);
  if (r.matched) refuse(r.accepted ? nav::Status::kOk : nav::Status::kImprobable, r);
}

PhotoResult register_photo(const Pack& pack, const std::string& pack_path, const std::string& path,
                           const PhotoOptions& o) {
  PhotoResult r;
  r.name = std::filesystem::path(path).filename().string();
  cv::Mat image;
  nav::Camera camera;
  tools::PhotoTags tags;
  try {
    image = tools::read_photo_pixels(path);
    tags = tools::read_photo_tags(path);
    camera = place_by_tags(tags, tools::zone_of(pack), o, image.size(), r);
  } catch (const Error& e) {
    if (e.code() != ExitCode::kBadInput) throw;
    r.reason = e.what();
    r.word = "unusable";
    return r;
  }
  const double reach_m = kTerrainReach * std::max(r.height_above_ground_m, 1.0);
  const nav::Terrain terrain = terrain_around(pack, pack_path, r.tag, reach_m);
  PhotoResult turned = r;
  register_picture(pack, terrain, image, camera, o, r);
  if (tags.edited) {
    cv::rotate(image, image, cv::ROTATE_180);
    turned.turned = true;
    register_picture(pack, terrain, image, camera, o, turned);
    r = better(r, turned);
  }
  pass(o.gate, r);
  return r;
}

/// Share of the rectified photograph's pixels that meet data of the map, with the camera at `camera`.
double share_on_map(const PhotoResult& r, const nav::MapSource& map, const Place& camera) {
  const features::GridImage& p = r.patch;
  const double west = camera.east_m + p.west_m, north = camera.north_m + p.north_m;
  for (const nav::Method method : nav::kMethods) {
    features::GridImage window;
    const nav::Status status = map.read(nav::layer_of(method), west, north - p.pixels.rows * p.gsd_m,
                                        west + p.pixels.cols * p.gsd_m, north, p.gsd_m, window);
    if (status == nav::Status::kNoLayer) continue;
    if (status != nav::Status::kOk) return 0;
    if (window.valid.empty()) return 1;
    const cv::Mat footprint = p.valid(cv::Rect({0, 0}, window.valid.size()) & cv::Rect({0, 0}, p.valid.size()));
    const cv::Mat covered = window.valid(cv::Rect({0, 0}, footprint.size()));
    return cv::countNonZero(footprint & covered) / double(std::max(cv::countNonZero(footprint), 1));
  }
  return 0;
}

}  // namespace

Place place_of(const PhotoResult& r, double east_m, double north_m) {
  const double c = r.similarity.scale * std::cos(r.similarity.rotation_rad),
               s = r.similarity.scale * std::sin(r.similarity.rotation_rad);
  return {r.camera.east_m + c * east_m + s * north_m, r.camera.north_m - s * east_m + c * north_m};
}

Place PhotoResult::image_centre() const { return place_of(*this, view.east_m, view.north_m); }

PhotoSummary summarize(const std::vector<PhotoResult>& photos) {
  PhotoSummary s;
  std::vector<Place> offsets;
  for (const PhotoResult& r : photos) {
    ++s.photos;
    s.placed += r.placed;
    if (r.accepted) offsets.push_back(r.offset());
  }
  s.accepted = int(offsets.size());
  s.common_offset = common_offset(offsets);
  std::vector<double> residuals;
  for (const PhotoResult& r : photos) {
    s.residuals_m.push_back(r.accepted ? distance(r.offset(), *s.common_offset) : NAN);
    if (r.accepted) residuals.push_back(s.residuals_m.back());
  }
  s.median_residual_m = median(residuals);
  s.largest_residual_m = residuals.empty() ? NAN : *std::max_element(residuals.begin(), residuals.end());
  return s;
}

std::vector<PhotoResult> register_photos(const Pack& pack, const std::string& pack_path,
                                         const std::vector<std::string>& photos, const PhotoOptions& o) {
  std::vector<PhotoResult> out(photos.size());
  tbb::task_arena arena(o.threads > 0 ? o.threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(size_t(0), photos.size(),
                      [&](size_t i) { out[i] = register_photo(pack, pack_path, photos[i], o); });
  });
  const Place common = summarize(out).common_offset.value_or(Place{});
  const nav::PackMap map(pack);
  for (PhotoResult& r : out)
    if (!r.patch.pixels.empty())
      r.on_map = share_on_map(
          r, map, r.accepted ? r.camera : Place{r.tag.east_m + common.east_m, r.tag.north_m + common.north_m});
  return out;
}

}  // namespace landfix::eval

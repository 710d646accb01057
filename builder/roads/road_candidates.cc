#include "builder/roads/road_candidates.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "builder/roads/road_scales.h"

namespace landfix::landmarks {
namespace {

constexpr float kSure = 0.4f;           // a coarse candidate alone
constexpr float kLeastOfCoarse = 0.1f;  // one that only says how wide a road is
constexpr float kSame = 0.6f;           // of the coarse probability: the fine one says the same
constexpr float kAlike_rad = 0.349f;    // 20 degrees
constexpr float kMargin = 0.25f;        // by which a fine one beside is surer
// A coarse place acts on fine ones within its greatest width and 4 pixels, and so do these on it.
constexpr int kCoarseReach = 20, kFineReach = 2 * kCoarseReach;
constexpr float kWide_px = 9;  // of 2 m: a strip wider than those that the fine filter knows
constexpr int kTilePx = 256;   // of evidence
constexpr size_t kTiles = 64;

const RoadModel::Judges& judges_for(const cv::Mat& image, const RoadModel& model) {
  return image.channels() == 1 ? model.gray : model.colour;
}

// One level; what is surely no road is left out, and what lies outside of `wanted`.
std::vector<RoadPlace> places_of_level(const RoadScales& scales, int level, const cv::Rect& wanted,
                                       const RoadModel::Judges& judges, float least) {
  std::vector<RoadPlace> places;
  features::RoadProfile profile;
  RoadScaleProfile at_both;
  for (const features::RoadCandidate& c : scales.candidates(level)) {
    if (!wanted.contains({c.x, c.y})) continue;
    const float width = scales.describe(c, level, profile);
    const float first = judges.first.probability(profile);
    if (first < kLeastOfFirst) continue;
    scales.describe(c, level, profile, at_both);
    float p = judges.second.probability(at_both);
    // Of the widest there is little to learn from: the second judge may doubt, and not reject.
    if (level == 1 && width >= kWide_px) p = std::max(p, first);
    if (p >= least) places.push_back({c.x, c.y, c.theta_rad, p, width});
  }
  return places;
}

cv::Rect grown(const cv::Rect& r, int by) { return {r.x - by, r.y - by, r.width + 2 * by, r.height + 2 * by}; }

// The fine places around a coarse one that point alike.
struct Beside {
  std::vector<int> on_line, aside;
  float same = 0, left = 0, right = 0;  // greatest probability on its line and on its sides
};

Beside look_beside(const RoadPlace& coarse, const std::vector<RoadPlace>& fine, const cv::Mat& index) {
  const float c = std::cos(coarse.theta_rad), s = std::sin(coarse.theta_rad);
  const float reach = coarse.width_px + 4;  // its width is in pixels of 2 m: half of it in pixels of 1 m
  const int r = int(std::ceil(reach)) + 1, x0 = 2 * coarse.x, y0 = 2 * coarse.y;
  Beside b;
  for (int y = std::max(0, y0 - r); y <= std::min(index.rows - 1, y0 + r); ++y) {
    for (int x = std::max(0, x0 - r); x <= std::min(index.cols - 1, x0 + r); ++x) {
      const int i = index.at<int>(y, x);
      if (i < 0) continue;
      const RoadPlace& f = fine[size_t(i)];
      const float dx = float(x - x0) - 0.5f, dy = float(y - y0) - 0.5f;
      const float along = dx * c + dy * s, across = dy * c - dx * s;
      if (dx * dx + dy * dy > reach * reach || std::abs(along) >= 3) continue;
      if (std::abs(std::remainder(f.theta_rad - coarse.theta_rad, std::numbers::pi_v<float>)) >= kAlike_rad) continue;
      const bool same = std::abs(across) <= 2.5f;
      (same ? b.on_line : b.aside).push_back(i);
      float& greatest = same ? b.same : (across > 0 ? b.right : b.left);
      greatest = std::max(greatest, f.probability);
    }
  }
  return b;
}

// Where both sides hold likely lines, the coarse one is what lies between them: the carriageways' markings or edges.
bool replaces(const RoadPlace& coarse, const Beside& b) {
  if (b.same >= kSame * coarse.probability || coarse.probability < kSure) return false;
  const bool both = b.left > 0.3f && b.right > 0.3f;
  return both || std::max(b.left, b.right) <= coarse.probability + kMargin;
}

std::vector<RoadPlace> merge(std::vector<RoadPlace> fine, const std::vector<RoadPlace>& coarse, const cv::Size& size) {
  cv::Mat index(size, CV_32SC1, cv::Scalar(-1));
  for (size_t i = 0; i < fine.size(); ++i) index.at<int>(fine[i].y, fine[i].x) = int(i);
  std::vector<bool> gone(fine.size(), false);
  std::vector<RoadPlace> added;
  for (const RoadPlace& p : coarse) {
    const Beside b = look_beside(p, fine, index);
    const bool wide = p.width_px >= kWide_px, replaced = replaces(p, b);
    for (const int i : b.on_line) {
      if (replaced) gone[size_t(i)] = true;
      // In the middle the fine filter may see the strip between two carriageways.
      if (wide) fine[size_t(i)].width_px = std::max(fine[size_t(i)].width_px, 2 * p.width_px);
    }
    // A wide road explains its edges and carriageways.
    const float sure = std::max(p.probability, b.same);
    for (const int i : b.aside)
      if (replaced || (wide && p.probability >= kSure && fine[size_t(i)].probability < sure)) gone[size_t(i)] = true;
    if (!replaced) continue;
    for (int step = -1; step <= 1; ++step) {  // three in a row, so that they join at 1 m
      const float dx = 0.5f + float(step) * std::cos(p.theta_rad), dy = 0.5f + float(step) * std::sin(p.theta_rad);
      added.push_back(
          {2 * p.x + int(std::lround(dx)), 2 * p.y + int(std::lround(dy)), p.theta_rad, p.probability, 2 * p.width_px});
    }
  }
  std::vector<RoadPlace> out;
  for (size_t i = 0; i < fine.size(); ++i)
    if (!gone[i]) out.push_back(fine[i]);
  out.insert(out.end(), added.begin(), added.end());
  return out;
}

// One per pixel, the surest.
void sort_places(std::vector<RoadPlace>& places) {
  std::sort(places.begin(), places.end(), [](const RoadPlace& a, const RoadPlace& b) {
    return std::tie(a.y, a.x, b.probability, a.theta_rad, a.width_px) <
           std::tie(b.y, b.x, a.probability, b.theta_rad, b.width_px);
  });
  places.erase(std::unique(places.begin(), places.end(),
                           [](const RoadPlace& a, const RoadPlace& b) { return a.x == b.x && a.y == b.y; }),
               places.end());
}

}  // namespace

std::vector<RoadPlace> find_road_places(const cv::Mat& image, const cv::Mat& valid, const cv::Rect& core,
                                        const RoadModel& model) {
  // An even border keeps the pixels of 2 m where they are.
  const cv::Point first(std::max(0, core.x - kRoadHaloPx) & ~1, std::max(0, core.y - kRoadHaloPx) & ~1);
  const cv::Point last(std::min(image.cols, core.br().x + kRoadHaloPx),
                       std::min(image.rows, core.br().y + kRoadHaloPx));
  const cv::Rect block(first, last);
  const cv::Mat seen = image(block), mask = valid.empty() ? valid : valid(block);
  const RoadModel::Judges& judges = judges_for(image, model);
  const cv::Rect inner = core - first, coarse = grown(inner, kCoarseReach);
  const cv::Rect wanted(coarse.x / 2 - 1, coarse.y / 2 - 1, coarse.width / 2 + 2, coarse.height / 2 + 2);
  const RoadScales scales(seen, mask);
  std::vector<RoadPlace> places =
      merge(places_of_level(scales, 0, grown(inner, kFineReach), judges, kLeastRoadProbability),
            places_of_level(scales, 1, wanted, judges, kLeastOfCoarse), seen.size());
  for (RoadPlace& p : places) {
    p.x += first.x;
    p.y += first.y;
  }
  std::erase_if(places, [&](const RoadPlace& p) { return !core.contains({p.x, p.y}); });
  sort_places(places);
  return places;
}

RoadEvidence::RoadEvidence(PixelSource source, const cv::Size& map, const RoadModel& model)
    : source_(std::move(source)), map_(map), model_(model) {}

const RoadEvidence::Tile& RoadEvidence::tile_at(const cv::Point& pixel) {
  const std::pair<int, int> key(pixel.y / kTilePx, pixel.x / kTilePx);
  const auto known = tiles_.find(key);
  if (known != tiles_.end()) {
    known->second.used = ++clock_;
    return known->second;
  }
  if (tiles_.size() >= kTiles) {
    tiles_.erase(std::min_element(tiles_.begin(), tiles_.end(),
                                  [](const auto& a, const auto& b) { return a.second.used < b.second.used; }));
  }
  const cv::Rect core(key.second * kTilePx, key.first * kTilePx, kTilePx, kTilePx);
  const cv::Mat pixels = source_(grown(core, features::kRoadProfileHaloPx) & cv::Rect({0, 0}, map_));
  gray_ = pixels.channels() == 1;
  Tile& tile = tiles_[key];
  features::road_bands(pixels, tile.bands);
  tile.used = ++clock_;
  return tile;
}

float RoadEvidence::operator()(double x, double y, double theta_rad) {
  float greatest = 0;
  features::RoadProfile profile;
  for (int step = -1; step <= 1; ++step) {
    const int px = std::clamp(int(std::lround(x - step * std::sin(theta_rad))), 0, map_.width - 1);
    const int py = std::clamp(int(std::lround(y + step * std::cos(theta_rad))), 0, map_.height - 1);
    const Tile& tile = tile_at({px, py});
    const cv::Point first(std::max(0, px / kTilePx * kTilePx - features::kRoadProfileHaloPx),
                          std::max(0, py / kTilePx * kTilePx - features::kRoadProfileHaloPx));
    features::road_profile(tile.bands, px - first.x, py - first.y, float(theta_rad), profile);
    greatest = std::max(greatest, (gray_ ? model_.gray : model_.colour).first.probability(profile));
  }
  return greatest;
}

}  // namespace landfix::landmarks

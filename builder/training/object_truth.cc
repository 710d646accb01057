#include "builder/training/object_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "builder/error.h"
#include "builder/ingest/vectors.h"
#include "builder/ingest/window.h"
#include "builder/landmarks/extraction.h"
#include "builder/landmarks/kinds.h"
#include "builder/random.h"
#include "builder/training/chips.h"

namespace landfix::landmarks {
namespace {

using ingest::VectorFeature;
using ingest::VectorPart;
using tiles::LandmarkClass;

constexpr uint8_t bit(Cover cover) { return uint8_t(1u << unsigned(cover)); }
constexpr uint8_t kAny = 31;
constexpr double kCrownShare = 0.9;    // of a crown's radius that leaves surely cover
constexpr double kWholeShare = 0.5;    // of intersection over union
constexpr double kDoubtShare = 0.4;    // from here on neither right nor wrong
constexpr double kCentre_px = 3;       // that a building's middle may be off
constexpr double kOverviewGsd_m = 64;  // enough to know where an image lies
constexpr double kAround_m = 60;       // shown around a square whose buildings are known
constexpr int kChipSide_px = 136;      // a chip's labelled middle and what its pixels' numbers depend on

size_t index(LandmarkClass cls) { return size_t(cls); }

/// The parts of a file's features in pixels of an image; (0.5, 0.5) is the middle of the first pixel.
template <typename Take>
void read_parts(const std::string& path, const features::GridImage& image, const tiles::Zone& zone, Take take) {
  const auto pixel = [&](const cv::Point2d& p) {
    return cv::Point2d((p.x - image.west_m) / image.gsd_m, (image.north_m - p.y) / image.gsd_m);
  };
  ingest::read_vectors(path, "", zone, ingest::bounds_of(image), [&](const VectorFeature& feature) {
    for (VectorPart part : feature.parts) {
      for (cv::Point2d& p : part.points) p = pixel(p);
      part.centroid = pixel(part.centroid);
      take(feature.tags, part);
    }
  });
}

void fill(const std::vector<cv::Point2d>& polygon, cv::Mat& mask, int value) {
  constexpr int kFraction = 4;
  std::vector<cv::Point> fixed;
  for (const cv::Point2d& p : polygon)
    fixed.emplace_back(cvRound((p.x - 0.5) * (1 << kFraction)), cvRound((p.y - 0.5) * (1 << kFraction)));
  cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{fixed}, cv::Scalar(value), cv::LINE_8, kFraction);
}

cv::Mat square(int radius) { return cv::Mat::ones(2 * radius + 1, 2 * radius + 1, CV_8U); }

// Numbers of the connected parts of a mask.
cv::Mat parts_of(const cv::Mat& mask) {
  cv::Mat out;
  cv::connectedComponents(mask, out, 4, CV_32S);
  return out;
}

/// Objects of a world as masks and numbers.
struct WorldMasks {
  cv::Mat building, tree, crown_rim, road, water;
};

void forbid(KnownScene& scene, const cv::Mat& where) { scene.allowed.setTo(0, where); }

void draw_world(const std::string& folder, const tiles::Zone& zone, KnownScene& scene, WorldMasks& m) {
  const auto file = [&](const char* kind) { return folder + "/" + kind + ".geojson"; };
  const cv::Size size = scene.image.pixels.size();
  for (cv::Mat* mask : {&m.building, &m.tree, &m.crown_rim, &m.road, &m.water}) *mask = cv::Mat::zeros(size, CV_8U);
  for (const LandmarkClass cls : {LandmarkClass::kBuilding, LandmarkClass::kField})
    scene.objects[index(cls)] = cv::Mat::zeros(size, CV_32S);
  int count = 0;
  read_parts(file("buildings"), scene.image, zone, [&](const ingest::Tags&, const VectorPart& p) {
    fill(p.points, scene.objects[index(LandmarkClass::kBuilding)], ++count);
    fill(p.points, m.building, 255);
  });
  read_parts(file("fields"), scene.image, zone, [&](const ingest::Tags&, const VectorPart& p) {
    fill(p.points, scene.objects[index(LandmarkClass::kField)], ++count);
  });
  read_parts(file("trees"), scene.image, zone, [&](const ingest::Tags& tags, const VectorPart& p) {
    const double radius = metres_of(tags, "radius_m").value_or(2) / scene.image.gsd_m;
    constexpr int kFraction = 4;
    const cv::Point at(cvRound((p.centroid.x - 0.5) * 16), cvRound((p.centroid.y - 0.5) * 16));
    cv::circle(m.tree, at, cvRound(radius * kCrownShare * 16), 255, cv::FILLED, cv::LINE_8, kFraction);
    cv::circle(m.crown_rim, at, cvRound((radius * 1.1 + 0.5) * 16), 255, cv::FILLED, cv::LINE_8, kFraction);
  });
  read_parts(file("roads"), scene.image, zone, [&](const ingest::Tags& tags, const VectorPart& p) {
    const auto kind = tags.find("kind");
    if (kind != tags.end() && kind->second == "track") return;
    std::vector<cv::Point> line;
    for (const cv::Point2d& q : p.points) line.emplace_back(cvRound(q.x - 0.5), cvRound(q.y - 0.5));
    cv::polylines(m.road, line, false, 255,
                  std::max(1, cvRound(metres_of(tags, "width_m").value_or(6) / scene.image.gsd_m)));
  });
  read_parts(file("water"), scene.image, zone,
             [&](const ingest::Tags&, const VectorPart& p) { fill(p.points, m.water, 255); });
}

// The side of a spot's square that is surely roof, and what may be.
void mark_spots(KnownScene& scene) {
  for (const Spot& s : scene.spots)
    cv::circle(scene.allowed, {cvRound(s.middle.x - 0.5), cvRound(s.middle.y - 0.5)},
               cvRound(s.long_px / 2 * 1.25 + 1.5), 0, cv::FILLED);
  for (const Spot& s : scene.spots)
    if (s.sure)
      cv::circle(scene.allowed, {cvRound(s.middle.x - 0.5), cvRound(s.middle.y - 0.5)},
                 std::max(1, int(s.short_px / 2 * 0.85)), bit(Cover::kBuilding), cv::FILLED);
}

std::optional<bool> is_spot(const KnownScene& scene, const Region& r) {
  if ((scene.spotted & r.box) != r.box) return std::nullopt;
  const cv::RotatedRect rect = rectangle_of(r);
  int inside = 0;
  const Spot* nearest = nullptr;
  double distance = std::numeric_limits<double>::max();
  for (const Spot& s : scene.spots) {
    const cv::Point at = cv::Point(int(s.middle.x), int(s.middle.y));
    inside += r.box.contains(at) && r.mask.at<uint8_t>(at - r.box.tl());
    const double d =
        std::hypot(s.middle.x - r.box.x - double(rect.center.x), s.middle.y - r.box.y - double(rect.center.y));
    if (d < distance) distance = d, nearest = &s;
  }
  if (nearest == nullptr) return false;
  const double reach = std::max(4.0, nearest->long_px / 2);
  if (distance > reach + 3) return false;
  if (!nearest->sure) return std::nullopt;
  const double share = r.area_px / nearest->area_px;
  if (inside > 1 || distance > 5 || share < 0.3 || share > 2.5) return false;
  if (distance > 3.5 || share < 0.45 || share > 1.8) return std::nullopt;
  return true;
}

cv::Rect place_of(const KnownScene& scene, const cv::Size& side, Random& random) {
  const cv::Size size = scene.image.pixels.size();
  const cv::Mat& buildings = scene.objects[index(LandmarkClass::kBuilding)];
  const int tries = buildings.empty() ? 1 : 1 + 5 * random.below(2);
  cv::Rect best;
  int most = -1;
  for (int i = 0; i < tries; ++i) {
    const cv::Rect place({random.below(size.width - side.width + 1), random.below(size.height - side.height + 1)},
                         side);
    const int count = buildings.empty() ? 0 : cv::countNonZero(buildings(place) > 0);
    if (count > most) best = place, most = count;
  }
  return best;
}

void vary_tones(cv::Mat& image, Random& random) {
  if (random.chance(0.75)) {
    cv::GaussianBlur(image, image, {7, 7}, random.between(0.3, 1.1));
  } else {
    cv::Mat soft;
    cv::GaussianBlur(image, soft, {5, 5}, 1);
    const double much = random.between(0.2, 0.9);
    cv::addWeighted(image, 1 + much, soft, -much, 0, image);
  }
  const double gamma = random.between(0.7, 1.35), haze = random.chance(0.5) ? random.between(0, 0.45) : 0,
               veil = random.between(140, 230), saturation = random.between(0.3, 1.4),
               gain = random.between(0.65, 1.35), noise = random.between(0, 3.5);
  std::array<double, 3> balance;
  for (double& b : balance) b = gain * std::exp(0.07 * random.normal());
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      cv::Vec3b& c = image.at<cv::Vec3b>(y, x);
      const double mean = (c[0] + c[1] + c[2]) / 3.0, grain = noise * random.normal();
      const double toned = 255 * std::pow(mean / 255, gamma), factor = toned / std::max(mean, 1.0);
      for (int k = 0; k < 3; ++k) {
        const double clear = (toned + (c[k] - mean) * saturation * factor) * balance[size_t(k)];
        c[k] = cv::saturate_cast<uint8_t>(clear * (1 - haze) + veil * haze + grain + 0.5 * noise * random.normal());
      }
    }
  }
}

constexpr int kBareSide_px = 320;

// Noise of deviation 1.
cv::Mat grain(double size_px, Random& random) {
  cv::Mat out(kBareSide_px, kBareSide_px, CV_32FC1);
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x) out.at<float>(y, x) = float(random.normal());
  if (size_px > 0.3) {
    cv::GaussianBlur(out, out, {0, 0}, size_px);
    out *= 2 * size_px;  // a blur takes about as much
  }
  return out;
}

// Tones from -1 to 1 in one direction, that come back every so many pixels: even, in two, or rising.
cv::Mat stripes(double period_px, Random& random) {
  const double angle =
      random.chance(0.5) ? random.below(2) * std::numbers::pi / 2 : random.between(0, std::numbers::pi);
  const double across = std::cos(angle) / period_px, down = std::sin(angle) / period_px, first = random.between(0, 1);
  const int form = random.below(3);
  cv::Mat out(kBareSide_px, kBareSide_px, CV_32FC1);
  for (int y = 0; y < out.rows; ++y) {
    for (int x = 0; x < out.cols; ++x) {
      const double at = first + across * x + down * y, phase = at - std::floor(at);
      out.at<float>(y, x) = float(form == 0   ? std::sin(2 * std::numbers::pi * phase)
                                  : form == 1 ? (phase < 0.5 ? -1 : 1)
                                              : 2 * phase - 1);
    }
  }
  return out;
}

// Cells of one tone each.
cv::Mat mosaic(double cell_px, Random& random) {
  const int across = int(kBareSide_px / cell_px) + 1;
  cv::Mat tones(across, across, CV_32FC1), out;
  for (int y = 0; y < across; ++y)
    for (int x = 0; x < across; ++x) tones.at<float>(y, x) = float(random.normal());
  cv::resize(tones, out, {}, cell_px, cell_px, cv::INTER_NEAREST);
  return out(cv::Rect(0, 0, kBareSide_px, kBareSide_px));
}

// What repeats, as weaving does, cells of both directions smaller than houses; or even noise.
cv::Mat pattern(Random& random) {
  constexpr double kLeast_px = 2, kMostCell_px = 9, kMostStripe_px = 60;
  const int kind = random.below(5);
  if (kind == 0) return stripes(random.between(kLeast_px, kMostStripe_px), random);
  if (kind == 1) return mosaic(random.below(int(kMostCell_px) - 1) + 1, random);
  if (kind == 2) return grain(random.between(0, 3), random);
  const cv::Mat one = stripes(random.between(kLeast_px, kMostCell_px), random),
                other = stripes(random.between(kLeast_px, kMostCell_px), random);
  return kind == 3 ? cv::Mat(0.7 * (one + other)) : one.mul(other);
}

KnownScene without_objects(const std::string& name, const cv::Mat& tones, const cv::Scalar& colour) {
  KnownScene out;
  out.name = name;
  std::array<cv::Mat, 3> bands;
  for (size_t k = 0; k < 3; ++k) cv::Mat(tones + colour[int(k)]).convertTo(bands[k], CV_8U);
  cv::merge(bands, out.image.pixels);
  out.image.gsd_m = kLandmarkGsd_m;
  out.allowed = cv::Mat(tones.size(), CV_8UC1, cv::Scalar(bit(Cover::kGround) | bit(Cover::kTree)));
  for (cv::Mat& objects : out.objects) objects = cv::Mat::zeros(tones.size(), CV_32SC1);
  return out;
}

}  // namespace

KnownScene read_known_world(const std::string& folder) {
  KnownScene scene;
  scene.name = folder;
  const tiles::Zone zone = ingest::standard_zone_of(folder + "/ortho.tif");
  scene.image = ingest::load_image({.path = folder + "/ortho.tif"}, zone, std::nullopt, kLandmarkGsd_m);
  if (scene.image.pixels.channels() != 3)
    throw Error(ExitCode::kBadInput, folder + "/ortho.tif: expected red, green and blue");
  WorldMasks m;
  draw_world(folder, zone, scene, m);
  scene.allowed = cv::Mat(scene.image.pixels.size(), CV_8U, cv::Scalar(bit(Cover::kGround)));
  scene.allowed.setTo(bit(Cover::kPaved), m.road);
  scene.allowed.setTo(bit(Cover::kWater), m.water);
  scene.allowed.setTo(bit(Cover::kBuilding), m.building);
  for (const cv::Mat* mask : {&m.road, &m.water, &m.building}) {  // rims are mixed
    cv::Mat wide, narrow;
    cv::dilate(*mask, wide, square(1));
    cv::erode(*mask, narrow, square(1));
    forbid(scene, wide & ~narrow);
  }
  forbid(scene, m.crown_rim);
  scene.allowed.setTo(bit(Cover::kTree), m.tree & ~m.building);
  scene.objects[index(LandmarkClass::kField)].setTo(0, m.crown_rim | m.building | m.water);
  scene.objects[index(LandmarkClass::kBuilding)].setTo(0, m.tree);
  scene.objects[index(LandmarkClass::kTree)] = parts_of(m.tree);
  scene.objects[index(LandmarkClass::kWater)] = parts_of(m.water);
  return scene;
}

KnownScene read_known_area(const std::string& image, const std::string& points, const std::string& extent) {
  KnownScene scene;
  scene.name = points;
  const tiles::Zone zone = ingest::standard_zone_of(image);
  const features::GridImage overview = ingest::load_image({.path = image}, zone, std::nullopt, kOverviewGsd_m);
  cv::Rect2d box;  // easting and northing
  read_parts(extent, overview, zone, [&](const ingest::Tags&, const VectorPart& p) {
    for (const cv::Point2d& q : p.points) {
      const cv::Rect2d one(overview.west_m + q.x * overview.gsd_m, overview.north_m - q.y * overview.gsd_m, 1e-6, 1e-6);
      box = box.empty() ? one : box | one;
    }
  });
  const ingest::GridBounds bounds = {box.x - kAround_m, box.y - kAround_m, box.x + box.width + kAround_m,
                                     box.y + box.height + kAround_m};
  scene.image = ingest::load_image({.path = image}, zone, bounds, kLandmarkGsd_m);
  const cv::Point corner(cvRound(box.x - scene.image.west_m), cvRound(scene.image.north_m - box.y - box.height));
  scene.spotted =
      cv::Rect(corner, cv::Size(cvRound(box.width), cvRound(box.height))) & cv::Rect({}, scene.image.pixels.size());
  read_parts(points, scene.image, zone, [&](const ingest::Tags& tags, const VectorPart& p) {
    if (const auto kind = tags.find("kind"); kind == tags.end() || kind->second != "building") return;
    const double width = metres_of(tags, "width_m").value_or(10), length = metres_of(tags, "length_m").value_or(10);
    const auto sure = tags.find("sure");
    scene.spots.push_back({p.centroid, width * length, std::max(width, length), std::min(width, length),
                           sure == tags.end() || sure->second != "0"});
  });
  scene.allowed = cv::Mat::zeros(scene.image.pixels.size(), CV_8U);
  scene.allowed(scene.spotted).setTo(kAny & ~bit(Cover::kBuilding));
  mark_spots(scene);
  return scene;
}

std::vector<KnownScene> read_known_chips(const std::string& csv, const std::string& image,
                                         const std::vector<std::string>& away_from, double margin_m) {
  static const std::map<features::LandmarkLabel, std::pair<int, double>> kMeaning = {
      {features::LandmarkLabel::kBuilding, {bit(Cover::kBuilding), 2.6}},
      {features::LandmarkLabel::kField, {bit(Cover::kGround), 14}},
      {features::LandmarkLabel::kTree, {bit(Cover::kTree) | bit(Cover::kGround), 12}},
      {features::LandmarkLabel::kWater, {bit(Cover::kWater), 12}},
      {features::LandmarkLabel::kPaved, {bit(Cover::kPaved), 8}}};
  const LabelledImage labelled = read_chips(csv, image);
  const tiles::Zone zone = ingest::standard_zone_of(image);
  std::vector<cv::Rect2d> forbidden;  // pixels
  for (const std::string& path : away_from)
    read_parts(path, labelled.image, zone, [&](const ingest::Tags&, const VectorPart& p) {
      cv::Rect2d box(p.points.front(), cv::Size2d(1e-6, 1e-6));
      for (const cv::Point2d& q : p.points) box |= cv::Rect2d(q, cv::Size2d(1e-6, 1e-6));
      forbidden.push_back({box.x - margin_m, box.y - margin_m, box.width + 2 * margin_m, box.height + 2 * margin_m});
    });
  std::vector<KnownScene> out;
  for (const Chip& chip : labelled.chips) {
    const auto meaning = kMeaning.find(chip.label);
    const cv::Point2d at(labelled.image.column_of(chip.east_m), labelled.image.row_of(chip.north_m));
    if (meaning == kMeaning.end() ||
        std::any_of(forbidden.begin(), forbidden.end(), [&](const cv::Rect2d& r) { return r.contains(at); }))
      continue;
    const cv::Rect box =
        cv::Rect(cvRound(at.x) - kChipSide_px / 2, cvRound(at.y) - kChipSide_px / 2, kChipSide_px, kChipSide_px) &
        cv::Rect({}, labelled.image.pixels.size());
    KnownScene scene;
    scene.name = chip.id;
    scene.image.pixels = labelled.image.pixels(box).clone();
    if (!labelled.image.valid.empty()) scene.image.valid = labelled.image.valid(box).clone();
    scene.allowed = cv::Mat::zeros(box.size(), CV_8U);
    cv::circle(scene.allowed, cv::Point(cvRound(at.x), cvRound(at.y)) - box.tl(), cvRound(meaning->second.second),
               meaning->second.first, cv::FILLED);
    out.push_back(std::move(scene));
  }
  return out;
}

std::optional<bool> is_whole(const KnownScene& scene, const Region& r) {
  const cv::Mat& objects = scene.objects[index(r.cls)];
  if (objects.empty())
    return r.cls == LandmarkClass::kBuilding && !scene.spotted.empty() ? is_spot(scene, r) : std::nullopt;
  std::map<int, int> shared;
  for (int y = 0; y < r.box.height; ++y)
    for (int x = 0; x < r.box.width; ++x)
      if (r.mask.at<uint8_t>(y, x)) ++shared[objects.at<int>(r.box.y + y, r.box.x + x)];
  int best = 0, most = 0;
  for (const auto& [id, count] : shared)
    if (id > 0 && count > most) best = id, most = count;
  if (best == 0) return false;
  // No object that is worth comparing reaches further than the region's own size around it.
  const cv::Rect wide = cv::Rect(r.box.x - r.box.width, r.box.y - r.box.height, 3 * r.box.width, 3 * r.box.height) &
                        cv::Rect({}, objects.size());
  const cv::Mat whole = objects(wide) == best;
  const int area = cv::countNonZero(whole);
  const double share = double(most) / (r.area_px + area - most);
  if (share < kDoubtShare) return false;
  if (share < kWholeShare) return std::nullopt;
  if (r.cls != LandmarkClass::kBuilding) return true;
  Region truth = r;
  truth.box = wide;
  truth.mask = whole / 255;
  const cv::Point2f off = rectangle_of(r).center - rectangle_of(truth).center + cv::Point2f(r.box.tl() - wide.tl());
  return std::hypot(double(off.x), double(off.y)) <= kCentre_px;
}

KnownScene varied(const KnownScene& scene, int side, uint64_t seed) {
  Random random(seed);
  const cv::Size size(std::min(side, scene.image.pixels.cols), std::min(side, scene.image.pixels.rows));
  const cv::Rect place = place_of(scene, size, random);
  KnownScene out;
  out.name = scene.name;
  out.image.pixels = scene.image.pixels(place).clone();
  if (!scene.image.valid.empty()) out.image.valid = scene.image.valid(place).clone();
  out.allowed = scene.allowed(place).clone();
  for (size_t k = 0; k < tiles::kLandmarkClasses; ++k)
    if (!scene.objects[k].empty()) out.objects[k] = scene.objects[k](place).clone();
  vary_tones(out.image.pixels, random);
  out.spots = scene.spots;
  for (Spot& s : out.spots) s.middle -= cv::Point2d(place.tl());
  if (!scene.spotted.empty()) out.spotted = (scene.spotted & place) - place.tl();
  return out;
}

KnownScene bare_scene(uint64_t seed) {
  Random random(seed);
  const double roughness = random.between(4, 45), grain_px = random.between(0, 3);
  const cv::Scalar colour(random.between(30, 190), random.between(40, 190), random.between(25, 170));
  return without_objects(fmt::format("bare {}", seed), grain(grain_px, random) * roughness, colour);
}

KnownScene pattern_scene(uint64_t seed) {
  Random random(seed);
  const cv::Mat tones = pattern(random) * random.between(4, 45);
  const bool gray = random.chance(0.4);
  cv::Scalar colour = cv::Scalar::all(random.between(35, 190));
  for (int k = 1; k < 3 && !gray; ++k) colour[k] = random.between(35, 190);
  KnownScene out = without_objects(fmt::format("pattern {}", seed), tones, colour);
  out.allowed.setTo(bit(Cover::kGround));
  out.only_colour = true;
  return out;
}

}  // namespace landfix::landmarks

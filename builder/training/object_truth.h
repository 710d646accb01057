// Images with known objects: what finding landmarks learns from and is calibrated by.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "builder/ingest/bounds.h"
#include "builder/landmarks/object_regions.h"
#include "runtime/features/grid_image.h"

namespace landfix::landmarks {

/// A building that is known by a point in its middle and its rough sides.
struct Spot {
  cv::Point2d middle;  ///< pixels; (0.5, 0.5) is the middle of the first
  double area_px = 0, long_px = 0, short_px = 0;
  bool sure = true;
};

struct KnownScene {
  std::string name;
  features::GridImage image;  ///< CV_8UC3, 1 m per pixel
  cv::Mat allowed;            ///< CV_8UC1: bit k is set where the cover may be k; 0 where nothing is known
  /// Of every class, the objects as numbers from 1 on in CV_32SC1, 0 for none, -1 where nothing is known; empty where
  /// nothing is known at all.
  std::array<cv::Mat, tiles::kLandmarkClasses> objects;
  std::vector<Spot> spots;  ///< buildings, all of them inside of `spotted`
  cv::Rect spotted;
  bool only_colour = false;  ///< teaches nothing about gray images
};

/// A world in `folder` as `landfix synth` writes it. Throws as ingest::load_image and ingest::read_vectors.
KnownScene read_known_world(const std::string& folder);

/// A square of an image in which every building is known: points with `kind` "building", `width_m`, `length_m` and
/// `sure`, and the polygon of the square. Throws likewise.
KnownScene read_known_area(const std::string& image, const std::string& points, const std::string& extent);

/// The surroundings of each labelled chip of an image (read_chips), its middle labelled, but for those within
/// `margin_m` of the squares in `away_from`.
std::vector<KnownScene> read_known_chips(const std::string& csv, const std::string& image,
                                         const std::vector<std::string>& away_from, double margin_m);

/// Ground, water or a closed wood without any landmark: even to rough, in a colour of its own, chosen by `seed`.
KnownScene bare_scene(uint64_t seed);

/// Stripes, waves or small cells, as furrows, vineyards and weaves have them, or noise, often gray, and no landmark.
/// Only for images with colours: without them roofs are told by little else than their tone.
KnownScene pattern_scene(uint64_t seed);

/// Whether a region is one whole object of its class; nullopt where that is not known or neither right nor wrong.
std::optional<bool> is_whole(const KnownScene& scene, const Region& region);

/// A part of the scene, `side` pixels at most, as another camera or season may show it, chosen by `seed`: with another
/// sharpness, contrast, balance of colours, haze and noise. Where there are buildings parts with many are preferred.
KnownScene varied(const KnownScene& scene, int side, uint64_t seed);

}  // namespace landfix::landmarks

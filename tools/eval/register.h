// Registration of templates cut from georeferenced images with a map, at random places.
//
// Protocol: a template of `template_m` is cut at a random place of the camera image, and searched in the square of
// ± `search_m` around the truth. The middle of that square misses the truth by up to half a pixel, so that the truth
// lies anywhere in a pixel of the map and of the search. Templates are wholly inside the image; at least 95 % of the
// square and of what a template at its rim would cover lies on the map.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/eval/camera_image.h"
#include "tools/eval/report.h"

namespace landfix::eval {

struct RegisterOptions {
  double template_m = 320;        ///< side of the template that votes
  double search_m = 320;          ///< to every side of the truth
  double hit_m = 15;              ///< an answer this near to the truth is true
  int samples = 1000;             ///< per camera image and seed
  uint64_t seed = 1;              ///< the first
  int seeds = 5;                  ///< sets of samples
  double rotation_sigma_rad = 0;  ///< of the templates' heading errors; the registrar knows it
  double scale_sigma = 0;         ///< of their relative scale errors; the registrar knows it
  int rim_px = 8;                 ///< beyond the template, for operators that look at neighbours; it does not vote
  std::vector<MatcherChoice> matchers{{}};
  nav::Gate gate = nav::Gate::kStandard;
  int threads = 0;  ///< 0: one per core
};

/// Throws Error(kUsage) naming the option, what was expected and what was found.
void check(const RegisterOptions& options);

/// One map per thread: sources keep buffers.
using OpenMap = std::function<std::unique_ptr<nav::MapSource>()>;

/// All trials of one camera image, by matcher, then seed, then sample; `camera_index` keeps the places of several
/// images apart. But for the times, the same whatever the number of threads. Throws as CameraImage and `check` do,
/// Error(kBadInput) where the template is larger than the image or its search window larger than the map, and
/// Error(kNoData) where no place can be found that both cover.
CameraTrials register_camera(const CameraImage& camera, int camera_index, const MapFrame& frame,
                             const OpenMap& open_map, const RegisterOptions& options);

}  // namespace landfix::eval

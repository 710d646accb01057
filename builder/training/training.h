// Training of the classifier of landmarks: seeded vocabularies, one linear machine per class, calibration on places
// that were held out (DeAngelo 2016 ch. 3; Platt 1999).
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "builder/training/chips.h"
#include "builder/training/confusion.h"
#include "runtime/features/landmark_classifier.h"

namespace landfix::landmarks {

struct TrainingOptions {
  uint64_t seed = 1;
  int words = 128;          ///< of either vocabulary
  int descriptors = 20000;  ///< that a vocabulary is made from
  int variants = 3;         ///< of chips of cameras: turned, scaled by 15 %, mirrored, other light and sharpness
  int drawn_variants = 1;   ///< of chips of drawn worlds
  double penalty = 0.3;     ///< C of the machines, classes balanced
};

/// A patch (CV_8UC3 or CV_8UC1, kPatchPx a side) to learn from.
struct Sample {
  cv::Mat patch;
  features::LandmarkLabel label = features::LandmarkLabel::kNone;
  int place = 0;         ///< over all sources
  bool original = true;  ///< as the image shows it, not a variant of that
};

/// All chips of the images and variants of them, in a fixed order for a seed.
std::vector<Sample> samples_of(const std::vector<LabelledImage>& images, const TrainingOptions& options);

struct HeldOut {
  Judgement colour, gray;  ///< with the images' colours, and without
};

/// Trains on all samples. The places are divided into two halves; machines trained on either half alone are asked about
/// the originals of the other: this calibrates the probabilities, and `held_out` says how they answered. Classes
/// without samples never answer. Throws Error(kBadInput) where fewer than two classes have samples at two places.
features::LandmarkModel train(const std::vector<Sample>& samples, const TrainingOptions& options, HeldOut& held_out);

/// What a model says about chips.
Judgement judge(const features::LandmarkModel& model, const LabelledImage& image);

}  // namespace landfix::landmarks

#include "builder/training/training.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <opencv2/ml.hpp>

#include "builder/error.h"
#include "builder/training/k_means.h"
#include "builder/training/platt.h"
#include "runtime/features/gray.h"

namespace landfix::landmarks {
namespace {

using features::kLandmarkLabels;
using features::kTrainedLabels;
using features::LandmarkBag;

constexpr int kNodes = features::kPoolingNodes.back();  // a side, that count
constexpr int kFirstNode = (kPatchPx / features::kWordStepPx - kNodes) / 2;
constexpr int kMostSteps = 200000;  // of the machines' solver
constexpr double kTolerance = 1e-3;

/// The same ground in other light, through another lens.
cv::Mat in_other_light(const cv::Mat& patch, cv::RNG& random) {
  cv::Mat f, blurred;
  patch.convertTo(f, CV_32F, 1 / 255.0);
  const double lens = random.uniform(0.0, 3.0);
  if (lens < 1) {
    cv::GaussianBlur(f, f, {}, random.uniform(0.4, 1.2));
  } else if (lens < 2) {
    const double more = random.uniform(0.3, 1.2);
    cv::GaussianBlur(f, blurred, {}, 1.2);
    cv::addWeighted(f, 1 + more, blurred, -more, 0, f);
  }
  const double gamma = std::exp(random.uniform(-0.35, 0.35)), brightness = random.uniform(-0.3, 0.3);
  const double saturation = std::exp(random.uniform(-0.4, 0.4)), noise = 0.01 * random.uniform(0.0, 1.0);
  float balance[3];
  for (float& b : balance) b = float(std::exp(random.gaussian(0.06) + brightness));
  const int channels = f.channels();
  for (int y = 0; y < f.rows; ++y) {
    float* p = f.ptr<float>(y);
    for (int x = 0; x < f.cols; ++x, p += channels) {
      float mean = 0;
      for (int c = 0; c < channels; ++c) {
        p[c] = float(std::pow(std::clamp(p[c], 1e-4f, 1.0f), gamma)) * balance[c];
        mean += p[c] / float(channels);
      }
      for (int c = 0; c < channels; ++c) p[c] = float(mean + (p[c] - mean) * saturation + random.gaussian(noise));
    }
  }
  cv::Mat out;
  f.convertTo(out, CV_8U, 255);
  return out;
}

/// Descriptors of a patch's nodes that count: kNodes² rows.
struct Described {
  cv::Mat texture, colour;
};

Described describe(const cv::Mat& patch) {
  features::WordDescriptors descriptors;
  descriptors.prepare(patch, {});
  const int columns = descriptors.columns(), dims = descriptors.colour_dims();
  std::vector<float> texture(size_t(columns) * features::kTextureDims), colour(size_t(columns * dims));
  std::vector<uint8_t> known(static_cast<size_t>(columns));
  Described out;
  for (int j = kFirstNode; j < kFirstNode + kNodes; ++j) {
    descriptors.row(j, texture, colour, known);
    out.texture.push_back(
        cv::Mat(columns, features::kTextureDims, CV_32FC1, texture.data()).rowRange(kFirstNode, kFirstNode + kNodes));
    out.colour.push_back(cv::Mat(columns, dims, CV_32FC1, colour.data()).rowRange(kFirstNode, kFirstNode + kNodes));
  }
  return out;
}

using Chosen = std::vector<size_t>;  // indices of samples

features::Vocabulary vocabulary_of(const std::vector<Described>& described, cv::Mat Described::*part,
                                   const Chosen& chosen, const TrainingOptions& options) {
  cv::RNG random(options.seed);
  cv::Mat drawn;
  for (int i = 0; i < options.descriptors; ++i) {
    const cv::Mat& rows = described[chosen[size_t(random.uniform(0, int(chosen.size())))]].*part;
    drawn.push_back(rows.row(random.uniform(0, rows.rows)));
  }
  return features::Vocabulary(k_means(drawn, options.words, options.seed));
}

cv::Mat histogram_of(const Described& described, const LandmarkBag& bag) {
  std::vector<uint16_t> counts(size_t(bag.features()), 0);
  size_t at = 0;
  std::vector<uint8_t> words(size_t(kNodes) * kNodes);
  for (const auto& [rows, vocabulary] :
       {std::pair(&described.texture, &bag.texture), std::pair(&described.colour, &bag.colour)}) {
    vocabulary->assign({rows->ptr<float>(), rows->total()}, words);
    for (const int nodes : features::kPoolingNodes) {
      const int first = (kNodes - nodes) / 2;
      for (int y = first; y < first + nodes; ++y)
        for (int x = first; x < first + nodes; ++x) ++counts[at + words[size_t(y) * kNodes + size_t(x)]];
      at += size_t(vocabulary->words());
    }
  }
  cv::Mat histogram(1, bag.features(), CV_32FC1);
  features::pooled(counts, bag, {histogram.ptr<float>(), histogram.total()});
  return histogram;
}

/// One class against the rest; classes without samples keep a machine that says no.
void train_machine(const cv::Mat& histograms, const std::vector<bool>& is_class, double penalty, int k,
                   LandmarkBag& bag) {
  cv::Mat labels(histograms.rows, 1, CV_32SC1);
  int yes = 0;
  for (int i = 0; i < histograms.rows; ++i) yes += labels.at<int>(i) = is_class[size_t(i)] ? 1 : 0;
  const int no = histograms.rows - yes;
  bag.bias[size_t(k)] = -1;
  if (yes == 0 || no == 0) return;
  const cv::Ptr<cv::ml::SVM> svm = cv::ml::SVM::create();
  svm->setType(cv::ml::SVM::C_SVC);
  svm->setKernel(cv::ml::SVM::LINEAR);
  svm->setC(penalty);
  svm->setClassWeights(
      cv::Mat((cv::Mat_<double>(2, 1) << histograms.rows / (2.0 * no), histograms.rows / (2.0 * yes))));
  svm->setTermCriteria({cv::TermCriteria::COUNT | cv::TermCriteria::EPS, kMostSteps, kTolerance});
  svm->train(cv::ml::TrainData::create(histograms, cv::ml::ROW_SAMPLE, labels));
  cv::Mat alpha, index;
  const double rho = svm->getDecisionFunction(0, alpha, index);
  const cv::Mat vector = svm->getSupportVectors().row(index.at<int>(0)) * alpha.at<double>(0);
  // The library does not say which class its positive side is: the larger mean is that of the class.
  double mean[2] = {0, 0};
  for (int i = 0; i < histograms.rows; ++i) mean[labels.at<int>(i)] += histograms.row(i).dot(vector);
  const double sign = mean[1] / yes > mean[0] / no ? 1 : -1;
  for (int f = 0; f < bag.features(); ++f) bag.weights.at<float>(f, k) = float(sign * vector.at<float>(f));
  bag.bias[size_t(k)] = float(-sign * rho);
}

using Values = std::array<float, kTrainedLabels>;

/// What machines that were trained on some samples say about others.
LandmarkBag machines_of(const std::vector<Described>& described, const std::vector<Sample>& samples,
                        const Chosen& chosen, const TrainingOptions& options) {
  LandmarkBag bag;
  bag.texture = vocabulary_of(described, &Described::texture, chosen, options);
  bag.colour = vocabulary_of(described, &Described::colour, chosen, options);
  bag.weights = cv::Mat::zeros(bag.features(), int(features::kWeightColumns), CV_32FC1);
  cv::Mat histograms;
  for (const size_t i : chosen) histograms.push_back(histogram_of(described[i], bag));
  for (size_t k = 0; k < kTrainedLabels; ++k) {
    std::vector<bool> is_class;
    for (const size_t i : chosen) is_class.push_back(size_t(samples[i].label) == k);
    train_machine(histograms, is_class, options.penalty, int(k), bag);
  }
  return bag;
}

void calibrate(const std::vector<Values>& values, const std::vector<features::LandmarkLabel>& labels,
               LandmarkBag& bag) {
  for (size_t k = 0; k < kTrainedLabels; ++k) {
    std::vector<double> value;
    std::vector<bool> yes;
    for (size_t i = 0; i < values.size(); ++i) value.push_back(values[i][k]), yes.push_back(size_t(labels[i]) == k);
    const Sigmoid sigmoid = fit_sigmoid(value, yes);
    bag.platt_a[k] = float(sigmoid.a), bag.platt_b[k] = float(sigmoid.b);
  }
}

/// Half of the places of every source: places are shuffled, and every second one goes to either half.
std::vector<bool> second_half(const std::vector<Sample>& samples, uint64_t seed) {
  std::map<int, bool> of_place;
  for (const Sample& s : samples) of_place[s.place] = false;
  std::vector<int> places;
  for (const auto& [place, half] : of_place) places.push_back(place);
  cv::RNG random(seed);
  for (size_t i = places.size(); i > 1; --i) std::swap(places[i - 1], places[size_t(random.uniform(0, int(i)))]);
  for (size_t i = 0; i < places.size(); ++i) of_place[places[i]] = i % 2 == 1;
  std::vector<bool> out;
  for (const Sample& s : samples) out.push_back(of_place[s.place]);
  return out;
}

LandmarkBag train_bag(const std::vector<Sample>& samples, const TrainingOptions& options, Judgement& held_out) {
  std::vector<Described> described;
  for (const Sample& s : samples) described.push_back(describe(s.patch));
  const std::vector<bool> second = second_half(samples, options.seed);
  std::vector<Values> values;
  std::vector<features::LandmarkLabel> labels;
  for (const bool trained_on : {false, true}) {
    Chosen chosen;
    for (size_t i = 0; i < samples.size(); ++i)
      if (second[i] == trained_on) chosen.push_back(i);
    if (chosen.empty()) throw Error(ExitCode::kBadInput, "training: all chips show one place; label several");
    const LandmarkBag bag = machines_of(described, samples, chosen, options);
    for (size_t i = 0; i < samples.size(); ++i) {
      if (second[i] == trained_on || !samples[i].original) continue;
      const cv::Mat histogram = histogram_of(described[i], bag);
      values.push_back(values_of(bag, {histogram.ptr<float>(), histogram.total()}));
      labels.push_back(samples[i].label);
    }
  }
  Chosen all(samples.size());
  for (size_t i = 0; i < all.size(); ++i) all[i] = i;
  LandmarkBag bag = machines_of(described, samples, all, options);
  calibrate(values, labels, bag);
  for (size_t i = 0; i < values.size(); ++i) held_out.add(labels[i], answer_of(bag, values[i]));
  return bag;
}

void require_classes(const std::vector<Sample>& samples) {
  std::array<std::vector<int>, kLandmarkLabels> places;
  for (const Sample& s : samples) places[size_t(s.label)].push_back(s.place);
  int usable = 0;
  for (const auto& of_class : places)
    usable += !of_class.empty() && *std::min_element(of_class.begin(), of_class.end()) !=
                                       *std::max_element(of_class.begin(), of_class.end());
  if (usable < 2)
    throw Error(ExitCode::kBadInput,
                "training: expected chips of at least two classes, each at two places or more; label more");
}

}  // namespace

std::vector<Sample> samples_of(const std::vector<LabelledImage>& images, const TrainingOptions& options) {
  std::vector<Sample> samples;
  cv::RNG random(options.seed);
  int first_place = 0;
  for (const LabelledImage& image : images) {
    int last = 0;
    for (const Chip& chip : image.chips) {
      const int place = first_place + chip.place;
      last = std::max(last, chip.place);
      samples.push_back({patch_at(image.image, chip.east_m, chip.north_m), chip.label, place, true});
      for (int v = 0; v < (image.drawn ? options.drawn_variants : options.variants); ++v) {
        Warp warp;
        warp.angle_rad = random.uniform(0.0, 2 * CV_PI);
        warp.scale = std::exp(random.uniform(-0.15, 0.15));
        warp.mirrored = random.uniform(0, 2) == 1;
        const cv::Mat patch = patch_at(image.image, chip.east_m, chip.north_m, warp);
        samples.push_back({in_other_light(patch, random), chip.label, place, false});
      }
    }
    first_place += last + 1;
  }
  return samples;
}

features::LandmarkModel train(const std::vector<Sample>& samples, const TrainingOptions& options, HeldOut& held_out) {
  held_out = {};
  std::vector<Sample> coloured, gray = samples;
  for (const Sample& s : samples)
    if (s.patch.channels() == 3) coloured.push_back(s);
  require_classes(coloured);
  for (Sample& s : gray) s.patch = features::gray_from_rgb(s.patch);
  features::LandmarkModel model;
  model.colour = train_bag(coloured, options, held_out.colour);
  model.gray = train_bag(gray, options, held_out.gray);
  return model;
}

Judgement judge(const features::LandmarkModel& model, const LabelledImage& image) {
  Judgement judgement;
  features::LandmarkClassifier classifier(model);
  constexpr int kMiddle = kPatchPx / features::kWordStepPx / 2;
  for (const Chip& chip : image.chips) {
    features::LandmarkAnswer answer;
    const cv::Mat patch = patch_at(image.image, chip.east_m, chip.north_m);
    if (classifier.prepare(patch, {}, false) != features::ClassifierStatus::kOk ||
        classifier.classify(kMiddle, kMiddle, answer) != features::ClassifierStatus::kOk)
      throw Error(ExitCode::kInternal, image.name + ": chip " + chip.id + " cannot be classified");
    judgement.add(chip.label, answer);
  }
  return judgement;
}

}  // namespace landfix::landmarks

#include "tools/eval/pairs.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "builder/error.h"
#include "runtime/nav/image_map.h"
#include "tools/common/photo.h"

namespace landfix::eval {
namespace {

namespace fs = std::filesystem;
constexpr double kSigmas = 3;  ///< of the prior that the whole image is

struct Pair {
  std::string name;
  cv::Mat sides[2];
};

std::set<std::string> names_in(const std::string& folder) {
  static const std::set<std::string> kImages = {".png", ".jpg", ".jpeg", ".tif", ".tiff"};
  std::error_code error;
  std::set<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (kImages.contains(extension)) names.insert(entry.path().filename().string());
  }
  if (error) throw Error(ExitCode::kIo, folder + ": the folder cannot be read: " + error.message());
  if (names.empty())
    throw Error(ExitCode::kBadInput, folder + ": expected images (.png, .jpg, .tif) in this folder, found none");
  return names;
}

std::vector<Pair> load(const std::string& a, const std::string& b, int template_px) {
  const std::set<std::string> names = names_in(a), others = names_in(b);
  std::vector<std::string> alone;
  std::set_symmetric_difference(names.begin(), names.end(), others.begin(), others.end(), std::back_inserter(alone));
  if (!alone.empty())
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: it is in only one of {} and {}; pairs have the same file name", alone.front(), a, b));
  std::vector<Pair> pairs;
  for (const std::string& name : names) {
    const std::string paths[2] = {(fs::path(a) / name).string(), (fs::path(b) / name).string()};
    Pair pair{name, {tools::read_photo_pixels(paths[0]), tools::read_photo_pixels(paths[1])}};
    const cv::Size first = pair.sides[0].size(), second = pair.sides[1].size();
    if (first != second)
      throw Error(
          ExitCode::kBadInput,
          fmt::format("{}: expected {}x{} pixels as {} has, found {}x{}; the sides of a pair show the same area",
                      paths[1], first.width, first.height, paths[0], second.width, second.height));
    if (template_px > std::min(first.width, first.height))
      throw Error(ExitCode::kBadInput, fmt::format("{}: the template of {} pixels is larger than the image ({}x{})",
                                                   paths[0], template_px, first.width, first.height));
    pairs.push_back(pair);
  }
  return pairs;
}

/// The template with its rim; pixels beyond the image are not valid.
features::GridImage cut(const cv::Mat& image, cv::Point corner, int side_px, int rim_px, double gsd_m) {
  const int full = side_px + 2 * rim_px;
  const cv::Rect wanted(corner - cv::Point(rim_px, rim_px), cv::Size(full, full)),
      common = wanted & cv::Rect({0, 0}, image.size());
  features::GridImage patch{cv::Mat::zeros(full, full, image.type()), cv::Mat::zeros(full, full, CV_8U),
                            -0.5 * full * gsd_m, 0.5 * full * gsd_m, gsd_m};
  image(common).copyTo(patch.pixels(common - wanted.tl()));
  patch.valid(common - wanted.tl()).setTo(255);
  return patch;
}

/// All templates of one image in the other, for every matcher.
std::vector<std::vector<Trial>> register_pair(const cv::Mat& camera, const cv::Mat& map_image, const Question& asked,
                                              const PairsOptions& o) {
  const nav::ImageMap map({map_image, {}, 0, 0, o.gsd_m});
  const double free_x = camera.cols - o.template_px, free_y = camera.rows - o.template_px;
  Question question = asked;
  question.hit_m = o.hit_px * o.gsd_m;
  question.prior.east_m = 0.5 * camera.cols * o.gsd_m;
  question.prior.north_m = -0.5 * camera.rows * o.gsd_m;
  question.prior.sigmas = kSigmas;
  question.prior.covariance_m2 = {std::pow(0.5 * free_x * o.gsd_m / kSigmas, 2), 0, 0,
                                  std::pow(0.5 * free_y * o.gsd_m / kSigmas, 2)};
  std::vector<std::vector<Trial>> out;
  for (const MatcherChoice& matcher : o.matchers) {
    nav::RegistrationOptions options;
    options.method = matcher.method;
    options.gate = o.gate;
    options.rim_px = o.rim_px;
    nav::Registrar registrar(map, options);
    nav::Registration found;
    std::vector<Trial>& trials = out.emplace_back();
    for (int row = 0; row < o.placements; ++row)
      for (int column = 0; column < o.placements; ++column) {
        const double steps = std::max(o.placements - 1, 1);
        const cv::Point corner(int(std::lround(free_x * column / steps)), int(std::lround(free_y * row / steps)));
        question.east_m = (corner.x + 0.5 * o.template_px) * o.gsd_m;
        question.north_m = -(corner.y + 0.5 * o.template_px) * o.gsd_m;
        trials.push_back(answer(registrar, cut(camera, corner, o.template_px, o.rim_px, o.gsd_m), question, found));
      }
  }
  return out;
}

}  // namespace

std::vector<CameraTrials> register_pairs(const std::string& a, const std::string& b, const PairsOptions& o) {
  const std::vector<Pair> pairs = load(a, b, o.template_px);
  std::vector<std::vector<std::vector<Trial>>> found(2 * pairs.size());
  tbb::task_arena arena(o.threads > 0 ? o.threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(size_t(0), found.size(), [&](size_t i) {
      const Pair& pair = pairs[i / 2];
      Question question;
      question.camera = pair.name;
      question.block = i / 2;
      found[i] = register_pair(pair.sides[i % 2], pair.sides[1 - i % 2], question, o);
    });
  });
  std::vector<CameraTrials> out = {{"A in B", {}}, {"B in A", {}}};
  for (size_t side = 0; side < 2; ++side)
    for (size_t m = 0; m < o.matchers.size(); ++m) {
      MatcherTrials& all = out[side].matchers.emplace_back(MatcherTrials{o.matchers[m], {}});
      for (size_t i = side; i < found.size(); i += 2)
        all.trials.insert(all.trials.end(), found[i][m].begin(), found[i][m].end());
    }
  return out;
}

}  // namespace landfix::eval

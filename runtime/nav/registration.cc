#include "runtime/nav/registration.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace landfix::nav {
namespace {

using features::GridImage;

constexpr int kMainLobePx = 8;         ///< around the peak: the features' own correlation, no rival
constexpr size_t kPreciseMatches = 2;  ///< similarities that are looked at precisely, of all that were tried
constexpr size_t kCandidates = 4;      ///< peaks of the search that are followed to finer levels
constexpr int kLeastRankedPx = 64;     ///< side of a patch by which similarities are chosen on a coarser level
constexpr double kHopeless = 0.75;     ///< of the highest peak's value: lower ones are not followed
constexpr int kRefineRadiusPx = 3;     ///< around where the coarser level saw it
constexpr int kFinishRadiusPx = 2;     ///< around where the finest level saw it
constexpr int kMostMoves = 3;          ///< half steps of rotation and scale from where the coarser level saw them
constexpr double kStepPx = 2;          ///< that a step of rotation or scale moves the patch's edge, in the search
constexpr double kLeastIndependentPixels = 30;  ///< with fewer, one of a thousand places fits by chance
constexpr int kEnoughPlaces = 200;       ///< outside of the main lobe, to know rivals by: as many as it has itself
constexpr double kChanceSigmas = 3;      ///< that unrelated content hardly exceeds in one place
constexpr double kLargestStretch = 0.5;  ///< of the scale that is searched; of rotation it is half a turn
constexpr double kMostScores = 1e9;      ///< positions × similarities: beyond, the answer would come too late
constexpr double kTypicalScore = 0.4;    ///< of a true match
constexpr double kLargestPenalty = 0.1;
constexpr double kPixelSigma = 0.35;  ///< of a position, in pixels, however sharp the peak

Status check(const GridImage& patch, const RegistrationPrior& p) {
  for (const double v : {p.east_m, p.north_m, p.covariance_m2[0], p.covariance_m2[1], p.covariance_m2[2],
                         p.covariance_m2[3], p.sigmas, p.heading_sigma_rad, p.scale_sigma, patch.west_m, patch.north_m})
    if (!std::isfinite(v)) return Status::kNotFinite;
  const double determinant = p.covariance_m2[0] * p.covariance_m2[3] - p.covariance_m2[1] * p.covariance_m2[2];
  if (p.covariance_m2[0] < 0 || p.covariance_m2[3] < 0 || determinant < -1e-9 * p.covariance_m2[0] * p.covariance_m2[3])
    return Status::kBadValue;
  if (std::abs(p.covariance_m2[1] - p.covariance_m2[2]) > 1e-6 * std::sqrt(p.covariance_m2[0] * p.covariance_m2[3]))
    return Status::kBadValue;
  if (!(p.sigmas > 0) || p.heading_sigma_rad < 0 || p.scale_sigma < 0 || !(patch.gsd_m > 0)) return Status::kBadValue;
  if (patch.pixels.empty() || patch.pixels.depth() != CV_8U) return Status::kBadImage;
  if (patch.pixels.channels() != 1 && patch.pixels.channels() < 3) return Status::kBadImage;
  if (!patch.valid.empty() && (patch.valid.type() != CV_8UC1 || patch.valid.size() != patch.pixels.size()))
    return Status::kBadImage;
  return !patch.valid.empty() && cv::countNonZero(patch.valid) == 0 ? Status::kBadImage : Status::kOk;
}

/// Half as many pixels a side: means of 2×2, valid where all four are.
GridImage halved(const GridImage& in) {
  GridImage out = in;
  const cv::Size size(in.pixels.cols / 2, in.pixels.rows / 2);
  const cv::Rect even(0, 0, 2 * size.width, 2 * size.height);
  out.gsd_m = 2 * in.gsd_m;
  cv::resize(in.pixels(even), out.pixels, size, 0, 0, cv::INTER_AREA);
  if (!in.valid.empty()) {
    cv::resize(in.valid(even), out.valid, size, 0, 0, cv::INTER_AREA);
    cv::compare(out.valid, 255, out.valid, cv::CMP_EQ);
  }
  return out;
}

/// Where a similarity of a search stands: multiples of steps around the prior.
struct Steps {
  double rotation_rad = 0, scale = 0;  ///< 0: not searched
  int rotations = 0, scales = 0;       ///< to either side
  size_t count() const { return size_t(2 * rotations + 1) * size_t(2 * scales + 1); }
};

/// A peak that is followed from level to level.
struct Candidate {
  double east_m = 0, north_m = 0, value = 0;
  Similarity similarity;
};

double parabola_top(double left, double middle, double right) {
  const double curvature = left - 2 * middle + right;
  return curvature < 0 ? std::clamp(0.5 * (left - right) / curvature, -0.5, 0.5) : 0;
}

/// Second derivative of the log likelihood −N/2·log(1 − c²) by a parameter of which c has this curvature at its peak.
double information(double independent_pixels, double value, double curvature) {
  const double c = std::clamp(value, 0.05, 0.95);
  return independent_pixels * c / (1 - c * c) * std::max(-curvature, 0.0);
}

/// Inverse of [[ee, en], [en, nn]], along its own axes at most `ceiling`, and everywhere wider by `floor`.
std::array<double, 4> bounded_inverse(double ee, double en, double nn, double floor, double ceiling) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes((Eigen::Matrix2d() << ee, en, en, nn).finished());
  const Eigen::Vector2d variances = axes.eigenvalues().cwiseMax(1 / ceiling).cwiseInverse();
  const Eigen::Matrix2d out = axes.eigenvectors() * variances.asDiagonal() * axes.eigenvectors().transpose() +
                              floor * Eigen::Matrix2d::Identity();
  return {out(0, 0), out(0, 1), out(1, 0), out(1, 1)};
}

}  // namespace

struct Registrar::State {
  State(const MapSource& source, const RegistrationOptions& o) : map(source), options(o) {}

  /// Patch and window of one level.
  struct Level {
    GridImage image;  ///< the patch with its rim
    GridImage patch, surface;
    GridImage window, near_window;
    int rim_px = 0;
    std::unique_ptr<Matcher> matcher;  ///< keeps the window of the region
    std::unique_ptr<Matcher> other;    ///< for windows around candidates, where that of the region is needed again
    Steps steps;
    Matcher& nearby() const { return steps.count() > 1 ? *other : *matcher; }
  };

  /// A similarity of the grid that is tried, and how well it did.
  struct Trial {
    double value;
    Similarity similarity;
    int row, column;
  };

  void run_auto(const GridImage& patch, const RegistrationPrior& prior, Registration& out);
  Status run_method(Method method, const GridImage& patch, const RegistrationPrior& prior, Registration& out);
  Status make_levels(Method method, const GridImage& patch, const RegistrationPrior& prior);
  Status choose_level(const RegistrationPrior& prior, size_t& chosen) const;
  Status search(Level& level, const RegistrationPrior& prior, Registration& out, std::vector<Candidate>& candidates);
  Status match_all(Level& level, const RegistrationPrior& prior, GridImage& combined, cv::Mat& which,
                   std::vector<Similarity>& similarities);
  Level& level_to_rank(Level& level, const RegistrationPrior& prior);
  std::vector<Similarity> rank(Level& level, const Steps& steps);
  Status refine(Level& level, Candidate& candidate, bool turn);
  Status finish(Level& finest, const Candidate& best, const RegistrationPrior& prior, Registration& out);
  Status refine_all(Level& level, std::vector<Candidate>& candidates, bool turn);
  Status look_again(Level& level, const Similarity& similarity, Registration& out);
  Status read_region(Level& level, const RegistrationPrior& prior);
  void spread_over_region(GridImage& surface) const;
  Status read_window(const Level& level, double west, double south, double east, double north, GridImage& window,
                     Matcher& matcher);
  Status read_around(Level& level, const Candidate& candidate, int radius_px);

  /// What the prior of heading and height takes off the scores of a similarity: −N/2·log(1 − c²) − z²/2 is largest
  /// where about c² − z²/N is.
  double penalty(const Similarity& similarity) const {
    const auto squared = [](double error, double sigma) { return sigma > 0 ? error * error / (sigma * sigma) : 0; };
    const double z2 = squared(similarity.rotation_rad, heading_sigma_rad) + squared(similarity.scale - 1, scale_sigma);
    return std::min(z2 / (2 * kTypicalScore * std::max(independent_pixels, 1.0)), kLargestPenalty);
  }

  const MapSource& map;
  RegistrationOptions options;
  double heading_sigma_rad = 0, scale_sigma = 0;  ///< of the prior
  double independent_pixels = 0;                  ///< at the level of the search
  GridImage region;                               ///< shape of a surface over all of the region searched
  std::vector<Level> levels;                      ///< finest first
  Method method_of_levels = Method::kGray;
};

namespace {

/// Half the search region's sides in metres.
cv::Point2d reach_of(const RegistrationPrior& p) {
  return {p.sigmas * std::sqrt(p.covariance_m2[0]), p.sigmas * std::sqrt(p.covariance_m2[3])};
}

Steps steps_for(const GridImage& patch, const RegistrationPrior& prior, double pose_sigmas) {
  const double step = kStepPx / (0.5 * std::max(patch.pixels.cols, patch.pixels.rows));
  Steps s;
  s.rotation_rad = s.scale = step;
  // Half a step off costs next to nothing: the features are wider than that.
  const auto steps_to = [step](double reach, double most) {
    return std::max(0, int(std::min(std::ceil(reach / step - 0.5), std::floor(most / step))));
  };
  s.rotations = steps_to(pose_sigmas * prior.heading_sigma_rad, std::numbers::pi);
  s.scales = steps_to(pose_sigmas * prior.scale_sigma, kLargestStretch);
  return s;
}

/// Up to `count` local maxima of a surface, highest first, farther from each other than the main lobe.
std::vector<Candidate> highest_peaks(const GridImage& surface, size_t count) {
  cv::Mat around, peaks;
  cv::dilate(surface.pixels, around, cv::Mat());
  peaks = (surface.pixels >= around) & surface.valid;
  std::vector<Candidate> found;
  while (found.size() < count) {
    double value;
    cv::Point at;
    cv::minMaxLoc(surface.pixels, nullptr, &value, nullptr, &at, peaks);
    if (at.x < 0 || peaks.at<uint8_t>(at) == 0) break;
    found.push_back(
        {surface.west_m + (at.x + 0.5) * surface.gsd_m, surface.north_m - (at.y + 0.5) * surface.gsd_m, value, {}});
    cv::circle(peaks, at, kMainLobePx, 0, cv::FILLED);
  }
  return found;
}

/// Puts the scores of one surface into another of its shape where they are higher; returns where they are.
cv::Mat keep_better(const GridImage& from, GridImage& into) {
  const cv::Mat better = (from.pixels > into.pixels) & from.valid;
  from.pixels.copyTo(into.pixels, better);
  into.valid |= from.valid;
  return better;
}

cv::Point pixel_of(const GridImage& image, double east_m, double north_m) {
  return {std::clamp(int(std::lround(image.column_of(east_m))), 0, image.pixels.cols - 1),
          std::clamp(int(std::lround(image.row_of(north_m))), 0, image.pixels.rows - 1)};
}

/// Standard deviation of a surface outside of the main lobe, and the highest score there. Not only local maxima: along
/// a road or a shore the scores fall off so slowly that a place on the flank rivals the peak. Where the region is too
/// small to show rivals, or next to nothing of it is on the map, or the patch says so little that it fits anywhere,
/// what unrelated content scores by chance stands in for them.
double spread_outside(const GridImage& surface, cv::Point top, double independent_pixels, double& rival) {
  cv::Mat outside = surface.valid.clone();
  cv::circle(outside, top, kMainLobePx, 0, cv::FILLED);
  const int places = cv::countNonZero(outside);
  cv::Scalar mean, deviation(0);
  if (places > 0) {
    cv::meanStdDev(surface.pixels, mean, deviation, outside);
    cv::minMaxLoc(surface.pixels, nullptr, &rival, nullptr, nullptr, outside);
  }
  if (places >= kEnoughPlaces && independent_pixels >= kLeastIndependentPixels) return std::max(deviation[0], 1e-6);
  const double by_chance = 1 / std::sqrt(std::max(independent_pixels, 1.0));
  rival = std::max(rival, kChanceSigmas * by_chance);
  return std::max(deviation[0], by_chance);
}

}  // namespace

Status Registrar::State::make_levels(Method method, const GridImage& patch, const RegistrationPrior& prior) {
  const auto [finest, coarsest] = map.gsd_range_m(layer_of(method));
  if (!(finest > 0 && coarsest >= finest)) return Status::kNoLayer;
  GridImage image = patch;
  while (image.gsd_m < finest && image.pixels.cols >= 2 && image.pixels.rows >= 2) image = halved(image);
  const double ratio = std::log2(image.gsd_m / finest);
  if (image.gsd_m < finest || image.gsd_m > coarsest || std::abs(ratio - std::round(ratio)) > 1e-6)
    return Status::kBadValue;
  if (method != method_of_levels) levels.clear();
  method_of_levels = method;
  size_t count = 0;
  while (true) {
    if (levels.size() == count) {
      levels.emplace_back().matcher = make_matcher(method, options.min_coverage);
      levels[count].other = make_matcher(method, options.min_coverage);
    }
    Level& level = levels[count++];
    level.image = image;
    level.rim_px = int(options.rim_px * patch.gsd_m / image.gsd_m);
    if (std::min(image.pixels.cols, image.pixels.rows) <= 2 * level.rim_px) return Status::kBadImage;
    level.patch = without_rim(image, level.rim_px);
    level.steps = steps_for(level.patch, prior, options.pose_sigmas);
    const int side = std::min(level.patch.pixels.cols, level.patch.pixels.rows);
    if (2 * image.gsd_m > coarsest || side / 2 < options.min_template_px) break;
    image = halved(image);
  }
  levels.resize(count);
  return Status::kOk;
}

Status Registrar::State::choose_level(const RegistrationPrior& prior, size_t& chosen) const {
  const cv::Point2d reach = reach_of(prior);
  for (chosen = 0; chosen < levels.size(); ++chosen) {
    const Level& level = levels[chosen];
    const double gsd = level.patch.gsd_m, columns = 2 * reach.x / gsd + 1, rows = 2 * reach.y / gsd + 1;
    const double side = std::max(columns + level.patch.pixels.cols, rows + level.patch.pixels.rows);
    if (columns * rows * double(level.steps.count()) <= options.search_budget_px && side <= options.max_window_px)
      return Status::kOk;
  }
  // The coarsest level is searched whatever it costs, within reason.
  const Level& coarsest = levels[--chosen];
  const double gsd = coarsest.patch.gsd_m, columns = 2 * reach.x / gsd + 1, rows = 2 * reach.y / gsd + 1;
  const bool small = std::max(columns, rows) <= 2.0 * options.max_window_px;
  return small && columns * rows * double(coarsest.steps.count()) <= kMostScores ? Status::kOk : Status::kTooLarge;
}

Status Registrar::State::read_window(const Level& level, double west, double south, double east, double north,
                                     GridImage& window, Matcher& matcher) {
  const GridImage& p = level.patch;
  const Status status =
      map.read(layer_of(method_of_levels), west + p.west_m, south + p.north_m - p.pixels.rows * p.gsd_m,
               east + p.west_m + p.pixels.cols * p.gsd_m, north + p.north_m, p.gsd_m, window);
  if (status != Status::kOk) return status;
  return window.gsd_m == p.gsd_m ? matcher.set_window(window) : Status::kMapError;
}

/// The whole region, less where the patch could not meet enough of the map.
Status Registrar::State::read_region(Level& level, const RegistrationPrior& prior) {
  const cv::Point2d reach = reach_of(prior);
  if (const Status s = read_window(level, prior.east_m - reach.x, prior.north_m - reach.y, prior.east_m + reach.x,
                                   prior.north_m + reach.y, level.window, *level.matcher);
      s != Status::kOk)
    return s;
  prepare_surface(level.patch, level.window, region);
  if (level.window.valid.empty()) return Status::kOk;
  const cv::Size patch = level.patch.pixels.size();
  const int dx = int((1 - options.min_coverage) * patch.width) + 1,
            dy = int((1 - options.min_coverage) * patch.height) + 1;
  cv::Rect useful = cv::boundingRect(level.window.valid);
  useful = cv::Rect(useful.x - dx, useful.y - dy, useful.width + 2 * dx, useful.height + 2 * dy) &
           cv::Rect({0, 0}, level.window.pixels.size());
  if (useful.width < patch.width || useful.height < patch.height) return Status::kOutsideMap;
  if (useful.size() == level.window.pixels.size()) return Status::kOk;
  level.window.west_m += useful.x * level.window.gsd_m;
  level.window.north_m -= useful.y * level.window.gsd_m;
  level.window.pixels = level.window.pixels(useful).clone();
  level.window.valid = level.window.valid(useful).clone();
  return level.matcher->set_window(level.window);
}

/// Brings a surface of a part of the region to its whole: the rest is not on the map, which excludes nothing.
void Registrar::State::spread_over_region(GridImage& surface) const {
  if (surface.pixels.size() == region.pixels.size()) return;
  const cv::Rect part(int(std::lround((surface.west_m - region.west_m) / region.gsd_m)),
                      int(std::lround((region.north_m - surface.north_m) / region.gsd_m)), surface.pixels.cols,
                      surface.pixels.rows);
  GridImage whole = region;
  whole.pixels = cv::Mat::zeros(region.pixels.size(), CV_32F);
  whole.valid = cv::Mat::zeros(region.pixels.size(), CV_8U);
  surface.pixels.copyTo(whole.pixels(part));
  surface.valid.copyTo(whole.valid(part));
  surface = whole;
}

Status Registrar::State::read_around(Level& level, const Candidate& candidate, int radius_px) {
  const double reach = radius_px * level.patch.gsd_m;
  return read_window(level, candidate.east_m - reach, candidate.north_m - reach, candidate.east_m + reach,
                     candidate.north_m + reach, level.near_window, level.nearby());
}

/// Where similarities are compared: one level coarser, if it is fine enough, costs a tenth and shows as well which of
/// them are right.
Registrar::State::Level& Registrar::State::level_to_rank(Level& level, const RegistrationPrior& prior) {
  if (&level == &levels.back()) return level;
  Level& coarser = *(&level + 1);
  if (std::min(coarser.patch.pixels.cols, coarser.patch.pixels.rows) < kLeastRankedPx) return level;
  if (coarser.matcher->set_patch(coarser.image, coarser.rim_px) != Status::kOk) return level;
  const GridImage searched = region;
  const Status status = read_region(coarser, prior);
  region = searched;
  return status == Status::kOk ? coarser : level;
}

/// The similarities with the highest scores, the best first. Every other one of the grid is tried, as on the dark
/// squares of a chessboard, and then the neighbours of the best.
std::vector<Similarity> Registrar::State::rank(Level& level, const Steps& steps) {
  independent_pixels = 0;
  const int columns = 2 * steps.scales + 1, rows = 2 * steps.rotations + 1;
  std::vector<Trial> trials;
  cv::Mat_<uint8_t> tried(rows, columns, uint8_t{0});
  const auto attempt = [&](int row, int column) {
    if (row < 0 || row >= rows || column < 0 || column >= columns || tried(row, column)) return;
    tried(row, column) = 1;
    const Similarity similarity{(row - steps.rotations) * steps.rotation_rad,
                                1 + (column - steps.scales) * steps.scale};
    if (level.matcher->match_fast(similarity, level.surface) != Status::kOk) return;
    double value;
    cv::minMaxLoc(level.surface.pixels, nullptr, &value, nullptr, nullptr, level.surface.valid);
    if (independent_pixels == 0) independent_pixels = level.matcher->independent_pixels();
    trials.push_back({value - penalty(similarity), similarity, row, column});
  };
  const auto sort = [&trials] {
    std::stable_sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) { return a.value > b.value; });
    trials.resize(std::min(trials.size(), kPreciseMatches));
  };
  for (int row = 0; row < rows; ++row)
    for (int column = (row + steps.rotations + steps.scales) % 2; column < columns; column += 2) attempt(row, column);
  sort();
  for (const Trial& best : std::vector<Trial>(trials))
    for (const auto& [down, right] : {std::pair(-1, 0), {0, -1}, {0, 1}, {1, 0}})
      attempt(best.row + down, best.column + right);
  sort();
  std::vector<Similarity> best;
  for (const Trial& trial : trials) best.push_back(trial.similarity);
  if (best.empty()) best.emplace_back();  // the precise match then says what is wrong
  return best;
}

/// The best score over all similarities at every position, and which of them it was.
Status Registrar::State::match_all(Level& level, const RegistrationPrior& prior, GridImage& combined, cv::Mat& which,
                                   std::vector<Similarity>& similarities) {
  const Steps& s = level.steps;
  Status worst = Status::kOutsideMap;
  combined = GridImage();
  for (const Similarity& similarity :
       s.count() > 1 ? rank(level_to_rank(level, prior), s) : std::vector<Similarity>{Similarity()}) {
    const Status status = level.matcher->match(similarity, level.surface);
    if (status != Status::kOk) {
      worst = status;
      continue;
    }
    if (combined.pixels.empty()) independent_pixels = level.matcher->independent_pixels();
    level.surface.pixels -= penalty(similarity);
    if (combined.pixels.empty()) {
      combined = level.surface;
      combined.pixels = level.surface.pixels.clone();
      combined.valid = level.surface.valid.clone();
      which = cv::Mat(combined.pixels.size(), CV_8U, cv::Scalar(0));
    } else {
      which.setTo(double(similarities.size()), keep_better(level.surface, combined));
    }
    similarities.push_back(similarity);
  }
  return combined.pixels.empty() ? worst : Status::kOk;
}

Status Registrar::State::search(Level& level, const RegistrationPrior& prior, Registration& out,
                                std::vector<Candidate>& candidates) {
  if (const Status s = level.matcher->set_patch(level.image, level.rim_px); s != Status::kOk) return s;
  if (const Status s = read_region(level, prior); s != Status::kOk) return s;
  cv::Mat which;
  std::vector<Similarity> similarities;
  if (const Status s = match_all(level, prior, out.surface, which, similarities); s != Status::kOk) return s;
  out.evidence.independent_pixels = independent_pixels;
  out.evidence.similarities = double(level.steps.count());
  out.gsd_m = level.patch.gsd_m;
  candidates = highest_peaks(out.surface, kCandidates);
  if (candidates.empty()) return Status::kOutsideMap;
  for (Candidate& c : candidates)
    c.similarity = similarities[which.at<uint8_t>(pixel_of(out.surface, c.east_m, c.north_m))];
  return Status::kOk;
}

/// Follows a candidate at its own or the next finer level: positions some pixels around and, if `turn`, similarities
/// half a step around.
Status Registrar::State::refine(Level& level, Candidate& candidate, bool turn) {
  if (const Status s = read_around(level, candidate, kRefineRadiusPx); s != Status::kOk) return s;
  const Similarity start = candidate.similarity;
  Similarity best = start;
  if (turn && level.steps.count() > 1) {
    double highest = -2;
    const auto consider = [&](const Similarity& trial) {
      double value;
      if (level.nearby().match_fast(trial, level.surface) != Status::kOk) return;
      cv::minMaxLoc(level.surface.pixels, nullptr, &value, nullptr, nullptr, level.surface.valid);
      value -= penalty(trial);
      if (value > highest) highest = value, best = trial;
    };
    const auto consider_rotations = [&] {
      if (level.steps.rotations == 0) return;
      for (const int r : {-1, 1}) consider({start.rotation_rad + 0.5 * r * level.steps.rotation_rad, best.scale});
    };
    consider(start);
    consider_rotations();
    const double rotation_rad = best.rotation_rad;
    if (level.steps.scales > 0)
      for (const int k : {-1, 1}) consider({rotation_rad, start.scale + 0.5 * k * level.steps.scale});
    if (best.scale != start.scale) consider_rotations();
  }
  if (const Status s = level.nearby().match(best, level.surface); s != Status::kOk) return s;
  const std::vector<Candidate> peak = highest_peaks(level.surface, 1);
  if (peak.empty()) return Status::kOutsideMap;
  candidate = peak[0];
  candidate.value -= penalty(best);
  candidate.similarity = best;
  return Status::kOk;
}

/// Refines all candidates and sorts them, the highest first.
Status Registrar::State::refine_all(Level& level, std::vector<Candidate>& candidates, bool turn) {
  std::vector<Candidate> kept;
  const double hopeless = std::min(kHopeless * candidates[0].value, candidates[0].value);
  for (Candidate& c : candidates)
    if (c.value >= hopeless && refine(level, c, turn) == Status::kOk) kept.push_back(c);
  if (kept.empty()) return Status::kOutsideMap;
  std::stable_sort(kept.begin(), kept.end(), [](const Candidate& a, const Candidate& b) { return a.value > b.value; });
  candidates = kept;
  return Status::kOk;
}

/// Adds the scores of a refined similarity over the whole region: the peak as high as it is, for its gap to the rivals.
Status Registrar::State::look_again(Level& level, const Similarity& similarity, Registration& out) {
  if (const Status s = level.matcher->match(similarity, level.surface); s != Status::kOk) return s;
  level.surface.pixels -= penalty(similarity);
  keep_better(level.surface, out.surface);
  return Status::kOk;
}

/// Sub-pixel position, uncertainties and the refined similarity, from the finest level.
Status Registrar::State::finish(Level& finest, const Candidate& best, const RegistrationPrior& prior,
                                Registration& out) {
  const double gsd = finest.patch.gsd_m;
  if (const Status s = read_around(finest, best, kFinishRadiusPx); s != Status::kOk) return s;
  out.similarity = best.similarity;
  out.rotation_sigma_rad = prior.heading_sigma_rad;
  out.scale_sigma = prior.scale_sigma;
  const auto value_at = [&](const Similarity& similarity) {
    double value = -1;
    if (finest.nearby().match(similarity, finest.surface) == Status::kOk)
      cv::minMaxLoc(finest.surface.pixels, nullptr, &value, nullptr, nullptr, finest.surface.valid);
    return value;
  };
  const double independent = out.evidence.independent_pixels;
  Similarity at = best.similarity;  // on the grid of half steps
  double middle = best.value + penalty(at);
  const auto refine_parameter = [&](double Similarity::*parameter, double step, double& sigma) {
    const auto value_beside = [&](double d) {
      Similarity trial = at;
      trial.*parameter += d;
      return value_at(trial);
    };
    double left = value_beside(-step), right = value_beside(step);
    for (int moves = 0; moves < kMostMoves && std::max(left, right) > middle; ++moves) {
      const bool up = right > left;
      at.*parameter += up ? step : -step;
      (up ? left : right) = middle;
      middle = up ? right : left;
      (up ? right : left) = value_beside(up ? step : -step);
    }
    out.similarity.*parameter = at.*parameter + step * parabola_top(left, middle, right);
    const double info = information(independent, middle, (left - 2 * middle + right) / (step * step));
    sigma = std::min(sigma, std::sqrt(variance_factor(out.method) / std::max(info, 1e-12) + step * step / 16));
  };
  if (finest.steps.rotations > 0)
    refine_parameter(&Similarity::rotation_rad, 0.5 * finest.steps.rotation_rad, out.rotation_sigma_rad);
  if (finest.steps.scales > 0) refine_parameter(&Similarity::scale, 0.5 * finest.steps.scale, out.scale_sigma);

  if (const Status s = finest.nearby().match(out.similarity, finest.surface); s != Status::kOk) return s;
  const cv::Mat& c = finest.surface.pixels;
  cv::Point top;
  double value;
  cv::minMaxLoc(c, nullptr, &value, nullptr, &top, finest.surface.valid);
  const cv::Point centre(std::clamp(top.x, 1, c.cols - 2), std::clamp(top.y, 1, c.rows - 2));
  const auto score = [&](int dx, int dy) { return double(c.at<float>(centre.y + dy, centre.x + dx)); };
  double column = top.x, row = top.y;
  if (top == centre) {
    column += parabola_top(score(-1, 0), value, score(1, 0));
    row += parabola_top(score(0, -1), value, score(0, 1));
  }
  out.peak.east_m = finest.surface.west_m + (column + 0.5) * gsd;
  out.peak.north_m = finest.surface.north_m - (row + 0.5) * gsd;
  const double g2 = gsd * gsd, en = -(score(1, 1) - score(-1, 1) - score(1, -1) + score(-1, -1)) / 4;  // rows run south
  const double scale =
      independent * std::clamp(value, 0.05, 0.95) / (1 - std::min(value, 0.95) * std::min(value, 0.95));
  // By least squares over all nine: of three alone, a sharp crest that runs aslant would look like a summit.
  double ee = 0, nn = 0;
  for (int k = -1; k <= 1; ++k) {
    ee += (2 * score(0, k) - score(-1, k) - score(1, k)) / 3;
    nn += (2 * score(k, 0) - score(k, -1) - score(k, 1)) / 3;
  }
  const double per_m2 = scale / (g2 * variance_factor(out.method));
  out.covariance_m2 = bounded_inverse(per_m2 * ee, -per_m2 * en, per_m2 * nn, kPixelSigma * kPixelSigma * g2,
                                      std::max(prior.covariance_m2[0], prior.covariance_m2[3]) + g2);
  const auto& covariance = out.covariance_m2;
  const double mean = 0.5 * (covariance[0] + covariance[3]), half = 0.5 * (covariance[0] - covariance[3]);
  out.evidence.sigma_px = std::sqrt((mean + std::hypot(half, covariance[1])) / g2);
  return Status::kOk;
}

Status Registrar::State::run_method(Method method, const GridImage& patch, const RegistrationPrior& prior,
                                    Registration& out) {
  out.method = method;
  heading_sigma_rad = prior.heading_sigma_rad;
  scale_sigma = prior.scale_sigma;
  if (const Status s = make_levels(method, patch, prior); s != Status::kOk) return s;
  size_t chosen;
  if (const Status s = choose_level(prior, chosen); s != Status::kOk) return s;
  std::vector<Candidate> candidates;
  if (levels[chosen].steps.count() > 1) levels[chosen].other->set_patch(levels[chosen].image, levels[chosen].rim_px);
  if (const Status s = search(levels[chosen], prior, out, candidates); s != Status::kOk) return s;

  if (levels[chosen].steps.count() > 1) {
    if (const Status s = refine_all(levels[chosen], candidates, true); s != Status::kOk) return s;
    if (const Status s = look_again(levels[chosen], candidates[0].similarity, out); s != Status::kOk) return s;
  }
  // Finer levels tell little more about which peak is true: all candidates go one level down, the best of them on.
  for (size_t i = chosen; i-- > 0;) {
    Level& level = levels[i];
    if (const Status s = level.nearby().set_patch(level.image, level.rim_px); s != Status::kOk) return s;
    // What the finest level could improve of the similarity, finish does.
    if (const Status s = refine_all(level, candidates, i > 0); s != Status::kOk) return s;
    candidates.resize(1);
  }
  if (const Status s = finish(levels[0], candidates[0], prior, out); s != Status::kOk) return s;

  const cv::Point top = pixel_of(out.surface, candidates[0].east_m, candidates[0].north_m);
  double rival = -1;
  out.evidence.spread = spread_outside(out.surface, top, out.evidence.independent_pixels, rival);
  cv::Mat lobe(out.surface.pixels.size(), CV_8U, cv::Scalar(0));
  cv::circle(lobe, top, 2, 255, cv::FILLED);
  cv::minMaxLoc(out.surface.pixels, nullptr, &out.peak.value, nullptr, nullptr, lobe);
  out.peak.gap = out.peak.value - rival;
  out.evidence.value = out.peak.value;
  out.evidence.gap = out.peak.gap;
  out.probability = probability_of(method, out.evidence);
  spread_over_region(out.surface);
  const LikelihoodOptions o{out.evidence.independent_pixels, 0.5 * out.gsd_m, options.outlier_probability};
  return likelihood_from_ncc(out.surface, o, out.likelihood);
}

/// The first of the methods that the map has a layer for and that sees something to compare: orientation survives most.
/// Where it is not sure, the next one is asked too, which may confirm, cast doubt, or be the surer one.
void Registrar::State::run_auto(const GridImage& patch, const RegistrationPrior& prior, Registration& out) {
  out.status = Status::kNoLayer;
  for (const Method method : {Method::kOrientation, Method::kGray, Method::kEdge, Method::kContour}) {
    Registration next;
    next.status = run_method(method, patch, prior, next);
    if (next.status == Status::kNoLayer) continue;
    if (out.status != Status::kOk) {
      const bool first = out.status == Status::kNoLayer;
      if (first || next.status == Status::kOk) out = std::move(next);
      if (out.status == Status::kOk && out.probability >= threshold_of(Gate::kStandard)) return;
      continue;
    }
    if (next.status != Status::kOk) return;
    const double apart_m = std::hypot(next.peak.east_m - out.peak.east_m, next.peak.north_m - out.peak.north_m);
    const bool agree = apart_m <= kMainLobePx * std::max(out.gsd_m, next.gsd_m);
    const double combined = combined_probability(out.probability, next.probability, agree);
    if (!agree && next.probability > out.probability) out = std::move(next);
    out.probability = combined;
    return;
  }
}

Registrar::Registrar(const MapSource& map, const RegistrationOptions& options)
    : state_(std::make_unique<State>(map, options)) {}
Registrar::~Registrar() = default;
Registrar::Registrar(Registrar&&) noexcept = default;
Registrar& Registrar::operator=(Registrar&&) noexcept = default;

const RegistrationOptions& Registrar::options() const { return state_->options; }

void Registrar::run(const GridImage& patch, const RegistrationPrior& prior, Registration& out) {
  out = Registration();
  out.status = check(patch, prior);
  if (out.status != Status::kOk) return;
  try {
    if (state_->options.method)
      out.status = state_->run_method(*state_->options.method, patch, prior, out);
    else
      state_->run_auto(patch, prior, out);
    if (out.status == Status::kOk && out.probability < threshold_of(state_->options.gate))
      out.status = Status::kImprobable;
  } catch (...) {
    out.status = Status::kInternal;
  }
}

}  // namespace landfix::nav

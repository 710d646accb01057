#include "runtime/nav/point_mass_filter.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace landfix::nav {
namespace {

constexpr double kReachSigmas = 5;  ///< of a Gaussian that the grid must hold
constexpr double kTrimTail = 2e-5;  ///< probability beyond each side of the grid that may be dropped to make it smaller
constexpr double kNegligibleTail = 1e-8;  ///< probability beyond which no growth of the grid is worth while
constexpr double kRefineShare =
    0.7;  ///< of the allowed side that a finer grid may take up; below 1 to change back and forth rarely

bool all_finite(std::initializer_list<double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// Weights of a Gaussian on the grid that sum to 1 and keep its variance: below half a squared cell, where samples of
/// the density would lose it, three weights of exactly that variance.
cv::Mat gaussian_kernel(double sigma_cells) {
  const double variance = sigma_cells * sigma_cells;
  if (variance < 0.5) return (cv::Mat_<double>(1, 3) << variance / 2, 1 - variance, variance / 2);
  const int radius = int(std::ceil(kReachSigmas * sigma_cells));
  cv::Mat_<double> kernel(1, 2 * radius + 1);
  for (int i = -radius; i <= radius; ++i) kernel(0, i + radius) = std::exp(-0.5 * i * i / variance);
  return kernel / cv::sum(kernel)[0];
}

/// First and one past the last index, of which at most `tail` of the total lies outside on either side.
std::pair<int, int> core_range(const cv::Mat& marginal, double tail) {
  int first = 0, last = int(marginal.total());
  const double* p = marginal.ptr<double>();
  for (double sum = p[first]; sum < tail && first + 1 < last; sum += p[first]) ++first;
  for (double sum = p[last - 1]; sum < tail && last - 1 > first; sum += p[last - 1]) --last;
  return {first, last};
}

cv::Rect grown(const cv::Rect& r, int by) { return {r.x - by, r.y - by, r.width + 2 * by, r.height + 2 * by}; }

/// Bilinear interpolation along one axis: for each of `n` grid points the lower neighbour in the likelihood and its
/// share; −1 outside.
struct Samples {
  Samples(double first, double step, int n, int size) : index(size_t(n)), upper_share(size_t(n)) {
    for (int i = 0; i < n; ++i) {
      const double at = first + i * step;
      const bool inside = at >= -0.5 && at <= size - 0.5;
      const double clamped = std::clamp(at, 0.0, double(size - 1));
      index[size_t(i)] = inside ? std::min(int(clamped), std::max(size - 2, 0)) : -1;
      upper_share[size_t(i)] = clamped - std::min(std::floor(clamped), double(std::max(size - 2, 0)));
    }
  }
  std::vector<int> index;
  std::vector<double> upper_share;
};

}  // namespace

PointMassFilter::PointMassFilter(const PointMassFilterOptions& options) : options_(options) {}

Status PointMassFilter::start(double east_m, double north_m, double sigma_m) {
  if (!all_finite({east_m, north_m, sigma_m, options_.min_cell_m})) return Status::kNotFinite;
  if (sigma_m < 0 || options_.min_cell_m <= 0 || options_.max_cells < 32) return Status::kBadValue;
  try {
    PointMassFilter fresh(options_);
    fresh.mass_ = cv::Mat(1, 1, CV_64F, cv::Scalar(1));
    fresh.cell_m_ = options_.min_cell_m;
    fresh.west_m_ = east_m;
    fresh.north_m_ = north_m;
    if (const Status status = fresh.predict(0, 0, sigma_m, sigma_m); status != Status::kOk) return status;
    *this = std::move(fresh);
    return Status::kOk;
  } catch (...) {
    return Status::kInternal;
  }
}

Status PointMassFilter::predict(double displacement_east_m, double displacement_north_m, double sigma_east_m,
                                double sigma_north_m) {
  if (!started()) return Status::kNotStarted;
  if (!all_finite({displacement_east_m, displacement_north_m, sigma_east_m, sigma_north_m})) return Status::kNotFinite;
  if (sigma_east_m < 0 || sigma_north_m < 0) return Status::kBadValue;
  try {
    PointMassFilter next = *this;  // shares the masses until they are replaced
    if (const double sigma_m = std::max(sigma_east_m, sigma_north_m); sigma_m > 0) {
      next.fit(kReachSigmas * sigma_m);
      cv::Mat spread;
      cv::sepFilter2D(next.mass_, spread, CV_64F, gaussian_kernel(sigma_east_m / next.cell_m_),
                      gaussian_kernel(sigma_north_m / next.cell_m_), {-1, -1}, 0, cv::BORDER_CONSTANT);
      next.mass_ = spread / cv::sum(spread)[0];
    }
    next.west_m_ += displacement_east_m;
    next.north_m_ += displacement_north_m;
    *this = std::move(next);
    return Status::kOk;
  } catch (...) {
    return Status::kInternal;
  }
}

Status PointMassFilter::update(const Likelihood& likelihood) {
  if (!started()) return Status::kNotStarted;
  const features::GridImage& l = likelihood.values;
  if (l.pixels.empty() || l.pixels.type() != CV_32F) return Status::kBadImage;
  if (!all_finite({l.west_m, l.north_m, l.gsd_m, likelihood.outside}) || !cv::checkRange(l.pixels))
    return Status::kNotFinite;
  double lowest = 0;
  cv::minMaxLoc(l.pixels, &lowest);
  if (!(l.gsd_m > 0) || lowest < 0 || likelihood.outside < 0) return Status::kBadValue;
  try {
    const double step = cell_m_ / l.gsd_m;
    const Samples columns(l.column_of(west_m_), step, mass_.cols, l.pixels.cols);
    const Samples rows(l.row_of(north_m_), step, mass_.rows, l.pixels.rows);
    cv::Mat product(mass_.size(), CV_64F);
    for (int y = 0; y < mass_.rows; ++y) {
      const double* prior = mass_.ptr<double>(y);
      double* posterior = product.ptr<double>(y);
      const int row = rows.index[size_t(y)];
      const float* upper = l.pixels.ptr<float>(std::max(row, 0));
      const float* lower = l.pixels.ptr<float>(std::clamp(row + 1, 0, l.pixels.rows - 1));
      const double b = rows.upper_share[size_t(y)];
      for (int x = 0; x < mass_.cols; ++x) {
        const int c = columns.index[size_t(x)], right = std::min(c + 1, l.pixels.cols - 1);
        const double a = columns.upper_share[size_t(x)];
        posterior[x] = prior[x] * (row < 0 || c < 0 ? likelihood.outside
                                                    : (1 - b) * ((1 - a) * upper[c] + a * upper[right]) +
                                                          b * ((1 - a) * lower[c] + a * lower[right]));
      }
    }
    const double total = cv::sum(product)[0];
    if (!(total > 0) || !std::isfinite(total)) return Status::kLost;
    PointMassFilter next = *this;
    next.mass_ = product / total;
    next.fit(0);
    *this = std::move(next);
    return Status::kOk;
  } catch (...) {
    return Status::kInternal;
  }
}

PointMassFilter::Moments PointMassFilter::moments() const {
  double east = 0, north = 0, ee = 0, en = 0, nn = 0;
  for (int y = 0; y < mass_.rows; ++y)
    for (int x = 0; x < mass_.cols; ++x) {
      east += mass_.at<double>(y, x) * x;
      north -= mass_.at<double>(y, x) * y;
    }
  for (int y = 0; y < mass_.rows; ++y)
    for (int x = 0; x < mass_.cols; ++x) {
      const double p = mass_.at<double>(y, x), de = x - east, dn = -y - north;
      ee += p * de * de;
      en += p * de * dn;
      nn += p * dn * dn;
    }
  const double c2 = cell_m_ * cell_m_, within = c2 / 12;
  return {west_m_ + east * cell_m_, north_m_ + north * cell_m_, {ee * c2 + within, en * c2, en * c2, nn * c2 + within}};
}

PointMassFilter::Bounds PointMassFilter::bounds(double tail_probability) const {
  if (!started()) return {0, 0, 0, 0};
  const cv::Rect b = box(tail_probability);
  return {west_m_ + (b.x - 0.5) * cell_m_, north_m_ - (b.y + b.height - 0.5) * cell_m_,
          west_m_ + (b.x + b.width - 0.5) * cell_m_, north_m_ - (b.y - 0.5) * cell_m_};
}

/// The grid points beyond each side of which lies at most `tail_probability`.
cv::Rect PointMassFilter::box(double tail_probability) const {
  cv::Mat over_columns, over_rows;
  cv::reduce(mass_, over_columns, 0, cv::REDUCE_SUM);
  cv::reduce(mass_, over_rows, 1, cv::REDUCE_SUM);
  const auto [left, right] = core_range(over_columns, tail_probability);
  const auto [top, bottom] = core_range(over_rows, tail_probability);
  return {left, top, right - left, bottom - top};
}

/// Makes the grid hold its probability and a margin around it, as finely as the allowed number of cells permits.
void PointMassFilter::fit(double margin_m) {
  cv::Rect core = box(kTrimTail);
  const auto side = [&](double cell_m) {
    return std::max(core.width, core.height) * (cell_m_ / cell_m) + 2 * (std::ceil(margin_m / cell_m) + 1);
  };
  while (side(cell_m_) > options_.max_cells) {
    crop(core);
    coarsen();
    core = box(kTrimTail);
  }
  while (cell_m_ / 2 >= options_.min_cell_m && side(cell_m_ / 2) <= kRefineShare * options_.max_cells) {
    crop(grown(core, 1));
    refine();
    core = box(kTrimTail);
  }
  const int pad = int(std::ceil(margin_m / cell_m_)) + 1;
  const cv::Rect grid({0, 0}, mass_.size()), needed = grown(core, pad),
                                             wanted = grid | grown(box(kNegligibleTail), pad);
  const bool trim = std::max(wanted.width, wanted.height) > options_.max_cells || 4 * needed.area() < wanted.area();
  crop(trim ? needed : wanted);
}

/// Another rectangle of the same grid; points that were not there have no mass, and what is left sums to 1 again.
void PointMassFilter::crop(const cv::Rect& target) {
  const cv::Rect grid({0, 0}, mass_.size());
  if (target == grid) return;
  cv::Mat next = cv::Mat::zeros(target.size(), CV_64F);
  const cv::Rect common = target & grid;
  mass_(common).copyTo(next(common - target.tl()));
  mass_ = next / cv::sum(next)[0];
  west_m_ += target.x * cell_m_;
  north_m_ -= target.y * cell_m_;
}

/// Every second point is left; the mass of each other one goes to its neighbours in halves, which keeps total and mean.
void PointMassFilter::coarsen() {
  crop(grown({{0, 0}, mass_.size()}, 1));  // so that the neighbours of the rim exist
  const cv::Mat halves = (cv::Mat_<double>(1, 3) << 0.5, 1, 0.5);
  cv::Mat shared;
  cv::sepFilter2D(mass_, shared, CV_64F, halves, halves, {-1, -1}, 0, cv::BORDER_CONSTANT);
  cv::Mat next((mass_.rows + 1) / 2, (mass_.cols + 1) / 2, CV_64F);
  for (int y = 0; y < next.rows; ++y)
    for (int x = 0; x < next.cols; ++x) next.at<double>(y, x) = shared.at<double>(2 * y, 2 * x);
  mass_ = next / cv::sum(next)[0];
  cell_m_ *= 2;
}

/// Points between the points, by bilinear interpolation, which keeps total and mean.
void PointMassFilter::refine() {
  cv::Mat next = cv::Mat::zeros(2 * mass_.rows + 1, 2 * mass_.cols + 1, CV_64F);
  for (int y = 0; y < mass_.rows; ++y)
    for (int x = 0; x < mass_.cols; ++x) next.at<double>(2 * y + 1, 2 * x + 1) = mass_.at<double>(y, x);
  const cv::Mat halves = (cv::Mat_<double>(1, 3) << 0.25, 0.5, 0.25);
  cv::sepFilter2D(next, mass_, CV_64F, halves, halves, {-1, -1}, 0, cv::BORDER_CONSTANT);
  cell_m_ /= 2;
  west_m_ -= cell_m_;
  north_m_ += cell_m_;
}

}  // namespace landfix::nav

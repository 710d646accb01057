#include "builder/ingest/alignment.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "runtime/features/orientation.h"
#include "runtime/features/vectorized.h"

namespace landfix::ingest {
namespace {

constexpr float kScale = 1023;          // of orientation as integers: sums of a row fit into 32 bits
constexpr double kLeastValid = 0.9;     // share of a patch that must have data
constexpr double kLeastEnergy = 0.002;  // mean square of orientation: below it there is nothing to compare
constexpr double kLeastGap = 0.02;      // between the peak and the best elsewhere
constexpr int kLobePx = 4;
constexpr int kRoughStep = 4, kRefine = 2;

/// Orientation of a source in a window as integers: `a` above `b`. Empty where too little of it has data.
cv::Mat orientation_of(const ImageSet& images, size_t source, const PixelWindow& w) {
  const int halo = features::kOrientationHaloPx;
  const auto epoch =
      images.read_source(source, {w.gsd_m, w.column - halo, w.row - halo, w.width + 2 * halo, w.height + 2 * halo});
  if (!epoch) return {};
  cv::Mat ab, valid;
  features::orientation(epoch->bands, epoch->valid, {}, ab, valid);
  const cv::Rect inner(halo, halo, int(w.width), int(w.height));
  if (cv::countNonZero(valid(inner)) < kLeastValid * inner.area()) return {};
  cv::Mat out(2 * inner.height, inner.width, CV_16SC1);
  for (int y = 0; y < inner.height; ++y)
    for (int x = 0; x < inner.width; ++x)
      for (int c = 0; c < 2; ++c)
        out.at<int16_t>(c * inner.height + y, x) =
            int16_t(std::lround(ab.at<cv::Vec2f>(y + halo, x + halo)[c] * kScale));
  return out;
}

LANDFIX_VECTORIZED int32_t dot(const int16_t* a, const int16_t* b, int count) {
  int32_t sum = 0;
  for (int i = 0; i < count; ++i) sum += a[i] * b[i];
  return sum;
}

/// Sum of products of every `step`th row of the patch and the window's part of its size at (x, y), over both channels.
int64_t product(const cv::Mat& patch, const cv::Mat& window, int x, int y, int step) {
  const int height = patch.rows / 2, window_height = window.rows / 2;
  int64_t sum = 0;
  for (int c = 0; c < 2; ++c)
    for (int row = 0; row < height; row += step)
      sum +=
          dot(patch.ptr<int16_t>(c * height + row), window.ptr<int16_t>(c * window_height + y + row) + x, patch.cols);
  return sum;
}

/// Sum of squares of the window's parts of the patch's size.
cv::Mat energies(const cv::Mat& window, cv::Size patch, cv::Size shifts) {
  const int height = window.rows / 2;
  cv::Mat_<double> table = cv::Mat_<double>::zeros(height + 1, window.cols + 1);  // whole numbers: exact
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < window.cols; ++x) {
      const double a = window.at<int16_t>(y, x), b = window.at<int16_t>(height + y, x);
      table(y + 1, x + 1) = a * a + b * b + table(y, x + 1) + table(y + 1, x) - table(y, x);
    }
  cv::Mat_<double> out(shifts);
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x)
      out(y, x) = table(y + patch.height, x + patch.width) - table(y, x + patch.width) - table(y + patch.height, x) +
                  table(y, x);
  return out;
}

/// Correlation of a patch with a window for any shift, normalised by the energy of both.
class Correlation {
 public:
  Correlation(const cv::Mat& patch, const cv::Mat& window)
      : patch_(patch), window_(window), energy_(energies(window, patch_size(), shifts())) {}

  cv::Size shifts() const { return {window_.cols - patch_.cols + 1, window_.rows / 2 - patch_.rows / 2 + 1}; }
  /// The places `where`, by every `step`th row of the patch.
  cv::Mat_<double> at(const cv::Rect& where, int step) const {
    const double patch_energy = double(product(patch_, patch_, 0, 0, step));
    const double least = kLeastEnergy * double(kScale) * double(kScale) * patch_size().area();
    cv::Mat_<double> out(where.size());
    for (int y = 0; y < out.rows; ++y)
      for (int x = 0; x < out.cols; ++x) {
        const cv::Point shift = where.tl() + cv::Point(x, y);
        const bool enough = patch_energy * step >= least && energy_(shift) >= least;
        out(y, x) = enough ? double(product(patch_, window_, shift.x, shift.y, step)) /
                                 std::sqrt(patch_energy * energy_(shift) / step)
                           : 0;
      }
    return out;
  }

 private:
  cv::Size patch_size() const { return {patch_.cols, patch_.rows / 2}; }
  cv::Mat patch_, window_;
  cv::Mat_<double> energy_;
};

cv::Point best_of(const cv::Mat_<double>& surface) {
  cv::Point best(0, 0);
  for (int y = 0; y < surface.rows; ++y)
    for (int x = 0; x < surface.cols; ++x)
      if (surface(y, x) > surface(best)) best = {x, y};
  return best;
}

/// Of the parabola through three neighbouring values, the middle one the largest.
double vertex(double before, double peak, double after) {
  const double curvature = before - 2 * peak + after;
  return curvature < 0 ? 0.5 * (before - after) / curvature : 0;
}

/// Whether nothing beyond the main lobe comes near the peak.
bool stands_out(const cv::Mat_<double>& surface, cv::Point best) {
  double rival = 0;
  for (int y = 0; y < surface.rows; ++y)
    for (int x = 0; x < surface.cols; ++x)
      if (std::max(std::abs(x - best.x), std::abs(y - best.y)) > kLobePx) rival = std::max(rival, surface(y, x));
  return surface(best) - rival >= kLeastGap;
}

/// The shift of the peak to a fraction of a pixel; nullopt where there is none inside, or it has a rival. The peak is
/// looked for by a part of the rows and refined by all.
std::optional<cv::Point2d> peak_of(const Correlation& correlation) {
  const cv::Rect all({}, correlation.shifts());
  const cv::Mat_<double> rough = correlation.at(all, kRoughStep);
  const cv::Point best = best_of(rough);
  const cv::Rect around(best - cv::Point(kRefine, kRefine), cv::Size(2 * kRefine + 1, 2 * kRefine + 1));
  if ((around & all) != around || !stands_out(rough, best)) return std::nullopt;
  const cv::Mat_<double> fine = correlation.at(around, 1);
  const cv::Point p = best_of(fine);
  if (p.x == 0 || p.y == 0 || p.x + 1 == fine.cols || p.y + 1 == fine.rows) return std::nullopt;
  return cv::Point2d(around.tl() + p) + cv::Point2d(vertex(fine(p.y, p.x - 1), fine(p), fine(p.y, p.x + 1)),
                                                    vertex(fine(p.y - 1, p.x), fine(p), fine(p.y + 1, p.x)));
}

/// How far east and south, in pixels, the reference shows what the source shows in the middle of `window`.
std::optional<cv::Point2d> shift_in(const ImageSet& images, size_t source, size_t reference, const PixelWindow& window,
                                    const AlignmentOptions& o) {
  const cv::Mat patch = orientation_of(
      images, source, {window.gsd_m, window.column + o.search_px, window.row + o.search_px, o.patch_px, o.patch_px});
  if (patch.empty()) return std::nullopt;
  const cv::Mat around = orientation_of(images, reference, window);
  if (around.empty()) return std::nullopt;
  const auto peak = peak_of({patch, around});
  if (!peak) return std::nullopt;
  return *peak - cv::Point2d(o.search_px, o.search_px);
}

GridBounds overlap_of(const Source& a, const Source& b) {
  return {std::max(a.bounds.west_m, b.bounds.west_m), std::max(a.bounds.south_m, b.bounds.south_m),
          std::min(a.bounds.east_m, b.bounds.east_m), std::min(a.bounds.north_m, b.bounds.north_m)};
}

double area_of(const GridBounds& b) { return b.empty() ? 0 : (b.east_m - b.west_m) * (b.north_m - b.south_m); }

/// Windows of patch and search, spread evenly over the overlap, at half their side from each other or more.
std::vector<PixelWindow> windows_in(const GridBounds& overlap, int level, const AlignmentOptions& o) {
  const PixelWindow all = window_covering(overlap, tiles::gsd_of(level));
  const int64_t side = o.patch_px + 2 * o.search_px;
  if (all.width < side || all.height < side) return {};
  const auto count = [&](int64_t pixels) {
    return std::min<int64_t>(o.windows_per_side, 1 + 2 * (pixels - side) / side);
  };
  const auto place = [&](int64_t pixels, int64_t i, int64_t n) {
    return n == 1 ? (pixels - side) / 2 : (pixels - side) * i / (n - 1);
  };
  std::vector<PixelWindow> out;
  const int64_t columns = count(all.width), rows = count(all.height);
  for (int64_t y = 0; y < rows; ++y)
    for (int64_t x = 0; x < columns; ++x)
      out.push_back(
          {all.gsd_m, all.column + place(all.width, x, columns), all.row + place(all.height, y, rows), side, side});
  return out;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  const size_t n = values.size();
  return n % 2 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

/// What the windows say together, as how far the source lies off.
void combine(const std::vector<cv::Point2d>& shifts, double gsd_m, const AlignmentOptions& o, Alignment& out) {
  out.windows = int(shifts.size());
  if (shifts.empty()) return;
  std::vector<double> xs, ys;
  for (const cv::Point2d& s : shifts) xs.push_back(s.x), ys.push_back(s.y);
  const cv::Point2d middle(median(xs), median(ys));
  std::vector<cv::Point2d> agreeing;
  for (const cv::Point2d& s : shifts)
    if (std::max(std::abs(s.x - middle.x), std::abs(s.y - middle.y)) <= o.agree_px) agreeing.push_back(s);
  out.agreeing = int(agreeing.size());
  out.measured = out.agreeing >= o.min_agreeing && 2 * out.agreeing > out.windows;
  if (!out.measured) return;
  const cv::Point2d mean = std::accumulate(agreeing.begin(), agreeing.end(), cv::Point2d()) / double(agreeing.size());
  double square = 0;
  for (const cv::Point2d& s : agreeing) square += (s - mean).dot(s - mean);
  out.spread_m = std::sqrt(square / double(agreeing.size())) * gsd_m;
  // What the reference shows further east, the source shows too far west.
  out.east_m = -mean.x * gsd_m;
  out.north_m = mean.y * gsd_m;
}

Alignment compare_at(const ImageSet& images, size_t source, size_t reference, int level, const AlignmentOptions& o) {
  Alignment out;
  out.reference = reference;
  out.gsd_m = tiles::gsd_of(level);
  const auto windows = windows_in(overlap_of(images.sources()[source], images.sources()[reference]), level, o);
  std::vector<std::optional<cv::Point2d>> found(windows.size());
  tbb::parallel_for(size_t(0), windows.size(),
                    [&](size_t i) { found[i] = shift_in(images, source, reference, windows[i], o); });
  std::vector<cv::Point2d> shifts;
  for (const auto& shift : found)
    if (shift) shifts.push_back(*shift);
  combine(shifts, out.gsd_m, o, out);
  return out;
}

/// At the finest level at which the windows agree; that of `level` where they do nowhere.
Alignment compare(const ImageSet& images, size_t source, size_t reference, int level, const AlignmentOptions& o) {
  const Alignment first = compare_at(images, source, reference, level, o);
  if (first.measured) return first;
  for (int coarser = level + 1; coarser <= std::min(level + o.coarser_levels, tiles::kMaxLevel); ++coarser)
    if (const Alignment a = compare_at(images, source, reference, coarser, o); a.measured) return a;
  return first;
}

std::vector<size_t> order_of(const std::vector<Source>& sources) {
  std::vector<size_t> order(sources.size());
  std::iota(order.begin(), order.end(), size_t(0));
  const auto error = [&](size_t i) {
    return sources[i].georegistration_error_m.value_or(std::numeric_limits<double>::infinity());
  };
  std::ranges::stable_sort(order, [&](size_t a, size_t b) {
    return error(a) != error(b) ? error(a) < error(b) : sources[a].date > sources[b].date;
  });
  return order;
}

}  // namespace

std::vector<Alignment> measure_alignment(const ImageSet& images, int level, const AlignmentOptions& options) {
  const std::vector<Source>& sources = images.sources();
  std::vector<Alignment> out(sources.size());
  std::vector<size_t> before;
  for (const size_t source : order_of(sources)) {
    double largest = 0;
    for (const size_t other : before) largest = std::max(largest, area_of(overlap_of(sources[source], sources[other])));
    const auto reference = std::ranges::find_if(
        before, [&](size_t other) { return area_of(overlap_of(sources[source], sources[other])) >= largest / 2; });
    if (largest > 0) {
      Alignment& a = out[source] = compare(images, source, *reference, level, options);
      if (a.measured) a.east_m += out[*reference].east_m, a.north_m += out[*reference].north_m;
    }
    before.push_back(source);
  }
  return out;
}

std::string text_of(const Alignment& a, const std::vector<std::string>& names) {
  if (!a.reference) return {};
  const std::string& name = names[*a.reference];
  if (!a.measured)
    return fmt::format("shift against {} not measurable: {} of {} windows at {} m agree", name, a.agreeing, a.windows,
                       a.gsd_m);
  return fmt::format(
      "lies {:.2f} m {}, {:.2f} m {} by comparison with {} ({} of {} windows at {} m agree, spread {:.2f} m)",
      std::abs(a.east_m), a.east_m < 0 ? "west" : "east", std::abs(a.north_m), a.north_m < 0 ? "south" : "north", name,
      a.agreeing, a.windows, a.gsd_m, a.spread_m);
}

}  // namespace landfix::ingest

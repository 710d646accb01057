#include "builder/navigability/predictors.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <vector>

#include "builder/navigability/altered_views.h"
#include "builder/navigability/information.h"
#include "runtime/features/gray.h"
#include "runtime/features/orientation.h"
#include "runtime/nav/image_map.h"
#include "runtime/nav/registration.h"

namespace landfix::navigability {
namespace {

using features::GridImage;

constexpr int kRimPx = 8;               ///< around the view, for operators that look at neighbours
constexpr double kLeastCoverage = 0.5;  ///< of the view that a date must show
constexpr double kSigmas = 3;           ///< of the prior that the search region is
constexpr double kLeastWeight = 0.02;   ///< of a match whose likelihood lies elsewhere, in the mean covariance
constexpr int kMainLobePx = 8;          ///< around the truth: the features' own correlation, no look-alike

double logit(double p) {
  const double limit = 1 / (1 + std::exp(kLargestLogit));
  p = std::clamp(p, limit, 1 - limit);
  return std::log(p / (1 - p));
}

/// Red, green and blue of an image; a camera has no near infrared.
GridImage seen_by_camera(const GridImage& image) {
  GridImage out = image;
  if (image.pixels.channels() != 4) return out;
  out.pixels = cv::Mat(image.pixels.size(), CV_8UC3);
  const int from_to[] = {0, 0, 1, 1, 2, 2};
  cv::mixChannels({image.pixels}, {out.pixels}, from_to, 3);
  return out;
}

/// Sums over any rectangle of how long the orientation vectors are.
class Structure {
 public:
  explicit Structure(const GridImage& image) {
    cv::Mat ab, valid, length;
    features::orientation(image.pixels, image.valid, {}, ab, valid);
    std::vector<cv::Mat> channels;
    cv::split(ab, channels);
    cv::sqrt(channels[0].mul(channels[0]) + channels[1].mul(channels[1]), length);
    const cv::Mat squared = length.mul(length);
    cv::integral(length, lengths_, CV_64F);
    cv::integral(squared, squares_, CV_64F);
    cv::integral(squared.mul(length), cubes_, CV_64F);
    cv::integral(valid / 255, pixels_, CV_64F);
  }

  double pixels(const cv::Rect& r) const { return sum(pixels_, r); }
  double mean(const cv::Rect& r) const { return sum(lengths_, r) / std::max(pixels(r), 1.0); }
  double crest(const cv::Rect& r) const { return sum(cubes_, r) / std::max(sum(squares_, r), 1e-3 * r.area()); }

 private:
  static double sum(const cv::Mat_<double>& s, const cv::Rect& r) {
    return s(r.y + r.height, r.x + r.width) - s(r.y, r.x + r.width) - s(r.y + r.height, r.x) + s(r.y, r.x);
  }

  cv::Mat lengths_, squares_, cubes_, pixels_;
};

/// A rectangle of an image that may reach beyond it: there, nothing is valid. West and north are relative to its
/// middle.
GridImage cut(const GridImage& image, const cv::Rect& wanted) {
  GridImage out{cv::Mat::zeros(wanted.size(), image.pixels.type()), cv::Mat::zeros(wanted.size(), CV_8U),
                -0.5 * wanted.width * image.gsd_m, 0.5 * wanted.height * image.gsd_m, image.gsd_m};
  const cv::Rect inside = wanted & cv::Rect({0, 0}, image.pixels.size());
  if (inside.empty()) return out;
  const cv::Rect there = inside - wanted.tl();
  image.pixels(inside).copyTo(out.pixels(there));
  if (image.valid.empty())
    out.valid(there).setTo(255);
  else
    image.valid(inside).copyTo(out.valid(there));
  return out;
}

/// What a build shows of several dates, in gray: of each pixel the first date that has it.
GridImage newest_of(std::span<const GridImage> dates) {
  GridImage out = dates[0];
  out.pixels = features::gray_from_rgb(dates[0].pixels);
  if (out.valid.empty()) return out;
  out.pixels = out.pixels.clone();
  out.valid = out.valid.clone();
  for (const GridImage& date : dates.subspan(1)) {
    cv::Mat added = out.valid == 0;
    if (!date.valid.empty()) added &= date.valid;
    if (cv::countNonZero(added) == 0) continue;
    features::gray_from_rgb(date.pixels).copyTo(out.pixels, added);
    out.valid.setTo(255, added);
  }
  return out;
}

double squared(double v) { return v * v; }

/// Where on a surface of scores, as seen from the truth.
struct Around {
  const GridImage& surface;
  double east_m, north_m;

  double east_of(int x) const { return surface.west_m + (x + 0.5) * surface.gsd_m - east_m; }
  double north_of(int y) const { return surface.north_m - (y + 0.5) * surface.gsd_m - north_m; }

  template <typename Visit>
  void for_each(const Visit& visit) const {
    for (int y = 0; y < surface.pixels.rows; ++y)
      for (int x = 0; x < surface.pixels.cols; ++x)
        if (surface.valid.at<uint8_t>(y, x)) visit(x, y, squared(east_of(x)) + squared(north_of(y)));
  }
};

/// Share of the likelihood, outliers left out, within `hit_m` of the truth.
double mass_near_truth(const nav::Likelihood& likelihood, const Around& around, double hit_m) {
  double near = 0, all = 0;
  around.for_each([&](int x, int y, double away_m2) {
    const double excess = likelihood.values.pixels.at<float>(y, x) - likelihood.outside;
    all += excess;
    if (away_m2 <= squared(hit_m)) near += excess;
  });
  return all > 0 ? near / all : 0;
}

double mean_beyond(const Around& around, double radius_m) {
  double sum = 0;
  int count = 0;
  around.for_each([&](int x, int y, double away_m2) {
    if (away_m2 <= squared(radius_m)) return;
    sum += around.surface.pixels.at<float>(y, x);
    ++count;
  });
  return count > 0 ? sum / count : 0;
}

std::optional<LookAlike> strongest_look_alike(const Around& mean, double hit_m) {
  const double lobe_m = std::max(2 * hit_m, kMainLobePx * mean.surface.gsd_m);
  double own = 0, highest = 0;
  LookAlike found;
  mean.for_each([&](int x, int y, double away_m2) {
    const double score = mean.surface.pixels.at<float>(y, x);
    if (away_m2 <= squared(hit_m)) own = std::max(own, score);
    if (away_m2 <= squared(lobe_m) || score <= highest) return;
    highest = score;
    found = {mean.east_of(x), mean.north_of(y), 0};
  });
  if (highest <= 0) return std::nullopt;
  found.strength = own > 0 ? std::min(highest / own, 1.0) : 1;
  return found;
}

}  // namespace

struct Witness::State {
  /// A date, and the map that it is matched with.
  struct Date {
    GridImage camera;  ///< what a camera would have seen
    Structure structure;
    Information information;
    /// Of all other dates, or of this one where there is no other; registrars point to them.
    std::optional<nav::ImageMap> fused, newest;
    std::array<std::unique_ptr<nav::Registrar>, std::size(nav::kMethods)>
        registrars;  ///< by method; null: not asked for

    Date(const GridImage& image, std::span<const GridImage> others, std::span<const nav::Method> methods)
        : camera(seen_by_camera(image)),
          structure(image),
          information(camera, others.empty() ? GridImage{} : newest_of(others)) {
      const std::span<const GridImage> shown = others.empty() ? std::span(&image, 1) : others;
      std::vector<nav::MapLayer> layers;
      for (const nav::Method method : methods)
        if (method == nav::Method::kOrientation)
          fused.emplace(shown, 1, 0, std::array{nav::MapLayer::kOrientation});
        else
          layers.push_back(nav::layer_of(method));
      if (!layers.empty()) newest.emplace(newest_of(shown), 1, 0, layers);
      for (const nav::Method method : methods) {
        nav::RegistrationOptions o;
        o.method = method;
        o.rim_px = kRimPx;
        const nav::ImageMap& map = method == nav::Method::kOrientation ? *fused : *newest;
        registrars[size_t(method)] = std::make_unique<nav::Registrar>(map, o);
      }
    }
    Date(const Date&) = delete;
    Date& operator=(const Date&) = delete;
  };

  /// A date that alone shows a place.
  struct Alone {
    std::shared_ptr<Date> date;  ///< matched with itself
    AlteredViews views;
  };

  /// What matches add up to.
  struct Sums {
    std::vector<double> logits;
    double background = 0, found = 0, accepted = 0, weight = 0;
    std::array<double, 4> covariance_m2{};
    GridImage surface;  ///< Σ of the scores, and where all of them are valid
    int surfaces = 0;
  };

  /// A square of a date's image, and where its middle is.
  struct Place {
    const Footprint& footprint;
    nav::Method method;
    cv::Point corner;
    int half_px = 0;  ///< rim included
    double east_m = 0, north_m = 0;

    cv::Rect square() const { return {corner.x - half_px, corner.y - half_px, 2 * half_px, 2 * half_px}; }
  };

  Alone& alone(size_t date);
  void match(Date& date, const Place& place, const GridImage& patch, Sums& sums);
  Sums match_altered(Alone& alone, const Place& place);

  std::vector<GridImage> images;
  std::vector<nav::Method> methods;
  GridImage heights;
  std::vector<std::shared_ptr<Date>> dates;         ///< registrars point to the maps beside them
  std::vector<std::unique_ptr<Alone>> alone_dates;  ///< made when a place asks for them
  nav::Registration found;
};

Witness::State::Alone& Witness::State::alone(size_t date) {
  if (!alone_dates[date]) {
    const auto itself =
        dates.size() == 1 ? dates[0] : std::make_shared<Date>(images[date], std::span<const GridImage>{}, methods);
    alone_dates[date] = std::make_unique<Alone>(Alone{itself, AlteredViews(itself->camera, heights)});
  }
  return *alone_dates[date];
}

void Witness::State::match(Date& date, const Place& place, const GridImage& patch, Sums& sums) {
  const Footprint& f = place.footprint;
  nav::RegistrationPrior prior;
  prior.east_m = place.east_m;
  prior.north_m = place.north_m;
  const double variance = std::pow(f.search_m / kSigmas, 2);
  prior.covariance_m2 = {variance, 0, 0, variance};
  prior.sigmas = kSigmas;
  date.registrars[size_t(place.method)]->run(patch, prior, found);
  if (found.status != nav::Status::kOk && found.status != nav::Status::kImprobable) {
    sums.logits.push_back(-kLargestLogit);  // nothing to match: as good as not found
    return;
  }
  const Around around{found.surface, prior.east_m, prior.north_m};
  const double mass = mass_near_truth(found.likelihood, around, f.hit_m);
  const bool hit = std::hypot(found.peak.east_m - prior.east_m, found.peak.north_m - prior.north_m) <= f.hit_m;
  sums.logits.push_back(logit(mass));
  sums.background += mean_beyond(around, 2 * f.hit_m);
  sums.found += hit;
  sums.accepted += found.status == nav::Status::kOk;
  const double weight = hit + kLeastWeight;
  sums.weight += weight;
  for (size_t i = 0; i < 4; ++i) sums.covariance_m2[i] += weight * found.covariance_m2[i];
  if (sums.surfaces++ == 0) {
    sums.surface = found.surface;
    sums.surface.pixels = found.surface.pixels.clone();
    sums.surface.valid = found.surface.valid.clone();
  } else if (sums.surface.pixels.size() == found.surface.pixels.size()) {
    sums.surface.pixels += found.surface.pixels;
    sums.surface.valid &= found.surface.valid;
  }
}

// Few views scatter less than they might: as if one more had been this far off.
bool sure_of_mean(const std::vector<double>& logits) {
  constexpr double kUsualScatter = 2;
  const double n = double(logits.size()), mean = std::accumulate(logits.begin(), logits.end(), 0.0) / n;
  double squares = kUsualScatter * kUsualScatter;
  for (const double l : logits) squares += (l - mean) * (l - mean);
  return squares / n <= n * kLargestError * kLargestError;
}

Witness::State::Sums Witness::State::match_altered(Alone& alone, const Place& place) {
  Sums sums;
  const Footprint& f = place.footprint;
  const AlteredViews::View view{place.corner, place.half_px, f.template_m, f.search_m / kSigmas};
  for (int i = 0; i < kMostViews && (i < kLeastViews || !sure_of_mean(sums.logits)); ++i)
    match(*alone.date, place, alone.views.draw(view, uint64_t(i)), sums);
  return sums;
}

Witness::Witness(std::span<const GridImage> dates, std::span<const nav::Method> methods, const GridImage& heights)
    : state_(std::make_unique<State>()) {
  if (dates.empty()) throw std::invalid_argument("navigability: no image to judge by");
  const auto differs = [&](const GridImage& image) {
    return image.pixels.size() != dates[0].pixels.size() || image.gsd_m != dates[0].gsd_m ||
           image.west_m != dates[0].west_m || image.north_m != dates[0].north_m;
  };
  if (std::ranges::any_of(dates, differs) || (!heights.pixels.empty() && differs(heights)))
    throw std::invalid_argument("navigability: the dates' images and the heights differ in size, place or GSD");
  state_->images.assign(dates.begin(), dates.end());
  state_->methods.assign(methods.begin(), methods.end());
  state_->heights = heights;
  state_->alone_dates.resize(dates.size());
  for (size_t i = 0; i < dates.size(); ++i) {
    std::vector<GridImage> others;
    for (size_t k = 0; k < dates.size(); ++k)
      if (k != i) others.push_back(dates[k]);
    state_->dates.push_back(std::make_shared<State::Date>(dates[i], others, methods));
  }
}
Witness::~Witness() = default;
Witness::Witness(Witness&&) noexcept = default;
Witness& Witness::operator=(Witness&&) noexcept = default;

Predictors Witness::at(double east_m, double north_m, const Footprint& f, nav::Method method) {
  for (const double length : {f.template_m, f.search_m, f.hit_m})
    if (!(length > 0) || !std::isfinite(length))
      throw std::invalid_argument("navigability: the lengths of a footprint are metres, more than 0");
  if (!state_->dates[0]->registrars[size_t(method)])
    throw std::invalid_argument("navigability: the witness was not made for this method");
  const GridImage& frame = state_->dates[0]->camera;
  const int side = 2 * int(std::lround(0.5 * f.template_m / frame.gsd_m));
  State::Place place{f, method, {}, side / 2 + kRimPx};
  place.corner = {int(std::lround((east_m - frame.west_m) / frame.gsd_m)),
                  int(std::lround((frame.north_m - north_m) / frame.gsd_m))};
  place.east_m = frame.west_m + place.corner.x * frame.gsd_m;
  place.north_m = frame.north_m - place.corner.y * frame.gsd_m;
  const cv::Rect view(place.corner.x - side / 2, place.corner.y - side / 2, side, side),
      inside = view & cv::Rect({0, 0}, frame.pixels.size());
  Predictors out;
  out.template_px = side;
  if (inside.empty()) return out;
  std::vector<size_t> shown;
  for (size_t i = 0; i < state_->dates.size(); ++i)
    if (state_->dates[i]->structure.pixels(inside) >= kLeastCoverage * view.area()) shown.push_back(i);
  if (shown.empty()) return out;
  out.dates = int(shown.size());
  out.newest = int(shown[0]);
  const bool alone = out.dates == 1;
  const double share = 1.0 / out.dates, px2 = frame.gsd_m * frame.gsd_m;
  State::Sums sums;
  for (const size_t i : shown) {
    State::Date& date = alone ? *state_->alone(i).date : *state_->dates[i];
    out.coverage += share * date.structure.pixels(inside) / view.area();
    out.structure += share * date.structure.mean(inside);
    out.crest += share * date.structure.crest(inside);
    const std::array<double, 4> least = date.information.least_covariance_px2(view, f.search_m / frame.gsd_m);
    for (size_t k = 0; k < 4; ++k) out.least_covariance_m2[k] += share * px2 * least[k];
    state_->match(date, place, cut(date.camera, place.square()), sums);
  }
  if (sums.surfaces > 0) {
    out.background = sums.background / sums.surfaces;
    out.look_alike = strongest_look_alike({sums.surface, place.east_m, place.north_m}, f.hit_m);
  }
  if (alone && method == nav::Method::kOrientation) {
    sums = state_->match_altered(state_->alone(shown[0]), place);
    out.views = int(sums.logits.size());
  }
  const double count = double(sums.logits.size());
  out.least_logit = *std::ranges::min_element(sums.logits);
  out.mean_logit = std::accumulate(sums.logits.begin(), sums.logits.end(), 0.0) / count;
  out.found = sums.found / count;
  out.accepted = sums.accepted / count;
  if (sums.weight > 0)
    for (size_t i = 0; i < 4; ++i) out.covariance_m2[i] = sums.covariance_m2[i] / sums.weight;
  return out;
}

}  // namespace landfix::navigability

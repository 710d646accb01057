#include "tools/route/simulate.h"

#include <cmath>
#include <limits>

#include "tools/fly/noise.h"
#include "tools/route/belief.h"

namespace landfix::route {
namespace {

/// Unit normals of the route at each image.
std::vector<Eigen::Vector2d> normals(const std::vector<Image>& images) {
  std::vector<Eigen::Vector2d> out(images.size(), Eigen::Vector2d::Zero());
  for (size_t i = 0; i < images.size(); ++i) {
    const Station &a = images[i > 0 ? i - 1 : i].station(),
                  &b = images[i > 0 ? i : std::min(i + 1, images.size() - 1)].station();
    const Eigen::Vector2d along(b.east_m - a.east_m, b.north_m - a.north_m);
    if (along.norm() > 0) out[i] = Eigen::Vector2d(-along.y(), along.x()).normalized();
  }
  return out;
}

class DrawnFlight {
 public:
  DrawnFlight(const Vehicle& vehicle, uint64_t seed)
      : vehicle_(vehicle), errors_(vehicle.errors), random_(seed, fly::Stream::kOdometry) {
    drift_ = errors_.drift_share * gaussian();
    bias_ = gaussian();
    error_ = errors_.start_sigma_m * gaussian();
    match_ = gaussian();
    filter_m2_ = errors_.start_sigma_m * errors_.start_sigma_m * Eigen::Matrix2d::Identity();
  }

  const Eigen::Vector2d& error() const { return error_; }

  void step(const Image& image) {
    const double flown_m = image.flown_m(), agl_m = image.station().agl_m;
    error_ += flown_m * drift_ + std::sqrt(errors_.noise_m2_per_m * flown_m) * gaussian();
    filter_m2_.diagonal().array() += errors_.filter_noise_m2_per_m(agl_m) * flown_m;
    since_fix_m_ += flown_m;
    const double correlation = outcome_correlation(flown_m, vehicle_.footprint_m(agl_m));
    match_ = correlation * match_ + std::sqrt(1 - correlation * correlation) * gaussian();
    const View& view = image.view(std::sqrt(std::max(filter_m2_(0, 0), filter_m2_(1, 1))));
    const double p = fix_probability_given(fixed_, last_probability_, view.fix_probability, correlation);
    const double none = 1 - view.fix_probability;
    const double deceived = none > 0 ? (1 - p) * std::min(1.0, view.false_probability / none) : 0;
    const double draw = random_.uniform();
    last_probability_ = view.fix_probability;
    fixed_ = draw < p;
    if (draw < p + deceived) take(view, fix_update(view, filter_m2_, since_fix_m_, vehicle_.independent_m(agl_m)));
  }

 private:
  Eigen::Vector2d gaussian() {
    const double east = random_.gaussian();
    return {east, random_.gaussian()};
  }

  void take(const View& view, const FixUpdate& update) {
    Eigen::Vector2d measured;
    if (fixed_) {
      measured = root(view.match_m2) * match_ + view.attitude_m * gaussian() + view.bias_m * bias_;
    } else {
      const double east = 2 * random_.uniform() - 1;
      measured = view.search_m * Eigen::Vector2d(east, 2 * random_.uniform() - 1);
    }
    error_ += update.gain * (measured - error_);
    filter_m2_ = update.filter_m2;
    since_fix_m_ = 0;
  }

  const Vehicle& vehicle_;
  const ErrorModel& errors_;
  fly::NoiseStream random_;
  Eigen::Vector2d drift_, bias_, error_, match_;
  Eigen::Matrix2d filter_m2_;
  double since_fix_m_ = std::numeric_limits<double>::infinity(), last_probability_ = -1;
  bool fixed_ = false;
};

}  // namespace

Flights simulate(const std::vector<Image>& images, const Vehicle& vehicle, const FlightsWanted& wanted) {
  const std::vector<Eigen::Vector2d> across = normals(images);
  Flights flights{std::vector<double>(images.size(), 0), std::vector<double>(images.size(), 0), 0};
  for (int run = 0; run < wanted.runs; ++run) {
    DrawnFlight flight(vehicle, wanted.seed + uint64_t(run) * 0x10001);
    bool inside = true;
    for (size_t i = 0; i < images.size(); ++i) {
      flight.step(images[i]);
      const Eigen::Vector2d& error = flight.error();
      flights.rms_m[i] += error.squaredNorm();
      flights.within[i] += error.norm() < wanted.radius_m;
      inside &= std::abs(error.dot(across[i])) <= wanted.corridor_m;
    }
    flights.in_corridor += inside;
  }
  for (double& rms : flights.rms_m) rms = std::sqrt(rms / wanted.runs);
  for (double& share : flights.within) share /= wanted.runs;
  flights.in_corridor /= wanted.runs;
  return flights;
}

}  // namespace landfix::route

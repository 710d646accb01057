#include "tools/fly/trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "builder/error.h"

namespace landfix::fly {
namespace {

constexpr double kProfileStepM = 5;
/// The roll of an aeroplane follows the curvature of its track over this time.
constexpr double kBankSmoothingS = 1.5;
constexpr double kGravity = 9.80665;

double ground_below(const terrain::Scene& scene, const RoutePoint& point, double distance_m) {
  const auto ground = scene.height_below(point.east_m, point.north_m);
  if (!ground) {
    throw Error(
        ExitCode::kNoData,
        fmt::format("the route leaves the scene's heights {:.0f} m after its start, at east {:.0f} north {:.0f}; "
                    "choose a shorter route, another centre, or a larger scene",
                    distance_m, point.east_m, point.north_m));
  }
  return *ground;
}

/// Two slow waves of drawn phase: smooth, bounded by 1, without a common period.
double sway(double time_s, const double* phase) {
  return 0.6 * std::sin(2 * M_PI * time_s / 4.7 + phase[0]) + 0.4 * std::sin(2 * M_PI * time_s / 1.9 + phase[1]);
}

}  // namespace

Trajectory::Trajectory(const terrain::Scene& scene, const Route& route, const FlightOptions& options, uint64_t seed)
    : route_(route), options_(options) {
  duration_s_ = route.length_m() * (route.closed() ? options.laps : 1) / options.speed_mps;
  NoiseStream noise(seed, Stream::kSway);
  for (double& phase : phases_) phase = 2 * M_PI * noise.uniform();

  const size_t steps = size_t(std::ceil(route.length_m() / kProfileStepM));
  profile_step_m_ = route.length_m() / double(steps);
  std::vector<double> ground(steps + 1);
  for (size_t i = 0; i <= steps; ++i) {
    const double distance = double(i) * profile_step_m_;
    ground[i] = ground_below(scene, route.at(distance), distance);
  }
  if (options.altitude_m) return;

  const long reach = std::lround(options.terrain_smoothing_m / profile_step_m_), count = long(steps);
  for (long i = 0; i <= count; ++i) {
    double sum = 0;
    for (long j = i - reach; j <= i + reach; ++j) {
      const long k = route.closed() ? ((j % count) + count) % count : std::clamp(j, 0l, count);
      sum += ground[size_t(k)];
    }
    profile_m_.push_back(sum / double(2 * reach + 1) + options.agl_m);
  }
}

double Trajectory::height_at(double distance_m) const {
  if (options_.altitude_m) return *options_.altitude_m;
  const double length = route_.length_m();
  const double on_route =
      route_.closed() ? distance_m - length * std::floor(distance_m / length) : std::clamp(distance_m, 0.0, length);
  const double position = on_route / profile_step_m_;
  const size_t below = std::min(size_t(position), profile_m_.size() - 2);
  return std::lerp(profile_m_[below], profile_m_[below + 1], position - double(below));
}

double Trajectory::curvature_at(double distance_m) const {
  const double reach = options_.speed_mps * kBankSmoothingS / 2;
  const double turn = route_.at(distance_m + reach).heading_rad - route_.at(distance_m - reach).heading_rad;
  return std::remainder(turn, 2 * M_PI) / (2 * reach);
}

terrain::Pose Trajectory::at(double time_s) const {
  const double distance = distance_m(time_s);
  const RoutePoint point = route_.at(distance);
  terrain::Pose pose{point.east_m, point.north_m, height_at(distance), {}};
  pose.attitude.roll = options_.sway_rad * sway(time_s, &phases_[0]);
  pose.attitude.pitch = options_.sway_rad * sway(time_s, &phases_[2]);
  pose.attitude.heading = point.heading_rad + options_.sway_rad * sway(time_s, &phases_[4]);
  if (options_.bank) {
    pose.attitude.roll += std::atan(options_.speed_mps * options_.speed_mps * curvature_at(distance) / kGravity);
  }
  return pose;
}

}  // namespace landfix::fly

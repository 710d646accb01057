#include "tools/fly/flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "builder/error.h"
#include "tools/fly/trajectory.h"

namespace landfix::fly {
namespace {

constexpr double kLeastCoverage = 0.5;
constexpr double kShortestDriftCorrelationM = 100, kDriftCorrelationPerHeight = 0.7;

void check(const FlightOptions& o) {
  const auto positive = [](double value, const char* name) {
    if (!(value > 0 && std::isfinite(value))) {
      throw Error(ExitCode::kBadInput, fmt::format("flight: {} must be a positive number, found {}", name, value));
    }
  };
  positive(o.speed_mps, "speed");
  positive(o.agl_m, "height above ground");
  positive(o.laps, "number of laps");
  positive(o.image_interval_s, "time between images");
  positive(o.odometry_interval_s, "time between odometry readings");
}

void check_coverage(const terrain::Picture& picture, const Record& record) {
  const double coverage = double(cv::countNonZero(picture.valid)) / double(picture.valid.total());
  if (coverage >= kLeastCoverage) return;
  throw Error(
      ExitCode::kNoData,
      fmt::format("{:.0f} m after its start the route leaves the scene's image (the camera at east {:.0f} north "
                  "{:.0f} sees {:.0f} % of a picture); choose a shorter route, another centre, or a larger scene",
                  record.distance_m, record.truth.east_m, record.truth.north_m, 100 * coverage));
}

/// The flight's state between images.
class Flight {
 public:
  Flight(const terrain::Scene& scene, const nav::MapSource& map, const Route& route, const FlightOptions& options,
         uint64_t seed)
      : scene_(scene),
        options_(options),
        trajectory_(scene, route, options, seed),
        sensors_(options.sensors, seed),
        localizer_(map, options.localizer),
        drift_correlation_m_(drift_correlation()) {}

  std::vector<Record> run(const FrameSink& frames) {
    std::vector<Record> records;
    const auto images = size_t(trajectory_.duration_s() / options_.image_interval_s) + 1;
    for (size_t i = 0; i < images; ++i) records.push_back(step(i, frames));
    return records;
  }

 private:
  double drift_correlation() const {
    if (options_.drift_correlation_m) return *options_.drift_correlation_m;
    const terrain::Pose start = trajectory_.at(0);
    const double agl_m = start.height_m - scene_.height_below(start.east_m, start.north_m).value_or(start.height_m);
    return std::max(kShortestDriftCorrelationM, kDriftCorrelationPerHeight * agl_m);
  }

  Record step(size_t index, const FrameSink& frames) {
    Record record;
    record.time_s = double(index) * options_.image_interval_s;
    record.distance_m = trajectory_.distance_m(record.time_s);
    record.truth = trajectory_.at(record.time_s);
    record.gnss = index == 0 || record.time_s < options_.gnss_until_s;
    if (record.gnss) {
      take_gnss(record.truth);
    } else {
      take_odometry(record.time_s);
      take_image(index, record, frames);
    }
    record.dead_reckoning_east_m = dead_reckoning_.x();
    record.dead_reckoning_north_m = dead_reckoning_.y();
    record.estimate = localizer_.estimate();
    return record;
  }

  void take_gnss(const terrain::Pose& truth) {
    dead_reckoning_ = sensors_.gnss_position(truth.east_m, truth.north_m);
    require(localizer_.start(dead_reckoning_.x(), dead_reckoning_.y(), options_.sensors.gnss_sigma_m), "start");
  }

  void take_odometry(double time_s) {
    const int readings = std::max(1, int(std::lround(options_.image_interval_s / options_.odometry_interval_s)));
    const double interval_s = options_.image_interval_s / readings, begin_s = time_s - options_.image_interval_s;
    Eigen::Vector2d displacement = Eigen::Vector2d::Zero();
    for (int i = 0; i < readings; ++i) {
      displacement += sensors_.displacement(trajectory_.at(begin_s + i * interval_s),
                                            trajectory_.at(begin_s + (i + 1) * interval_s));
    }
    dead_reckoning_ += displacement;
    // A wrong heading turns what odometry measured.
    const double drift = std::hypot(options_.sensors.odometry_drift, options_.sensors.heading_bias_rad);
    const double sigma_m = drift * std::sqrt(displacement.norm() * drift_correlation_m_);
    require(localizer_.predict(displacement.x(), displacement.y(), sigma_m), "predict");
  }

  void take_image(size_t index, Record& record, const FrameSink& frames) {
    const terrain::Picture seen = scene_.render(options_.camera, record.truth);
    check_coverage(seen, record);
    const cv::Mat picture = sensors_.picture(seen.image);
    record.fix = localizer_.update(picture, options_.camera, sensors_.attitude(record.truth.attitude),
                                   sensors_.height(record.truth.height_m), record.time_s);
    if (frames) frames(index, record, picture);
  }

  static void require(nav::Status status, const char* step) {
    if (status == nav::Status::kOk) return;
    throw Error(ExitCode::kBadInput,
                fmt::format("flight: the localizer refused to {}: {}", step, nav::to_text(status)));
  }

  const terrain::Scene& scene_;
  const FlightOptions options_;
  const Trajectory trajectory_;
  Sensors sensors_;
  nav::Localizer localizer_;
  const double drift_correlation_m_;
  Eigen::Vector2d dead_reckoning_ = Eigen::Vector2d::Zero();
};

}  // namespace

FlightOptions with_known_errors(FlightOptions options) {
  options.localizer.attitude_sigma_rad = options.sensors.attitude_noise_rad;
  options.localizer.attitude_bias_sigma_rad = options.sensors.attitude_bias_rad;
  options.localizer.heading_sigma_rad = std::hypot(options.sensors.heading_noise_rad, options.sensors.heading_bias_rad);
  return options;
}

std::vector<Record> fly(const terrain::Scene& scene, const nav::MapSource& map, const Route& route,
                        const FlightOptions& options, uint64_t seed, const FrameSink& frames) {
  check(options);
  return Flight(scene, map, route, options, seed).run(frames);
}

}  // namespace landfix::fly

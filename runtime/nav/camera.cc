#include "runtime/nav/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace landfix::nav {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kFoldStepRad = 0.25 * kPi / 180;  ///< in which a fold is looked for, as an angle off the optical axis
constexpr int kFoldDirections = 32;                ///< where tangential terms make it depend on the direction
constexpr double kConverged = 1e-10;               ///< on the plane at distance 1: a millionth of a pixel
constexpr int kIterations = 40;

}  // namespace

Status check(const Camera& camera) {
  const Distortion& d = camera.distortion;
  for (double v : {camera.fx, camera.fy, camera.cx, camera.cy, d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6})
    if (!std::isfinite(v)) return Status::kNotFinite;
  if (camera.fx <= 0 || camera.fy <= 0 || camera.width <= 0 || camera.height <= 0) return Status::kBadValue;
  if (!camera.mask.empty() &&
      (camera.mask.type() != CV_8UC1 || camera.mask.cols != camera.width || camera.mask.rows != camera.height))
    return Status::kBadImage;
  return Status::kOk;
}

Camera shrunk(const Camera& camera, int factor) {
  return {camera.width / factor, camera.height / factor,           camera.fx / factor,
          camera.fy / factor,    (camera.cx + 0.5) / factor - 0.5, (camera.cy + 0.5) / factor - 0.5,
          camera.distortion};
}

Lens::Lens(const Camera& camera)
    : fx_(camera.fx), fy_(camera.fy), cx_(camera.cx), cy_(camera.cy), d_(camera.distortion), distorted_(!d_.none()) {
  double fold = std::numeric_limits<double>::infinity();
  if (distorted_) {
    const int directions = d_.p1 == 0 && d_.p2 == 0 ? 1 : kFoldDirections;
    for (int i = 0; i < directions; ++i) fold = std::min(fold, fold_along(2 * kPi * i / directions));
  }
  fold2_ = fold * fold;
}

double Lens::fold_radius() const { return std::sqrt(fold2_); }

Eigen::Vector2d Lens::distort(const Eigen::Vector2d& p) const {
  const double x = p.x(), y = p.y(), r2 = x * x + y * y, xy = 2 * x * y;
  const double c = (1 + r2 * (d_.k1 + r2 * (d_.k2 + r2 * d_.k3))) / (1 + r2 * (d_.k4 + r2 * (d_.k5 + r2 * d_.k6)));
  return {x * c + d_.p1 * xy + d_.p2 * (r2 + 2 * x * x), y * c + d_.p1 * (r2 + 2 * y * y) + d_.p2 * xy};
}

bool Lens::jacobian(const Eigen::Vector2d& p, Eigen::Matrix2d& j) const {
  const double x = p.x(), y = p.y(), r2 = x * x + y * y;
  const double above = 1 + r2 * (d_.k1 + r2 * (d_.k2 + r2 * d_.k3));
  const double below = 1 + r2 * (d_.k4 + r2 * (d_.k5 + r2 * d_.k6));
  if (!(above > 0 && below > 0)) return false;
  const double above_slope = d_.k1 + r2 * (2 * d_.k2 + r2 * 3 * d_.k3);
  const double below_slope = d_.k4 + r2 * (2 * d_.k5 + r2 * 3 * d_.k6);
  const double c = above / below, slope = (above_slope - c * below_slope) / below;  // slope = dc/dr²
  const double mixed = 2 * (x * y * slope + d_.p1 * x + d_.p2 * y);
  j << c + 2 * x * x * slope + 2 * d_.p1 * y + 6 * d_.p2 * x, mixed,  //
      mixed, c + 2 * y * y * slope + 6 * d_.p1 * y + 2 * d_.p2 * x;
  return j.determinant() > 0;
}

double Lens::fold_along(double direction_rad) const {
  const Eigen::Vector2d direction(std::cos(direction_rad), std::sin(direction_rad));
  Eigen::Matrix2d unused;
  const auto one_to_one = [&](double angle_rad) { return jacobian(std::tan(angle_rad) * direction, unused); };
  double good = 0, bad = kFoldStepRad;
  while (one_to_one(bad)) {
    good = bad;
    bad += kFoldStepRad;
    if (bad >= 0.5 * kPi) return std::numeric_limits<double>::infinity();
  }
  for (int i = 0; i < 30; ++i) (one_to_one(0.5 * (good + bad)) ? good : bad) = 0.5 * (good + bad);
  return std::tan(good);
}

bool Lens::ray_of(const Eigen::Vector2d& pixel, Eigen::Vector3d& ray) const {
  const Eigen::Vector2d seen((pixel.x() - cx_) / fx_, (pixel.y() - cy_) / fy_);
  if (!seen.allFinite()) return false;
  Eigen::Vector2d ideal = seen;
  if (distorted_) {
    // Newton's steps are shortened until they come nearer to the goal inside the fold, so that none crosses it.
    const double fold = fold_radius();
    if (ideal.norm() >= fold) ideal *= 0.9 * fold / ideal.norm();
    Eigen::Vector2d error = distort(ideal) - seen;
    for (int i = 0; i < kIterations && error.norm() > kConverged; ++i) {
      Eigen::Matrix2d j;
      if (!jacobian(ideal, j)) return false;
      Eigen::Vector2d step = j.inverse() * error, next, next_error;
      for (int halvings = 0;; ++halvings, step *= 0.5) {
        next = ideal - step;
        next_error = distort(next) - seen;
        if (next.squaredNorm() < fold2_ && next_error.norm() < error.norm()) break;
        if (halvings == 30) return false;
      }
      ideal = next;
      error = next_error;
    }
    if (!(error.norm() <= kConverged)) return false;
  }
  ray = {ideal.x(), ideal.y(), 1};
  return true;
}

Attitude attitude_from(const Eigen::Matrix3d& r) {
  const double pitch = std::atan2(-r(2, 0), std::hypot(r(2, 1), r(2, 2)));
  if (std::abs(std::cos(pitch)) < 1e-9) return {0, pitch, std::atan2(-r(0, 1), r(1, 1))};
  return {std::atan2(r(2, 1), r(2, 2)), pitch, std::atan2(r(1, 0), r(0, 0))};
}

}  // namespace landfix::nav

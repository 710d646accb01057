#include "builder/navigability/information.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "runtime/features/gray.h"

namespace landfix::navigability {
namespace {

constexpr double kSobelScale = 8;   // it answers so much to a slope of one gray level per pixel
constexpr double kSensorNoise = 3;  // gray levels, of map and camera together where no other date tells
constexpr double kLeastNoise2 = 1;  // of values that are whole gray levels
constexpr int kLeastPixels = 30;    // that two images share, to fit gain and offset

cv::Mat gray_of(const features::GridImage& image) {
  cv::Mat out;
  features::gray_from_rgb(image.pixels).convertTo(out, CV_64F);
  return out;
}

cv::Mat valid_of(const features::GridImage& image) {
  return image.valid.empty() ? cv::Mat(image.pixels.size(), CV_8U, cv::Scalar(255)) : image.valid;
}

Eigen::Matrix2d matrix_of(const std::array<double, 4>& m) { return Eigen::Map<const Eigen::Matrix2d>(m.data()); }

std::array<double, 4> array_of(const Eigen::Matrix2d& m) { return {m(0, 0), m(0, 1), m(1, 0), m(1, 1)}; }

}  // namespace

Information::Information(const features::GridImage& camera, const features::GridImage& map) {
  const auto add_up = [&](Sum which, const cv::Mat& values, const cv::Mat& where) {
    cv::Mat counted;
    values.copyTo(counted, where);  // zero elsewhere
    cv::integral(counted, sums_[which], CV_64F);
  };
  const cv::Mat gray = gray_of(camera), valid = valid_of(camera);
  cv::Mat east, south, inside;
  cv::Sobel(gray, east, CV_64F, 1, 0, 3, 1 / kSobelScale, 0, cv::BORDER_REPLICATE);
  cv::Sobel(gray, south, CV_64F, 0, 1, 3, 1 / kSobelScale, 0, cv::BORDER_REPLICATE);
  cv::erode(valid, inside, cv::Mat::ones(3, 3, CV_8U));
  add_up(kXX, east.mul(east), inside);
  add_up(kXY, -east.mul(south), inside);
  add_up(kYY, south.mul(south), inside);
  if (map.pixels.empty()) return;
  const cv::Mat other = gray_of(map), both = valid & valid_of(map);
  add_up(kBoth, cv::Mat::ones(gray.size(), CV_64F), both);
  add_up(kCamera, gray, both);
  add_up(kMap, other, both);
  add_up(kCameraCamera, gray.mul(gray), both);
  add_up(kCameraMap, gray.mul(other), both);
  add_up(kMapMap, other.mul(other), both);
}

double Information::sum(Sum which, const cv::Rect& r) const {
  const cv::Mat_<double> s = sums_[which];
  return s(r.br()) - s(r.y, r.br().x) - s(r.br().y, r.x) + s(r.tl());
}

// Variance that the map's values, scaled and shifted, do not explain.
double Information::noise_of(const cv::Rect& view) const {
  const double count = sums_[kBoth].empty() ? 0 : sum(kBoth, view);
  if (count < kLeastPixels) return kSensorNoise * kSensorNoise;
  const double c = sum(kCamera, view) / count, m = sum(kMap, view) / count;
  const double cc = sum(kCameraCamera, view) / count - c * c, cm = sum(kCameraMap, view) / count - c * m,
               mm = sum(kMapMap, view) / count - m * m;
  return std::max(mm > kLeastNoise2 ? cc - cm * cm / mm : cc, kLeastNoise2);
}

std::array<double, 4> Information::least_covariance_px2(const cv::Rect& view, double search_px) const {
  const cv::Rect inside = view & cv::Rect(0, 0, sums_[kXX].cols - 1, sums_[kXX].rows - 1);
  Eigen::Matrix2d information = Eigen::Matrix2d::Identity() * (3 / (search_px * search_px));
  if (!inside.empty()) {
    const double noise = noise_of(inside), xy = sum(kXY, inside);
    Eigen::Matrix2d gradients;
    gradients << sum(kXX, inside), xy, xy, sum(kYY, inside);
    information += gradients / noise;
  }
  return array_of(information.inverse());
}

std::array<double, 4> bounded_below(const std::array<double, 4>& covariance, const std::array<double, 4>& least) {
  const Eigen::Matrix2d bound = matrix_of(least);
  if (Eigen::LLT<Eigen::Matrix2d>(bound).info() != Eigen::Success) return covariance;  // none is known
  // C v = λ B v with VᵀBV = 1: C = B V Λ Vᵀ B, which is at least B where no λ is below 1.
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> solver(matrix_of(covariance), bound);
  const Eigen::Matrix2d axes = bound * solver.eigenvectors();
  return array_of(axes * solver.eigenvalues().cwiseMax(1).asDiagonal() * axes.transpose());
}

}  // namespace landfix::navigability

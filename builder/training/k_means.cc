#include "builder/training/k_means.h"

#include <algorithm>
#include <limits>
#include <opencv2/flann.hpp>
#include <vector>

namespace landfix::landmarks {
namespace {

constexpr int kSteps = 25;

double squared_distance(const cv::Mat& a, const cv::Mat& b) {
  double sum = 0;
  for (int d = 0; d < a.cols; ++d) {
    const double apart = double(a.at<float>(d)) - b.at<float>(d);
    sum += apart * apart;
  }
  return sum;
}

/// Points far from all centres so far are the likelier to be the next.
cv::Mat spread_centres(const cv::Mat& points, int words, cv::RNG& random) {
  cv::Mat centres = points.row(random.uniform(0, points.rows)).clone();
  std::vector<double> nearest(size_t(points.rows), std::numeric_limits<double>::infinity());
  while (centres.rows < words) {
    double total = 0;
    const cv::Mat last = centres.row(centres.rows - 1);
    for (int i = 0; i < points.rows; ++i)
      total += nearest[size_t(i)] = std::min(nearest[size_t(i)], squared_distance(points.row(i), last));
    double left = random.uniform(0.0, 1.0) * total;
    int next = 0;
    while (next + 1 < points.rows && (left -= nearest[size_t(next)]) >= 0) ++next;
    centres.push_back(points.row(next));
  }
  return centres;
}

}  // namespace

cv::Mat k_means(const cv::Mat& points, int words, uint64_t seed) {
  CV_Assert(points.type() == CV_32FC1 && words >= 1 && points.rows >= words);
  cv::RNG random(seed);
  cv::Mat centres = spread_centres(points, words, random), nearest, distances;
  for (int step = 0; step < kSteps; ++step) {
    cv::flann::Index(centres, cv::flann::LinearIndexParams()).knnSearch(points, nearest, distances, 1);
    cv::Mat sums = cv::Mat::zeros(centres.size(), CV_64FC1), next = centres.clone();
    std::vector<int> counts(size_t(words), 0);
    for (int i = 0; i < points.rows; ++i) {
      const int word = nearest.at<int>(i);
      ++counts[size_t(word)];
      for (int d = 0; d < points.cols; ++d) sums.at<double>(word, d) += points.at<float>(i, d);
    }
    for (int word = 0; word < words; ++word)
      for (int d = 0; d < points.cols && counts[size_t(word)] > 0; ++d)
        next.at<float>(word, d) = float(sums.at<double>(word, d) / counts[size_t(word)]);
    if (std::equal(next.begin<float>(), next.end<float>(), centres.begin<float>())) break;
    centres = next;
  }
  return centres;
}

}  // namespace landfix::landmarks

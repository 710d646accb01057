// Scenes with roads, drawn for tests.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "tiles/road.h"

namespace landfix::landmarks {

inline uint32_t noise_at(int x, int y) { return (uint32_t(x) * 73856093u ^ uint32_t(y) * 19349663u) * 2654435761u; }

/// Green ground with gray roads of 6 m, and noise that is the same everywhere.
inline cv::Mat drawn(const cv::Size& size, const std::vector<std::pair<cv::Point, cv::Point>>& roads) {
  cv::Mat image(size, CV_8UC3, cv::Scalar(80, 110, 60));
  for (const auto& [a, b] : roads) cv::line(image, a, b, {150, 150, 150}, 6, cv::LINE_AA);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      for (int k = 0; k < 3; ++k) image.at<cv::Vec3b>(y, x)[k] += uint8_t(noise_at(x + 7 * k, y) >> 28);
  return image;
}

inline size_t intersections(const tiles::RoadGraph& graph) {
  size_t count = 0;
  for (const tiles::RoadNode& n : graph.nodes) count += n.kind == tiles::RoadNodeKind::kIntersection;
  return count;
}

inline double total_length(const tiles::RoadGraph& graph) {
  double sum = 0;
  for (const tiles::RoadEdge& e : graph.edges) sum += tiles::length_of(graph, e);
  return sum;
}

}  // namespace landfix::landmarks

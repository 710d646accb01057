// Where on the map templates were found, refused and taken for true though they were false.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "tools/eval/report.h"

namespace landfix::eval {

/// A panel per matcher: the map, and a mark per trial of the first seed at the true place of its template, by outcome.
/// CV_8UC3 in OpenCV's order.
cv::Mat draw_registration(const std::vector<CameraTrials>& trials, const nav::MapSource& map);

}  // namespace landfix::eval

// A camera's calibration as a file.
#pragma once

#include <string>

#include "runtime/nav/camera.h"

namespace landfix::tools {

/// Reads a calibration in YAML: as OpenCV's calibration sample or ROS's camera_calibration write it (image_width,
/// image_height, camera_matrix, distortion_coefficients; matrices as maps with `data`), or a ROS camera_info message
/// (width, height, K or k, D or d). Distortion: 0, 4, 5 or 8 coefficients of the models plumb_bob and
/// rational_polynomial (12 or 14 where the further ones are 0). Pixel (0, 0) is the centre of the top left pixel, in
/// those programs as here. Throws Error(kIo) where the file cannot be read and Error(kBadInput) naming the key, what
/// was expected and what was found.
nav::Camera read_camera_model(const std::string& path);

/// The calibration for a photograph's size: a photograph may have been shrunk since it was taken. Throws
/// Error(kBadInput), naming `path`, where the sides have another ratio.
nav::Camera fitted(const nav::Camera& camera, cv::Size size, const std::string& path);

}  // namespace landfix::tools

// A photograph and what its file says about where and how it was taken.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "runtime/nav/camera.h"
#include "tiles/geodesy.h"

namespace landfix::tools {

/// What EXIF and XMP (DJI's names) state; nothing where a tag is missing or not a number.
struct PhotoTags {
  std::string file;    ///< path, for messages
  std::string camera;  ///< maker and model
  std::optional<tiles::Geodetic> place;
  std::optional<double> altitude_m;           ///< as tagged; which datum, the file does not say
  std::optional<double> relative_altitude_m;  ///< above the take-off point
  std::optional<double> gimbal_yaw_rad;       ///< clockwise from true north
  std::optional<double> gimbal_pitch_rad;     ///< 0 level, −π/2 straight down
  std::optional<double> gimbal_roll_rad;
  std::optional<double> flight_yaw_rad;
  std::optional<double> focal_length_mm, focal_length_35mm_mm;
  std::optional<double> sensor_width_mm;
  std::optional<double> calibrated_focal_length_px;  ///< at `tagged_width_px`
  std::optional<double> tagged_width_px;             ///< of the picture as taken; the file may have been shrunk since
  std::string capture_time;                          ///< ISO 8601, local unless it ends with an offset
  /// A program wrote the file again after it was taken (DateTime later than DateTimeOriginal): it may have turned the
  /// picture, and the attitude in the tags then belongs to another picture.
  bool edited = false;
  std::optional<int> rtk_flag;  ///< DJI: 0 none, 16 single point, 34 float, 50 fixed
  std::optional<double> rtk_sigma_east_m, rtk_sigma_north_m, rtk_sigma_up_m;
};

/// Reads the tags. Throws Error(kIo) where the file cannot be opened and Error(kBadInput) where it is no picture with
/// metadata that exiv2 reads.
PhotoTags read_photo_tags(const std::string& path);

/// H×W CV_8UC3 (red, green, blue), as the sensor lies: the orientation tag, which is for people, does not turn it.
/// Serves any image of 8 bits. Throws Error(kIo) or Error(kBadInput).
cv::Mat read_photo_pixels(const std::string& path);

/// Throws Error(kBadInput) that lists every tag without which a photograph cannot be placed (position, relative
/// altitude, gimbal yaw and pitch; focal length unless `camera_known`) and says what to do.
void require_placeable(const PhotoTags& tags, bool camera_known);

/// Pinhole camera for an image of this size from, in this order: the calibrated focal length, the focal length as 35 mm
/// equivalent, focal length and sensor width. `source`, if given, says in words which one it was. Good to a few per
/// cent: lens distortion is not in the tags. Throws Error(kBadInput) where all are missing.
nav::Camera camera_from_tags(const PhotoTags& tags, int width, int height, std::string* source = nullptr);

/// Attitude of the nadir mount (nav/camera.h) for gimbal angles, all in radians: the gimbal turns by yaw (clockwise
/// from true north), pitch and roll a camera that looks level northwards. Straight down yaw and roll turn about the
/// same axis; their sum is what counts. `convergence_rad`: as tiles::GridPoint has it.
nav::Attitude attitude_from_gimbal(double yaw_rad, double pitch_rad, double roll_rad, double convergence_rad);

/// Position and attitude on the grid by a photograph's tags.
struct PhotoPose {
  double east_m = 0, north_m = 0;
  nav::Attitude attitude;
};

/// Throws as `require_placeable`, and Error(kBadInput) where the place lies outside the zone's domain.
PhotoPose pose_from_tags(const PhotoTags& tags, const tiles::Zone& zone);

}  // namespace landfix::tools

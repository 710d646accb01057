// Photographs and camera models as files: every tag that is read, every convention, and what is said when one is
// missing.
#include "tools/common/photo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <exiv2/exiv2.hpp>
#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>

#include "builder/error.h"
#include "tools/common/camera_model.h"

namespace landfix::tools {
namespace {

namespace fs = std::filesystem;
using Write = std::function<void(Exiv2::ExifData&, Exiv2::XmpData&)>;

constexpr double kDegree = 0.017453292519943295;

std::string path_of(const std::string& name) {
  const fs::path folder = fs::path(::testing::TempDir()) / "landfix_photo";
  fs::create_directories(folder);
  return (folder / (::testing::UnitTest::GetInstance()->current_test_info()->name() + ("_" + name))).string();
}

/// A red JPEG with a blue right half, tagged by `write`.
std::string photograph(const Write& write, int width = 400, int height = 300) {
  const std::string path = path_of("photo.jpg");
  cv::Mat image(height, width, CV_8UC3, cv::Scalar(0, 0, 255));  // OpenCV's order: blue, green, red
  image.colRange(width / 2, width).setTo(cv::Scalar(255, 0, 0));
  EXPECT_TRUE(cv::imwrite(path, image));
  const auto file = Exiv2::ImageFactory::open(path);
  file->readMetadata();
  Exiv2::ExifData exif;
  Exiv2::XmpData xmp;
  Exiv2::XmpProperties::registerNs("http://www.dji.com/drone-dji/1.0/", "drone-dji");
  write(exif, xmp);
  file->setExifData(exif);
  file->setXmpData(xmp);
  file->writeMetadata();
  return path;
}

void place(Exiv2::ExifData& exif) {
  exif["Exif.GPSInfo.GPSLatitudeRef"] = "S";
  exif["Exif.GPSInfo.GPSLatitude"] = "46/1 50/1 3312/100";
  exif["Exif.GPSInfo.GPSLongitudeRef"] = "W";
  exif["Exif.GPSInfo.GPSLongitude"] = "91/1 59/1 4026/100";
}

/// Everything that a DJI aircraft writes and this reads.
void full(Exiv2::ExifData& exif, Exiv2::XmpData& xmp) {
  place(exif);
  exif["Exif.Image.Make"] = "DJI";
  exif["Exif.Image.Model"] = "FC300S";
  exif["Exif.Image.Orientation"] = uint16_t(3);
  exif["Exif.GPSInfo.GPSAltitude"] = "19831/100";
  exif["Exif.Photo.DateTimeOriginal"] = "2016:06:23 16:31:59";
  exif["Exif.Photo.FocalLength"] = "361/100";
  exif["Exif.Photo.FocalLengthIn35mmFilm"] = uint16_t(20);
  exif["Exif.Photo.PixelXDimension"] = uint32_t(4000);
  xmp["Xmp.drone-dji.RelativeAltitude"] = "+39.80";
  xmp["Xmp.drone-dji.GimbalYawDegree"] = "+45.00";
  xmp["Xmp.drone-dji.GimbalPitchDegree"] = "-89.90";
  xmp["Xmp.drone-dji.GimbalRollDegree"] = "+0.00";
  xmp["Xmp.drone-dji.FlightYawDegree"] = "-46.00";
  xmp["Xmp.drone-dji.RtkFlag"] = "50";
  xmp["Xmp.drone-dji.RtkStdLon"] = "0.011";
  xmp["Xmp.drone-dji.RtkStdLat"] = "0.012";
  xmp["Xmp.drone-dji.RtkStdHgt"] = "0.025";
}

/// The message of the Error that a call throws.
template <typename Call>
std::string refusal(ExitCode code, Call call) {
  try {
    call();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), code) << e.what();
    return e.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

#define EXPECT_SAYS(message, words) EXPECT_NE((message).find(words), std::string::npos) << (message)

TEST(Photo, TagsAreRead) {
  const PhotoTags t = read_photo_tags(photograph(full));
  EXPECT_EQ(t.camera, "DJI FC300S");
  ASSERT_TRUE(t.place);
  EXPECT_NEAR(t.place->latitude_rad / kDegree, -(46 + 50 / 60. + 33.12 / 3600), 1e-9);
  EXPECT_NEAR(t.place->longitude_rad / kDegree, -(91 + 59 / 60. + 40.26 / 3600), 1e-9);
  EXPECT_NEAR(t.altitude_m.value(), 198.31, 1e-9);
  EXPECT_NEAR(t.relative_altitude_m.value(), 39.8, 1e-9);
  EXPECT_NEAR(t.gimbal_yaw_rad.value(), 45 * kDegree, 1e-9);
  EXPECT_NEAR(t.gimbal_pitch_rad.value(), -89.9 * kDegree, 1e-9);
  EXPECT_EQ(t.gimbal_roll_rad.value(), 0);
  EXPECT_NEAR(t.flight_yaw_rad.value(), -46 * kDegree, 1e-9);
  EXPECT_NEAR(t.focal_length_mm.value(), 3.61, 1e-9);
  EXPECT_EQ(t.focal_length_35mm_mm.value(), 20);
  EXPECT_EQ(t.tagged_width_px.value(), 4000);
  EXPECT_EQ(t.capture_time, "2016-06-23T16:31:59");
  EXPECT_FALSE(t.edited) << "nothing says when the file was written";
  EXPECT_EQ(t.rtk_flag.value(), 50);
  EXPECT_NEAR(t.rtk_sigma_east_m.value(), 0.011, 1e-12);
  EXPECT_NEAR(t.rtk_sigma_up_m.value(), 0.025, 1e-12);
  EXPECT_FALSE(t.sensor_width_mm);
  EXPECT_FALSE(t.calibrated_focal_length_px);
  EXPECT_NO_THROW(require_placeable(t, false));
}

TEST(Photo, PixelsAreRgbAsTheSensorLies) {
  // The orientation tag says upside down; the left half must stay red.
  const cv::Mat rgb = read_photo_pixels(photograph(full));
  ASSERT_EQ(rgb.size(), cv::Size(400, 300));
  const cv::Vec3b left = rgb.at<cv::Vec3b>(150, 50), right = rgb.at<cv::Vec3b>(150, 350);
  EXPECT_GT(left[0], 240);
  EXPECT_LT(left[2], 15);
  EXPECT_GT(right[2], 240);
}

TEST(Photo, WhatDjiWritesItselfComesFirst) {
  const PhotoTags t = read_photo_tags(photograph([](Exiv2::ExifData& exif, Exiv2::XmpData& xmp) {
    full(exif, xmp);
    xmp["Xmp.drone-dji.GpsLatitude"] = "47.5";
    xmp["Xmp.drone-dji.GpsLongtitude"] = "+8.25";  // sic
    xmp["Xmp.drone-dji.AbsoluteAltitude"] = "-3.5";
  }));
  EXPECT_NEAR(t.place->latitude_rad, 47.5 * kDegree, 1e-12);
  EXPECT_NEAR(t.place->longitude_rad, 8.25 * kDegree, 1e-12);
  EXPECT_EQ(t.altitude_m.value(), -3.5);
}

TEST(Photo, NonsenseInTagsIsAsIfTheyWereMissing) {
  const PhotoTags t = read_photo_tags(photograph([](Exiv2::ExifData& exif, Exiv2::XmpData& xmp) {
    exif["Exif.GPSInfo.GPSLatitudeRef"] = "N";
    exif["Exif.GPSInfo.GPSLatitude"] = "46/0 0/0 0/0";
    exif["Exif.GPSInfo.GPSLongitudeRef"] = "E";
    exif["Exif.GPSInfo.GPSLongitude"] = "8/1 0/1 0/1";
    exif["Exif.Photo.FocalLength"] = "0/0";
    exif["Exif.Photo.FocalLengthIn35mmFilm"] = uint16_t(0);
    exif["Exif.Photo.DateTimeOriginal"] = "yesterday";
    xmp["Xmp.drone-dji.RelativeAltitude"] = "39,80";
    xmp["Xmp.drone-dji.GimbalYawDegree"] = "nan";
    xmp["Xmp.drone-dji.GimbalPitchDegree"] = "";
  }));
  EXPECT_FALSE(t.place);
  EXPECT_FALSE(t.focal_length_mm);
  EXPECT_FALSE(t.focal_length_35mm_mm);
  EXPECT_FALSE(t.relative_altitude_m);
  EXPECT_FALSE(t.gimbal_yaw_rad);
  EXPECT_FALSE(t.gimbal_pitch_rad);
  EXPECT_EQ(t.capture_time, "");
}

TEST(Photo, WrittenLaterThanTakenIsEdited) {
  const auto edited = [](const char* written, const char* taken) {
    return read_photo_tags(photograph([&](Exiv2::ExifData& exif, Exiv2::XmpData&) {
             if (*written) exif["Exif.Image.DateTime"] = written;
             if (*taken) exif["Exif.Photo.DateTimeOriginal"] = taken;
           }))
        .edited;
  };
  EXPECT_TRUE(edited("2016:06:23 19:24:42", "2016:06:23 16:31:59"));
  EXPECT_FALSE(edited("2016:06:23 16:31:59", "2016:06:23 16:31:59"));
  EXPECT_FALSE(edited("2016:06:23 19:24:42", "")) << "when it was taken is not known";
  EXPECT_FALSE(edited("", "2016:06:23 16:31:59"));
}

TEST(Photo, WithoutTagsTheMessageListsWhatIsMissing) {
  const PhotoTags bare = read_photo_tags(photograph([](Exiv2::ExifData&, Exiv2::XmpData&) {}));
  const std::string all = refusal(ExitCode::kBadInput, [&] { require_placeable(bare, false); });
  for (const char* words : {"photo.jpg", "position", "GPSLatitude", "RelativeAltitude", "GimbalYawDegree",
                            "GimbalPitchDegree", "FocalLengthIn35mmFilm", "camera model", "editors"})
    EXPECT_SAYS(all, words);
  const std::string camera_known = refusal(ExitCode::kBadInput, [&] { require_placeable(bare, true); });
  EXPECT_EQ(camera_known.find("ocal length"), std::string::npos) << camera_known;
  EXPECT_SAYS(refusal(ExitCode::kBadInput, [&] { camera_from_tags(bare, 400, 300); }), "camera model");
  const PhotoTags placed = read_photo_tags(photograph([](auto& exif, auto&) { place(exif); }));
  const std::string rest = refusal(ExitCode::kBadInput, [&] { pose_from_tags(placed, {15, true}); });
  EXPECT_EQ(rest.find("GPSLatitude"), std::string::npos) << rest;
  EXPECT_SAYS(rest, "GimbalYawDegree");
}

TEST(Photo, FilesThatAreNoPhotographsAreRefused) {
  const std::string missing = path_of("none.jpg"), text = path_of("text.jpg"), cut = path_of("cut.jpg");
  EXPECT_SAYS(refusal(ExitCode::kIo, [&] { read_photo_tags(missing); }), "none.jpg");
  EXPECT_SAYS(refusal(ExitCode::kIo, [&] { read_photo_pixels(missing); }), "none.jpg");
  EXPECT_SAYS(refusal(ExitCode::kIo, [&] { read_photo_tags(::testing::TempDir()); }), "opened");
  std::ofstream(text) << "this is no picture";
  EXPECT_SAYS(refusal(ExitCode::kBadInput, [&] { read_photo_tags(text); }), "exiv2");
  EXPECT_SAYS(refusal(ExitCode::kBadInput, [&] { read_photo_pixels(text); }), "decoded");
  std::ofstream(cut, std::ios::binary) << "\xff\xd8\xff\xe1";
  EXPECT_SAYS(refusal(ExitCode::kBadInput, [&] { read_photo_pixels(cut); }), "cut.jpg");
}

TEST(PhotoCamera, ComesFromTheBestTagThatThereIs) {
  std::string source;
  PhotoTags t;
  t.focal_length_mm = 8.8;
  t.sensor_width_mm = 13.2;
  nav::Camera c = camera_from_tags(t, 5472, 3648, &source);
  EXPECT_NEAR(c.fx, 5472 * 8.8 / 13.2, 1e-9);
  EXPECT_SAYS(source, "sensor width");
  t.focal_length_35mm_mm = 24;
  c = camera_from_tags(t, 5472, 3648, &source);
  EXPECT_NEAR(c.fx, 3648, 1);  // 24 mm is as long as the film is high; this picture has the film's 3:2
  EXPECT_SAYS(source, "35 mm");
  // A 16:9 cut-out has the focal length of the whole 4:3 sensor: 20 mm of it are 94.5° across the diagonal of 5000 px.
  t.focal_length_35mm_mm = 20;
  EXPECT_NEAR(camera_from_tags(t, 4000, 2250).fx, 2311, 1);
  EXPECT_NEAR(camera_from_tags(t, 4000, 3000).fx, 2311, 1);
  t.calibrated_focal_length_px = 3666.7;
  t.tagged_width_px = 5472;
  c = camera_from_tags(t, 2736, 1824, &source);  // the file was shrunk to half
  EXPECT_NEAR(c.fx, 1833.35, 1e-9);
  EXPECT_SAYS(source, "calibrated");
  EXPECT_EQ(c.width, 2736);
  EXPECT_EQ(c.cx, 1367.5);
  EXPECT_EQ(c.cy, 911.5);
  EXPECT_TRUE(c.distortion.none());
}

TEST(PhotoCamera, KnowsTheSensorFromItsPixelDensity) {
  const PhotoTags t = read_photo_tags(photograph([](Exiv2::ExifData& exif, Exiv2::XmpData&) {
    exif["Exif.Photo.FocalPlaneXResolution"] = "4145454/1000";  // per cm: 5472 px on 13.2 mm
    exif["Exif.Photo.FocalPlaneResolutionUnit"] = uint16_t(3);
    exif["Exif.Photo.PixelXDimension"] = uint32_t(5472);
  }));
  EXPECT_NEAR(t.sensor_width_mm.value(), 13.2, 1e-4);
}

void expect_direction(const Eigen::Vector3d& found, const Eigen::Vector3d& expected, const char* what) {
  EXPECT_LT((found - expected).norm(), 1e-9) << what << ": " << found.transpose();
}

TEST(GimbalAttitude, StraightDownYawIsHeading) {
  for (double yaw_deg : {0.0, 45.0, -131.0, 179.0}) {
    const nav::Attitude a = attitude_from_gimbal(yaw_deg * kDegree, -90 * kDegree, 0, 0);
    EXPECT_NEAR(a.roll, 0, 1e-9);
    EXPECT_NEAR(a.pitch, 0, 1e-9);
    EXPECT_NEAR(std::remainder(a.heading - yaw_deg * kDegree, 2 * M_PI), 0, 1e-9);
  }
  // The top of the image points north-east at a yaw of 45°: the camera's y axis points south-west.
  const Eigen::Matrix3d enu = nav::enu_from_camera(attitude_from_gimbal(45 * kDegree, -90 * kDegree, 0, 0));
  expect_direction(enu.col(2), {0, 0, -1}, "optical axis");
  expect_direction(enu.col(1), {-std::sqrt(0.5), -std::sqrt(0.5), 0}, "down the image");
}

TEST(GimbalAttitude, ObliqueViewsLookWhereTheGimbalPoints) {
  const Eigen::Matrix3d east = nav::enu_from_camera(attitude_from_gimbal(90 * kDegree, -45 * kDegree, 0, 0));
  expect_direction(east.col(2), {std::sqrt(0.5), 0, -std::sqrt(0.5)}, "optical axis");
  expect_direction(east.col(0), {0, -1, 0}, "right in the image");
  const Eigen::Matrix3d level = nav::enu_from_camera(attitude_from_gimbal(0, 0, 0, 0));
  expect_direction(level.col(2), {0, 1, 0}, "optical axis");
  expect_direction(level.col(1), {0, 0, -1}, "down the image");
  // Rolled to the right: the right side of the image sinks.
  EXPECT_LT(nav::enu_from_camera(attitude_from_gimbal(0, -30 * kDegree, 10 * kDegree, 0))(2, 0), -0.1);
}

TEST(GimbalAttitude, StraightDownYawAndRollAddUp) {
  // The gimbal's own lock: the same view written as yaw 40°, as yaw 30° with roll 10°, or turned over by 180°.
  const Eigen::Matrix3d plain = nav::enu_from_camera(attitude_from_gimbal(40 * kDegree, -90 * kDegree, 0, 0));
  for (double roll_deg : {10.0, -25.0, 180.0}) {
    const nav::Attitude a = attitude_from_gimbal((40 - roll_deg) * kDegree, -90 * kDegree, roll_deg * kDegree, 0);
    EXPECT_LT((nav::enu_from_camera(a) - plain).norm(), 1e-9) << roll_deg;
    EXPECT_NEAR(a.heading, 40 * kDegree, 1e-9);
  }
}

TEST(GimbalAttitude, PoseIsOnTheGridNotOnTrueNorth) {
  const PhotoTags t = read_photo_tags(photograph([](Exiv2::ExifData& exif, Exiv2::XmpData& xmp) {
    full(exif, xmp);
    exif["Exif.GPSInfo.GPSLatitudeRef"] = "N";
  }));
  // 1.0055° east of zone 15's central meridian, latitude 46.84°: grid north lies 1.0055° · sin(46.84°) = 0.733° east
  // of true north, and a true heading of 45° is a grid heading of 44.27°.
  const PhotoPose p = pose_from_tags(t, {15, true});
  EXPECT_NEAR(p.attitude.heading, (45 - 0.7334) * kDegree, 1e-4);
  EXPECT_NEAR(p.attitude.pitch, 0.1 * kDegree, 1e-9);
  EXPECT_NEAR(p.east_m, 576'667, 40);
  EXPECT_NEAR(p.north_m, 5'188'156, 60);
  EXPECT_SAYS(refusal(ExitCode::kBadInput, [&] { pose_from_tags(t, {45, true}); }), "zone");
}

std::string model(const std::string& yaml) {
  const std::string path = path_of("camera.yaml");
  std::ofstream(path) << yaml;
  return path;
}

constexpr char kRos[] =
    "image_width: 640\nimage_height: 480\ncamera_name: narrow\n"
    "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [500.5, 0, 320.25, 0, 501, 239.75, 0, 0, 1]\n"
    "distortion_model: plumb_bob\n"
    "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.3, 0.1, 0.001, -0.002, 0.05]\n";

std::string with(std::string yaml, const std::string& from, const std::string& to) {
  const size_t found = yaml.find(from);
  EXPECT_NE(found, std::string::npos) << from;
  return yaml.replace(found, from.size(), to);
}

TEST(CameraModel, IsReadAsRosWritesIt) {
  const nav::Camera c = read_camera_model(model(kRos));
  EXPECT_EQ(c.width, 640);
  EXPECT_EQ(c.height, 480);
  EXPECT_EQ(c.fx, 500.5);
  EXPECT_EQ(c.fy, 501);
  EXPECT_EQ(c.cx, 320.25);
  EXPECT_EQ(c.cy, 239.75);
  EXPECT_EQ(c.distortion, (nav::Distortion{-0.3, 0.1, 0.001, -0.002, 0.05}));
  const nav::Camera info = read_camera_model(
      model("width: 640\nheight: 480\ndistortion_model: rational_polynomial\nD: [1, 2, 3, 4, 5, 6, 7, 8]\n"
            "K: [500.5, 0, 320.25, 0, 501, 239.75, 0, 0, 1]\n"));
  EXPECT_EQ(info.fx, 500.5);
  EXPECT_EQ(info.distortion, (nav::Distortion{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_TRUE(read_camera_model(model("width: 640\nheight: 480\nk: [5, 0, 3, 0, 5, 2, 0, 0, 1]\n")).distortion.none());
}

TEST(CameraModel, IsReadAsOpenCvWritesIt) {
  const std::string path = path_of("opencv.yml");
  cv::FileStorage out(path, cv::FileStorage::WRITE);
  out << "calibration_time"
      << "today"
      << "image_width" << 1920 << "image_height" << 1080 << "camera_matrix"
      << (cv::Mat_<double>(3, 3) << 1400, 0, 959.5, 0, 1401, 539.5, 0, 0, 1) << "distortion_coefficients"
      << (cv::Mat_<double>(5, 1) << -0.3, 0.1, 0.001, -0.002, 0.05) << "avg_reprojection_error" << 0.3;
  out.release();
  const nav::Camera c = read_camera_model(path);
  EXPECT_EQ(c.width, 1920);
  EXPECT_EQ(c.fy, 1401);
  EXPECT_EQ(c.distortion, (nav::Distortion{-0.3, 0.1, 0.001, -0.002, 0.05}));
}

TEST(CameraModel, SaysWhatIsWrong) {
  const auto says = [](const std::string& yaml) {
    return refusal(ExitCode::kBadInput, [&] { read_camera_model(model(yaml)); });
  };
  EXPECT_SAYS(refusal(ExitCode::kIo, [] { read_camera_model(path_of("none.yaml")); }), "none.yaml");
  EXPECT_SAYS(says("just words"), "camera.yaml");
  EXPECT_SAYS(says("a: [1, 2\nb: }"), "camera.yaml");
  EXPECT_SAYS(says(with(kRos, "camera_matrix", "camera_metrics")), "has no 'camera_matrix'");
  EXPECT_SAYS(says(with(kRos, "image_width", "image_with")), "has no 'image_width'");
  EXPECT_SAYS(says(with(kRos, "image_width: 640", "image_width: wide")), "no number");
  EXPECT_SAYS(says(with(kRos, "image_height: 480", "image_height: 0")), "640x0");
  EXPECT_SAYS(says(with(kRos, "[500.5, 0, 320.25, 0, 501, 239.75, 0, 0, 1]", "[500.5, 0, 320.25]")), "3 numbers");
  EXPECT_SAYS(says(with(kRos, "[500.5, 0,", "[500.5, 0.2,")), "[fx, 0, cx, 0, fy, cy, 0, 0, 1]");
  EXPECT_SAYS(says(with(kRos, "[500.5", "[-500.5")), "focal length");
  EXPECT_SAYS(says(with(kRos, "[-0.3, 0.1, 0.001, -0.002, 0.05]", "[-0.3, 0.1]")), "2 distortion coefficients");
  EXPECT_SAYS(says(with(kRos, "plumb_bob", "equidistant")), "equidistant");
  EXPECT_SAYS(says(with(kRos, "0.05]", "0.05, 0, 0, 0, 0.1, 0, 0, 0]")), "thin-prism");
}

}  // namespace
}  // namespace landfix::tools

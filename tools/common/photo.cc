#include "tools/common/photo.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <exiv2/exiv2.hpp>
#include <filesystem>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "builder/error.h"

namespace landfix::tools {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegree = kPi / 180;
constexpr double kFilmDiagonalMm = 43.266615305567875;          ///< of 36 mm × 24 mm
constexpr double kUsualSensor = 4.0 / 3, kWidestSensor = 1.55;  ///< long side over short side

/// A number such as "+39.80", whatever the locale.
std::optional<double> number(std::string text) {
  if (text.starts_with('+')) text.erase(0, 1);
  double value;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<double> in_radians(const std::optional<double>& degrees) {
  return degrees ? std::optional(*degrees * kDegree) : std::nullopt;
}

/// Tags by name; a missing one is nothing.
class Tags {
 public:
  Tags(const Exiv2::ExifData& exif, const Exiv2::XmpData& xmp) : exif_(exif), xmp_(xmp) {}

  std::string exif_text(const char* name) const {
    const auto found = exif_.findKey(Exiv2::ExifKey(name));
    return found == exif_.end() ? "" : found->toString();
  }
  /// A rational or whole number; nothing for x/0.
  std::optional<double> exif(const char* name, long index = 0) const {
    const auto found = exif_.findKey(Exiv2::ExifKey(name));
    if (found == exif_.end() || index >= long(found->count())) return std::nullopt;
    const Exiv2::Rational r = found->toRational(index);
    return r.second == 0 ? std::nullopt : std::optional(double(r.first) / r.second);
  }
  /// A positive number: EXIF writes 0 for "not known".
  std::optional<double> positive_exif(const char* name) const {
    const std::optional<double> value = exif(name);
    return value && *value > 0 ? value : std::nullopt;
  }
  std::optional<double> dji(const std::string& name) const {
    for (const auto& datum : xmp_)  // no XmpKey: it throws for a namespace that no file has introduced yet
      if (datum.key() == "Xmp.drone-dji." + name) return number(datum.toString());
    return std::nullopt;
  }
  /// Degrees, minutes and seconds with the letter of the hemisphere.
  std::optional<double> angle_deg(const std::string& name, char negative) const {
    const std::string key = "Exif.GPSInfo." + name, hemisphere = exif_text((key + "Ref").c_str());
    const std::optional<double> degrees = exif(key.c_str(), 0), minutes = exif(key.c_str(), 1),
                                seconds = exif(key.c_str(), 2);
    if (!degrees || hemisphere.empty()) return std::nullopt;
    const double size = *degrees + minutes.value_or(0) / 60 + seconds.value_or(0) / 3600;
    return hemisphere[0] == negative ? -size : size;
  }

 private:
  const Exiv2::ExifData& exif_;
  const Exiv2::XmpData& xmp_;
};

std::optional<tiles::Geodetic> place_of(const Tags& tags) {
  // DJI's own are decimal; its older files spell the longitude like this.
  std::optional<double> latitude = tags.dji("GpsLatitude"), longitude = tags.dji("GpsLongitude");
  if (!longitude) longitude = tags.dji("GpsLongtitude");
  if (!latitude || !longitude) {
    latitude = tags.angle_deg("GPSLatitude", 'S');
    longitude = tags.angle_deg("GPSLongitude", 'W');
  }
  if (!latitude || !longitude || std::abs(*latitude) > 90 || std::abs(*longitude) > 180) return std::nullopt;
  if (*latitude == 0 && *longitude == 0) return std::nullopt;  // written without a GNSS fix
  return tiles::Geodetic{*latitude * kDegree, *longitude * kDegree};
}

std::optional<double> altitude_of(const Tags& tags) {
  if (const std::optional<double> absolute = tags.dji("AbsoluteAltitude")) return absolute;
  const std::optional<double> size = tags.exif("Exif.GPSInfo.GPSAltitude");
  if (!size) return std::nullopt;
  return tags.exif("Exif.GPSInfo.GPSAltitudeRef").value_or(0) == 1 ? -*size : *size;
}

/// From the pixels per inch or centimetre on the sensor.
std::optional<double> sensor_width_mm(const Tags& tags, const std::optional<double>& width_px) {
  const std::optional<double> density = tags.positive_exif("Exif.Photo.FocalPlaneXResolution");
  if (!density || !width_px) return std::nullopt;
  const double unit = tags.exif("Exif.Photo.FocalPlaneResolutionUnit").value_or(2);
  const double unit_mm = unit == 3 ? 10 : unit == 4 ? 1 : unit == 5 ? 0.001 : 25.4;
  return *width_px / *density * unit_mm;
}

/// "2016:06:23 16:31:59" to "2016-06-23T16:31:59", with the offset from UTC where the camera knew it.
std::string capture_time(const Tags& tags) {
  std::string time = tags.exif_text("Exif.Photo.DateTimeOriginal");
  if (time.size() < 19 || time[4] != ':' || time[7] != ':' || time[10] != ' ') return "";
  time.resize(19);
  time[4] = time[7] = '-';
  time[10] = 'T';
  return time + tags.exif_text("Exif.Photo.OffsetTimeOriginal");
}

bool is_edited(const Tags& tags) {
  const std::string written = tags.exif_text("Exif.Image.DateTime"),
                    taken = tags.exif_text("Exif.Photo.DateTimeOriginal");
  return !taken.empty() && written > taken;  // "2016:06:23 19:24:42": the order of the texts is that of the times
}

PhotoTags tags_of(const std::string& path, const Tags& tags) {
  PhotoTags t;
  t.file = path;
  const std::string maker = tags.exif_text("Exif.Image.Make"), model = tags.exif_text("Exif.Image.Model");
  t.camera = maker.empty() ? model : maker + " " + model;
  t.place = place_of(tags);
  t.altitude_m = altitude_of(tags);
  t.relative_altitude_m = tags.dji("RelativeAltitude");
  t.gimbal_yaw_rad = in_radians(tags.dji("GimbalYawDegree"));
  t.gimbal_pitch_rad = in_radians(tags.dji("GimbalPitchDegree"));
  t.gimbal_roll_rad = in_radians(tags.dji("GimbalRollDegree"));
  t.flight_yaw_rad = in_radians(tags.dji("FlightYawDegree"));
  t.focal_length_mm = tags.positive_exif("Exif.Photo.FocalLength");
  t.focal_length_35mm_mm = tags.positive_exif("Exif.Photo.FocalLengthIn35mmFilm");
  t.calibrated_focal_length_px = tags.dji("CalibratedFocalLength");
  t.tagged_width_px = tags.positive_exif("Exif.Photo.PixelXDimension");
  t.sensor_width_mm = sensor_width_mm(tags, t.tagged_width_px);
  t.capture_time = capture_time(tags);
  t.edited = is_edited(tags);
  if (const std::optional<double> flag = tags.dji("RtkFlag")) t.rtk_flag = int(*flag);
  t.rtk_sigma_east_m = tags.dji("RtkStdLon");
  t.rtk_sigma_north_m = tags.dji("RtkStdLat");
  t.rtk_sigma_up_m = tags.dji("RtkStdHgt");
  return t;
}

/// Keeps what is written to standard error while one lives, one thread at a time: libpng, libjpeg and OpenCV write
/// there what is wrong with an image, besides returning it, and can only in part be told not to. Dropped unless
/// `show` passes it on.
class QuietDecoding {
 public:
  QuietDecoding() : lock_(mutex()), kept_(fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 0)), said_(memfd_create("said", 0)) {
    if (kept_ >= 0 && said_ >= 0) dup2(said_, STDERR_FILENO);
  }
  ~QuietDecoding() {
    if (kept_ >= 0) dup2(kept_, STDERR_FILENO);
    for (const int file : {kept_, said_})
      if (file >= 0) close(file);
  }
  QuietDecoding(const QuietDecoding&) = delete;
  QuietDecoding& operator=(const QuietDecoding&) = delete;

  /// Writes what was said so far, after the image's name.
  void show(const std::string& path) const {
    char text[512];
    const ssize_t length = said_ < 0 ? 0 : pread(said_, text, sizeof text, 0);
    if (length > 0 && kept_ >= 0) dprintf(kept_, "warning: %s: %.*s", path.c_str(), int(length), text);
  }

 private:
  static std::mutex& mutex() {
    static std::mutex mutex;
    return mutex;
  }
  const std::lock_guard<std::mutex> lock_;
  const int kept_, said_;
};

void require_file(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw Error(ExitCode::kIo, path + ": the image cannot be opened: no such file or no permission");
}

std::vector<std::string> missing_tags(const PhotoTags& t, bool camera_known) {
  std::vector<std::string> missing;
  if (!t.place) missing.push_back("position (EXIF GPSLatitude, GPSLongitude)");
  if (!t.relative_altitude_m) missing.push_back("height above ground (XMP drone-dji:RelativeAltitude)");
  if (!t.gimbal_yaw_rad) missing.push_back("heading (XMP drone-dji:GimbalYawDegree)");
  if (!t.gimbal_pitch_rad) missing.push_back("pitch (XMP drone-dji:GimbalPitchDegree)");
  if (!camera_known && !t.calibrated_focal_length_px && !t.focal_length_35mm_mm &&
      !(t.focal_length_mm && t.sensor_width_mm))
    missing.push_back("focal length (EXIF FocalLengthIn35mmFilm, or FocalLength with FocalPlaneXResolution)");
  return missing;
}

}  // namespace

PhotoTags read_photo_tags(const std::string& path) {
  require_file(path);
  static std::once_flag once;  // exiv2's XMP parser must be set up by one thread
  std::call_once(once, [] {
    Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute);
    Exiv2::XmpParser::initialize();
  });
  try {
    const auto image = Exiv2::ImageFactory::open(path);
    image->readMetadata();
    return tags_of(path, Tags(image->exifData(), image->xmpData()));
  } catch (const std::exception& e) {
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: expected a photograph with EXIF metadata, but exiv2 says: {}; use "
                            "the camera's own JPEG or TIFF file",
                            path, e.what()));
  }
}

cv::Mat read_photo_pixels(const std::string& path) {
  require_file(path);
  cv::Mat image;
  try {
    const QuietDecoding quiet;
    image = cv::imread(path, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
    if (!image.empty()) quiet.show(path);  // it is used: a truncated JPEG, say
  } catch (const cv::Exception& e) {
    throw Error(ExitCode::kBadInput, path + ": the image cannot be decoded: " + e.err);
  }
  if (image.empty())
    throw Error(ExitCode::kBadInput, path + ": the image cannot be decoded: not a JPEG, PNG or TIFF, or damaged");
  cv::cvtColor(image, image, cv::COLOR_BGR2RGB);
  return image;
}

void require_placeable(const PhotoTags& tags, bool camera_known) {
  const std::vector<std::string> missing = missing_tags(tags, camera_known);
  if (missing.empty()) return;
  throw Error(ExitCode::kBadInput,
              fmt::format("{}: the photograph lacks {}; use the file as the aircraft wrote it (editors and messengers "
                          "drop metadata), write the tags with exiv2 or exiftool{}",
                          tags.file, fmt::join(missing, ", "),
                          camera_known ? "" : ", or give the focal length by a camera model"));
}

nav::Camera camera_from_tags(const PhotoTags& t, int width, int height, std::string* source) {
  double focal_px;
  std::string how;
  if (t.calibrated_focal_length_px) {
    focal_px = *t.calibrated_focal_length_px * width / t.tagged_width_px.value_or(width);
    how = "calibrated focal length (XMP)";
  } else if (t.focal_length_35mm_mm) {
    // The equivalent compares diagonals, the sensor's whole one: a picture wider than 3:2 is cut out of a 4:3 sensor.
    const double long_px = std::max(width, height), short_px = std::min(width, height);
    const double sensor_short_px = long_px > kWidestSensor * short_px ? long_px / kUsualSensor : short_px;
    focal_px = *t.focal_length_35mm_mm / kFilmDiagonalMm * std::hypot(long_px, sensor_short_px);
    how = "35 mm equivalent focal length (EXIF)";
  } else if (t.focal_length_mm && t.sensor_width_mm) {
    focal_px = *t.focal_length_mm / *t.sensor_width_mm * width;
    how = "focal length and sensor width (EXIF)";
  } else {
    throw Error(ExitCode::kBadInput,
                t.file +
                    ": the photograph states no focal length (EXIF FocalLengthIn35mmFilm, or FocalLength with "
                    "FocalPlaneXResolution); give a camera model");
  }
  if (source) *source = how;
  return {width, height, focal_px, focal_px, 0.5 * (width - 1), 0.5 * (height - 1)};
}

nav::Attitude attitude_from_gimbal(double yaw_rad, double pitch_rad, double roll_rad, double convergence_rad) {
  // The gimbal's own frame looks forward (x) where a nadir mount looks down: camera z is its x, camera x its y.
  const Eigen::Matrix3d ned_from_gimbal = nav::ned_from_body({roll_rad, pitch_rad, yaw_rad - convergence_rad});
  Eigen::Matrix3d gimbal_from_camera;
  gimbal_from_camera << 0, 0, 1,  //
      1, 0, 0,                    //
      0, 1, 0;
  return nav::attitude_from(ned_from_gimbal * gimbal_from_camera * nav::body_from_nadir_camera().transpose());
}

PhotoPose pose_from_tags(const PhotoTags& tags, const tiles::Zone& zone) {
  require_placeable(tags, true);
  const std::optional<tiles::GridPoint> point = tiles::grid_from_geodetic(zone, *tags.place);
  if (!point)
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: the photograph was taken at latitude {:.5f}, longitude {:.5f}, outside of the map's "
                            "zone; check its tags",
                            tags.file, tags.place->latitude_rad / kDegree, tags.place->longitude_rad / kDegree));
  return {point->east_m, point->north_m,
          attitude_from_gimbal(*tags.gimbal_yaw_rad, *tags.gimbal_pitch_rad, tags.gimbal_roll_rad.value_or(0),
                               point->convergence_rad)};
}

}  // namespace landfix::tools

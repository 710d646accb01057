// Photographs with tags, drawn from a world in autumn, against a pack of the same place in summer.
#include <gtest/gtest.h>

#include <exiv2/exiv2.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "builder/build.h"
#include "runtime/nav/pack_map.h"
#include "tests/nav/scene.h"
#include "tests/tools/eval_world.h"
#include "tools/common/open_pack.h"
#include "tools/eval/photos.h"

namespace landfix::eval {
namespace {

using ingest::expect_error;
using ingest::kDegree;
constexpr double kAboveGroundM = 150, kTrueEastM = kWestM + 420, kTrueNorthM = kNorthM - 380;

/// How a photograph was taken, and what its tags say of it.
struct Shot {
  nav::testing::Pose pose = {kTrueEastM, kTrueNorthM, kAboveGroundM, {0, 0, 30 * kDegree}};
  double tag_east_m = 0, tag_north_m = 0;  ///< errors of the tagged position
  double tag_yaw_deg = 0;                  ///< error of the tagged heading
  double tag_height = 1;                   ///< factor of the relative altitude
  std::string taken = "2021:10:15 11:00:00", written = taken;
  bool turned = false;  ///< by an editor
};

class EvalPhotos : public EvalTest {
 protected:
  void SetUp() override {
    EvalTest::SetUp();
    // One pack for all tests: at 1 m, flat ground at the height of the ellipsoid.
    static const std::string pack = [this] {
      const std::string file = (std::filesystem::temp_directory_path() /
                                ("landfix_eval_photos_" + std::to_string(CPLGetCurrentProcessID()) + ".lfpack"))
                                   .string();
      BuildOptions options;
      options.images = {{.path = save("summer.tif", summer())}};
      options.zone = kZone;
      options.layers = {"gray", "orientation"};
      options.output = file;
      options.force = true;
      Progress silent;
      build(options, silent);
      return file;
    }();
    pack_file_ = pack;
  }
  static void TearDownTestSuite() {
    std::filesystem::remove(std::filesystem::temp_directory_path() /
                            ("landfix_eval_photos_" + std::to_string(CPLGetCurrentProcessID()) + ".lfpack"));
  }

  std::string photograph(const std::string& name, const Shot& shot, const cv::Mat& replaced = {}) const {
    const nav::Camera camera = nav::camera_from_field_of_view(480, 360, 60 * kDegree);
    cv::Mat rgb = replaced.empty() ? nav::testing::take_picture(autumn(), camera, shot.pose) : replaced, bgr;
    if (shot.turned) cv::rotate(rgb, rgb, cv::ROTATE_180);
    cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
    EXPECT_TRUE(cv::imwrite(path(name), bgr, {cv::IMWRITE_JPEG_QUALITY, 95}));
    write_tags(name, shot, camera.fx);
    return path(name);
  }

  std::vector<PhotoResult> run(const std::vector<std::string>& photos, PhotoOptions options = narrow()) const {
    const Pack pack = tools::open_pack(pack_file_);
    return register_photos(pack, pack_file_, photos, options);
  }

  /// A small search keeps the tests quick.
  static PhotoOptions narrow() {
    PhotoOptions o;
    o.prior_sigma_m = 10, o.heading_sigma_rad = 2 * kDegree, o.height_sigma = 0.02, o.threads = 1;
    return o;
  }

  std::string pack_file_;

 private:
  void write_tags(const std::string& name, const Shot& shot, double focal_px) const {
    const auto file = Exiv2::ImageFactory::open(path(name));
    file->readMetadata();
    Exiv2::XmpProperties::registerNs("http://www.dji.com/drone-dji/1.0/", "drone-dji");
    Exiv2::ExifData exif;
    Exiv2::XmpData xmp;
    exif["Exif.Image.DateTime"] = shot.written;
    exif["Exif.Photo.DateTimeOriginal"] = shot.taken;
    const auto place =
        tiles::geodetic_from_grid(kZone, shot.pose.east_m + shot.tag_east_m, shot.pose.north_m + shot.tag_north_m);
    const auto set = [&](const char* key, double value) {
      xmp[std::string("Xmp.drone-dji.") + key] = std::to_string(value);
    };
    xmp["Xmp.drone-dji.GpsLatitude"] = fmt_digits(place->latitude_rad / kDegree);
    xmp["Xmp.drone-dji.GpsLongitude"] = fmt_digits(place->longitude_rad / kDegree);
    set("RelativeAltitude", shot.pose.height_above_ground_m * shot.tag_height);
    set("GimbalYawDegree", (shot.pose.attitude.heading + place->convergence_rad) / kDegree + shot.tag_yaw_deg);
    set("GimbalPitchDegree", -90 + shot.pose.attitude.pitch / kDegree);
    set("GimbalRollDegree", 0);
    set("CalibratedFocalLength", focal_px);
    file->setExifData(exif);
    file->setXmpData(xmp);
    file->writeMetadata();
  }
  static std::string fmt_digits(double value) {
    std::ostringstream out;
    out.precision(12);
    out << value;
    return out.str();
  }
};

TEST_F(EvalPhotos, FindsWhatTheTagsHaveWrong) {
  Shot shot;
  shot.tag_east_m = 7, shot.tag_north_m = -5, shot.tag_yaw_deg = 2, shot.tag_height = 1 / 1.02;
  const PhotoResult r = run({photograph("a.jpg", shot)})[0];
  ASSERT_TRUE(r.accepted) << r.reason << " " << r.probability;
  EXPECT_NEAR(r.offset().east_m, -7, 0.6) << "half a pixel of the map";
  EXPECT_NEAR(r.offset().north_m, 5, 0.6);
  EXPECT_NEAR(r.similarity.rotation_rad, -2 * kDegree, 0.4 * kDegree) << "the true heading is less than the tagged one";
  EXPECT_NEAR(r.similarity.scale, 1.02, 0.006) << "the true height is 2 % more";
  EXPECT_FALSE(r.turned);
  EXPECT_NEAR(r.on_map, 1, 1e-9);
  // Straight down, the image's centre is the point below the camera.
  EXPECT_NEAR(r.image_centre().east_m, kTrueEastM, 1);
  EXPECT_NEAR(r.image_centre().north_m, kTrueNorthM, 1);
}

TEST_F(EvalPhotos, ObliqueViewLooksAhead) {
  Shot shot;
  shot.pose.attitude = {0, 12 * kDegree, 90 * kDegree};  // nose up: the camera looks ahead, to the east
  const PhotoResult r = run({photograph("a.jpg", shot)})[0];
  ASSERT_TRUE(r.accepted) << r.reason << " " << r.probability;
  EXPECT_NEAR(r.camera.east_m, kTrueEastM, 1.2);
  EXPECT_NEAR(r.camera.north_m, kTrueNorthM, 1.2);
  EXPECT_NEAR(r.image_centre().east_m, kTrueEastM + kAboveGroundM * std::tan(12 * kDegree), 1.5);
  EXPECT_NEAR(r.image_centre().north_m, kTrueNorthM, 1.5);
}

TEST_F(EvalPhotos, WrongBeliefIsCorrected) {
  PhotoOptions o = narrow();
  o.prior_offset_m = {20, -15};
  const PhotoResult r = run({photograph("a.jpg", {})}, o)[0];
  ASSERT_TRUE(r.accepted) << r.reason;
  EXPECT_NEAR(r.offset().east_m, 0, 0.6) << "offsets are from the tags, not from the belief";
  EXPECT_NEAR(r.offset().north_m, 0, 0.6);
}

TEST_F(EvalPhotos, EditedPictureIsTriedUpsideDown) {
  Shot shot;
  shot.turned = true;
  shot.written = "2021:10:15 19:00:00";
  const PhotoResult edited = run({photograph("a.jpg", shot)})[0];
  ASSERT_TRUE(edited.accepted) << edited.reason;
  EXPECT_TRUE(edited.turned);
  EXPECT_NEAR(edited.offset().east_m, 0, 0.8);
  EXPECT_NEAR(edited.offset().north_m, 0, 0.8);
  shot.written = shot.taken;
  const PhotoResult wrong = run({photograph("b.jpg", shot)})[0];
  EXPECT_FALSE(wrong.accepted) << "as the camera wrote it, so the heading is wrong; yet a fix of probability "
                               << wrong.probability << " by " << nav::name_of(wrong.method);
}

TEST_F(EvalPhotos, NoFixFromWhatCannotBeMatched) {
  const cv::Mat bare(360, 480, CV_8UC3, cv::Scalar(100, 110, 90));
  cv::Mat noise = bare.clone();
  cv::RNG rng(3);
  rng.fill(noise, cv::RNG::UNIFORM, 0, 255);
  Shot focal, beyond, ground;
  focal.tag_height = 1.6;  // as a focal length that is wrong by as much
  beyond.pose.east_m = kWestM + 5000;
  ground.pose.height_above_ground_m = -3;
  const std::vector<PhotoResult> results =
      run({photograph("blank.jpg", {}, bare), photograph("noise.jpg", {}, noise), photograph("focal.jpg", focal),
           photograph("beyond.jpg", beyond, noise), photograph("ground.jpg", ground, noise)});
  for (const PhotoResult& r : results) {
    EXPECT_FALSE(r.accepted) << r.name;
    EXPECT_FALSE(r.reason.empty()) << r.name;
  }
  EXPECT_EQ(results[3].word, "outside_map");
  EXPECT_EQ(results[3].on_map, 0);
  EXPECT_EQ(results[4].word, "below_ground");
}

TEST_F(EvalPhotos, PhotographWithoutTagsIsNamedWithItsReason) {
  ASSERT_TRUE(cv::imwrite(path("bare.jpg"), cv::Mat(60, 80, CV_8UC3, cv::Scalar(1, 2, 3))));
  const std::vector<PhotoResult> results = run({path("bare.jpg"), photograph("good.jpg", {})});
  EXPECT_EQ(results[0].word, "unusable");
  EXPECT_NE(results[0].reason.find("GPSLatitude"), std::string::npos) << results[0].reason;
  EXPECT_TRUE(results[1].accepted);
  expect_error(ExitCode::kIo, {"nowhere.jpg"}, [&] { run({path("nowhere.jpg")}); });
  PhotoOptions o = narrow();
  o.camera = nav::camera_from_field_of_view(400, 400, 1);
  const PhotoResult other = run({path("good.jpg")}, o)[0];
  EXPECT_NE(other.reason.find("400x400"), std::string::npos) << "a square camera takes no picture of 4:3";
}

TEST_F(EvalPhotos, CameraModelServesShrunkPhotographs) {
  PhotoOptions o = narrow();
  o.camera = nav::camera_from_field_of_view(1920, 1440, 60 * kDegree);
  const PhotoResult r = run({photograph("a.jpg", {})}, o)[0];
  ASSERT_TRUE(r.accepted) << r.reason;
  EXPECT_NEAR(r.similarity.scale, 1, 0.005);
  EXPECT_EQ(r.camera_source, "camera model");
}

TEST(EvalPhotoSummary, CommonOffsetLeavesOutWhatLiesFarOff) {
  std::vector<PhotoResult> photos(5);
  const double east[] = {2, 3, 4, 60, 0};
  for (size_t i = 0; i < 5; ++i) {
    photos[i].accepted = i < 4;
    photos[i].camera = {1000 + east[i], 500};
    photos[i].tag = {1000, 500};
  }
  const PhotoSummary s = summarize(photos);
  EXPECT_EQ(s.accepted, 4);
  EXPECT_DOUBLE_EQ(s.common_offset->east_m, 3) << "the mean of 2, 3 and 4";
  EXPECT_DOUBLE_EQ(s.residuals_m[0], 1);
  EXPECT_DOUBLE_EQ(s.largest_residual_m, 57);
  EXPECT_TRUE(std::isnan(s.residuals_m[4]));
  EXPECT_FALSE(summarize(std::vector<PhotoResult>{}).common_offset);
}

TEST_F(EvalPhotos, ReportHasAllThatWasFound) {
  Shot far;
  far.pose.east_m = kWestM + 5000;
  const std::vector<PhotoResult> results =
      run({photograph("a.jpg", {}), photograph("far.jpg", far, autumn().pixels(cv::Rect(0, 0, 480, 360)))});
  const nlohmann::ordered_json json = to_json(results, kZone);
  const auto& first = json["photos"][0];
  EXPECT_EQ(first["fix"], true);
  EXPECT_TRUE(first["reason"].is_null());
  EXPECT_NEAR(first["heading_grid_deg"].get<double>(), 30, 0.5);
  EXPECT_NEAR(first["heading_true_deg"].get<double>() - first["heading_grid_deg"].get<double>(),
              results[0].convergence_rad / kDegree, 1e-9);
  EXPECT_NEAR(first["height_above_ground_found_m"].get<double>(), kAboveGroundM, 2);
  for (const char* key :
       {"probability", "matcher", "camera", "image_centre", "offset_from_tag_m", "rotation_deg", "scale"})
    EXPECT_TRUE(first.contains(key)) << key;
  EXPECT_EQ(json["photos"][1]["fix"], false);
  EXPECT_EQ(json["summary"]["fixes"], 1);
  EXPECT_NE(to_text(results).find("far.jpg"), std::string::npos);
  const Pack pack = tools::open_pack(pack_file_);
  const cv::Mat picture = draw_photos(results, nav::PackMap(pack));
  EXPECT_EQ(picture.type(), CV_8UC3);
  EXPECT_GT(picture.cols, 1500) << "two panels";
}

}  // namespace
}  // namespace landfix::eval

// Registration of templates cut from georeferenced images, and of pairs, with maps in memory.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "runtime/nav/image_map.h"
#include "tests/tools/eval_world.h"
#include "tools/eval/pairs.h"
#include "tools/eval/register.h"
#include "tools/eval/register_picture.h"

namespace landfix::eval {
namespace {

using ingest::expect_error;

/// Shares one map in memory among the threads.
class SharedMap : public nav::MapSource {
 public:
  explicit SharedMap(const nav::ImageMap& map) : map_(map) {}
  std::pair<double, double> gsd_range_m(nav::MapLayer layer) const override { return map_.gsd_range_m(layer); }
  nav::Status read(nav::MapLayer layer, double west_m, double south_m, double east_m, double north_m, double gsd_m,
                   features::GridImage& window) const override {
    return map_.read(layer, west_m, south_m, east_m, north_m, gsd_m, window);
  }
  std::optional<double> ground_height_m(double, double) const override { return 0; }

 private:
  const nav::ImageMap& map_;
};

const nav::ImageMap& summer_map() {
  static const nav::ImageMap map(summer(), 2);
  return map;
}

MapFrame summer_frame() { return {"summer.lfpack", kZone, ingest::bounds_of(summer()), {1, 2}}; }

RegisterOptions few() {
  RegisterOptions o;
  o.template_m = 100, o.search_m = 60, o.hit_m = 3, o.samples = 25, o.seeds = 2, o.threads = 2;
  o.matchers = matchers_named({"orientation", "gray"});
  return o;
}

class EvalRegister : public EvalTest {
 protected:
  CameraTrials run(const features::GridImage& camera, const RegisterOptions& options) const {
    const CameraImage image(save("camera.tif", camera), summer_frame());
    return register_camera(
        image, 0, summer_frame(), [] { return std::make_unique<SharedMap>(summer_map()); }, options);
  }
};

double hits(const MatcherTrials& m) { return summarize(m.trials).hit_rate; }

TEST_F(EvalRegister, FindsEveryTemplateOfTheMapItself) {
  const CameraTrials trials = run(summer(), few());
  ASSERT_EQ(trials.matchers.size(), 2u);
  for (const MatcherTrials& m : trials.matchers) {
    ASSERT_EQ(m.trials.size(), 50u);
    const Summary s = summarize(m.trials);
    EXPECT_EQ(s.hit_rate, 1) << m.matcher.name;
    EXPECT_LT(s.error_quantiles_m[2], 0.3) << m.matcher.name << ": templates lie anywhere between the pixels of 1 m";
    EXPECT_GT(s.error_quantiles_m[0], 0.001) << "the truth is no whole pixel";
    EXPECT_GT(s.median_ms, 0);
  }
}

TEST_F(EvalRegister, FollowsTheProtocol) {
  for (const Trial& t : run(summer(), few()).matchers[0].trials) {
    const Question& q = t.question;
    EXPECT_LE(std::abs(q.prior.east_m - q.east_m), 0.5) << "the search is centred on the truth within half a pixel";
    EXPECT_LE(std::abs(q.prior.north_m - q.north_m), 0.5);
    EXPECT_NEAR(q.prior.sigmas * std::sqrt(q.prior.covariance_m2[0]), 60, 1e-9) << "and reaches 60 m to every side";
    // 110 m from the edge: half a template and the search.
    EXPECT_GE(q.east_m - kWestM, 110);
    EXPECT_LE(q.east_m - kWestM, kSizeM - 110);
    EXPECT_GE(kNorthM - q.north_m, 110);
    EXPECT_LE(kNorthM - q.north_m, kSizeM - 110);
    EXPECT_EQ(q.block >> 32, uint64_t(q.east_m / 220)) << "blocks have the side of a search window";
  }
}

TEST_F(EvalRegister, OrientationSurvivesTheSeason) {
  const CameraTrials trials = run(autumn(), few());
  const double orientation = hits(trials.matchers[0]), gray = hits(trials.matchers[1]);
  EXPECT_GE(orientation, 0.8);
  EXPECT_GE(orientation, gray + 0.1);
}

TEST_F(EvalRegister, ResultsDoNotDependOnThreads) {
  RegisterOptions o = few();
  o.samples = 10;
  const CameraTrials two = run(autumn(), o);
  o.threads = 1;
  const CameraTrials one = run(autumn(), o);
  const auto without_times = [](const std::string& csv) {
    std::string out;
    for (size_t begin = 0, end; (end = csv.find('\n', begin)) != std::string::npos; begin = end + 1)
      out += csv.substr(begin, csv.rfind(',', end) - begin) + "\n";
    return out;
  };
  EXPECT_EQ(without_times(to_csv({one})), without_times(to_csv({two})));
  o.seed = 2;
  EXPECT_NE(without_times(to_csv({one})), without_times(to_csv({run(autumn(), o)}))) << "another seed, other places";
}

TEST_F(EvalRegister, FindsRotationAndScaleOfTheTemplates) {
  RegisterOptions o = few();
  o.samples = 20, o.seeds = 1, o.search_m = 20;
  o.rotation_sigma_rad = 3 * ingest::kDegree, o.scale_sigma = 0.03;
  o.matchers = matchers_named({"orientation"});
  const Summary s = summarize(run(summer(), o).matchers[0].trials);
  EXPECT_GE(s.hit_rate, 0.9) << "errors beyond two sigma are not searched: some 5 % each";
  // One step of the search moves a template's edge by a pixel: 1.1 degrees and 2 %. Of the wrong sign it were 6° and 6
  // %.
  EXPECT_LT(s.rotation_rms_rad, 1 * ingest::kDegree);
  EXPECT_LT(s.scale_rms, 0.015);
}

TEST_F(EvalRegister, BlankImageHasNoFix) {
  features::GridImage blank = summer();
  blank.pixels = cv::Mat(blank.pixels.size(), CV_8UC3, cv::Scalar(90, 120, 80));
  RegisterOptions o = few();
  o.samples = 5;
  o.matchers = matchers_named({"all"});
  for (const MatcherTrials& m : run(blank, o).matchers) {
    const Summary s = summarize(m.trials);
    EXPECT_EQ(s.standard.accepted, 0) << m.matcher.name;
    EXPECT_EQ(s.hit_rate, 0) << m.matcher.name;
  }
}

TEST_F(EvalRegister, SaysWhatDoesNotFit) {
  RegisterOptions o = few();
  o.template_m = 900;
  expect_error(ExitCode::kBadInput, {"camera.tif", "template", "900"}, [&] { run(summer(), o); });
  o = few();
  o.search_m = 400;
  expect_error(ExitCode::kBadInput, {"summer.lfpack", "search region", "900"}, [&] { run(summer(), o); });
  o = few();
  o.samples = 0;
  expect_error(ExitCode::kUsage, {"--samples", "0"}, [&] { run(summer(), o); });
  features::GridImage elsewhere = summer();
  elsewhere.west_m += 5000;
  expect_error(ExitCode::kNoData, {"camera.tif", "summer.lfpack", "overlap"}, [&] { run(elsewhere, few()); });
  features::GridImage hole = summer();
  hole.valid = cv::Mat(hole.pixels.size(), CV_8U, cv::Scalar(255));
  hole.valid(cv::Rect(60, 60, 680, 680)) = 0;
  expect_error(ExitCode::kNoData, {"camera.tif", "none lies wholly in the image"}, [&] { run(hole, few()); });
  expect_error(ExitCode::kUsage, {"--matcher", "colour", "orientation"}, [] { matchers_named({"colour"}); });
}

TEST_F(EvalRegister, ImageWithoutGeoreferenceIsRefused) {
  ingest::Sketch sketch;
  sketch.geotransform[1] = 0;
  const std::string file = write("plain.tif", sketch);
  expect_error(ExitCode::kBadInput, {"plain.tif"}, [&] { CameraImage(file, summer_frame()); });
}

TEST_F(EvalRegister, PatchShowsTheGroundThatItsSimilaritySays) {
  // Brightness rises by 0.25 per metre east and by 0.125 per metre south.
  features::GridImage slope{cv::Mat(800, 800, CV_8UC3), {}, kWestM, kNorthM, 1};
  for (int y = 0; y < 800; ++y)
    for (int x = 0; x < 800; ++x) slope.pixels.at<cv::Vec3b>(y, x) = cv::Vec3b::all(uchar(0.25 * x / 2 + 0.125 * y));
  const CameraImage camera(save("slope.tif", slope), summer_frame());
  const nav::Similarity similarity{0.3, 1.1};
  features::GridImage patch;
  ASSERT_TRUE(camera.cut(kWestM + 400.3, kNorthM - 300.7, 100, similarity, patch));
  EXPECT_EQ(patch.west_m, -50);
  EXPECT_EQ(patch.north_m, 50);
  for (const cv::Point p : {cv::Point(10, 20), cv::Point(90, 15), cv::Point(50, 80)}) {
    // From the middle, x right and y down, turned clockwise by 0.3 rad and stretched by 1.1.
    const double x = p.x + 0.5 - 50, y = p.y + 0.5 - 50, c = 1.1 * std::cos(0.3), s = 1.1 * std::sin(0.3);
    const double column = 400.3 + c * x - s * y - 0.5, row = 300.7 + s * x + c * y - 0.5;
    EXPECT_NEAR(patch.pixels.at<cv::Vec3b>(p)[0], 0.125 * column + 0.125 * row, 1.1) << p;
  }
  EXPECT_FALSE(camera.cut(kWestM + 40, kNorthM - 300, 100, {}, patch)) << "reaches beyond the image";
}

TEST_F(EvalRegister, LevelServesTheCamera) {
  EXPECT_EQ(level_for({1, 32}, 1), 1);
  EXPECT_EQ(level_for({4, 32}, 5), 4) << "a camera of 5 m is at most 1.4 times coarser than 4 m";
  EXPECT_EQ(level_for({1, 32}, 5), 4);
  EXPECT_EQ(level_for({1, 32}, 0.1), 1);
  EXPECT_EQ(level_for({1, 2}, 100), 2);
}

TEST_F(EvalRegister, ReportPoolsCamerasAndWritesEverySample) {
  RegisterOptions o = few();
  o.samples = 10;
  std::vector<CameraTrials> trials = {run(summer(), o), run(autumn(), o)};
  trials[1].camera = "autumn.tif";
  const std::vector<MatcherReport> reports = report(trials);
  ASSERT_EQ(reports.size(), 2u);
  EXPECT_EQ(reports[0].matcher, "orientation");
  EXPECT_EQ(reports[0].pooled.samples, 40);
  EXPECT_DOUBLE_EQ(reports[0].pooled.hit_rate,
                   (reports[0].cameras[0].second.hit_rate + reports[0].cameras[1].second.hit_rate) / 2);
  const nlohmann::ordered_json json = to_json(reports);
  EXPECT_EQ(json[0]["cameras"][1]["camera"], "autumn.tif");
  EXPECT_EQ(json[0]["pooled"]["reliability"].size(), 10u);
  EXPECT_EQ(json[0]["pooled"]["gate"]["standard"]["accepted"], reports[0].pooled.standard.accepted);
  const std::string csv = to_csv(trials), header = csv.substr(0, csv.find('\n'));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 2 * 2 * 20);
  const auto commas = std::count(header.begin(), header.end(), ',');
  for (size_t begin = 0, end; (end = csv.find('\n', begin)) != std::string::npos; begin = end + 1)
    ASSERT_EQ(std::count(csv.begin() + long(begin), csv.begin() + long(end), ','), commas);
  EXPECT_NE(to_text(reports).find("autumn.tif"), std::string::npos);
  const cv::Mat picture = draw_registration(trials, summer_map());
  EXPECT_GT(picture.cols, 1000) << "two panels";
  EXPECT_EQ(picture.type(), CV_8UC3);
}

TEST(EvalTrial, UnansweredTrialHasAllColumns) {
  Trial trial;
  trial.status = nav::Status::kNoTexture;
  const std::string line = trial_csv_line("gray", trial), header = trial_csv_header();
  EXPECT_EQ(std::count(line.begin(), line.end(), ','), std::count(header.begin(), header.end(), ','));
  EXPECT_NE(line.find("no_texture"), std::string::npos);
  EXPECT_FALSE(sample_of(trial).answered);
}

class EvalPairs : public EvalTest {
 protected:
  void SetUp() override {
    EvalTest::SetUp();
    for (const char* side : {"a", "b"}) std::filesystem::create_directories(path(side));
  }
  void save_rgb(const std::string& name, const cv::Mat& rgb) const {
    cv::Mat bgr;
    cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
    ASSERT_TRUE(cv::imwrite(path(name), bgr));
  }
  void save_pair(const std::string& name, cv::Point corner) const {
    const cv::Rect part(corner, cv::Size(256, 256));
    save_rgb("a/" + name, summer().pixels(part));
    save_rgb("b/" + name, autumn().pixels(part));
  }
};

TEST_F(EvalPairs, SearchesBothWays) {
  save_pair("one.png", {40, 60});
  save_pair("two.png", {400, 300});
  PairsOptions o;
  o.placements = 3;
  o.matchers = matchers_named({"orientation", "gray"});
  const std::vector<CameraTrials> trials = register_pairs(path("a"), path("b"), o);
  ASSERT_EQ(trials.size(), 2u);
  EXPECT_EQ(trials[0].camera, "A in B");
  for (const CameraTrials& side : trials) {
    ASSERT_EQ(side.matchers[0].trials.size(), 2u * 9);
    EXPECT_GE(hits(side.matchers[0]), 0.7) << side.camera;
  }
  const Question first = trials[0].matchers[0].trials.front().question,
                 last = trials[0].matchers[0].trials.back().question;
  EXPECT_EQ(first.east_m, 64) << "the first template touches the north-western corner";
  EXPECT_EQ(first.north_m, -64);
  EXPECT_EQ(last.east_m, 256 - 64);
  EXPECT_EQ(last.north_m, -(256 - 64));
  EXPECT_EQ(first.camera, "one.png");
  EXPECT_NE(first.block, last.block) << "every pair is a block";
  // An image in itself: every template is found to a fraction of a pixel.
  const std::vector<CameraTrials> self = register_pairs(path("a"), path("a"), o);
  for (const Trial& t : self[0].matchers[1].trials) EXPECT_LT(t.error_m(), 0.2);
}

TEST_F(EvalPairs, GroundSampleDistanceScalesEverything) {
  save_pair("one.png", {40, 60});
  PairsOptions o;
  o.placements = 2, o.gsd_m = 4;
  const std::vector<CameraTrials> trials = register_pairs(path("a"), path("a"), o);
  for (const Trial& t : trials[0].matchers[0].trials) {
    EXPECT_EQ(t.question.hit_m, 12);
    EXPECT_TRUE(t.hit());
  }
}

TEST_F(EvalPairs, SaysWhatIsWrongWithThePairs) {
  const auto run = [&](int template_px = 128) {
    return [this, template_px] {
      PairsOptions o;
      o.template_px = template_px;
      register_pairs(path("a"), path("b"), o);
    };
  };
  expect_error(ExitCode::kBadInput, {"found none"}, run());
  save_pair("one.png", {0, 0});
  expect_error(ExitCode::kBadInput, {"one.png", "300", "256x256"}, run(300));
  save_rgb("a/two.png", summer().pixels(cv::Rect(0, 0, 256, 256)));
  expect_error(ExitCode::kBadInput, {"two.png", "only one"}, run());
  save_rgb("b/two.png", summer().pixels(cv::Rect(0, 0, 255, 256)));
  expect_error(ExitCode::kBadInput, {"two.png", "256x256", "255x256"}, run());
  expect_error(ExitCode::kIo, {"nowhere"}, [&] { register_pairs(path("nowhere"), path("b"), {}); });
}

}  // namespace
}  // namespace landfix::eval

// `landfix landmarks`: the landmarks of one image, to look at and to try models.
#include <fmt/format.h>

#include <memory>
#include <opencv2/imgproc.hpp>

#include "builder/ingest/window.h"
#include "builder/landmarks/extraction.h"
#include "builder/landmarks/known.h"
#include "tools/common/drawing.h"
#include "tools/common/files.h"
#include "tools/common/grid_image_io.h"
#include "tools/common/landmark_file.h"
#include "tools/common/map_features.h"
#include "tools/landfix/commands.h"

namespace landfix::tools {
namespace {

struct Arguments {
  std::string image, bands, output, picture, model;
  double confidence = landmarks::kLeastConfidence;
  bool gray = false;
  int threads = 0;
};

// Outlines and centres over the image at two pixels per metre, the stronger the surer.
void draw(const std::string& path, const features::GridImage& image,
          const std::vector<landmarks::Extracted>& landmarks) {
  EnlargedPicture picture(image, 2);
  for (const landmarks::Extracted& e : landmarks) {
    const auto& c = kLandmarkStyles[size_t(e.landmark.cls)].colour;
    const cv::Scalar colour(c[2], c[1], c[0], 255);
    std::vector<cv::Point> outline;
    for (const cv::Point2d& p : e.outline.empty() ? rectangle_of(e.landmark) : e.outline)
      outline.push_back(picture.at(p.x, p.y));
    cv::polylines(picture.pixels(), outline, true, colour, e.landmark.confidence > 0.6 ? 2 : 1, cv::LINE_AA, kShift);
    cv::circle(picture.pixels(), picture.at(e.landmark.east_m, e.landmark.north_m), 2 << kShift, colour, cv::FILLED,
               cv::LINE_AA, kShift);
  }
  write_picture(path, picture.pixels());
}

void run(const Arguments& a) {
  const tiles::Zone zone = ingest::standard_zone_of(a.image);
  features::GridImage image =
      ingest::load_image({.path = a.image, .bands = a.bands}, zone, std::nullopt, landmarks::kLandmarkGsd_m);
  if (a.gray && image.pixels.channels() == 3) cv::cvtColor(image.pixels, image.pixels, cv::COLOR_RGB2GRAY);
  const landmarks::ObjectModel& model =
      a.model.empty() ? landmarks::default_object_model() : landmarks::read_object_model(a.model);
  std::vector<landmarks::Extracted> found = landmarks::extract_landmarks(image, model, a.threads);
  std::erase_if(found, [&](const landmarks::Extracted& e) { return e.landmark.confidence < a.confidence; });
  if (!a.output.empty()) write_landmark_file(a.output, found, zone);
  if (!a.picture.empty()) draw(a.picture, image, found);
  std::vector<tiles::Landmark> all;
  for (const landmarks::Extracted& e : found) all.push_back(e.landmark);
  fmt::print("{}\n", landmarks::text_of(all));
}

}  // namespace

void add_landmarks(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  CLI::App* sub = app.add_subcommand("landmarks", "Find buildings, fields, trees, water and paved areas in an image");
  sub->add_option("image", a.image, "Georeferenced image")->required()->type_name("IMAGE");
  add_bands(*sub, a.bands);
  sub->add_option("-o,--output", a.output, "Write centres and outlines to a GeoPackage")->type_name("FILE.gpkg");
  sub->add_option("--picture", a.picture, "Draw them over the image")->type_name("FILE.png");
  sub->add_option("--model", a.model, "What landmarks look like [the model that comes with landfix]")
      ->type_name("FILE");
  sub->add_option("--confidence", a.confidence, "Leave out what is less likely to be there")
      ->check(CLI::Range(landmarks::kLeastConfidence, 1.0))
      ->capture_default_str();
  sub->add_flag("--gray", a.gray, "Do without the image's colours");
  sub->add_option("--threads", a.threads, "Threads; 0 for all cores. What is found is the same whatever their number")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->footer(R"(
Example:
  landfix landmarks city.tif -o landmarks.gpkg --picture landmarks.png
)");
  sub->callback([arguments] { run(*arguments); });
}

}  // namespace landfix::tools

// `landfix eval landmarks --points`: landmarks found in an image against points that are known, or another image.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <opencv2/imgproc.hpp>

#include "builder/error.h"
#include "builder/ingest/window.h"
#include "builder/landmarks/extraction.h"
#include "builder/roads/road_extraction.h"
#include "tools/common/map_features.h"
#include "tools/eval/points.h"
#include "tools/landfix/landmarks.h"

namespace landfix::tools {
namespace {

using eval::FoundPoint;
using eval::KnownPoint;
using nlohmann::ordered_json;

constexpr double kMargin_m = 256;  ///< around the extent: what lies in it is seen as in the whole image

features::GridImage cut(const features::GridImage& image, const ingest::GridBounds& extent) {
  const cv::Point first(int(std::floor(image.column_of(extent.west_m - kMargin_m))),
                        int(std::floor(image.row_of(extent.north_m + kMargin_m))));
  const cv::Point last(int(std::ceil(image.column_of(extent.east_m + kMargin_m))),
                       int(std::ceil(image.row_of(extent.south_m - kMargin_m))));
  const cv::Rect part = cv::Rect(first, last) & cv::Rect({}, image.pixels.size());
  return {image.pixels(part), image.valid.empty() ? image.valid : image.valid(part),
          image.west_m + part.x * image.gsd_m, image.north_m - part.y * image.gsd_m, image.gsd_m};
}

// Where an extent is given, that part of it.
features::GridImage load(const std::string& path, const tiles::Zone& zone, const PointArguments& a) {
  features::GridImage image = ingest::load_image({.path = path}, zone, std::nullopt, landmarks::kLandmarkGsd_m);
  if (!a.extent.empty()) image = cut(image, eval::read_extent(a.extent, zone, ingest::bounds_of(image)));
  if (a.gray && image.pixels.channels() == 3) cv::cvtColor(image.pixels, image.pixels, cv::COLOR_RGB2GRAY);
  return image;
}

std::vector<FoundPoint> found_in(const features::GridImage& image, const PointArguments& a) {
  const landmarks::ObjectModel& model =
      a.objects.empty() ? landmarks::default_object_model() : landmarks::read_object_model(a.objects);
  std::vector<FoundPoint> out;
  for (const landmarks::Extracted& e : landmarks::extract_landmarks(image, model))
    if (e.landmark.cls == a.cls) out.push_back({{e.landmark.east_m, e.landmark.north_m}, e.landmark.confidence});
  return out;
}

std::vector<FoundPoint> intersections_in(const features::GridImage& image) {
  std::vector<tiles::RoadIntersection> roads;
  if (!tiles::intersections_of(landmarks::extract_roads(image, landmarks::default_road_model()), roads))
    throw Error(ExitCode::kInternal, "no memory for intersections");
  std::vector<FoundPoint> out;
  for (const tiles::RoadIntersection& i : roads) out.push_back({{i.east_m, i.north_m}, i.confidence});
  return out;
}

// Every known intersection with the distance to the found one that it is matched with.
std::string intersections_text(const features::GridImage& image, const PointArguments& a, const tiles::Zone& zone,
                               ordered_json& json) {
  std::vector<KnownPoint> known =
      eval::read_known_points(a.points, "intersection", false, zone, ingest::bounds_of(image));
  if (known.empty()) return {};
  const std::vector<FoundPoint> found = intersections_in(image);
  const eval::PointMatch match = eval::match_points(found, known, ingest::bounds_of(image), a.reach_m);
  std::string out;
  for (size_t i = 0; i < known.size(); ++i) {
    const bool hit = !std::isnan(match.distance_m[i]);
    out += fmt::format("intersection {} ({}): {}\n", known[i].name, known[i].sure ? "sure" : "unsure",
                       hit ? fmt::format("found, {:.1f} m off", match.distance_m[i]) : "not found");
    json.push_back({{"id", known[i].name},
                    {"sure", known[i].sure},
                    {"distance_m", hit ? ordered_json(match.distance_m[i]) : ordered_json(nullptr)}});
  }
  return out;
}

// How many of the found of one image another shows, and the other way round.
std::string compared(const std::string& what, const std::vector<FoundPoint>& here, const std::vector<FoundPoint>& there,
                     double reach_m, ordered_json& json) {
  const size_t both = eval::found_again(here, there, reach_m);
  const auto share = [both](size_t of) { return of > 0 ? double(both) / double(of) : 0; };
  json = {{"distance_m", reach_m}, {"first", here.size()}, {"second", there.size()}, {"both", both}};
  return fmt::format("{}: {} of {} are found again within {:g} m ({:.3f}), of {} in the other image ({:.3f})\n", what,
                     both, here.size(), reach_m, share(here.size()), there.size(), share(there.size()));
}

std::string again_text(const features::GridImage& image, const std::vector<FoundPoint>& found, const PointArguments& a,
                       const tiles::Zone& zone, ordered_json& json) {
  const auto sure = [&](const std::vector<FoundPoint>& points) {
    std::vector<FoundPoint> out;
    std::ranges::copy_if(points, std::back_inserter(out),
                         [&](const FoundPoint& f) { return f.confidence >= a.confidence; });
    return out;
  };
  const features::GridImage other = load(a.again, zone, a);
  return compared("landmarks", sure(found), sure(found_in(other, a)), a.reach_m, json["landmarks"]) +
         compared("intersections", intersections_in(image), intersections_in(other), a.reach_m, json["intersections"]);
}

}  // namespace

void add_point_options(CLI::App& sub, PointArguments& a) {
  static const std::map<std::string, tiles::LandmarkClass> kClasses = {{"building", tiles::LandmarkClass::kBuilding},
                                                                       {"field", tiles::LandmarkClass::kField},
                                                                       {"tree", tiles::LandmarkClass::kTree},
                                                                       {"water", tiles::LandmarkClass::kWater},
                                                                       {"paved", tiles::LandmarkClass::kPaved}};
  sub.add_option("--points,--truth", a.points,
                 "Known landmarks as points or polygons (kind, sure, length_m), to compare with what is found")
      ->type_name("VECTORS");
  sub.add_option("--extent", a.extent, "Where all of them are known [the image]")->type_name("POLYGON");
  sub.add_option("--again", a.again, "Another image of the place: how many landmarks and intersections it shows again")
      ->type_name("IMAGE");
  sub.add_option("--class", a.cls, "Class of the landmarks [building]")
      ->transform(CLI::CheckedTransformer(kClasses).description("{building,field,tree,water,paved}"))
      ->type_name("CLASS");
  sub.add_option("--objects", a.objects, "Model of objects [the model that comes with landfix]")->type_name("FILE");
  sub.add_option("--distance-m", a.reach_m, "Distance within which points agree")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub.add_option("--confidence", a.confidence, "Landmarks less likely than this are left out")
      ->check(CLI::Range(landmarks::kLeastConfidence, 1.0))
      ->capture_default_str();
  sub.add_flag("--gray", a.gray, "Do without the images' colours");
}

std::string judge_points(const PointArguments& a, const std::string& image_path, ordered_json& json) {
  const tiles::Zone zone = ingest::standard_zone_of(image_path);
  const features::GridImage image = load(image_path, zone, a);
  const std::vector<FoundPoint> found = found_in(image, a);
  std::string text;
  if (!a.points.empty()) {
    const ingest::GridBounds extent =
        a.extent.empty() ? ingest::bounds_of(image) : eval::read_extent(a.extent, zone, ingest::bounds_of(image));
    const std::vector<KnownPoint> known =
        eval::read_known_points(a.points, kLandmarkStyles[size_t(a.cls)].name, true, zone, ingest::bounds_of(image));
    const eval::PointReport report = eval::report_points(found, known, extent, a.reach_m, a.confidence);
    text += to_text(report);
    json["landmarks"] = to_json(report);
    json["intersections"] = ordered_json::array();
    text += intersections_text(image, a, zone, json["intersections"]);
  }
  if (!a.again.empty()) text += again_text(image, found, a, zone, json["again"]);
  return text;
}

}  // namespace landfix::tools

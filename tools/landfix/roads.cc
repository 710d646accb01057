// `landfix roads`: the roads of one image, to look at and to try models.
#include <fmt/format.h>

#include <memory>
#include <opencv2/imgproc.hpp>

#include "builder/ingest/window.h"
#include "builder/roads/road_extraction.h"
#include "tools/common/drawing.h"
#include "tools/common/grid_image_io.h"
#include "tools/common/map_features.h"
#include "tools/common/road_file.h"
#include "tools/landfix/commands.h"

namespace landfix::tools {
namespace {

struct Arguments {
  std::string image, bands, output, picture, model;
  int threads = 0;
};

// Lines and intersections over the image at two pixels per metre.
void draw(const std::string& path, const features::GridImage& image, const tiles::RoadGraph& graph) {
  EnlargedPicture picture(image, 2);
  const cv::Scalar road(kRoadColour[2], kRoadColour[1], kRoadColour[0], 255), node(255, 0, 255, 255);
  for (const tiles::RoadEdge& e : graph.edges) {
    std::vector<cv::Point> line;
    for (const tiles::RoadPoint& p : tiles::line_of(graph, e)) line.push_back(picture.at(p.east_m, p.north_m));
    cv::polylines(picture.pixels(), line, false, road, 2, cv::LINE_AA, kShift);
  }
  for (const tiles::RoadNode& n : graph.nodes)
    if (n.kind == tiles::RoadNodeKind::kIntersection)
      cv::circle(picture.pixels(), picture.at(n.east_m, n.north_m), 6 << kShift, node, 2, cv::LINE_AA, kShift);
  write_picture(path, picture.pixels());
}

void run(const Arguments& a) {
  const tiles::Zone zone = ingest::standard_zone_of(a.image);
  const features::GridImage image =
      ingest::load_image({.path = a.image, .bands = a.bands}, zone, std::nullopt, landmarks::kRoadGsd_m);
  const landmarks::RoadModel model =
      a.model.empty() ? landmarks::default_road_model() : landmarks::read_road_model(a.model);
  const tiles::RoadGraph graph = landmarks::extract_roads(image, model, a.threads);
  if (!a.output.empty()) write_road_file(a.output, graph, zone);
  if (!a.picture.empty()) draw(a.picture, image, graph);
  double length_m = 0;
  size_t intersections = 0;
  for (const tiles::RoadEdge& e : graph.edges) length_m += tiles::length_of(graph, e);
  for (const tiles::RoadNode& n : graph.nodes) intersections += n.kind == tiles::RoadNodeKind::kIntersection;
  fmt::print("{:.2f} km of roads in {} parts, {} intersections\n", length_m / 1000, graph.edges.size(), intersections);
}

}  // namespace

void add_roads(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  CLI::App* sub = app.add_subcommand("roads", "Find the roads of an image");
  sub->add_option("image", a.image, "Georeferenced image")->required()->type_name("IMAGE");
  add_bands(*sub, a.bands);
  sub->add_option("-o,--output", a.output, "Write the roads and intersections to a GeoPackage")->type_name("FILE.gpkg");
  sub->add_option("--picture", a.picture, "Draw them over the image")->type_name("FILE.png");
  sub->add_option("--model", a.model, "What roads look like [the model that comes with landfix]")->type_name("FILE");
  sub->add_option("--threads", a.threads, "Threads; 0 for all cores. The roads are the same whatever their number")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->footer(R"(
Example:
  landfix roads city.tif -o roads.gpkg --picture roads.png
)");
  sub->callback([arguments] { run(*arguments); });
}

}  // namespace landfix::tools

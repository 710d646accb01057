// `landfix eval roads`: how well roads are found in an image whose roads are known.
#include <fmt/format.h>

#include <memory>

#include "builder/ingest/window.h"
#include "builder/roads/road_extraction.h"
#include "tools/eval/roads.h"
#include "tools/landfix/commands.h"

namespace landfix::tools {
namespace {

struct Arguments {
  std::string image, truth, intersections, model;
  double line_m = 2, node_m = 3;
  int threads = 0;
  bool json = false;
};

void run(const Arguments& a) {
  const tiles::Zone zone = ingest::standard_zone_of(a.image);
  const std::vector<eval::RoadLine> truth = eval::read_road_lines(a.truth, zone);
  const std::vector<tiles::RoadPoint> nodes =
      a.intersections.empty() ? eval::intersections_of_lines(truth) : eval::read_intersections(a.intersections, zone);
  const features::GridImage image = ingest::load_image({.path = a.image}, zone, std::nullopt, landmarks::kRoadGsd_m);
  const landmarks::RoadModel model =
      a.model.empty() ? landmarks::default_road_model() : landmarks::read_road_model(a.model);
  const tiles::RoadGraph graph = landmarks::extract_roads(image, model, a.threads);
  const ingest::GridBounds bounds = {image.west_m, image.north_m - image.pixels.rows * image.gsd_m,
                                     image.west_m + image.pixels.cols * image.gsd_m, image.north_m};
  const eval::RoadScore score = eval::score_roads(graph, truth, nodes, bounds, a.line_m, a.node_m);
  if (a.json)
    fmt::print("{}\n", eval::to_json(score).dump(2));
  else
    fmt::print("{}", eval::to_text(score, a.line_m, a.node_m));
}

}  // namespace

void add_eval_roads(CLI::App& eval) {
  auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  CLI::App* sub = eval.add_subcommand("roads", "Find the roads of an image and compare them with known ones");
  sub->add_option("--image", a.image, "Georeferenced image")->required()->type_name("IMAGE");
  sub->add_option("--truth", a.truth, "Known centrelines, any vector format")->required()->type_name("LINES");
  sub->add_option("--intersections", a.intersections, "Known intersections [where ends of known lines meet]")
      ->type_name("POINTS");
  sub->add_option("--model", a.model, "What roads look like [the model that comes with landfix]")->type_name("FILE");
  sub->add_option("--line-m", a.line_m, "Distance within which lines agree")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub->add_option("--node-m", a.node_m, "Distance within which intersections agree")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub->add_option("--threads", a.threads, "Threads; 0 for all cores")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->add_flag("--json", a.json, "Report as JSON");
  sub->footer(R"(
Known intersections are where ends of known lines meet, three or more.

Example:
  landfix synth -o world --seed 7
  landfix eval roads --image world/ortho.tif --truth world/roads.geojson --intersections world/intersections.geojson
)");
  sub->callback([arguments] { run(*arguments); });
}

}  // namespace landfix::tools

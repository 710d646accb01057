// landfix query: ask a pack what an aircraft would ask it, and see the answer.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/core.hpp>

#include "tiles/grid.h"
#include "tools/common/drawing.h"
#include "tools/common/feature_picture.h"
#include "tools/common/grid_image_io.h"
#include "tools/common/manifest_json.h"
#include "tools/common/open_pack.h"
#include "tools/landfix/commands.h"

namespace landfix::tools {
namespace {

using nlohmann::ordered_json;
constexpr double kDegree = std::numbers::pi / 180;

struct QueryOptions {
  std::string pack, layer = "gray", output;
  std::vector<std::string> keys, draw;
  std::vector<double> at, grid, covariance, bbox;
  double sigma = 50, k = 3, gsd = 0;
  bool json = false, manifest = false;
};

struct Question {
  Ellipse ellipse;  ///< mean only where a box is asked for
  Region region;
};

// Said here by the option's name: the runtime knows arguments only.
void require_sound(const QueryOptions& o) {
  const auto require = [](bool sound, const char* option, const std::vector<double>& given, const char* expected) {
    if (!sound)
      throw Error(ExitCode::kBadInput, fmt::format("{} {}: expected {}", option, fmt::join(given, ","), expected));
  };
  const auto finite = [](const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  };
  const std::vector<double>&at = o.at, &c = o.covariance, &b = o.bbox;
  require(at.empty() || (std::abs(at[0]) <= 360 && std::abs(at[1]) <= 90), "--at", at,
          "longitude, then latitude, in degrees");
  require(finite(o.grid), "--grid", o.grid, "easting and northing in metres");
  require(b.empty() || (finite(b) && b[0] < b[2] && b[1] < b[3] && b[1] >= -90 && b[3] <= 90), "--bbox", b,
          "west, south, east and north in degrees, in this order");
  require(c.empty() || (finite(c) && c[0] >= 0 && c[2] >= 0 && c[0] * c[2] >= c[1] * c[1]), "--covariance", c,
          "EE,EN,NN in square metres: finite numbers, EE and NN not negative, EN * EN at most EE * NN");
  require(std::isfinite(o.sigma) && o.sigma >= 0, "--sigma", {o.sigma}, "metres, 0 or more");
  require(std::isfinite(o.k) && o.k >= 0, "-k", {o.k}, "a number of sigmas, 0 or more");
  require(std::isfinite(o.gsd) && o.gsd >= 0, "--gsd", {o.gsd}, "metres per pixel");
}

GridPosition position_of(const Pack& pack, const QueryOptions& o) {
  if (!o.grid.empty()) {
    const auto geodetic = pack.geodetic_from_grid(o.grid[0], o.grid[1]);
    if (!geodetic)
      throw Error(ExitCode::kNoData,
                  fmt::format("{}: --grid {} is far outside of the map; 'landfix info' shows its bounds", o.pack,
                              fmt::join(o.grid, ",")));
    return {o.grid[0], o.grid[1], geodetic->convergence_rad, geodetic->scale};
  }
  const auto position = pack.grid_from_geodetic(o.at[1] * kDegree, o.at[0] * kDegree);
  if (!position)
    throw Error(
        ExitCode::kNoData,
        fmt::format("{}: --at {},{} is far outside of the map, beyond its zone {}; give longitude first, then latitude",
                    o.pack, o.at[0], o.at[1], zone_name(zone_of(pack))));
  return *position;
}

// The pixels around a box given in degrees: its edges are no straight lines on the grid, so they are followed.
Result<Region> region_of_bbox(const Pack& pack, uint32_t layer, const std::vector<double>& b, double gsd_m) {
  double west = INFINITY, south = INFINITY, east = -INFINITY, north = -INFINITY;
  constexpr int kSteps = 32;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j) {
      if (i % kSteps != 0 && j % kSteps != 0) continue;
      const auto p = pack.grid_from_geodetic((b[1] + (b[3] - b[1]) * j / kSteps) * kDegree,
                                             (b[0] + (b[2] - b[0]) * i / kSteps) * kDegree);
      if (!p) return LF_OUTSIDE_MAP;  // beyond the zone
      west = std::min(west, p->east_m), east = std::max(east, p->east_m);
      south = std::min(south, p->north_m), north = std::max(north, p->north_m);
    }
  const lf_info map = pack.info();
  if (east <= map.west_m || west >= map.east_m || north <= map.south_m || south >= map.north_m) return LF_OUTSIDE_MAP;
  return pack.box(layer, west, south, east, north, gsd_m);
}

Question question_of(const Pack& pack, const QueryOptions& o) {
  const Result<uint32_t> layer = pack.find_layer(o.layer.c_str());
  check(layer.status(), o.pack + ": layer '" + o.layer + "'");
  if (const uint8_t type = pack.layer(*layer)->pixel_type; type == LF_LANDMARKS || type == LF_ROADS)
    throw Error(ExitCode::kUsage,
                fmt::format("--layer {}: it has no pixels; --draw {} draws it over another layer, and "
                            "'landfix export' writes it to a file",
                            o.layer, o.layer));
  const double gsd = o.gsd > 0 ? o.gsd : pack.level(*layer, 0)->gsd_m;
  Question q{};
  if (!o.bbox.empty()) {
    const auto region = region_of_bbox(pack, *layer, o.bbox, gsd);
    check(region.status(), o.pack + ": --bbox");
    q.region = *region;
    q.ellipse.east_m = region->west_m + 0.5 * region->width * region->gsd_m;
    q.ellipse.north_m = region->north_m - 0.5 * region->height * region->gsd_m;
    return q;
  }
  const GridPosition p = position_of(pack, o);
  q.ellipse = {p.east_m, p.north_m, o.sigma * o.sigma, 0, o.sigma * o.sigma, o.k};
  if (!o.covariance.empty())
    q.ellipse.cov_ee = o.covariance[0], q.ellipse.cov_en = o.covariance[1], q.ellipse.cov_nn = o.covariance[2];
  const auto region = pack.region(*layer, q.ellipse, gsd);
  check(region.status(), fmt::format("{}: easting {:.1f}, northing {:.1f}", o.pack, p.east_m, p.north_m));
  q.region = *region;
  return q;
}

// The planes of a region as channels of 0 and 1.
features::GridImage read_planes(const Pack& pack, const Region& region, const lf_layer_info& layer,
                                const std::string& path) {
  const std::string what = path + ": layer '" + layer.name + "'";
  check(pack.prepare(region), what);
  const size_t line = (size_t(region.width) + 63) / 64, plane = line * region.height;
  std::vector<uint64_t> words(plane * layer.channels);
  check(pack.read_bits(region, words, line, plane), what);
  features::GridImage image;
  image.west_m = region.west_m, image.north_m = region.north_m, image.gsd_m = region.gsd_m;
  image.pixels.create(int(region.height), int(region.width), CV_8UC(layer.channels));
  image.valid = cv::Mat::zeros(image.pixels.size(), CV_8UC1);
  for (int y = 0; y < image.pixels.rows; ++y)
    for (int x = 0; x < image.pixels.cols; ++x)
      for (size_t p = 0; p < layer.channels; ++p) {
        const auto bit = uint8_t(words[p * plane + size_t(y) * line + size_t(x) / 64] >> (x % 64) & 1);
        image.pixels.ptr<uint8_t>(y, x)[p] = bit;
        if (bit != layer.nodata) image.valid.at<uint8_t>(y, x) = 255;
      }
  return image;
}

features::GridImage image_of(const Pack& pack, const QueryOptions& o, const Region& region) {
  const lf_layer_info layer = *pack.layer(region.layer);
  if (layer.channels != 1 && layer.channels != 3 && o.output.ends_with(".png"))
    throw Error(ExitCode::kUsage, fmt::format("{}: layer '{}' has {} channels, a picture shows 1 or 3: write a .tif",
                                              o.output, layer.name, layer.channels));
  return layer.pixel_type == LF_BIT ? read_planes(pack, region, layer, o.pack) : read_region(pack, region, o.pack);
}

ordered_json date_of(const Pack& pack, uint32_t epoch) {
  const lf_epoch_info info = *pack.epoch(epoch);
  return *info.date ? ordered_json(info.date) : ordered_json("undated");
}

// What went into the tiles of the region: null where the pack does not say.
ordered_json dates_json(const Pack& pack, const Region& region) {
  const auto range = pack.epochs(region);
  if (!range || range->dated_tiles == 0) return {{"newest", nullptr}, {"oldest", nullptr}};
  return {{"newest", date_of(pack, range->newest)}, {"oldest", date_of(pack, range->oldest)}};
}

// The dates of the layer's tile at a point, newest first.
ordered_json dates_at(const Pack& pack, const Region& region, double east_m, double north_m) {
  const auto column = int64_t(std::floor(east_m / region.gsd_m)), row = int64_t(std::floor(-north_m / region.gsd_m));
  const tiles::TileIndex tile = tiles::tile_of_pixel(region.level, column, row);
  std::vector<uint16_t> epochs(pack.info().epoch_count);
  const auto count = pack.tile_epochs(region.layer, region.level, tile.x, tile.y, epochs);
  ordered_json dates = ordered_json::array();
  for (uint32_t i = 0; count && i < *count; ++i) dates.push_back(date_of(pack, epochs[i]));
  return dates;
}

// Heights may be compressed: decodes what lies around a point, at every level.
void prepare_heights(const Pack& pack, double east_m, double north_m, const std::string& path) {
  const auto layer = pack.find_layer("height");
  for (uint32_t i = 0; layer && i < pack.layer(*layer)->level_count; ++i) {
    const double gsd = pack.level(*layer, i)->gsd_m;
    const auto around = pack.box(*layer, east_m - gsd, north_m - gsd, east_m + gsd, north_m + gsd, gsd);
    if (around) check(pack.prepare(*around), path + ": layer 'height'");
  }
}

ordered_json answer_json(const Pack& pack, const QueryOptions& o, const Question& q, const features::GridImage& image) {
  const Region& r = q.region;
  const auto geodetic = pack.geodetic_from_grid(q.ellipse.east_m, q.ellipse.north_m);
  check(geodetic.status(), "position");
  prepare_heights(pack, q.ellipse.east_m, q.ellipse.north_m, o.pack);
  const auto height = pack.height(q.ellipse.east_m, q.ellipse.north_m);
  const auto undulation = pack.undulation(q.ellipse.east_m, q.ellipse.north_m);
  return {{"position",
           {{"longitude_deg", geodetic->longitude_rad / kDegree},
            {"latitude_deg", geodetic->latitude_rad / kDegree},
            {"east_m", q.ellipse.east_m},
            {"north_m", q.ellipse.north_m},
            {"zone", zone_name(zone_of(pack))},
            {"convergence_deg", geodetic->convergence_rad / kDegree},
            {"scale", geodetic->scale},
            {"ground_height_m", height ? ordered_json(height->height_m) : ordered_json(nullptr)},
            {"ground_height_from",
             height ? ordered_json(height->from_layer ? "height layer" : "assumed plane") : ordered_json(nullptr)},
            {"geoid_undulation_m", undulation ? ordered_json(*undulation) : ordered_json(nullptr)},
            {"dates", dates_at(pack, q.region, q.ellipse.east_m, q.ellipse.north_m)}}},
          {"region",
           {{"layer", o.layer},
            {"level", r.level},
            {"gsd_m", r.gsd_m},
            {"west_m", r.west_m},
            {"north_m", r.north_m},
            {"width_px", r.width},
            {"height_px", r.height},
            {"dates", dates_json(pack, r)},
            {"valid_share", double(cv::countNonZero(image.valid)) / double(image.valid.total())}}}};
}

// The features of the region's rectangle.
DrawnFeatures features_of(const Pack& pack, const QueryOptions& o, const Region& r) {
  FeatureQuery query;
  query.west_m = r.west_m, query.east_m = r.west_m + r.width * r.gsd_m;
  query.south_m = r.north_m - r.height * r.gsd_m, query.north_m = r.north_m;
  DrawnFeatures out;
  for (const std::string& layer : o.draw) {
    if (layer == "landmarks") {
      out.landmarks = find_landmarks(pack, query, o.pack);
    } else if (layer == "roads") {
      out.roads = find_roads(pack, query, o.pack);
      out.intersections = find_intersections(pack, query, o.pack);
    } else {
      throw Error(ExitCode::kUsage, fmt::format("--draw {}: expected landmarks, roads or both", layer));
    }
  }
  return out;
}

// What is drawn, by class.
ordered_json features_json(const DrawnFeatures& features) {
  ordered_json out = ordered_json::object();
  if (features.landmarks)
    for (size_t c = 0; c < kLandmarkStyles.size(); ++c)
      out[kLandmarkStyles[c].name] = std::ranges::count(*features.landmarks, c, &Landmark::landmark_class);
  if (features.roads) {
    out["roads"] = features.roads->roads.size();
    out["intersections"] = features.intersections.size();
  }
  return out;
}

void print_answer(const ordered_json& answer) {
  for (const auto& [group, values] : answer.items()) {
    fmt::print("{}\n", group);
    for (const auto& [name, value] : values.items())
      fmt::print("  {:<20} {}\n", name, value.is_string() ? value.get<std::string>() : value.dump());
  }
}

void query(const QueryOptions& o) {
  if (o.manifest) {
    fmt::print("{}\n", manifest_json(open_pack(o.pack, o.keys)).dump(2));
    return;
  }
  if ((o.at.empty() ? 0 : 1) + (o.grid.empty() ? 0 : 1) + (o.bbox.empty() ? 0 : 1) != 1)
    throw Error(ExitCode::kUsage, "say where: one of --at LON,LAT, --grid E,N or --bbox W,S,E,N (or --manifest)");
  require_sound(o);
  if (!o.draw.empty() && !o.output.ends_with(".png"))
    throw Error(ExitCode::kUsage, "--draw: give the picture's name, -o NAME.png");
  const Pack pack = open_pack(o.pack, o.keys);
  const Question q = question_of(pack, o);
  const features::GridImage image = image_of(pack, o, q.region);
  ordered_json answer = answer_json(pack, o, q, image);
  if (!o.draw.empty()) {
    const DrawnFeatures features = features_of(pack, o, q.region);
    answer["features"] = features_json(features);
    write_picture(o.output, draw_features(picture_of(image), q.region, features));
  } else if (!o.output.empty()) {
    write_grid_image(o.output, image, zone_of(pack));
  }
  if (o.json)
    fmt::print("{}\n", answer.dump(2));
  else
    print_answer(answer);
}

}  // namespace

void add_query(CLI::App& app) {
  auto o = std::make_shared<QueryOptions>();
  CLI::App* c = app.add_subcommand("query", "Ask a pack for a region, heights and geodesy, as an aircraft would");
  c->add_option("pack", o->pack, "the pack")->required();
  c->add_option("--at", o->at, "LON,LAT in degrees: centre of the region")->delimiter(',')->expected(2);
  c->add_option("--grid", o->grid, "E,N in metres of the pack's zone: centre of the region")
      ->delimiter(',')
      ->expected(2);
  c->add_option("--bbox", o->bbox, "W,S,E,N in degrees: the region")->delimiter(',')->expected(4);
  c->add_option("--sigma", o->sigma, "standard deviation of the position per axis, metres")->capture_default_str();
  c->add_option("--covariance", o->covariance, "EE,EN,NN in square metres, instead of --sigma")
      ->delimiter(',')
      ->expected(3);
  c->add_option("-k", o->k, "how many sigmas the region reaches")->capture_default_str();
  c->add_option("--layer", o->layer, "gray, overview, orientation, height, ...")->capture_default_str();
  c->add_option("--gsd", o->gsd, "wanted metres per pixel (default: the layer's finest)");
  c->add_option("-o,--output", o->output, "write the region: .png for people, .tif for programs");
  c->add_option("--draw", o->draw, "landmarks, roads or both: draw them over the picture")->delimiter(',');
  c->add_option("--key", o->keys, "trusted public key file")->allow_extra_args(false);
  c->add_flag("--json", o->json, "print JSON");
  c->add_flag("--manifest", o->manifest, "print the manifest as JSON instead, as 'landfix info --json' does");
  c->footer(
      "Examples:\n"
      "  landfix query area.lfpack --at 34.93,31.30 --sigma 40 -o region.png\n"
      "  landfix query area.lfpack --at 34.93,31.30 --sigma 100 --draw landmarks,roads -o landmarks.png\n"
      "  landfix query area.lfpack --grid 683900,3464000 --layer height --gsd 4 -o heights.tif\n"
      "  landfix query area.lfpack --bbox 34.92,31.29,34.94,31.31 --layer overview -o area.png");
  c->callback([o] { query(*o); });
}

}  // namespace landfix::tools

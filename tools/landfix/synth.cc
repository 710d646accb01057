// `landfix synth`: draws a procedural world for tests and demonstrations.
#include <fmt/format.h>

#include <array>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/landfix/commands.h"
#include "tools/synth/world.h"

namespace landfix::tools {
namespace {

struct Arguments {
  synth::WorldOptions world;
  std::string directory;
  std::string season = "summer";
  std::array<double, 2> sun_deg = {150, 45};
  std::array<double, 2> origin_m = {world.west_m, world.south_m};
  int threads = 0;
  bool json = false;
};

synth::Season season_named(const std::string& name) {
  static const std::map<std::string, synth::Season> kSeasons = {{"spring", synth::Season::kSpring},
                                                                {"summer", synth::Season::kSummer},
                                                                {"autumn", synth::Season::kAutumn},
                                                                {"winter", synth::Season::kWinter}};
  return kSeasons.at(name);
}

constexpr const char* kFooter = R"(
Examples:
  A place of 2 km by 2 km in summer, and the map of it:
    landfix synth -o world --seed 7
    landfix build world/ortho.tif --dem world/dsm.tif -o world.lfpack
  The same place two years later, in autumn, under an evening sun, to fly over:
    landfix synth -o autumn --seed 7 --season autumn --year 2022 --sun 235,25
  A winter with snow, with near infrared, hilly, in zone 11:
    landfix synth -o snow --seed 3 --season winter --snow --nir --relief-m 80 --zone 11 --origin 420000,4100000

Writes ortho.tif (with ortho.tif.json: date, licence), dtm.tif and dsm.tif (metres above the WGS84 ellipsoid) and the truth as
buildings, trees, roads, intersections, fields and water .geojson. Seed and origin decide what stands where; a larger --size-m
adds land around it, to the east and north. Season, year and sun change colours and shadows, never geometry.
)";

void report(const Arguments& a, const synth::WriteSummary& s) {
  if (a.json) {
    nlohmann::ordered_json out;
    for (const auto& file : s.files) out["files"].push_back(file.string());
    out["seed"] = a.world.seed;
    out["epsg"] = (a.world.south ? 32700 : 32600) + a.world.zone;
    out["date"] = synth::date_of(a.world.year, a.world.season);
    out["dem_datum"] = "ellipsoid";
    out["pixels"] = {{"ortho", s.ortho_pixels}, {"heights", s.height_pixels}};
    out["labels"] = {{"buildings", s.buildings},         {"trees", s.trees},   {"roads", s.roads},
                     {"intersections", s.intersections}, {"fields", s.fields}, {"water", s.water}};
    fmt::print("{}\n", out.dump(2));
    return;
  }
  fmt::print("{} Mpx of orthophoto, {} buildings, {} trees, {} roads, {} intersections, {} fields, {} lakes\n",
             static_cast<double>(s.ortho_pixels) / 1e6, s.buildings, s.trees, s.roads, s.intersections, s.fields,
             s.water);
  for (const auto& file : s.files) fmt::print("  {}\n", file.string());
  fmt::print("Heights are above the ellipsoid, as their files say.\n");
}

}  // namespace

void add_synth(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  CLI::App* sub =
      app.add_subcommand("synth", "Draw a procedural world: orthophoto, heights and the truth about every object");
  sub->add_option("-o,--output", a.directory,
                  "Directory to write to; made if missing, files of the same names are replaced")
      ->required();
  sub->add_option("--seed", a.world.seed, "Which world")->capture_default_str();
  sub->add_option("--size-m", a.world.size_m, "Length of each side in metres")->capture_default_str();
  sub->add_option("--gsd", a.world.gsd_m, "Ground sample distance of the orthophoto in metres")->capture_default_str();
  sub->add_option("--dem-gsd", a.world.dem_gsd_m, "Ground sample distance of the heights in metres")
      ->capture_default_str();
  sub->add_option("--season", a.season, "Season of the picture")
      ->check(CLI::IsMember({"spring", "summer", "autumn", "winter"}))
      ->capture_default_str();
  sub->add_option("--year", a.world.year, "Year of the picture; crops rotate")->capture_default_str();
  sub->add_flag("--varied-roads", a.world.varied_roads,
                "Roads of more kinds: carriageways apart, shoulders, roundabouts, tracks of different width");
  sub->add_flag("--snow", a.world.snow, "Snow on the ground (winter only)");
  sub->add_option("--sun", a.sun_deg, "Azimuth from grid north and elevation in degrees")
      ->delimiter(',')
      ->capture_default_str();
  sub->add_option("--relief-m", a.world.relief_m, "Height of the hills above and below the mean in metres")
      ->capture_default_str();
  sub->add_option("--base-height-m", a.world.base_height_m, "Mean height of the ground above the ellipsoid")
      ->capture_default_str();
  sub->add_flag("--nir", a.world.near_infrared, "Add a near-infrared band");
  sub->add_option("--zone", a.world.zone, "UTM zone")->capture_default_str();
  sub->add_flag("--south", a.world.south, "Southern hemisphere");
  sub->add_option("--origin", a.origin_m, "Easting and northing of the south-western corner in metres")
      ->delimiter(',')
      ->capture_default_str();
  sub->add_option("--threads", a.threads,
                  "Threads to draw with; 0 for all cores. The files are the same whatever their number")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->add_flag("--json", a.json, "Report as JSON");
  sub->footer(kFooter);
  sub->callback([arguments] {
    Arguments& given = *arguments;
    given.world.season = season_named(given.season);
    given.world.sun_azimuth_deg = given.sun_deg[0];
    given.world.sun_elevation_deg = given.sun_deg[1];
    given.world.west_m = given.origin_m[0];
    given.world.south_m = given.origin_m[1];
    report(given, synth::write_world(given.world, given.directory, {given.threads, nullptr}));
  });
}

}  // namespace landfix::tools

#include "tools/landfix/route_setup.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "tools/common/manifest_json.h"
#include "tools/common/open_pack.h"

namespace landfix::tools {
namespace {

std::optional<int> day_of(const std::string& date) {
  if (date.empty()) return std::nullopt;
  const std::optional<int> day = nav::day_of(date.c_str());
  if (!day) throw Error(ExitCode::kUsage, "--date: expected a day such as 2026-05-31, found \"" + date + '"');
  return day;
}

/// From where GNSS ends.
fly::FlightOptions flight_options(RouteArguments a, const lf_info& map) {
  a.flight.gnss_until_s = 0;
  return flight_of(a, map);
}

}  // namespace

void add_route_options(CLI::App& command, RouteArguments& a) {
  command.add_option("--map", a.map, "The map pack, with navigability")->required()->type_name("PACK");
  command.add_option("--key", a.key_files, "Trusted public key file of the map (may be repeated)")
      ->allow_extra_args(false);
  command.add_option("--require", a.require, "Position error and the share of cases in which it must be kept")
      ->capture_default_str()
      ->type_name("METRESm@PERCENT%");
  command
      .add_option("--date", a.date,
                  "Day of the flight: chances fall with the age of the map [as old as maps usually are]")
      ->type_name("YYYY-MM-DD");
  command.add_option("--corridor", a.score.corridor_m, "Half the width of the corridor to stay in, m")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  add_aircraft_options(command, a);
}

RouteSetup::RouteSetup(const RouteArguments& a)
    : pack(open_pack(a.map, a.key_files)),
      info(pack.info()),
      zone(zone_of(pack)),
      ground(pack),
      navigability(route::open_navigability(pack, a.map, day_of(a.date))),
      flight(flight_options(a, info)),
      score(a.score) {
  prepare_layers(pack, a.map, std::array{"height"});
  if (!pack.find_layer("height"))
    fmt::print(stderr,
               "{}: no heights: the ground is taken for a plane {:g} m above the ellipsoid, and heights above ground "
               "are those above it (landfix build --dem)\n",
               a.map, info.plane_height_m);
  heights.ground_m = [this](double east_m, double north_m) -> std::optional<double> {
    const route::Extent e = navigability->extent();
    return e.holds(east_m, north_m) ? ground.ground_height_m(east_m, north_m) : std::nullopt;
  };
  heights.geoid_m = [this](double east_m, double north_m) -> std::optional<double> {
    const Result<double> undulation = pack.undulation(east_m, north_m);
    return undulation ? std::optional(*undulation) : std::nullopt;
  };
  vehicle.camera = flight.camera;
  vehicle.image_interval_s = flight.image_interval_s;
  vehicle.errors = route::error_model(flight);
  score.requirement = route::parse_requirement(a.require);
  if (!(score.corridor_m > 0 && std::isfinite(score.corridor_m)))
    throw Error(ExitCode::kUsage, fmt::format("--corridor: expected metres, found {}", score.corridor_m));
}

}  // namespace landfix::tools

// What flies, as the commands that plan and simulate flights ask for it: camera and errors.
#pragma once

#include <CLI/CLI.hpp>
#include <vector>

#include "landfix/landfix.hpp"
#include "tools/fly/flight.h"

namespace landfix::tools {

/// The command line as given, degrees where it says so.
struct AircraftArguments {
  fly::FlightOptions flight;
  std::vector<int> image_size = {640, 480};
  double field_of_view_deg = 60, attitude_noise_deg = 0.5, attitude_bias_deg = 0.3, heading_noise_deg = 0.5,
         heading_bias_deg = 0.3;
  double map_error_m = -1;  ///< negative: as the pack says
};

void add_aircraft_options(CLI::App& command, AircraftArguments& arguments);

/// The flight with what was asked for; its localizer knows the size of the sensors' errors and of the map's.
fly::FlightOptions flight_of(const AircraftArguments& arguments, const lf_info& map);

}  // namespace landfix::tools

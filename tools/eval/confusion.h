// How often a classifier of landmarks is right, with intervals, for people and programs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "builder/training/confusion.h"

namespace landfix::eval {

using landmarks::Confusion;

/// A share with its 95 % interval (Wilson 1927), NaN of none.
struct Share {
  int hits = 0, of = 0;
  double share = 0, low = 0, high = 0;
};
Share share_of(int hits, int of);

/// The share of a class that is recognised, and of everything.
Share recognised(const Confusion& confusion, size_t label);
Share recognised(const Confusion& confusion);

/// A table with a line per class that occurs, and the share of everything.
std::string to_text(const Confusion& confusion);

/// {"labels", "confusion", "classes": {name: {"right", "of", "share", "low", "high"}}, "overall"}.
nlohmann::ordered_json to_json(const Confusion& confusion);

/// The same with the calibration error ("calibration_error" in JSON).
std::string to_text(const landmarks::Judgement& judgement);
nlohmann::ordered_json to_json(const landmarks::Judgement& judgement);

}  // namespace landfix::eval

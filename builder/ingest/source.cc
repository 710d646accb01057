// Apart from roles.cc: the pack writer needs it where there is no GDAL.
#include "builder/ingest/source.h"

namespace landfix::ingest {

const char* name_of(BandRole role) {
  switch (role) {
    case BandRole::kGray:
      return "gray";
    case BandRole::kRed:
      return "red";
    case BandRole::kGreen:
      return "green";
    case BandRole::kBlue:
      return "blue";
    case BandRole::kNir:
      return "nir";
  }
  return "";
}

}  // namespace landfix::ingest

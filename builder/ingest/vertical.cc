#include "builder/ingest/vertical.h"

#include <fmt/format.h>
#include <proj.h>

#include <cmath>
#include <limits>
#include <vector>

#include "builder/ingest/gdal.h"
#include "builder/ingest/raster.h"

namespace landfix::ingest {
namespace {

constexpr int kEpsgEgm96 = 5773;
constexpr int kEpsgWgs84With3Axes = 4979;
constexpr double kProbeHeight = 1000;

int epsg_of(const std::string& text) {
  if (text == kEgm96) return kEpsgEgm96;
  constexpr size_t kPrefix = 5;
  const bool numbered = (text.rfind("EPSG:", 0) == 0 || text.rfind("epsg:", 0) == 0) && text.size() > kPrefix &&
                        text.size() <= kPrefix + 6 &&
                        text.find_first_not_of("0123456789", kPrefix) == std::string::npos;
  return numbered ? std::stoi(text.substr(kPrefix)) : 0;
}

struct ProjDeleter {
  void operator()(PJ_CONTEXT* p) const { proj_context_destroy(p); }
  void operator()(PJ* p) const { proj_destroy(p); }
  void operator()(PJ_OBJ_LIST* p) const { proj_list_destroy(p); }
  void operator()(PJ_OPERATION_FACTORY_CONTEXT* p) const { proj_operation_factory_context_destroy(p); }
};
template <typename T>
using ProjPointer = std::unique_ptr<T, ProjDeleter>;

/// The grid files that transformations between two CRSs would need and that are not on this machine, as "a, b"; empty
/// for none.
std::string missing_grids(const OGRSpatialReference& source, const OGRSpatialReference& target) {
  const ProjPointer<PJ_CONTEXT> context(proj_context_create());
  proj_log_level(context.get(), PJ_LOG_NONE);
  const ProjPointer<PJ> from(proj_create(context.get(), wkt_of(source).c_str()));
  const ProjPointer<PJ> to(proj_create(context.get(), wkt_of(target).c_str()));
  if (!from || !to) return "";
  const ProjPointer<PJ_OPERATION_FACTORY_CONTEXT> factory(
      proj_create_operation_factory_context(context.get(), nullptr));
  proj_operation_factory_context_set_allow_ballpark_transformations(context.get(), factory.get(), 0);
  proj_operation_factory_context_set_grid_availability_use(context.get(), factory.get(),
                                                           PROJ_GRID_AVAILABILITY_IGNORED);
  const ProjPointer<PJ_OBJ_LIST> operations(proj_create_operations(context.get(), from.get(), to.get(), factory.get()));
  std::string names;
  for (int i = 0; operations && i < proj_list_get_count(operations.get()); ++i) {
    const ProjPointer<PJ> operation(proj_list_get(context.get(), operations.get(), i));
    for (int g = 0; g < proj_coordoperation_get_grid_used_count(context.get(), operation.get()); ++g) {
      const char* name = nullptr;
      int available = 0;
      if (!proj_coordoperation_get_grid_used(context.get(), operation.get(), g, &name, nullptr, nullptr, nullptr,
                                             nullptr, nullptr, &available) ||
          available || !name || names.find(name) != std::string::npos) {
        continue;
      }
      names += (names.empty() ? "" : ", ") + std::string(name);
    }
  }
  return names;
}

}  // namespace

std::string parse_datum(const std::string& text, ExitCode code, const std::string& where) {
  setup_gdal();
  if (text == kEllipsoid || text == kEgm96) return text;
  if (const int epsg = epsg_of(text); epsg != 0) {
    const GdalMessages messages;
    OGRSpatialReference crs;
    if (crs.importFromEPSG(epsg) == OGRERR_NONE) {
      if (epsg == kEpsgEgm96) return kEgm96;
      if (crs.IsVertical() && !crs.IsCompound()) return fmt::format("EPSG:{}", epsg);
      if (crs.IsGeographic() && crs.GetAxesCount() == 3) return kEllipsoid;
    }
  }
  throw Error(
      code,
      fmt::format(
          "{}: vertical datum \"{}\": expected ellipsoid, egm96 or EPSG:n of a vertical CRS, for instance EPSG:5773",
          where, text));
}

std::string datum_of(const OGRSpatialReference& crs) {
  if (crs.IsCompound()) {
    const char* authority = crs.GetAuthorityName("COMPD_CS|VERT_CS");
    const char* code = crs.GetAuthorityCode("COMPD_CS|VERT_CS");
    if (!authority || !code || !EQUAL(authority, "EPSG")) return "";
    return std::stoi(code) == kEpsgEgm96 ? kEgm96 : fmt::format("EPSG:{}", code);
  }
  return crs.GetAxesCount() == 3 && !crs.IsGeocentric() ? kEllipsoid : "";
}

double metres_per_unit(const std::string& datum) {
  OGRSpatialReference crs;
  if (datum == kEllipsoid || crs.importFromEPSG(epsg_of(datum)) != OGRERR_NONE) return 1;
  return crs.GetTargetLinearUnits("VERT_CS");
}

VerticalTransformation::VerticalTransformation(const std::string& datum, const tiles::Zone& zone,
                                               const GridBounds& area, const std::string& where) {
  setup_gdal();
  OGRSpatialReference vertical;
  vertical.importFromEPSG(epsg_of(datum));
  const OGRSpatialReference horizontal = zone_crs(zone);
  source_.SetCompoundCS("grid and height", &horizontal, &vertical);
  source_.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  target_.importFromEPSG(kEpsgWgs84With3Axes);
  target_.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  double x = 0.5 * (area.west_m + area.east_m), y = 0.5 * (area.south_m + area.north_m);
  const GdalMessages messages;
  if (transformation()) shift_and_scale(1, &x, &y);
  if (std::isfinite(x) && std::isfinite(y) && transformation()) return;
  const std::string missing = missing_grids(source_, target_);
  throw Error(
      ExitCode::kBadInput,
      fmt::format("{}: heights above {} ({}) cannot be converted to heights above the ellipsoid here: {}", where, datum,
                  vertical.GetName() ? vertical.GetName() : "unknown",
                  missing.empty()
                      ? std::string("PROJ knows no transformation for this place")
                      : "PROJ lacks the grid file " + missing +
                            " (install it with projsync or the package proj-data, or convert the heights first)"));
}

std::unique_ptr<OGRCoordinateTransformation> VerticalTransformation::transformation() const {
  OGRCoordinateTransformationOptions options;
  options.SetBallparkAllowed(false);
  return std::unique_ptr<OGRCoordinateTransformation>(OGRCreateCoordinateTransformation(&source_, &target_, options));
}

void VerticalTransformation::shift_and_scale(int count, double* x, double* y) const {
  const GdalMessages messages;
  auto& mine = transformations_.local();
  if (!mine) mine = transformation();
  const size_t n = size_t(count);
  std::vector<double> xs(x, x + n), ys(y, y + n), low(n, 0.0), high(n, kProbeHeight);
  std::vector<int> good_low(n, 0), good_high(n, 0);
  std::vector<double> xs2 = xs, ys2 = ys;
  mine->Transform(count, xs.data(), ys.data(), low.data(), good_low.data());
  mine->Transform(count, xs2.data(), ys2.data(), high.data(), good_high.data());
  for (size_t i = 0; i < n; ++i) {
    const bool good = good_low[i] && good_high[i] && std::isfinite(low[i]) && std::isfinite(high[i]);
    x[i] = good ? low[i] : std::numeric_limits<double>::quiet_NaN();
    y[i] = good ? (high[i] - low[i]) / kProbeHeight : x[i];
  }
}

}  // namespace landfix::ingest

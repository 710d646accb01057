#include "builder/ingest/area.h"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_geometry.h>
#include <ogrsf_frmts.h>

#include <cmath>
#include <mutex>
#include <numbers>
#include <optional>
#include <vector>

#include "builder/error.h"
#include "builder/ingest/footprint.h"
#include "builder/ingest/gdal.h"
#include "builder/ingest/raster.h"
#include "builder/ingest/zone.h"

namespace landfix::ingest {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kPointsPerSide = 64;  ///< straight lines of one CRS are curves in another

using GeometryPointer = std::unique_ptr<OGRGeometry>;

GeometryPointer geometry_from_wkt(const std::string& wkt) {
  OGRGeometry* geometry = nullptr;
  OGRGeometryFactory::createFromWkt(wkt.c_str(), nullptr, &geometry);
  return GeometryPointer(geometry);
}

GeometryPointer rectangle(const GridBounds& b) {
  OGRLinearRing ring;
  ring.addPoint(b.west_m, b.south_m);
  ring.addPoint(b.east_m, b.south_m);
  ring.addPoint(b.east_m, b.north_m);
  ring.addPoint(b.west_m, b.north_m);
  ring.closeRings();
  auto polygon = std::make_unique<OGRPolygon>();
  polygon->addRing(&ring);
  return polygon;
}

Error bad_area(const std::string& where, const std::string& why) {
  return Error(ExitCode::kBadInput, fmt::format("{}: {}", where, why));
}

/// Adds the polygons of a geometry of any type.
void collect_polygons(const OGRGeometry& geometry, OGRMultiPolygon& polygons) {
  const GeometryPointer linear(geometry.getLinearGeometry());
  const OGRwkbGeometryType type = wkbFlatten(linear->getGeometryType());
  if (type == wkbPolygon) {
    polygons.addGeometry(linear.get());
  } else if (OGR_GT_IsSubClassOf(type, wkbGeometryCollection)) {
    for (const OGRGeometry* part : *linear->toGeometryCollection()) collect_polygons(*part, polygons);
  }
}

void reproject(OGRGeometry& polygons, const OGRSpatialReference& crs, const tiles::Zone& zone,
               const std::string& where) {
  const GdalMessages messages;
  OGREnvelope e;
  polygons.getEnvelope(&e);
  polygons.segmentize(std::max(e.MaxX - e.MinX, e.MaxY - e.MinY) / kPointsPerSide);
  const OGRSpatialReference grid = zone_crs(zone);
  OGRCoordinateTransformationOptions options;
  options.SetBallparkAllowed(false);
  const std::unique_ptr<OGRCoordinateTransformation> to_grid(OGRCreateCoordinateTransformation(&crs, &grid, options));
  if (!to_grid || polygons.transform(to_grid.get()) != OGRERR_NONE) {
    throw bad_area(
        where,
        fmt::format(
            "cannot be projected onto the grid of zone {} ({}). Is its CRS right, and the zone that of the place?",
            zone_text(zone), messages.text()));
  }
}

/// Polygons of all features of a layer, on the grid.
void collect_layer(OGRLayer& layer, const tiles::Zone& zone, const std::string& where, OGRMultiPolygon& all) {
  OGRMultiPolygon polygons;
  for (const auto& feature : layer) {
    if (const OGRGeometry* geometry = feature->GetGeometryRef()) collect_polygons(*geometry, polygons);
  }
  if (polygons.IsEmpty()) return;
  for (const OGRPolygon* polygon : polygons) {
    if (!polygon->IsValid()) {
      throw bad_area(
          where,
          "holds an invalid polygon (one that crosses itself, for instance). Repair it: ogr2ogr -makevalid OUT IN");
    }
  }
  const OGRSpatialReference* crs = layer.GetSpatialRef();
  if (crs == nullptr || crs->IsEmpty() || crs->IsLocal()) {
    throw bad_area(where, "its coordinate reference system is missing. Name it: ogr2ogr -a_srs EPSG:n OUT IN");
  }
  reproject(polygons, *crs, zone, where);
  for (const OGRPolygon* polygon : polygons) all.addGeometry(polygon);
}

}  // namespace

std::string multipolygon_wkt(const std::vector<std::vector<cv::Point2d>>& outlines) {
  OGRMultiPolygon polygons;
  for (const auto& outline : outlines) {
    OGRLinearRing ring;
    for (const cv::Point2d& p : outline) ring.addPoint(p.x, p.y);
    ring.closeRings();
    OGRPolygon polygon;
    polygon.addRing(&ring);
    polygons.addGeometry(&polygon);
  }
  return polygons.exportToWkt();
}

/// A geometry prepared for many questions. GEOS builds its index while answering, one thread at a time.
struct Area::Shape {
  explicit Shape(GeometryPointer g)
      : geometry(std::move(g)), prepared(OGRCreatePreparedGeometry(OGRGeometry::ToHandle(geometry.get()))) {
    if (!prepared) throw Error(ExitCode::kInternal, "this GDAL lacks GEOS, which areas of interest need");
    OGREnvelope e;
    geometry->getEnvelope(&e);
    bounds = {e.MinX, e.MinY, e.MaxX, e.MaxY};
  }

  GeometryPointer geometry;
  OGRPreparedGeometryUniquePtr prepared;
  GridBounds bounds;
  mutable std::mutex mutex;
};

Area::Area(std::shared_ptr<const Shape> shape) : shape_(std::move(shape)) {}

Area Area::of_images(const ImageSet& images) {
  GeometryPointer all = geometry_from_wkt(images.footprints_wkt());
  GeometryPointer merged(all->UnionCascaded());
  return Area(std::make_shared<Shape>(merged ? std::move(merged) : std::move(all)));
}

Area Area::from_file(const std::string& path, const tiles::Zone& zone) {
  setup_gdal();
  VSIStatBufL status;
  if (VSIStatExL(path.c_str(), &status, VSI_STAT_EXISTS_FLAG) != 0)
    throw Error(ExitCode::kIo, fmt::format("{}: no such file", path));
  const GdalMessages messages;
  const GDALDatasetUniquePtr dataset(GDALDataset::Open(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY));
  if (!dataset) throw bad_area(path, "is not a vector file that GDAL can read (" + messages.text() + ")");
  auto polygons = std::make_unique<OGRMultiPolygon>();
  for (OGRLayer* layer : dataset->GetLayers()) collect_layer(*layer, zone, path, *polygons);
  if (polygons->IsEmpty()) throw bad_area(path, "holds no polygon; expected the area of interest as one or more");
  GeometryPointer merged(polygons->UnionCascaded());
  if (!merged || merged->IsEmpty()) throw bad_area(path, "its polygons enclose no area");
  return Area(std::make_shared<Shape>(std::move(merged)));
}

Area Area::from_bbox(const std::string& text, const tiles::Zone& zone) {
  setup_gdal();
  const auto refuse = [&](const std::string& why) {
    return Error(
        ExitCode::kUsage,
        fmt::format("bbox \"{}\": {}. Expected WEST,SOUTH,EAST,NORTH in degrees, for instance 34.90,31.28,34.95,31.31",
                    text, why));
  };
  const CPLStringList fields(CSLTokenizeString2(text.c_str(), ",", CSLT_ALLOWEMPTYTOKENS));
  if (fields.size() != 4) throw refuse(fmt::format("{} numbers", fields.size()));
  double v[4];
  for (int i = 0; i < 4; ++i) {
    char* end = nullptr;
    v[i] = CPLStrtod(fields[i], &end);
    if (end == fields[i] || *end != '\0' || !std::isfinite(v[i]))
      throw refuse(fmt::format("\"{}\" is no number", fields[i]));
  }
  const double west = v[0], south = v[1], east = v[2] < v[0] ? v[2] + 360 : v[2], north = v[3];
  if (std::abs(west) > 180 || std::abs(v[2]) > 180 || std::abs(south) > 90 || std::abs(north) > 90)
    throw refuse("out of range");
  if (!(west < east && south < north)) throw refuse("it is empty");
  std::vector<cv::Point2d> outline;
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i < kPointsPerSide; ++i) {
      const double f = double(i) / kPointsPerSide;
      const double x = side == 0   ? f
                       : side == 1 ? 1
                       : side == 2 ? 1 - f
                                   : 0,
                   y = side == 0   ? 0
                       : side == 1 ? f
                       : side == 2 ? 1
                                   : 1 - f;
      const auto p = tiles::grid_from_geodetic(
          zone, {(south + y * (north - south)) * kDegree, (west + x * (east - west)) * kDegree});
      if (!p) throw refuse(fmt::format("it does not fit onto the grid of zone {}", zone_text(zone)));
      outline.emplace_back(p->east_m, p->north_m);
    }
  }
  return Area(std::make_shared<Shape>(geometry_from_wkt(multipolygon_wkt({outline}))));
}

void Area::require_overlap(const ImageSet& images) const {
  const std::lock_guard lock(shape_->mutex);
  const GeometryPointer footprints = geometry_from_wkt(images.footprints_wkt());
  if (OGRPreparedGeometryIntersects(shape_->prepared.get(), OGRGeometry::ToHandle(footprints.get()))) return;
  const GridBounds &a = shape_->bounds, &b = images.bounds();
  throw Error(ExitCode::kNoData, fmt::format("the area of interest does not touch any image: it covers easting "
                                               "{:.0f} to {:.0f}, northing {:.0f} to {:.0f} of "
                                               "zone {}, the images {:.0f} to {:.0f}, {:.0f} to {:.0f}",
                                               a.west_m, a.east_m, a.south_m, a.north_m, zone_text(images.zone()),
                                               b.west_m, b.east_m, b.south_m, b.north_m));
}

const GridBounds& Area::bounds() const { return shape_->bounds; }

bool Area::touches(const tiles::TileIndex& tile) const { return touches(bounds_of(tile)); }

bool Area::touches(const GridBounds& r) const {
  if (!shape_->bounds.intersects(r)) return false;
  const GeometryPointer box = rectangle(r);
  const std::lock_guard lock(shape_->mutex);
  return OGRPreparedGeometryIntersects(shape_->prepared.get(), OGRGeometry::ToHandle(box.get()));
}

}  // namespace landfix::ingest

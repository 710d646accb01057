#include "builder/ingest/vectors.h"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gdal_priv.h>
#include <ogr_geometry.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "builder/error.h"
#include "builder/ingest/gdal.h"
#include "builder/ingest/hash.h"
#include "builder/ingest/provenance.h"
#include "builder/ingest/raster.h"
#include "builder/ingest/zone.h"

namespace landfix::ingest {
namespace {

constexpr int kPointsPerSide = 21;   ///< straight sides of the map are curves in the layer's CRS
constexpr double kMargin = 0.01;     ///< of the map's sides, for what those points miss of the curves
constexpr double kFarthest_m = 5e7;  ///< from the grid's origin; farther than any place on Earth

using Transformation = std::unique_ptr<OGRCoordinateTransformation>;

/// One layer under way.
struct LayerReader {
  OGRLayer* layer = nullptr;
  Transformation to_grid;  ///< absent: the layer has no features, or none that can be drawn
  uint64_t unusable = 0;   ///< features that cannot be projected onto the grid, or are nothing that can be drawn
};

Error refusal(const std::string& path, const std::string& layer, const std::string& why) {
  return Error(ExitCode::kBadInput, fmt::format("{}, layer \"{}\": {}", path, layer, why));
}

Transformation transformation(const OGRSpatialReference& from, const OGRSpatialReference& to) {
  OGRCoordinateTransformationOptions options;
  options.SetBallparkAllowed(false);
  return Transformation(OGRCreateCoordinateTransformation(&from, &to, options));
}

/// Only features near the map are read: files of whole countries are common.
bool filter(OGRLayer& layer, const OGRSpatialReference& grid, const OGRSpatialReference& crs, const GridBounds& b) {
  const Transformation from_grid = transformation(grid, crs);
  double west, south, east, north;
  if (!from_grid || !from_grid->TransformBounds(b.west_m, b.south_m, b.east_m, b.north_m, &west, &south, &east, &north,
                                                kPointsPerSide))
    return false;
  if (!(west <= east)) return true;  // across the antimeridian: no rectangle of this CRS, so all features are read
  const double x = kMargin * (east - west), y = kMargin * (north - south);
  layer.SetSpatialFilterRect(west - x, south - y, east + x, north + y);
  return true;
}

LayerReader reader_of(const std::string& path, OGRLayer& layer, const tiles::Zone& zone, const GridBounds& bounds) {
  LayerReader reader{&layer, nullptr};
  if (layer.GetGeomType() == wkbNone) return reader;
  const OGRSpatialReference* crs = layer.GetSpatialRef();
  // GeoPackage has a name for it.
  if (crs == nullptr || crs->IsEmpty() || crs->IsLocal() || STARTS_WITH_CI(crs->GetName(), "undefined"))
    throw refusal(path, layer.GetName(),
                  "its coordinate reference system is missing. Name it: ogr2ogr -a_srs EPSG:n OUT IN");
  const GdalMessages messages;
  const OGRSpatialReference grid = zone_crs(zone);
  reader.to_grid = transformation(*crs, grid);
  if (!reader.to_grid || !filter(layer, grid, *crs, bounds))
    throw refusal(path, layer.GetName(),
                  fmt::format("cannot be projected onto the grid of zone {} ({}). Is its CRS right?", zone_text(zone),
                              messages.text()));
  return reader;
}

Tags tags_of(const OGRFeature& feature) {
  Tags tags;
  std::string other;
  for (int i = 0; i < feature.GetFieldCount(); ++i) {
    if (!feature.IsFieldSetAndNotNull(i)) continue;
    const CPLString name = CPLString(feature.GetFieldDefnRef(i)->GetNameRef()).tolower();
    const std::string value = feature.GetFieldAsString(i);
    if (name == "other_tags")
      other = value;
    else if (!value.empty())
      tags.emplace(name, value);
  }
  add_hstore(other, tags);
  return tags;
}

std::vector<cv::Point2d> points_of(const OGRSimpleCurve& curve) {
  std::vector<cv::Point2d> points;
  for (int i = 0; i < curve.getNumPoints(); ++i) points.emplace_back(curve.getX(i), curve.getY(i));
  return points;
}

GridBounds box_of(const VectorPart& part) {
  GridBounds box;
  for (const cv::Point2d& p : part.points) box.extend({p.x, p.y, p.x, p.y});
  return box;
}

void add_polygon(const OGRPolygon& polygon, std::vector<VectorPart>& parts) {
  const OGRLinearRing* ring = polygon.getExteriorRing();
  if (!ring || ring->getNumPoints() < 4) return;
  VectorPart part{Shape::kPolygon, points_of(*ring), {}};
  part.points.pop_back();
  const GridBounds box = box_of(part);
  part.centroid = {0.5 * (box.west_m + box.east_m), 0.5 * (box.south_m + box.north_m)};
  // Rings that cross themselves may have none, or one that lies far away.
  OGRPoint c;
  if (polygon.Centroid(&c) == OGRERR_NONE && !c.IsEmpty() && c.getX() >= box.west_m && c.getX() <= box.east_m &&
      c.getY() >= box.south_m && c.getY() <= box.north_m)
    part.centroid = {c.getX(), c.getY()};
  parts.push_back(std::move(part));
}

void add_parts(const OGRGeometry& geometry, std::vector<VectorPart>& parts) {
  const OGRwkbGeometryType type = wkbFlatten(geometry.getGeometryType());
  if (geometry.IsEmpty()) return;
  if (type == wkbPoint) {
    const OGRPoint& p = *geometry.toPoint();
    parts.push_back({Shape::kPoint, {{p.getX(), p.getY()}}, {p.getX(), p.getY()}});
  } else if (type == wkbLineString) {
    parts.push_back({Shape::kLine, points_of(*geometry.toLineString()), {}});
  } else if (type == wkbPolygon) {
    add_polygon(*geometry.toPolygon(), parts);
  } else if (OGR_GT_IsSubClassOf(type, wkbGeometryCollection)) {
    for (const OGRGeometry* part : *geometry.toGeometryCollection()) add_parts(*part, parts);
  }
}

bool is_on_earth(const VectorPart& part) {
  return std::ranges::all_of(part.points, [](const cv::Point2d& p) {
    return std::abs(p.x) <= kFarthest_m && std::abs(p.y) <= kFarthest_m;  // false for what is not a number
  });
}

bool touches(const VectorPart& part, const GridBounds& bounds) {
  const GridBounds box = box_of(part);
  return box.west_m <= bounds.east_m && bounds.west_m <= box.east_m && box.south_m <= bounds.north_m &&
         bounds.south_m <= box.north_m;
}

/// The feature's parts near the map, on the grid.
std::vector<VectorPart> parts_of(const OGRFeature& feature, LayerReader& reader, const GridBounds& bounds) {
  std::vector<VectorPart> parts;
  const OGRGeometry* geometry = feature.GetGeometryRef();
  if (!geometry || geometry->IsEmpty()) return parts;
  const std::unique_ptr<OGRGeometry> linear(geometry->getLinearGeometry());
  linear->flattenTo2D();
  const GdalMessages own;  // what cannot be projected is counted: no reason to stop reading
  if (linear->transform(reader.to_grid.get()) == OGRERR_NONE) add_parts(*linear, parts);
  std::erase_if(parts, [](const VectorPart& part) { return !is_on_earth(part); });
  if (parts.empty()) ++reader.unusable;
  std::erase_if(parts, [&](const VectorPart& part) { return !touches(part, bounds); });
  return parts;
}

std::string crs_text(const OGRSpatialReference& crs) {
  const char *authority = crs.GetAuthorityName(nullptr), *code = crs.GetAuthorityCode(nullptr);
  return authority && code ? fmt::format("{}:{}", authority, code) : wkt_of(crs);
}

Source source_of(const std::string& path, const std::vector<LayerReader>& readers) {
  Source source;
  source.path = path;
  source.name = std::filesystem::path(path).filename().string();
  source.sha256 = vector_sha256(path);
  const Sidecar sidecar = read_sidecar(path);
  source.date = sidecar.date;
  source.licence = sidecar.licence;
  source.attribution = sidecar.attribution;
  for (const LayerReader& reader : readers)
    if (reader.to_grid && source.crs.empty()) source.crs = crs_text(*reader.layer->GetSpatialRef());
  return source;
}

std::vector<LayerReader> open_layers(GDALDataset& dataset, const std::string& path, const std::string& wanted,
                                     const tiles::Zone& zone, const GridBounds& bounds) {
  std::vector<LayerReader> readers;
  std::vector<std::string> names;
  for (OGRLayer* layer : dataset.GetLayers()) {
    names.push_back(layer->GetName());
    if (wanted.empty() || wanted == layer->GetName()) readers.push_back(reader_of(path, *layer, zone, bounds));
  }
  if (!wanted.empty() && readers.empty())
    throw Error(ExitCode::kBadInput, fmt::format("{}: has no layer \"{}\"; it has {}", path, wanted,
                                                 names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
  return readers;
}

/// What all features of a layer cover, in its CRS; nullopt for none.
std::optional<OGREnvelope> extent_of(GDALDataset& dataset, OGRLayer& layer) {
  OGREnvelope extent;
  if (layer.GetExtent(&extent, TRUE) == OGRERR_NONE) return extent;
  dataset.ResetReading();  // files of OpenStreetMap need not say it
  for (OGRLayer* from = nullptr;;) {
    const OGRFeatureUniquePtr feature(dataset.GetNextFeature(&from, nullptr, nullptr, nullptr));
    if (!feature) break;
    OGREnvelope one;
    if (from != &layer || !feature->GetGeometryRef() || feature->GetGeometryRef()->IsEmpty()) continue;
    feature->GetGeometryRef()->getEnvelope(&one);
    extent.Merge(one);
  }
  return extent.IsInit() ? std::optional(extent) : std::nullopt;
}

/// Metres between the map and what a layer covers; nullopt where that is no place of the grid.
std::optional<double> gap_m(const LayerReader& reader, const OGREnvelope& e, const GridBounds& bounds) {
  double west, south, east, north;
  if (!reader.to_grid->TransformBounds(e.MinX, e.MinY, e.MaxX, e.MaxY, &west, &south, &east, &north, kPointsPerSide))
    return std::nullopt;
  const double gap = std::hypot(std::max({0.0, west - bounds.east_m, bounds.west_m - east}),
                                std::max({0.0, south - bounds.north_m, bounds.south_m - north}));
  return gap <= kFarthest_m ? std::optional(gap) : std::nullopt;
}

/// Nothing of the file touches the map. Throws Error where it lies at another place: probably its CRS is wrong.
void explain_nothing(GDALDataset& dataset, const std::string& path, const std::vector<LayerReader>& readers,
                     const GridBounds& bounds, VectorFile& out) {
  const GdalMessages own;  // how much can be said is all that depends on it
  std::optional<Error> elsewhere;
  bool is_here = false;
  for (const LayerReader& reader : readers)
    if (reader.to_grid) reader.layer->SetSpatialFilter(nullptr);
  for (const LayerReader& reader : readers) {
    if (!reader.to_grid || reader.layer->GetFeatureCount() == 0) continue;
    const auto e = extent_of(dataset, *reader.layer);
    if (!e) continue;
    const auto gap = gap_m(reader, *e, bounds);
    is_here = is_here || gap == 0;
    elsewhere = refusal(
        path, reader.layer->GetName(),
        fmt::format("lies wholly outside of the map, {}: x {} to {}, y {} to {} in {}. If the layer is of this place, "
                    "its CRS is not the one that its coordinates are in: ogr2ogr -a_srs EPSG:n OUT IN names another",
                    gap ? fmt::format("{:.{}f} km from it", *gap / 1000, *gap < 1e4 ? 1 : 0) : "where no grid reaches",
                    e->MinX, e->MaxX, e->MinY, e->MaxY, crs_text(*reader.layer->GetSpatialRef())));
  }
  if (elsewhere && !is_here) throw *elsewhere;
  out.warnings.push_back(fmt::format("{}: {}", path, is_here ? "nothing of it lies on the map" : "holds no features"));
}

}  // namespace

bool file_exists(const std::string& path) {
  VSIStatBufL status;
  return VSIStatExL(path.c_str(), &status, VSI_STAT_EXISTS_FLAG) == 0;
}

void add_hstore(const std::string& text, Tags& tags) {
  size_t at = 0;
  const auto quoted = [&]() -> std::optional<std::string> {
    if (at >= text.size() || text[at] != '"') return std::nullopt;
    std::string out;
    for (++at; at < text.size() && text[at] != '"'; ++at) {
      if (text[at] == '\\' && ++at == text.size()) return std::nullopt;
      out += text[at];
    }
    return at++ < text.size() ? std::optional(out) : std::nullopt;
  };
  while (const auto key = quoted()) {
    if (text.compare(at, 2, "=>") != 0) return;
    at += 2;
    const auto value = quoted();
    if (!value) return;
    if (!value->empty()) tags.emplace(CPLString(*key).tolower(), *value);
    if (at >= text.size() || text[at] != ',') return;
    at = text.find_first_not_of(' ', at + 1);
  }
}

VectorFile read_vectors(const std::string& path, const std::string& layer, const tiles::Zone& zone,
                        const GridBounds& bounds, const std::function<void(const VectorFeature&)>& take) {
  setup_gdal();
  if (!file_exists(path)) throw Error(ExitCode::kIo, fmt::format("{}: no such file", path));
  const GdalMessages messages;
  const GDALDatasetUniquePtr dataset(GDALDataset::Open(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY));
  if (!dataset)
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: is not a vector file that GDAL can read ({})", path, messages.text()));
  std::vector<LayerReader> readers = open_layers(*dataset, path, layer, zone, bounds);
  VectorFile out{source_of(path, readers), EQUAL(dataset->GetDriverName(), "OSM"), {}};
  uint64_t taken = 0, unusable = 0;
  dataset->ResetReading();
  // Through the dataset: files of OpenStreetMap hold the features of all layers in one stream.
  for (OGRLayer* from = nullptr;;) {
    const OGRFeatureUniquePtr feature(dataset->GetNextFeature(&from, nullptr, nullptr, nullptr));
    if (!feature) break;
    const auto reader = std::ranges::find(readers, from, &LayerReader::layer);
    if (reader == readers.end() || !reader->to_grid) continue;
    VectorFeature f{from->GetName(), {}, parts_of(*feature, *reader, bounds)};
    if (f.parts.empty()) continue;
    f.tags = tags_of(*feature);
    take(f);
    ++taken;
  }
  if (messages.failed())
    throw Error(ExitCode::kBadInput, fmt::format("{}: cannot be read to its end ({})", path, messages.text()));
  for (const LayerReader& reader : readers) unusable += reader.unusable;
  if (unusable > 0)
    out.warnings.push_back(fmt::format("{}: {} features without usable geometry are left out", path, unusable));
  else if (taken == 0)
    explain_nothing(*dataset, path, readers, bounds, out);
  return out;
}

}  // namespace landfix::ingest

#include "tools/eval/roads.h"

#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "builder/error.h"
#include "builder/ingest/gdal.h"
#include "builder/ingest/raster.h"
#include "builder/point_grid.h"
#include "tools/eval/pairing.h"

namespace landfix::eval {
namespace {

using landmarks::PointGrid;
using tiles::RoadPoint;

void add_line(const OGRLineString& line, const std::string& path, std::vector<RoadLine>& lines) {
  RoadLine out;
  for (int i = 0; i < line.getNumPoints(); ++i) {
    if (!std::isfinite(line.getX(i)) || !std::isfinite(line.getY(i)))
      throw Error(ExitCode::kBadInput, path + ": a line lies off the grid of the image; is its CRS right?");
    out.push_back({line.getX(i), line.getY(i)});
  }
  if (out.size() >= 2) lines.push_back(std::move(out));
}

// Calls visit(geometry on the zone's grid) for every feature of all layers.
template <typename Visit>
void for_each_geometry(const std::string& path, const tiles::Zone& zone, const char* expected, Visit visit) {
  ingest::setup_gdal();
  const ingest::GdalMessages messages;
  const GDALDatasetUniquePtr file(GDALDataset::Open(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY));
  if (!file)
    throw Error(ExitCode::kIo, fmt::format("{}: expected a vector file with {}; cannot be opened", path, expected));
  OGRSpatialReference grid = ingest::zone_crs(zone);
  for (OGRLayer* layer : file->GetLayers()) {
    for (const auto& feature : *layer) {
      const OGRGeometry* given = feature->GetGeometryRef();
      if (given == nullptr) continue;
      const OGRGeometryUniquePtr geometry(given->clone());
      if (geometry->transformTo(&grid) != OGRERR_NONE)
        throw Error(ExitCode::kBadInput, path + ": cannot be brought onto the image's grid; is its CRS right?");
      visit(*geometry);
    }
  }
}

bool inside(const ingest::GridBounds& b, const RoadPoint& p) {
  return p.east_m >= b.west_m && p.east_m <= b.east_m && p.north_m >= b.south_m && p.north_m <= b.north_m;
}

// Points at every metre of a line, those inside of the bounds.
void sample(const RoadLine& line, const ingest::GridBounds& bounds, std::vector<RoadPoint>& out) {
  for (size_t i = 1; i < line.size(); ++i) {
    const RoadPoint &a = line[i - 1], &b = line[i];
    const int steps = std::max(1, int(std::lround(std::hypot(b.east_m - a.east_m, b.north_m - a.north_m))));
    for (int s = 0; s < steps; ++s) {
      const double t = (s + 0.5) / steps;
      const RoadPoint p{a.east_m + t * (b.east_m - a.east_m), a.north_m + t * (b.north_m - a.north_m)};
      if (inside(bounds, p)) out.push_back(p);
    }
  }
}

PointGrid grid_of(const std::vector<RoadPoint>& points, double cell_m) {
  PointGrid grid(cell_m);
  for (size_t i = 0; i < points.size(); ++i) grid.add({points[i].east_m, points[i].north_m}, int(i));
  return grid;
}

size_t count_near(const std::vector<RoadPoint>& points, const std::vector<RoadPoint>& others, double reach_m) {
  const PointGrid grid = grid_of(others, std::max(reach_m, 1.0));
  return size_t(std::count_if(points.begin(), points.end(), [&](const RoadPoint& p) {
    return grid.nearest({p.east_m, p.north_m}, reach_m) >= 0;
  }));
}

std::vector<cv::Point2d> places_of(const std::vector<RoadPoint>& points) {
  std::vector<cv::Point2d> out;
  for (const RoadPoint& p : points) out.emplace_back(p.east_m, p.north_m);
  return out;
}

size_t match(const std::vector<RoadPoint>& a, const std::vector<RoadPoint>& b, double reach_m) {
  return nearest_pairs(places_of(a), places_of(b), reach_m).size();
}

}  // namespace

std::vector<RoadLine> read_road_lines(const std::string& path, const tiles::Zone& zone) {
  std::vector<RoadLine> lines;
  for_each_geometry(path, zone, "lines", [&](OGRGeometry& geometry) {
    if (wkbFlatten(geometry.getGeometryType()) == wkbLineString) {
      add_line(*geometry.toLineString(), path, lines);
    } else if (wkbFlatten(geometry.getGeometryType()) == wkbMultiLineString) {
      for (const OGRLineString* part : *geometry.toMultiLineString()) add_line(*part, path, lines);
    }
  });
  if (lines.empty()) throw Error(ExitCode::kBadInput, path + ": expected lines of roads, found none");
  return lines;
}

std::vector<ingest::GridBounds> read_windows(const std::string& path, const tiles::Zone& zone) {
  std::vector<ingest::GridBounds> windows;
  for_each_geometry(path, zone, "polygons", [&](OGRGeometry& geometry) {
    if (wkbFlatten(geometry.getGeometryType()) != wkbPolygon) return;
    OGREnvelope box;
    geometry.getEnvelope(&box);
    windows.push_back({box.MinX, box.MinY, box.MaxX, box.MaxY});
  });
  if (windows.empty()) throw Error(ExitCode::kBadInput, path + ": expected polygons around what was drawn, found none");
  return windows;
}

std::vector<RoadPoint> read_intersections(const std::string& path, const tiles::Zone& zone) {
  std::vector<RoadPoint> points;
  for_each_geometry(path, zone, "points", [&](OGRGeometry& geometry) {
    if (wkbFlatten(geometry.getGeometryType()) == wkbPoint)
      points.push_back({geometry.toPoint()->getX(), geometry.toPoint()->getY()});
  });
  if (points.empty()) throw Error(ExitCode::kBadInput, path + ": expected points of intersections, found none");
  return points;
}

std::vector<RoadPoint> intersections_of_lines(const std::vector<RoadLine>& lines) {
  constexpr double kSame_m = 0.1;
  PointGrid grid(1);
  std::vector<RoadPoint> nodes;
  std::vector<int> arms;
  const auto touch = [&](const RoadPoint& p, int count) {
    const int found = grid.nearest({p.east_m, p.north_m}, kSame_m);
    if (found >= 0) {
      arms[size_t(found)] += count;
      return;
    }
    grid.add({p.east_m, p.north_m}, int(nodes.size()));
    nodes.push_back(p);
    arms.push_back(count);
  };
  for (const RoadLine& line : lines) {
    touch(line.front(), 1);
    touch(line.back(), 1);
  }
  for (const RoadLine& line : lines) {
    for (size_t i = 1; i + 1 < line.size(); ++i) {
      const int found = grid.nearest({line[i].east_m, line[i].north_m}, kSame_m);
      if (found >= 0) arms[size_t(found)] += 2;
    }
  }
  std::vector<RoadPoint> out;
  for (size_t i = 0; i < nodes.size(); ++i)
    if (arms[i] >= 3) out.push_back(nodes[i]);
  return out;
}

RoadScore score_roads(const tiles::RoadGraph& found, const std::vector<RoadLine>& truth,
                      const std::vector<RoadPoint>& true_intersections, const ingest::GridBounds& bounds, double line_m,
                      double node_m) {
  std::vector<RoadPoint> known, seen, known_nodes, seen_nodes;
  for (const RoadLine& line : truth) sample(line, bounds, known);
  for (const tiles::RoadEdge& edge : found.edges) sample(tiles::line_of(found, edge), bounds, seen);
  for (const RoadPoint& p : true_intersections)
    if (inside(bounds, p)) known_nodes.push_back(p);
  std::vector<tiles::RoadIntersection> intersections;
  tiles::intersections_of(found, intersections);
  for (const tiles::RoadIntersection& i : intersections)
    if (inside(bounds, {i.east_m, i.north_m})) seen_nodes.push_back({i.east_m, i.north_m});
  return {double(known.size()),
          double(count_near(known, seen, line_m)),
          double(seen.size()),
          double(count_near(seen, known, line_m)),
          known_nodes.size(),
          seen_nodes.size(),
          match(known_nodes, seen_nodes, node_m)};
}

std::string to_text(const RoadScore& s, double line_m, double node_m) {
  return fmt::format(
      "centrelines within {:g} m: completeness {:.3f} ({:.0f} of {:.0f} m), correctness {:.3f} ({:.0f} of {:.0f} m)\n"
      "intersections within {:g} m: recall {:.3f} ({} of {}), precision {:.3f} ({} of {})\n",
      line_m, s.completeness(), s.true_found_m, s.true_m, s.correctness(), s.found_true_m, s.found_m, node_m,
      s.recall(), s.matched_nodes, s.true_nodes, s.precision(), s.matched_nodes, s.found_nodes);
}

nlohmann::ordered_json to_json(const RoadScore& s) {
  return {{"completeness", s.completeness()},
          {"correctness", s.correctness()},
          {"true_m", s.true_m},
          {"true_found_m", s.true_found_m},
          {"found_m", s.found_m},
          {"found_true_m", s.found_true_m},
          {"intersections",
           {{"recall", s.recall()},
            {"precision", s.precision()},
            {"true", s.true_nodes},
            {"found", s.found_nodes},
            {"matched", s.matched_nodes}}}};
}

}  // namespace landfix::eval

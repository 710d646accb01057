#include "tests/pack/fixture.h"

#include <sodium.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <stdexcept>

#include "landfix/landfix.h"
#include "tests/pack/draw.h"

namespace landfix::tests {
namespace {

using tiles::Codec;
using Bytes = std::vector<uint8_t>;

constexpr int32_t kWestX = 1952, kSouthY = 19528;  // level 0; whole tiles of level 2 begin here too
constexpr double kWestM = kWestX * 256.0, kSouthM = kSouthY * 256.0;
constexpr int kNoHeight = -32768;

// From 0 to `period` and back, in whole numbers: hills that look the same on every machine.
int64_t hills(int64_t x, int64_t period) { return std::abs((x % (2 * period) + 2 * period) % (2 * period) - period); }

int gray_hills(const PixelOf& p) {
  const int64_t scale = int64_t(1) << p.level, x = p.column * scale, y = p.row * scale;
  if (p.letter == 'c' && hills(x, 60) + hills(y, 60) < 30) return 0;  // ponds without data
  return int(40 + hills(x, 70) + hills(y, 90) + hills(x + y, 40));
}

DrawnLayer gray() {
  DrawnLayer layer;
  layer.description = "luma of the newest date";
  layer.levels = {{0, kWestX, kSouthY, "ab\nc."}, {1, kWestX >> 1, kSouthY >> 1, "p"}};
  layer.pixel = gray_hills;
  layer.epochs = [](char letter) -> catalog::EpochSet {
    if (letter == 'c') return {0, 1};
    return {0};
  };
  layer.codec = [](char letter) { return letter == 'a' ? Codec::kRaw : letter == 'b' ? Codec::kZstd : Codec::kJpeg; };
  return layer;
}

DrawnLayer overview() {
  DrawnLayer layer;
  layer.name = "overview";
  layer.format.channels = 3;
  layer.levels = {{2, kWestX >> 2, kSouthY >> 2, "o"}};
  layer.pixel = [](const PixelOf& p) {
    return int(30 + hills(p.column + 20 * p.channel, 50) + hills(p.row, 60 + 20 * p.channel));
  };
  layer.codec = [](char) { return Codec::kJpeg; };
  return layer;
}

// Which way two families of hills rise, as ternary orientation: planes a+, a-, b+, b-. Flat ground has neither.
int orientation_hills(const PixelOf& p) {
  const int64_t scale = int64_t(1) << p.level, x = p.column * scale, y = p.row * scale;
  if (p.letter == 'c' && hills(x, 60) + hills(y, 60) < 30) return 1;  // ponds without data
  const int64_t a = hills(x + 2 * y, 70) + hills(y, 90) - 80, b = hills(x, 50) - hills(x + y, 40);
  const bool planes[] = {a > 12, a<-12, b> 8, b < -8};
  return planes[p.channel];
}

DrawnLayer orientation() {
  DrawnLayer layer = gray();
  layer.name = "orientation";
  layer.description = "doubled-angle orientation of both dates";
  layer.format = {tiles::PixelType::kBit, 4, 1};
  layer.pixel = orientation_hills;
  layer.codec = [](char letter) {
    return letter == 'a' ? Codec::kRaw : letter == 'b' ? Codec::kZstd : tiles::Codec::kContext;
  };
  layer.epochs = [](char) -> catalog::EpochSet { return {0, 1}; };
  return layer;
}

DrawnLayer height() {
  DrawnLayer layer;
  layer.name = "height";
  layer.format = {tiles::PixelType::kI16, 1, kNoHeight};
  layer.levels = {{2, kWestX >> 2, kSouthY >> 2, "h"}};
  layer.pixel = [](const PixelOf& p) {
    return (p.column & 255) > 240 ? kNoHeight : int(hills(p.column, 100) * 3 + hills(p.row, 80) - 100);
  };
  layer.codec = [](char) { return Codec::kZstd; };
  layer.value_offset = 450.5f;
  layer.value_step = 0.25f;
  return layer;
}

// Landmarks of every class, of one that this version does not know, and of two tiles, in rows along two streets.
std::vector<tiles::Landmark> landmarks() {
  std::vector<tiles::Landmark> out;
  uint32_t random = 1;
  const auto next = [&random](uint32_t below) { return (random = random * 1664525u + 1013904223u) / 65536 % below; };
  for (uint32_t i = 0; i < 90; ++i) {
    tiles::Landmark m;
    m.east_m = kWestM + 40.125 + 25 * i, m.north_m = kSouthM + 300 + (i % 2) * 24 + 0.25 * next(40);
    m.cls = tiles::LandmarkClass(i % 29 == 28 ? 9 : next(5));
    m.length_m = 4 + 0.5 * next(80), m.width_m = m.length_m / (1 + 0.25 * next(4));
    if (m.cls != tiles::LandmarkClass::kTree) m.orientation_rad = 0.1 * next(31);
    m.confidence = 0.05 * next(21), m.distinctiveness_m = next(600);
    m.epochs_seen = uint16_t(1 + next(2)), m.source = uint16_t(next(8) == 0);
    out.push_back(m);
  }
  return out;
}

// A street across the border of two tiles with a fork, a ring, a crossing of four and a bend; widths and sources
// differ.
tiles::RoadGraph roads() {
  const auto node = [](double x, double y) { return tiles::RoadNode{kWestM + x, kSouthM + y}; };
  const auto point = [](double x, double y) { return tiles::RoadPoint{kWestM + x, kSouthM + y}; };
  tiles::RoadGraph g;
  g.nodes = {node(10, 312), node(600, 312), node(600, 30), node(2200, 320), node(600, 900), node(800, 312.25)};
  g.edges = {{0, 1, 6, 0.9, 0, {}},
             {1, 5, 6, 0.9, 0, {}},
             {5, 3, 7.5, 0.8, 1, {point(1400, 310), point(1900, 300), point(2100, 305)}},
             {1, 2, 4, 0.7, 0, {}},
             {4, 1, 5, 1, 1, {point(630, 700), point(640, 650), point(640, 600), point(630, 550)}},
             {5, 5, 3, 0.5, 0, {point(850, 350), point(900, 312), point(850, 280)}}};
  return g;
}

exporter::PackDescription description() {
  exporter::PackDescription d;
  d.zone = {32, true};
  d.builder = "landfix fixture";
  d.plane_height_m = 441.25;
  d.georegistration_error_m = 0.5;
  d.parameters = {{"gsd_m", "1"}, {"note", "drawn by code, no place on earth: Zürich is far"}};
  exporter::PackSource newest;
  newest.source.name = "newest.tif";
  newest.source.sha256 = std::string(32, '0') + std::string(32, '1');
  newest.source.date = "2021-06-30";
  newest.source.licence = "CC0-1.0";
  newest.source.attribution = "nobody";
  newest.source.crs = "EPSG:2056";
  newest.source.bands = {ingest::BandRole::kRed, ingest::BandRole::kGreen, ingest::BandRole::kBlue,
                         ingest::BandRole::kNir};
  newest.source.gsd_m = 0.25;
  exporter::PackSource older = newest;
  older.source.name = "older.tif";
  older.source.sha256 = std::string(64, 'a');
  older.source.date = "2009-08-18";
  older.source.bands = {ingest::BandRole::kGray};
  exporter::PackSource dem;
  dem.role = exporter::SourceRole::kElevation;
  dem.source.name = "dem.tif";
  dem.source.sha256 = std::string(64, 'b');
  dem.source.crs = "EPSG:32632";
  dem.source.vertical_datum = "egm96";
  dem.source.gsd_m = 4;
  exporter::PackSource known;
  known.role = exporter::SourceRole::kVector;
  known.source.name = "known.gpkg";
  known.source.sha256 = std::string(64, 'c');
  known.source.crs = "EPSG:4326";
  d.sources = {newest, older, dem, known};
  d.epochs = {{"2021-06-30", {0}}, {"2009-08-18", {1}}};
  d.geoid = ingest::GeoidGrid{
      "egm96", 496000, 4996000, 4000, 3, 3, {46.5f, 46.75f, 47, 47.25f, 47.5f, 47.75f, 48, 48.25f, 48.5f}};
  return d;
}

void sign(Bytes& pack) {
  uint8_t public_key[32], secret_key[64];
  crypto_sign_seed_keypair(public_key, secret_key,
                           reinterpret_cast<const uint8_t*>("landfix test key - not a secret!"));
  if (lf_sign_header(pack.data(), secret_key) != LF_OK) throw std::logic_error("the fixture cannot be signed");
}

// As fuzz_pack.cc reads it: a first byte 1, the header's fields without its reserved bytes, and what follows the header
// page.
Bytes compact(const Bytes& pack) {
  constexpr size_t kFields = offsetof(schema::Header, reserved);
  Bytes out(1 + kFields + pack.size() - schema::kPageSize, 1);
  std::copy_n(pack.begin(), kFields, out.begin() + 1);
  std::copy(pack.begin() + schema::kPageSize, pack.end(), out.begin() + 1 + kFields);
  return out;
}

// As it is, behind a first byte 0.
Bytes as_is(const Bytes& pack) {
  Bytes out(1 + pack.size(), 0);
  std::copy(pack.begin(), pack.end(), out.begin() + 1);
  return out;
}

}  // namespace

std::vector<uint8_t> draw_fixture() {
  Bytes pack = draw({.layers = {gray(), overview(), orientation(), height()},
                     .landmarks = landmarks(),
                     .roads = roads(),
                     .vector_epochs =
                         [](const tiles::TileIndex&) {
                           return catalog::EpochSet{0, 1};
                         },
                     .description = description()});
  sign(pack);
  return pack;
}

std::vector<std::pair<std::string, std::vector<uint8_t>>> draw_fuzz_seeds() {
  DrawnLayer packed = gray(), masked = gray(), colour = overview(), flat = gray(), bits = orientation();
  for (DrawnLayer* layer : {&packed, &masked, &flat}) layer->epochs = [](char) { return catalog::EpochSet(); };
  bits.codec = [](char letter) { return letter == 'a' ? Codec::kZstd : tiles::Codec::kContext; };
  bits.pixel = [](const PixelOf& p) { return int((p.column >> 5 & 1) == (p.channel & 1)); };
  packed.codec = [](char) { return Codec::kZstd; };
  packed.pixel = [](const PixelOf& p) { return int(1 + (p.column >> 5 & 7) * 16); };
  masked.codec = [](char) { return Codec::kJpeg; };
  masked.pixel = [](const PixelOf& p) { return (p.column & 255) < 100 ? 0 : 90; };
  colour.pixel = [](const PixelOf& p) { return 100 + p.channel; };
  flat.levels = {{0, -2, -1, "xxx\nxyx\nx.x"}};
  flat.codec = packed.codec;
  flat.pixel = [](const PixelOf& p) { return int(p.letter); };
  Drawing plain{.layers = {flat}}, full{.layers = {masked, colour, height()}, .description = description()};
  full.layers[2].pixel = [](const PixelOf& p) { return int(p.row & 255); };
  Bytes signed_pack = draw(full);
  sign(signed_pack);
  return {{"zstd", compact(draw({.layers = {packed}}))},
          {"jpeg", compact(draw({.layers = {masked}}))},
          {"equal_tiles", compact(draw(plain))},
          {"all_layers", compact(draw(full))},
          {"bits", compact(draw({.layers = {bits}, .description = description()}))},
          {"vectors", compact(draw({.landmarks = landmarks(), .roads = roads(), .description = description()}))},
          {"as_is", as_is(signed_pack)}};
}

}  // namespace landfix::tests

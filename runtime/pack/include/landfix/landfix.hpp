// C++20 face of landfix.h: the same functions with ownership, spans and results. Header only, so that the C ABI is the
// only one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "landfix/landfix.h"

namespace landfix {

using Status = lf_status;

/// A value, or the status that says why there is none.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)), status_(LF_OK) {}
  Result(Status status) : status_(status) {}
  explicit operator bool() const { return status_ == LF_OK; }
  Status status() const { return status_; }
  /// Sentence on what went wrong and what to do.
  const char* text() const { return lf_status_text(status_); }
  T& operator*() { return *value_; }
  const T& operator*() const { return *value_; }
  T* operator->() { return &*value_; }
  const T* operator->() const { return &*value_; }

 private:
  std::optional<T> value_;
  Status status_;
};

using PublicKey = std::array<uint8_t, 32>;

struct OpenOptions {
  bool copy = false;                         ///< read to memory instead of mapping
  std::vector<PublicKey> trusted_keys = {};  ///< refuse what none of these signed
};

using Ellipse = lf_ellipse;
using Region = lf_region;
using Tile = lf_tile;
using EpochRange = lf_epoch_range;
using Landmark = lf_landmark;
using Intersection = lf_intersection;
using Road = lf_road;
using Point = lf_point;

/// What is asked of landmarks and roads: those in the ellipse or, without one, in the box.
struct FeatureQuery {
  std::optional<Ellipse> ellipse = {};
  double west_m = 0, south_m = 0, east_m = 0, north_m = 0;
  uint32_t class_mask = 0;   ///< of landmarks: bit c asks for class c (lf_landmark_class); 0: all
  float min_confidence = 0;  ///< 0 to 1
};

struct Height {
  double height_m = 0;      ///< above the ellipsoid
  bool from_layer = false;  ///< false: the assumed plane
};

struct GridPosition {
  double east_m = 0, north_m = 0, convergence_rad = 0, scale = 1;
};

struct GeodeticPosition {
  double latitude_rad = 0, longitude_rad = 0, convergence_rad = 0, scale = 1;
};

/// An open pack. Moves, does not copy. All const members may be called from many threads.
class Pack {
 public:
  static Result<Pack> open(const char* path, const OpenOptions& options = {}) {
    const lf_open_options c = c_options(options);
    lf_pack* pack = nullptr;
    const Status status = lf_open(path, &c, &pack);
    return status == LF_OK ? Result<Pack>(Pack(pack)) : Result<Pack>(status);
  }
  static Result<Pack> open_memory(std::span<const std::byte> bytes, const OpenOptions& options = {}) {
    const lf_open_options c = c_options(options);
    lf_pack* pack = nullptr;
    const Status status = lf_open_memory(bytes.data(), bytes.size(), &c, &pack);
    return status == LF_OK ? Result<Pack>(Pack(pack)) : Result<Pack>(status);
  }
  Pack(Pack&& other) noexcept : pack_(std::exchange(other.pack_, nullptr)) {}
  Pack& operator=(Pack&& other) noexcept {
    std::swap(pack_, other.pack_);
    return *this;
  }
  ~Pack() { lf_close(pack_); }

  const lf_pack* c_pack() const { return pack_; }

  lf_info info() const {
    lf_info i{};
    lf_get_info(pack_, &i);
    return i;
  }
  Result<uint32_t> find_layer(const char* name) const {
    uint32_t layer;
    const Status s = lf_find_layer(pack_, name, &layer);
    return s == LF_OK ? Result<uint32_t>(layer) : Result<uint32_t>(s);
  }
  Result<lf_layer_info> layer(uint32_t index) const { return get<lf_layer_info>(lf_get_layer, index); }
  Result<lf_level_info> level(uint32_t layer, uint32_t index) const {
    return get<lf_level_info>(lf_get_level, layer, index);
  }
  Result<lf_source_info> source(uint32_t index) const { return get<lf_source_info>(lf_get_source, index); }
  Result<lf_epoch_info> epoch(uint32_t index) const { return get<lf_epoch_info>(lf_get_epoch, index); }
  /// Name and value of a parameter of the build.
  Result<std::pair<std::string_view, std::string_view>> parameter(uint32_t index) const {
    const char *name, *value;
    const Status s = lf_get_parameter(pack_, index, &name, &value);
    if (s != LF_OK) return s;
    return std::pair<std::string_view, std::string_view>(name, value);
  }

  /// The region that a k-sigma ellipse asks for, at the coarsest level not coarser than `gsd_m`.
  Result<Region> region(uint32_t layer, const Ellipse& ellipse, double gsd_m) const {
    return get<Region>(lf_ellipse_region, layer, &ellipse, gsd_m);
  }
  Result<Region> box(uint32_t layer, double west_m, double south_m, double east_m, double north_m, double gsd_m) const {
    return get<Region>(lf_box_region, layer, west_m, south_m, east_m, north_m, gsd_m);
  }
  Status read(const Region& region, std::span<uint8_t> out, size_t row_bytes) const {
    return lf_read(pack_, &region, out.data(), row_bytes, out.size());
  }
  Status read_heights(const Region& region, std::span<float> out, size_t row_bytes) const {
    return lf_read_heights(pack_, &region, out.data(), row_bytes, out.size_bytes());
  }
  /// Bit planes, 64 columns to a word; see lf_read_bits for their layout.
  Status read_bits(const Region& region, std::span<uint64_t> out, size_t row_words, size_t plane_words) const {
    return lf_read_bits(pack_, &region, out.data(), row_words, plane_words, out.size());
  }
  Result<Tile> tile(uint32_t layer, int32_t level, int32_t x, int32_t y) const {
    return get<Tile>(lf_tile_view, layer, level, x, y);
  }
  /// Calls visit(const Tile&) for the tiles of the region that hold data and, where `ellipse` is given, that it
  /// touches.
  template <typename Visit>
  Status for_each_tile(const Region& region, const Ellipse* ellipse, Visit visit) const {
    uint64_t cursor = 0;
    Tile next;
    Status s;
    while ((s = lf_next_tile(pack_, &region, ellipse, &cursor, &next)) == LF_OK) visit(std::as_const(next));
    return s == LF_END ? LF_OK : s;
  }
  /// Writes the indices of a tile's epochs, newest first, to `out`; how many, or why not. See lf_tile_epochs.
  Result<uint32_t> tile_epochs(uint32_t layer, int32_t level, int32_t x, int32_t y, std::span<uint16_t> out) const {
    return get<uint32_t>(lf_tile_epochs, layer, level, x, y, out.data(), uint32_t(out.size()));
  }
  Result<EpochRange> epochs(const Region& region) const { return get<EpochRange>(lf_region_epochs, &region); }
  Status prepare(const Region& region, uint32_t flags = 0) const { return lf_prepare(pack_, &region, flags); }

  /// Fills `out` from its front; `count` tells how many there are, also where the answer is LF_BUFFER_TOO_SMALL. See
  /// lf_find_landmarks.
  Status find_landmarks(uint32_t layer, const FeatureQuery& query, std::span<Landmark> out, size_t& count) const {
    const lf_feature_query c = c_query(query);
    return lf_find_landmarks(pack_, layer, &c, out.data(), out.size(), &count);
  }
  Status find_intersections(uint32_t layer, const FeatureQuery& query, std::span<Intersection> out,
                            size_t& count) const {
    const lf_feature_query c = c_query(query);
    return lf_find_intersections(pack_, layer, &c, out.data(), out.size(), &count);
  }
  Status find_roads(uint32_t layer, const FeatureQuery& query, std::span<Road> roads, size_t& road_count,
                    std::span<Point> vertices, size_t& vertex_count) const {
    const lf_feature_query c = c_query(query);
    return lf_find_roads(pack_, layer, &c, roads.data(), roads.size(), &road_count, vertices.data(), vertices.size(),
                         &vertex_count);
  }

  Result<Height> height(double east_m, double north_m) const {
    Height h;
    lf_height_source source;
    const Status s = lf_height(pack_, east_m, north_m, &h.height_m, &source);
    if (s != LF_OK) return s;
    h.from_layer = source == LF_HEIGHT_LAYER;
    return h;
  }
  Result<double> undulation(double east_m, double north_m) const { return get<double>(lf_undulation, east_m, north_m); }
  Result<GridPosition> grid_from_geodetic(double latitude_rad, double longitude_rad) const {
    GridPosition g;
    const Status s =
        lf_grid_from_geodetic(pack_, latitude_rad, longitude_rad, &g.east_m, &g.north_m, &g.convergence_rad, &g.scale);
    return s == LF_OK ? Result<GridPosition>(g) : Result<GridPosition>(s);
  }
  Result<GeodeticPosition> geodetic_from_grid(double east_m, double north_m) const {
    GeodeticPosition g;
    const Status s =
        lf_geodetic_from_grid(pack_, east_m, north_m, &g.latitude_rad, &g.longitude_rad, &g.convergence_rad, &g.scale);
    return s == LF_OK ? Result<GeodeticPosition>(g) : Result<GeodeticPosition>(s);
  }
  /// Number of tiles checked.
  Result<uint64_t> verify(bool deep) const { return get<uint64_t>(lf_verify_pack, int(deep)); }

 private:
  explicit Pack(lf_pack* pack) : pack_(pack) {}

  static lf_open_options c_options(const OpenOptions& o) {
    return {sizeof(lf_open_options), o.copy ? uint32_t(LF_OPEN_COPY) : 0u,
            o.trusted_keys.empty() ? nullptr : reinterpret_cast<const uint8_t(*)[32]>(o.trusted_keys.data()),
            o.trusted_keys.size()};
  }
  static lf_feature_query c_query(const FeatureQuery& q) {
    return {sizeof(lf_feature_query),          q.class_mask,    q.west_m, q.south_m, q.east_m, q.north_m,
            q.ellipse ? &*q.ellipse : nullptr, q.min_confidence};
  }
  template <typename T, typename Function, typename... Arguments>
  Result<T> get(Function function, Arguments... arguments) const {
    T value{};
    const Status s = function(pack_, arguments..., &value);
    return s == LF_OK ? Result<T>(std::move(value)) : Result<T>(s);
  }

  lf_pack* pack_ = nullptr;
};

}  // namespace landfix

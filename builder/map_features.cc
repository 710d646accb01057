#include "builder/map_features.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <iterator>
#include <map>
#include <set>

#include "builder/export/vector_layers.h"
#include "builder/ground_cover.h"
#include "builder/landmarks/broad_regions.h"
#include "builder/landmarks/extraction.h"
#include "builder/landmarks/fusion.h"
#include "builder/landmarks/preference.h"
#include "builder/layers/window.h"
#include "builder/roads/road_candidates.h"
#include "builder/roads/road_graph.h"
#include "tiles/landmark.h"
#include "tiles/road.h"

namespace landfix {
namespace {

using catalog::Catalog;
using catalog::FinishedTile;
using landmarks::RoadPlace;
using schema::TileRecord;

// Names in the journal; no layer of a pack can have them.
constexpr char kFoundLandmarks[] = "found/landmarks", kFoundRoads[] = "found/roads", kFoundImage[] = "found/image";
constexpr char kFoundView[] = "found/view/";  // and the index of the epoch
constexpr int kBlockLevel = kFeatureLevel + layers::kBlockLog2;
constexpr int kViewLevel = kFeatureLevel + 2;  // of broad views
constexpr int kMostWindows = 2;                // looked at together: 350 MB each

static_assert(landmarks::kLandmarkGsd_m == 1 && landmarks::kRoadGsd_m == 1, "the pixels of kFeatureLevel");
static_assert(landmarks::kBroadStep_px == 1 << (kViewLevel - kFeatureLevel), "those of kViewLevel");
static_assert(landmarks::kBroadWindow_px == tiles::kTilePixels << (tiles::kVectorLevel - kViewLevel), "a vector tile");

// A landmarks::Sighting in the journal: bytes without gaps.
struct StoredSighting {
  double east_m, north_m;
  float length_m, width_m, orientation_rad, confidence;
  uint16_t epoch, chances;
  uint8_t cls, is_newest, unused[2];
};
static_assert(sizeof(StoredSighting) == 40);

template <typename Stored>
FinishedTile journal_tile(const std::string& name, const tiles::TileIndex& tile, const std::vector<Stored>& items) {
  std::vector<uint8_t> data(items.size() * sizeof(Stored));
  if (!items.empty()) std::memcpy(data.data(), items.data(), data.size());
  return catalog::finished_tile(name, tile, std::move(data));
}

template <typename Stored>
void read_all(const Catalog& catalog, const char* name, std::vector<Stored>& out) {
  for (const TileRecord& record : catalog.tiles(name, kBlockLevel)) {
    const size_t begin = out.size();
    out.resize(begin + record.length / sizeof(Stored));
    catalog.read(record, {reinterpret_cast<uint8_t*>(out.data() + begin), record.length});
  }
}

bool has_colours(const ingest::EpochInfo& epoch) {
  using ingest::BandRole;
  return std::ranges::all_of(std::array{BandRole::kRed, BandRole::kGreen, BandRole::kBlue},
                             [&](BandRole role) { return std::ranges::count(epoch.roles, role) > 0; });
}

// False colours would mislead: gray then.
int channels_of(const ingest::EpochInfo& epoch) { return has_colours(epoch) ? 3 : 1; }

// Roads are linked over the whole map: its image has one number of channels.
int road_channels(const Plan& plan) { return std::ranges::all_of(plan.images->epochs(), has_colours) ? 3 : 1; }

features::GridImage image_of(const ingest::Stack& stack, const tiles::PixelRect& rect, int channels) {
  const layers::Newest newest = layers::newest(stack, rect, channels);
  if (newest.pixels.empty()) return {};
  return {newest.pixels, newest.owner > 0, rect.west_m(), rect.north_m(), tiles::gsd_of(rect.level)};
}

std::string view_of(size_t epoch) { return kFoundView + std::to_string(epoch); }

// Landmarks of all epochs, the broad view of each, and what covers the ground where navigability asks for it.
std::vector<FinishedTile> find_sightings(const Plan& plan, const ingest::Stack& images, const tiles::PixelRect& rect,
                                         const cv::Rect& core, const tiles::TileIndex& block) {
  std::vector<StoredSighting> out;
  std::vector<FinishedTile> views;
  std::vector<cv::Mat> covers;
  std::vector<features::GridImage> shown;
  for (const ingest::Epoch& epoch : images.epochs)
    shown.push_back(image_of({images.rect, {epoch}}, rect, channels_of(plan.images->epochs()[epoch.index])));
  const auto shows = [&](const features::GridImage& image, const tiles::Landmark& m) {
    const int x = int(std::lround(image.column_of(m.east_m))), y = int(std::lround(image.row_of(m.north_m)));
    return !image.pixels.empty() &&
           image.valid.at<uint8_t>(std::clamp(y, 0, image.valid.rows - 1), std::clamp(x, 0, image.valid.cols - 1)) != 0;
  };
  for (size_t i = 0; i < shown.size(); ++i) {
    if (shown[i].pixels.empty()) continue;
    cv::Mat view, *cover = plan.footprints.empty() ? nullptr : &covers.emplace_back();
    const std::vector<landmarks::Extracted> all =
        landmarks::find_landmarks(shown[i], core, *plan.object_model, &view, cover);
    if (!view.empty())
      views.push_back(
          journal_tile(view_of(images.epochs[i].index), block, std::vector<uint8_t>(view.datastart, view.dataend)));
    for (const landmarks::Extracted& found : all) {
      const tiles::Landmark& m = found.landmark;
      const auto chances = uint16_t(std::ranges::count_if(shown, [&](const auto& image) { return shows(image, m); }));
      const bool is_newest =
          std::none_of(shown.begin(), shown.begin() + int(i), [&](const auto& image) { return shows(image, m); });
      out.push_back({m.east_m,
                     m.north_m,
                     float(m.length_m),
                     float(m.width_m),
                     float(m.orientation_rad),
                     float(m.confidence),
                     uint16_t(images.epochs[i].index),
                     std::max(chances, uint16_t(1)),
                     uint8_t(m.cls),
                     is_newest,
                     {}});
    }
  }
  views.push_back(journal_tile(kFoundLandmarks, block, out));
  if (!plan.footprints.empty()) views.push_back(describe_covers(block, covers));
  return views;
}

std::vector<landmarks::Sighting> sightings_of(const Catalog& catalog) {
  std::vector<StoredSighting> stored;
  read_all(catalog, kFoundLandmarks, stored);
  std::vector<landmarks::Sighting> out;
  for (const StoredSighting& s : stored) {
    landmarks::Sighting sighting{{}, s.epoch, s.chances, s.is_newest != 0};
    tiles::Landmark& m = sighting.landmark;
    m.east_m = s.east_m, m.north_m = s.north_m;
    m.cls = tiles::LandmarkClass(s.cls);
    m.length_m = s.length_m, m.width_m = s.width_m, m.orientation_rad = s.orientation_rad;
    m.confidence = s.confidence;
    out.push_back(sighting);
  }
  return out;
}

// The epochs that show something in the blocks of each vector tile.
exporter::EpochsOfTile epochs_by_tile(const Catalog& catalog) {
  std::map<uint64_t, std::set<uint16_t>> epochs;
  for (const char* name : {kFoundLandmarks, kFoundRoads})
    for (const TileRecord& record : catalog.tiles(name, kBlockLevel))
      for (const uint16_t epoch : catalog.epochs_of(record))
        epochs[record.key >> 2 * (tiles::kVectorLevel - kBlockLevel)].insert(epoch);
  return [epochs](const tiles::TileIndex& tile) -> catalog::EpochSet {
    const auto found = epochs.find(tiles::hilbert_key(tile));
    if (found == epochs.end()) return {};
    return {found->second.begin(), found->second.end()};
  };
}

using Records = std::map<uint64_t, TileRecord>;  // by key

Records records_of(const Catalog& catalog, const std::string& name) {
  Records out;
  for (const TileRecord& record : catalog.tiles(name, kBlockLevel)) out.emplace(record.key, record);
  return out;
}

// Pixels that blocks left in the journal.
class FoundPixels {
 public:
  FoundPixels(const Catalog& catalog, const Records& records, int level, int channels)
      : catalog_(catalog), records_(records), level_(level), channels_(channels) {}

  /// Those of a rectangle of their level, 0 where there is no data.
  cv::Mat read(const tiles::PixelRect& rect) {
    cv::Mat out = cv::Mat::zeros(int(rect.height), int(rect.width), CV_8UC(channels_));
    const tiles::TileRange range = blocks_of(rect);
    for (int32_t y = range.y_min; y <= range.y_max; ++y) {
      for (int32_t x = range.x_min; x <= range.x_max; ++x) {
        const tiles::TileIndex block{kBlockLevel, x, y};
        const cv::Mat& pixels = page(block);
        if (pixels.empty()) continue;
        const tiles::PixelRect whole = layers::pixels_of(block, level_);
        const tiles::PixelRect common = layers::intersection(rect, whole);
        pixels(layers::region_of(common, whole)).copyTo(out(layers::region_of(common, rect)));
      }
    }
    return out;
  }

 private:
  static constexpr size_t kMostPages = 16;  // 50 MB

  static tiles::TileRange blocks_of(const tiles::PixelRect& rect) {
    tiles::TileRange range = tiles::tiles_of(rect);
    for (int32_t* i : {&range.x_min, &range.x_max, &range.y_min, &range.y_max}) *i >>= kBlockLevel - rect.level;
    return range;
  }

  const cv::Mat& page(const tiles::TileIndex& block) {
    const uint64_t key = tiles::hilbert_key(block);
    if (const auto found = pages_.find(key); found != pages_.end()) return found->second;
    if (pages_.size() >= kMostPages) pages_.clear();  // what is asked for next lies close by: few come back
    cv::Mat& pixels = pages_[key];
    const auto record = records_.find(key);
    if (record == records_.end()) return pixels;
    const int side = tiles::kTilePixels << (kBlockLevel - level_);
    pixels.create(side, side, CV_8UC(channels_));
    catalog_.read(record->second, {pixels.ptr<uint8_t>(), record->second.length});
    return pixels;
  }

  const Catalog& catalog_;
  const Records& records_;
  const int level_, channels_;
  std::map<uint64_t, cv::Mat> pages_;
};

// Broad landmarks of all epochs with their middle in one vector tile.
std::vector<landmarks::Sighting> find_broad_in(const Plan& plan, const Catalog& catalog,
                                               const std::vector<Records>& seen, const tiles::TileIndex& tile) {
  const tiles::PixelRect inner = layers::pixels_of(tile, kViewLevel);
  const tiles::PixelRect rect = layers::grown(inner, landmarks::kBroadHalo_px);
  std::vector<features::GridImage> views;
  for (size_t epoch = 0; epoch < seen.size(); ++epoch) {
    const int channels = landmarks::broad_channels(channels_of(plan.images->epochs()[epoch]));
    views.push_back({FoundPixels(catalog, seen[epoch], kViewLevel, channels).read(rect),
                     {},
                     rect.west_m(),
                     rect.north_m(),
                     tiles::gsd_of(kViewLevel)});
  }
  const auto shows = [](const features::GridImage& view, const tiles::Landmark& m) {
    const cv::Point at(int(std::lround(view.column_of(m.east_m))), int(std::lround(view.row_of(m.north_m))));
    return cv::Rect({}, view.pixels.size()).contains(at) && view.pixels.ptr(at.y, at.x)[0] == 255;
  };
  std::vector<landmarks::Sighting> out;
  for (size_t epoch = 0; epoch < views.size(); ++epoch) {
    for (const landmarks::Extracted& e : landmarks::find_broad(views[epoch], layers::region_of(inner, rect))) {
      const auto shown = [&](const features::GridImage& view) { return shows(view, e.landmark); };
      const auto chances = std::ranges::count_if(views, shown);
      const bool is_newest = std::none_of(views.begin(), views.begin() + std::ptrdiff_t(epoch), shown);
      out.push_back({e.landmark, uint16_t(epoch), uint16_t(std::max(chances, std::ptrdiff_t(1))), is_newest});
    }
  }
  return out;
}

std::vector<tiles::Landmark> broad_of(const Plan& plan, const Catalog& catalog) {
  if (!plan.find_landmarks) return {};
  std::set<uint64_t> keys;  // of vector tiles that show anything
  for (const TileRecord& record : catalog.tiles(kFoundLandmarks, kBlockLevel))
    keys.insert(record.key >> 2 * (tiles::kVectorLevel - kBlockLevel));
  const std::vector<uint64_t> windows(keys.begin(), keys.end());
  std::vector<Records> seen;  // of every epoch
  for (size_t epoch = 0; epoch < plan.images->epochs().size(); ++epoch)
    seen.push_back(records_of(catalog, view_of(epoch)));
  std::vector<std::vector<landmarks::Sighting>> found(windows.size());
  tbb::task_arena(kMostWindows).execute([&] {
    tbb::parallel_for(size_t(0), windows.size(), [&](size_t i) {
      found[i] = find_broad_in(plan, catalog, seen, tiles::tile_of_key(tiles::kVectorLevel, windows[i]));
    });
  });
  std::vector<landmarks::Sighting> all;
  for (const std::vector<landmarks::Sighting>& some : found) all.insert(all.end(), some.begin(), some.end());
  return landmarks::fuse_epochs(landmarks::without_covered(all));
}

std::vector<tiles::Landmark> landmarks_of(const Plan& plan, const Catalog& catalog, const tiles::RoadGraph& roads) {
  std::vector<tiles::Landmark> all = plan.known.landmarks;
  // Broad ones first: what else is found in a field is a piece of it.
  for (std::vector<tiles::Landmark> found : {broad_of(plan, catalog), landmarks::fuse_epochs(sightings_of(catalog))}) {
    std::erase_if(found,
                  [&](const tiles::Landmark& m) { return !plan.description.bounds.contains(m.east_m, m.north_m); });
    landmarks::drop_on_roads(found, roads);
    landmarks::add_new(all, found, landmarks::kSamePlace_m);
  }
  tiles::measure_distinctiveness(all, tiles::kDistinctRadius_m);
  return all;
}

// Places on roads, and the image itself for the last pass.
std::vector<FinishedTile> find_places(const Plan& plan, const features::GridImage& image, const tiles::PixelRect& rect,
                                      const cv::Rect& core, const tiles::TileIndex& block) {
  if (image.pixels.empty()) return {};
  std::vector<RoadPlace> places = landmarks::find_road_places(image.pixels, image.valid, core, *plan.road_model);
  for (RoadPlace& p : places) p.x += int32_t(rect.column), p.y += int32_t(rect.row);  // pixels of the zone
  const cv::Mat shown = image.pixels(core).clone();
  return {journal_tile(kFoundRoads, block, places),
          journal_tile(kFoundImage, block, std::vector<uint8_t>(shown.datastart, shown.dataend))};
}

tiles::RoadGraph roads_of(const Plan& plan, const Catalog& catalog) {
  if (!plan.find_roads) return plan.known.roads;
  const tiles::PixelRect map = ingest::pixels_covering(plan.description.bounds, kFeatureLevel);
  std::vector<RoadPlace> places;
  read_all(catalog, kFoundRoads, places);
  for (RoadPlace& p : places) p.x -= int32_t(map.column), p.y -= int32_t(map.row);
  const cv::Size size(int(map.width), int(map.height));
  std::erase_if(places, [&](const RoadPlace& p) { return !cv::Rect({}, size).contains({p.x, p.y}); });
  const Records records = records_of(catalog, kFoundImage);
  FoundPixels image(catalog, records, kFeatureLevel, road_channels(plan));
  const auto read = [&](const cv::Rect& part) {
    return image.read({kFeatureLevel, map.column + part.x, map.row + part.y, part.width, part.height});
  };
  landmarks::RoadEvidence evidence(read, size, *plan.road_model);
  return landmarks::link_roads(places, size, std::ref(evidence),
                               {map.west_m(), map.north_m(), tiles::gsd_of(kFeatureLevel)});
}

}  // namespace

int feature_halo_px() { return (std::max(landmarks::kLandmarkHalo_px, landmarks::kRoadHaloPx) + 1) & ~1; }

std::vector<FinishedTile> find_features(const Plan& plan, const ingest::Stack& images, const tiles::TileIndex& block) {
  if (images.epochs.empty()) return {};
  // Even the first pixel, so that those of 2 m lie where those of other blocks do.
  const tiles::PixelRect rect = layers::grown(layers::pixels_of(block, kFeatureLevel), feature_halo_px());
  const cv::Rect core = layers::region_of(layers::pixels_of(block, kFeatureLevel), rect);
  std::vector<FinishedTile> of_landmarks, of_roads;
  // Isolated as the tiles of a block are.
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_invoke(
        [&] {
          if (plan.find_landmarks) of_landmarks = find_sightings(plan, images, rect, core, block);
        },
        [&] {
          if (plan.find_roads)
            of_roads = find_places(plan, image_of(images, rect, road_channels(plan)), rect, core, block);
        });
  });
  std::vector<FinishedTile> out = std::move(of_landmarks);
  std::ranges::move(of_roads, std::back_inserter(out));
  catalog::EpochSet epochs;
  for (const ingest::Epoch& epoch : images.epochs) epochs.push_back(uint16_t(epoch.index));
  std::ranges::sort(epochs);
  for (FinishedTile& tile : out) tile.epochs = epochs;
  return out;
}

std::vector<FinishedTile> link_features(const Plan& plan, const Catalog& catalog, std::vector<std::string>& warnings) {
  const exporter::EpochsOfTile epochs = epochs_by_tile(catalog);
  const tiles::RoadGraph roads = plan.roads ? roads_of(plan, catalog) : plan.known.roads;
  std::vector<FinishedTile> out;
  if (plan.landmarks) out = exporter::landmark_tiles(landmarks_of(plan, catalog, roads), epochs, &warnings);
  if (plan.roads) std::ranges::move(exporter::road_tiles(roads, epochs, &warnings), std::back_inserter(out));
  return out;
}

std::vector<std::string> text_of_features(const Plan& plan, const Catalog& catalog) {
  const auto for_each_tile = [&](const char* layer, const auto& visit) {
    for (const TileRecord& record : catalog.tiles(layer, tiles::kVectorLevel)) {
      std::vector<uint8_t> data(record.length);
      catalog.read(record, data);
      visit(tiles::tile_of_key(tiles::kVectorLevel, record.key), data);
    }
  };
  std::vector<std::string> lines;
  if (plan.landmarks) {
    std::vector<tiles::Landmark> all, some;
    for_each_tile(exporter::kLandmarks, [&](const tiles::TileIndex& tile, const std::vector<uint8_t>& data) {
      tiles::decode_landmarks(tile, data, some);
      all.insert(all.end(), some.begin(), some.end());
    });
    lines.push_back("landmarks: " + landmarks::text_of(all));
  }
  if (plan.roads) {
    std::vector<tiles::RoadGraph> graphs;
    for_each_tile(exporter::kRoads, [&](const tiles::TileIndex& tile, const std::vector<uint8_t>& data) {
      tiles::decode_roads(tile, data, graphs.emplace_back());
    });
    lines.push_back("roads: " + landmarks::text_of(graphs));
  }
  return lines;
}

}  // namespace landfix

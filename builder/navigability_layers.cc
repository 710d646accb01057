#include "builder/navigability_layers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "builder/export/vector_layers.h"
#include "builder/ground_cover.h"
#include "builder/layers/window.h"
#include "builder/map_navigability.h"
#include "builder/point_grid.h"
#include "tiles/landmark.h"

namespace landfix {
namespace {

using catalog::Catalog;
using catalog::FinishedTile;
using schema::TileRecord;
using tiles::Finder;
using tiles::Footprint;
using tiles::Navigability;
using tiles::Reason;

constexpr double kMuch = 0.5;               // of a view, of water or wood
constexpr double kMuchShadow = 0.25;        // the rest lies beside it
constexpr double kStrongRelief = 1.0 / 12;  // of the view's side: standard deviation of its heights
constexpr int kHeightLevel = 4;             // at which heights are looked at
constexpr double kLandmarkCell_m = 64;      // of the grid that landmarks are looked up in

// The nodes of a tile, rows from the north.
struct Places {
  static constexpr int kSide = tiles::kTilePixels;

  tiles::TileIndex tile;
  std::vector<std::optional<Navigability>> nodes{size_t(kSide) * kSide};

  std::optional<Navigability>& at(int x, int y) { return nodes[size_t(y) * kSide + size_t(x)]; }
  cv::Point2d middle(size_t node) const {
    const double side_m = tiles::tile_side(tile.level);
    const double spacing_m = tiles::gsd_of(tile.level);
    return {tile.x * side_m + (double(node % kSide) + 0.5) * spacing_m,
            (tile.y + 1) * side_m - (double(node / kSide) + 0.5) * spacing_m};
  }
};

// All landmarks of the pack, as its tiles hold them.
std::vector<tiles::Landmark> landmarks_of(const Catalog& catalog) {
  std::vector<tiles::Landmark> all, some;
  for (const TileRecord& record : catalog.tiles(exporter::kLandmarks, tiles::kVectorLevel)) {
    std::vector<uint8_t> data(record.length);
    catalog.read(record, data);
    if (tiles::decode_landmarks(tiles::tile_of_key(tiles::kVectorLevel, record.key), data, some))
      all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

// Entropy of the classes in a view over that of all classes alike (DeAngelo 2016 ch. 7), 0 to 1.
double diversity_of(const std::array<unsigned, tiles::kLandmarkClasses>& counts, unsigned all) {
  double entropy = 0;
  for (const unsigned count : counts)
    if (count > 0) entropy -= double(count) / all * std::log(double(count) / all);
  return entropy / std::log(double(counts.size()));
}

void count_landmarks(const landmarks::PointGrid& grid, const std::vector<tiles::Landmark>& all,
                     const cv::Point2d& middle, double view_m, Navigability& place) {
  std::array<unsigned, tiles::kLandmarkClasses> counts{};
  grid.within(middle, view_m * std::numbers::sqrt2 / 2, [&](const cv::Point2d& at, int id) {
    if (std::max(std::abs(at.x - middle.x), std::abs(at.y - middle.y)) <= view_m / 2)
      ++counts[size_t(all[size_t(id)].cls)];
  });
  place.landmarks = 0;
  for (const unsigned count : counts) place.landmarks += count;
  if (place.landmarks > 0) place.diversity = diversity_of(counts, place.landmarks);
}

// How far heights spread in a view.
class Relief {
 public:
  // Around the nodes of a tile in the area, as far as `reach_m` beyond.
  Relief(const Plan& plan, const tiles::TileIndex& tile, double reach_m) {
    if (!plan.elevation) return;
    const int reach_px = int(std::ceil(reach_m / tiles::gsd_of(kHeightLevel)));
    const tiles::PixelRect area = ingest::pixels_covering(plan.description.bounds, kHeightLevel);
    rect_ = layers::grown(layers::intersection(area, layers::pixels_of(tile, kHeightLevel)), reach_px);
    const features::GridImage heights = plan.elevation->read(rect_);
    cv::Mat values, known;
    heights.valid.convertTo(known, CV_64F, 1.0 / 255);
    heights.pixels.convertTo(values, CV_64F);
    cv::integral(known, sums_[0], CV_64F);
    cv::integral(values, sums_[1], CV_64F);
    cv::integral(values.mul(values), sums_[2], CV_64F);
  }

  /// Standard deviation; nothing where no height is known.
  std::optional<double> spread_m(const cv::Point2d& middle, double view_m) const {
    if (sums_[0].empty()) return std::nullopt;
    const double gsd_m = tiles::gsd_of(kHeightLevel);
    const int side = std::max(2, int(std::lround(view_m / gsd_m)));
    const cv::Point corner(int(std::lround((middle.x - rect_.west_m()) / gsd_m - 0.5 * side)),
                           int(std::lround((rect_.north_m() - middle.y) / gsd_m - 0.5 * side)));
    const cv::Rect view = cv::Rect(corner, cv::Size(side, side)) & cv::Rect(0, 0, int(rect_.width), int(rect_.height));
    if (view.empty()) return std::nullopt;
    std::array<double, 3> sums;
    for (size_t k = 0; k < 3; ++k) {
      const cv::Mat_<double> s = sums_[k];
      sums[k] = s(view.br()) - s(view.y, view.br().x) - s(view.br().y, view.x) + s(view.tl());
    }
    if (sums[0] < 1) return std::nullopt;
    const double mean = sums[1] / sums[0];
    return std::sqrt(std::max(sums[2] / sums[0] - mean * mean, 0.0));
  }

 private:
  tiles::PixelRect rect_;
  std::array<cv::Mat, 3> sums_;  // of known pixels, of heights, of their squares
};

// What lies on the ground of the whole map.
struct Surroundings {
  Surroundings(const Plan& plan, const Catalog& catalog)
      : landmarks(plan.landmarks ? landmarks_of(catalog) : std::vector<tiles::Landmark>{}), ground(plan, catalog) {
    for (size_t i = 0; i < landmarks.size(); ++i) grid.add({landmarks[i].east_m, landmarks[i].north_m}, int(i));
  }

  std::vector<tiles::Landmark> landmarks;
  landmarks::PointGrid grid{kLandmarkCell_m};
  GroundMap ground;
};

void add_reasons(const GroundMap& ground, const Relief& relief, const cv::Point2d& middle, double view_m,
                 Navigability& place) {
  const auto say = [&](Reason reason, bool is_so) {
    place.reasons = uint16_t(place.reasons | unsigned(is_so) << unsigned(reason));
  };
  const auto share = [&](Ground kind) { return ground.share(kind, middle.x, middle.y, view_m).value_or(0); };
  say(Reason::kWater, share(Ground::kWater) >= kMuch);
  say(Reason::kWood, share(Ground::kWood) >= kMuch);
  say(Reason::kShadow, share(Ground::kShadow) >= kMuchShadow);
  say(Reason::kRelief, relief.spread_m(middle, view_m).value_or(0) >= kStrongRelief * view_m);
}

double logit(double p) { return std::log(p / (1 - p)); }

// Chances by matchers that were asked at every so manieth node only. Between these their log odds lie as far from those
// of the first matcher, which is known everywhere, as at the nodes around.
void fill_chances(Places& places, Finder first, Finder other, int stride) {
  const std::vector<std::optional<Navigability>> judged = places.nodes;
  for (int y = 0; y < Places::kSide; ++y) {
    for (int x = 0; x < Places::kSide; ++x) {
      std::optional<Navigability>& place = places.at(x, y);
      if (!place || !std::isnan(place->fix_probability[size_t(other)])) continue;
      double apart = 0;
      int count = 0;
      const int reach = stride - 1;
      for (int v = std::max(y - reach, 0); v <= std::min(y + reach, Places::kSide - 1); ++v)
        for (int u = std::max(x - reach, 0); u <= std::min(x + reach, Places::kSide - 1); ++u) {
          const std::optional<Navigability>& near = judged[size_t(v) * Places::kSide + size_t(u)];
          if (!near || std::isnan(near->fix_probability[size_t(other)])) continue;
          apart += logit(near->fix_probability[size_t(other)]) - logit(near->fix_probability[size_t(first)]);
          ++count;
        }
      if (count == 0) continue;
      const double own = logit(place->fix_probability[size_t(first)]) + apart / count;
      place->fix_probability[size_t(other)] = 1 / (1 + std::exp(-own));
    }
  }
}

// What the blocks of a tile have said.
Places places_of(const Catalog& catalog, const std::vector<TileRecord>& records, const tiles::TileIndex& tile,
                 const JudgedBlocks& blocks) {
  Places out{tile};
  const int side = blocks.side_nodes, per_tile = Places::kSide / side;
  for (const TileRecord& record : records) {
    const tiles::TileIndex block = tiles::tile_of_key(blocks.level, record.key);
    const int left = (block.x - tile.x * per_tile) * side, top = ((tile.y + 1) * per_tile - 1 - block.y) * side;
    std::vector<uint8_t> pixels(record.length);
    catalog.read(record, pixels);
    for (int i = 0; i < side * side; ++i)
      out.at(left + i % side, top + i / side) = tiles::decode_navigability(
          std::span(pixels).subspan(size_t(i) * tiles::kNavigabilityChannels, tiles::kNavigabilityChannels));
  }
  return out;
}

// Adds what blocks cannot know of the nodes in the area; without data beyond. Whether any is left.
bool finish_places(const Plan& plan, const Surroundings& s, const Relief& relief, const Footprint& f, Places& places) {
  for (size_t m = 1; m < plan.matchers.size(); ++m)
    fill_chances(places, finder_of(plan.matchers[0]), finder_of(plan.matchers[m]), nodes_per_view(f));
  bool any = false;
  for (size_t i = 0; i < places.nodes.size(); ++i) {
    if (!places.nodes[i]) continue;
    const cv::Point2d middle = places.middle(i);
    if (!plan.area->bounds().contains(middle.x, middle.y)) {
      places.nodes[i].reset();
      continue;
    }
    count_landmarks(s.grid, s.landmarks, middle, f.template_m, *places.nodes[i]);
    add_reasons(s.ground, relief, middle, f.template_m, *places.nodes[i]);
    any = true;
  }
  return any;
}

FinishedTile encoded(const Footprint& f, const Places& places, const Catalog& catalog,
                     const std::vector<TileRecord>& blocks, const Plan& plan) {
  std::vector<uint8_t> pixels(kNavigabilityFormat.bytes());
  for (size_t i = 0; i < places.nodes.size(); ++i)
    if (places.nodes[i])
      std::ranges::copy(tiles::encode_navigability(*places.nodes[i]),
                        pixels.begin() + ptrdiff_t(i * tiles::kNavigabilityChannels));
  std::set<uint16_t> epochs;
  for (const TileRecord& record : blocks)
    for (const uint16_t epoch : catalog.epochs_of(record)) epochs.insert(epoch);
  FinishedTile out = catalog::finished_tile(
      tiles::layer_of(f), places.tile, tiles::encode(tiles::Codec::kZstd, kNavigabilityFormat, pixels, plan.encoding));
  out.record.codec = uint8_t(tiles::Codec::kZstd);
  out.epochs.assign(epochs.begin(), epochs.end());
  return out;
}

template <typename Visit>
void for_each_node(const Catalog& catalog, const TileRecord& record, Visit visit) {
  std::vector<uint8_t> data(record.length), pixels(kNavigabilityFormat.bytes());
  catalog.read(record, data);
  if (!tiles::decode(tiles::Codec(record.codec), kNavigabilityFormat, data, pixels)) return;
  for (size_t i = 0; i < pixels.size(); i += tiles::kNavigabilityChannels)
    if (const auto place = tiles::decode_navigability(std::span(pixels).subspan(i, tiles::kNavigabilityChannels)))
      visit(*place);
}

}  // namespace

exporter::PackLayer navigability_layer(const Footprint& footprint) {
  exporter::PackLayer layer;
  layer.name = tiles::layer_of(footprint);
  layer.description = fmt::format(
      "how well a camera that sees {} m finds itself, up to {} m off: chances by matcher, spread, look-alike, "
      "landmarks, reasons",
      footprint.template_m, footprint.search_m);
  layer.format = kNavigabilityFormat;
  layer.levels.push_back({tiles::navigability_level(footprint), {}});
  return layer;
}

std::vector<FinishedTile> link_navigability(const Plan& plan, const Catalog& catalog) {
  struct Judged {
    const Footprint* footprint = nullptr;
    std::vector<TileRecord> blocks;
  };
  std::map<std::pair<int, uint64_t>, std::vector<Judged>> tiles;  // by level and key
  for (const Footprint& f : plan.footprints) {
    const JudgedBlocks blocks(f, plan.image_level);
    const int level = tiles::navigability_level(f);
    for (const TileRecord& record : catalog.tiles(blocks.name, blocks.level)) {
      std::vector<Judged>& judged = tiles[{level, record.key >> 2 * (level - blocks.level)}];
      if (judged.empty() || judged.back().footprint != &f) judged.push_back({&f, {}});
      judged.back().blocks.push_back(record);
    }
  }
  double reach_m = 0;
  for (const Footprint& f : plan.footprints) reach_m = std::max(reach_m, f.template_m / 2);
  const Surroundings surroundings(plan, catalog);
  std::vector<FinishedTile> out;
  for (const auto& [place, footprints] : tiles) {
    const tiles::TileIndex tile = tiles::tile_of_key(place.first, place.second);
    const Relief relief(plan, tile, reach_m);
    for (const Judged& judged : footprints) {
      const Footprint& f = *judged.footprint;
      Places places = places_of(catalog, judged.blocks, tile, JudgedBlocks(f, plan.image_level));
      if (finish_places(plan, surroundings, relief, f, places))
        out.push_back(encoded(f, places, catalog, judged.blocks, plan));
    }
  }
  return out;
}

std::vector<std::string> text_of_navigability(const Plan& plan, const Catalog& catalog) {
  std::vector<std::string> out;
  for (const Footprint& f : plan.footprints) {
    std::vector<double> chances;
    for (const TileRecord& record : catalog.tiles(tiles::layer_of(f), tiles::navigability_level(f)))
      for_each_node(catalog, record,
                    [&](const Navigability& n) { chances.push_back(n.fix_probability[size_t(tiles::Finder::kAuto)]); });
    if (chances.empty()) {
      out.push_back(tiles::layer_of(f) + ": no place can be judged");
      continue;
    }
    std::ranges::sort(chances);
    out.push_back(fmt::format("{}: {} places; chance of a fix {:.2f} at the median, below {:.2f} at a tenth of them",
                              tiles::layer_of(f), chances.size(), chances[chances.size() / 2],
                              chances[chances.size() / 10]));
  }
  return out;
}

}  // namespace landfix

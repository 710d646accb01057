#include "builder/layers/window.h"

#include <algorithm>
#include <array>

#include "runtime/features/gray.h"

namespace landfix::layers {
namespace {

using ingest::BandRole;

// Channel of a role in the epoch, or -1.
int channel_of(const ingest::Epoch& epoch, BandRole role) {
  const auto it = std::find(epoch.roles.begin(), epoch.roles.end(), role);
  return it == epoch.roles.end() ? -1 : int(it - epoch.roles.begin());
}

cv::Mat channel(const cv::Mat& bands, int index) {
  cv::Mat one;
  cv::extractChannel(bands, one, index);
  return one;
}

// Three channels of the epoch for a person's eye.
cv::Mat colours(const ingest::Epoch& epoch, const cv::Mat& bands) {
  const int gray = channel_of(epoch, BandRole::kGray), nir = channel_of(epoch, BandRole::kNir);
  std::array<int, 3> from = {channel_of(epoch, BandRole::kRed), channel_of(epoch, BandRole::kGreen),
                             channel_of(epoch, BandRole::kBlue)};
  if (from[0] < 0 || from[1] < 0 || from[2] < 0) {
    if (gray >= 0)
      from = {gray, gray, gray};
    else if (nir >= 0 && from[0] >= 0 && from[1] >= 0)
      from = {nir, from[0], from[1]};
    else
      from = {0, 0, 0};
  }
  if (bands.channels() == 3 && from == std::array{0, 1, 2}) return bands;
  cv::Mat out(bands.size(), CV_8UC3);
  for (int c = 0; c < 3; ++c) cv::insertChannel(channel(bands, from[size_t(c)]), out, c);
  return out;
}

cv::Mat brightness(const ingest::Epoch& epoch, const cv::Mat& bands) {
  if (const int gray = channel_of(epoch, BandRole::kGray); gray >= 0) return channel(bands, gray);
  std::vector<int> visible;
  for (const BandRole role : {BandRole::kRed, BandRole::kGreen, BandRole::kBlue})
    if (const int c = channel_of(epoch, role); c >= 0) visible.push_back(c);
  if (visible.size() == 3) return features::gray_from_rgb(colours(epoch, bands));
  if (visible.size() < 2) return channel(bands, visible.empty() ? 0 : visible[0]);
  const cv::Mat a = channel(bands, visible[0]), b = channel(bands, visible[1]);
  cv::Mat mean(bands.size(), CV_8UC1);
  for (int y = 0; y < mean.rows; ++y)
    for (int x = 0; x < mean.cols; ++x)
      mean.at<uint8_t>(y, x) = uint8_t((a.at<uint8_t>(y, x) + b.at<uint8_t>(y, x) + 1) / 2);
  return mean;
}

// Copies the epoch's data to the pixels of `out` that have none yet; returns how many it filled.
template <int kChannels>
int fill(const cv::Mat& shown, const cv::Mat& valid, cv::Mat out) {
  int filled = 0;
  for (int y = 0; y < out.rows; ++y) {
    const uint8_t* mask = valid.ptr<uint8_t>(y);
    const uint8_t* from = shown.ptr<uint8_t>(y);
    uint8_t* to = out.ptr<uint8_t>(y);
    for (int x = 0; x < out.cols; ++x, from += kChannels, to += kChannels) {
      if (!mask[x] || std::any_of(to, to + kChannels, [](uint8_t v) { return v != 0; })) continue;
      const bool black = std::all_of(from, from + kChannels, [](uint8_t v) { return v == 0; });
      for (int c = 0; c < kChannels; ++c) to[c] = black ? uint8_t(1) : from[c];
      ++filled;
    }
  }
  return filled;
}

}  // namespace

tiles::PixelRect pixels_of(const tiles::TileIndex& tile, int level) {
  const int finer = tile.level - level;
  const int64_t side = int64_t(tiles::kTilePixels) << finer;
  return {level, first_column(tile) << finer, first_row(tile) << finer, side, side};
}

tiles::PixelRect intersection(const tiles::PixelRect& a, const tiles::PixelRect& b) {
  tiles::PixelRect r{a.level, std::max(a.column, b.column), std::max(a.row, b.row), 0, 0};
  r.width = std::max<int64_t>(0, std::min(a.column + a.width, b.column + b.width) - r.column);
  r.height = std::max<int64_t>(0, std::min(a.row + a.height, b.row + b.height) - r.row);
  if (r.width == 0 || r.height == 0) r.width = r.height = 0;
  return r;
}

cv::Rect region_of(const tiles::PixelRect& inner, const tiles::PixelRect& outer) {
  return {int(inner.column - outer.column), int(inner.row - outer.row), int(inner.width), int(inner.height)};
}

cv::Mat newest(const ingest::Stack& stack, const tiles::PixelRect& rect, int channels) {
  const tiles::PixelRect common = intersection(rect, stack.rect);
  if (common.width == 0) return {};
  cv::Mat out(int(rect.height), int(rect.width), CV_8UC(channels), cv::Scalar::all(0));
  const cv::Mat part = out(region_of(common, rect));
  const cv::Rect region = region_of(common, stack.rect);
  int filled = 0;
  for (const ingest::Epoch& epoch : stack.epochs) {
    const cv::Mat bands = epoch.bands(region), valid = epoch.valid(region);
    filled +=
        channels == 1 ? fill<1>(brightness(epoch, bands), valid, part) : fill<3>(colours(epoch, bands), valid, part);
    if (filled == part.rows * part.cols) break;
  }
  return filled ? out : cv::Mat();
}

}  // namespace landfix::layers

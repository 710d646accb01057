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

// Copies the epoch's data to the pixels of `out` that have no owner yet; returns how many it filled.
template <int kChannels>
int fill(const cv::Mat& shown, const cv::Mat& valid, uint16_t number, cv::Mat out, cv::Mat owner) {
  int filled = 0;
  for (int y = 0; y < out.rows; ++y) {
    const uint8_t* mask = valid.ptr<uint8_t>(y);
    const uint8_t* from = shown.ptr<uint8_t>(y);
    uint8_t* to = out.ptr<uint8_t>(y);
    uint16_t* owned = owner.ptr<uint16_t>(y);
    for (int x = 0; x < out.cols; ++x, from += kChannels, to += kChannels) {
      if (!mask[x] || owned[x]) continue;
      uint8_t any = 0;
      for (int c = 0; c < kChannels; ++c) any |= from[c];
      for (int c = 0; c < kChannels; ++c) to[c] = any ? from[c] : uint8_t(1);
      owned[x] = number;
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

tiles::PixelRect grown(const tiles::PixelRect& r, int px) {
  return {r.level, r.column - px, r.row - px, r.width + 2 * px, r.height + 2 * px};
}

Newest newest(const ingest::Stack& stack, const tiles::PixelRect& rect, int channels) {
  const tiles::PixelRect common = intersection(rect, stack.rect);
  if (common.width == 0 || stack.epochs.empty()) return {};
  Newest out{cv::Mat(int(rect.height), int(rect.width), CV_8UC(channels), cv::Scalar::all(0)),
             cv::Mat(int(rect.height), int(rect.width), CV_16UC1, cv::Scalar(0)),
             {}};
  const cv::Mat part = out.pixels(region_of(common, rect)), owner = out.owner(region_of(common, rect));
  const cv::Rect region = region_of(common, stack.rect);
  int filled = 0;
  for (const ingest::Epoch& epoch : stack.epochs) {
    const cv::Mat bands = epoch.bands(region), valid = epoch.valid(region);
    if (cv::countNonZero(valid) == 0) continue;
    const auto number = uint16_t(out.epochs.size() + 1);
    const int added = channels == 1 ? fill<1>(brightness(epoch, bands), valid, number, part, owner)
                                    : fill<3>(colours(epoch, bands), valid, number, part, owner);
    if (added > 0) out.epochs.push_back(uint16_t(epoch.index));
    filled += added;
    if (filled == part.rows * part.cols) break;
  }
  return filled ? out : Newest{};
}

Newest cut(const Newest& newest, const tiles::PixelRect& rect, const tiles::PixelRect& part) {
  const tiles::PixelRect common = intersection(part, rect);
  if (newest.pixels.empty() || common.width == 0) return {};
  const cv::Rect from = region_of(common, rect), to = region_of(common, part);
  if (cv::countNonZero(newest.owner(from)) == 0) return {};
  if (common == part) return {newest.pixels(from), newest.owner(from), newest.epochs};
  const cv::Size size(int(part.width), int(part.height));
  Newest out{cv::Mat::zeros(size, newest.pixels.type()), cv::Mat::zeros(size, CV_16UC1), newest.epochs};
  newest.pixels(from).copyTo(out.pixels(to));
  newest.owner(from).copyTo(out.owner(to));
  return out;
}

void for_each_epoch(const Newest& newest, const std::function<void(const cv::Mat& mask)>& visit) {
  for (size_t i = 0; i < newest.epochs.size(); ++i) {
    const cv::Mat mask = newest.owner == int(i + 1);
    if (cv::countNonZero(mask) > 0) visit(mask);
  }
}

std::vector<uint16_t> epochs_in(const Newest& newest, const cv::Rect& region) {
  std::vector<uint16_t> out;
  for (size_t i = 0; i < newest.epochs.size(); ++i)
    if (cv::countNonZero(newest.owner(region) == int(i + 1)) > 0) out.push_back(newest.epochs[i]);
  return out;
}

}  // namespace landfix::layers

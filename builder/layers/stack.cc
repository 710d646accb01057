#include "builder/layers/stack.h"

#include <array>

#include "builder/layers/window.h"

namespace landfix::layers {
namespace {

constexpr int kSide = tiles::kTilePixels;

template <int kBands>
void halve_row(const uint8_t* const bands[2], const uint8_t* const valid[2], uint8_t* out, uint8_t* out_valid) {
  for (int x = 0; x < kSide; ++x, out += kBands) {
    const std::array<const uint8_t*, 4> pixel = {bands[0] + 2 * x * kBands, bands[0] + (2 * x + 1) * kBands,
                                                 bands[1] + 2 * x * kBands, bands[1] + (2 * x + 1) * kBands};
    const std::array<uint8_t, 4> has = {valid[0][2 * x], valid[0][2 * x + 1], valid[1][2 * x], valid[1][2 * x + 1]};
    if (has[0] & has[1] & has[2] & has[3]) {
      for (int b = 0; b < kBands; ++b)
        out[b] = uint8_t((pixel[0][b] + pixel[1][b] + pixel[2][b] + pixel[3][b] + 2) / 4);
      out_valid[x] = 255;
      continue;
    }
    const int count = (has[0] & 1) + (has[1] & 1) + (has[2] & 1) + (has[3] & 1);
    if (count < 2) continue;
    for (int b = 0; b < kBands; ++b) {
      int sum = 0;
      for (size_t i = 0; i < 4; ++i) sum += pixel[i][b] & has[i];
      out[b] = uint8_t((sum + count / 2) / count);
    }
    out_valid[x] = 255;
  }
}

void halve_row(int bands, const uint8_t* const from[2], const uint8_t* const valid[2], uint8_t* out,
               uint8_t* out_valid) {
  switch (bands) {
    case 1:
      return halve_row<1>(from, valid, out, out_valid);
    case 2:
      return halve_row<2>(from, valid, out, out_valid);
    case 3:
      return halve_row<3>(from, valid, out, out_valid);
    case 4:
      return halve_row<4>(from, valid, out, out_valid);
    default:
      CV_Error(cv::Error::StsUnsupportedFormat, "an epoch has 1 to 4 bands");
  }
}

// What the epoch shows in the tile, at the fine level: 512x512 pixels. False where it shows nothing.
bool cut(const ingest::Stack& fine, const ingest::Epoch& epoch, const tiles::TileIndex& tile,
         const std::function<bool(const tiles::TileIndex&)>& used, cv::Mat& bands, cv::Mat& valid) {
  bands = cv::Mat::zeros(2 * kSide, 2 * kSide, epoch.bands.type());
  valid = cv::Mat::zeros(2 * kSide, 2 * kSide, CV_8UC1);
  const tiles::PixelRect all = pixels_of(tile, fine.rect.level);
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const tiles::TileIndex child = tiles::child(tile, quadrant);
    const tiles::PixelRect common = intersection(pixels_of(child, fine.rect.level), fine.rect);
    if (common.width == 0 || !used(child)) continue;
    epoch.bands(region_of(common, fine.rect)).copyTo(bands(region_of(common, all)));
    epoch.valid(region_of(common, fine.rect)).copyTo(valid(region_of(common, all)));
  }
  return cv::countNonZero(valid) > 0;
}

}  // namespace

std::vector<EpochTile> halved(const ingest::Stack& fine, const tiles::TileIndex& tile,
                              const std::function<bool(const tiles::TileIndex&)>& used) {
  std::vector<EpochTile> out;
  cv::Mat bands, valid, out_valid(kSide, kSide, CV_8UC1);
  for (const ingest::Epoch& epoch : fine.epochs) {
    if (!cut(fine, epoch, tile, used, bands, valid)) continue;
    const int count = bands.channels();
    EpochTile half{epoch.index, tile, std::vector<uint8_t>(size_t(kSide * kSide * count))};
    out_valid.setTo(0);
    for (int y = 0; y < kSide; ++y) {
      const uint8_t* const from[2] = {bands.ptr<uint8_t>(2 * y), bands.ptr<uint8_t>(2 * y + 1)};
      const uint8_t* const mask[2] = {valid.ptr<uint8_t>(2 * y), valid.ptr<uint8_t>(2 * y + 1)};
      halve_row(count, from, mask, half.data.data() + y * kSide * count, out_valid.ptr<uint8_t>(y));
    }
    const int with_data = cv::countNonZero(out_valid);
    if (with_data == 0) continue;
    if (with_data < kSide * kSide) half.data.insert(half.data.end(), out_valid.datastart, out_valid.dataend);
    out.push_back(std::move(half));
  }
  return out;
}

ingest::Stack stack_of_tiles(const tiles::PixelRect& rect, std::span<const ingest::EpochInfo> epochs,
                             const ReadEpochTile& read) {
  ingest::Stack out{rect, {}};
  const tiles::TileRange range = tiles::tiles_of(rect);
  for (size_t e = 0; e < epochs.size(); ++e) {
    ingest::Epoch epoch{epochs[e].date, epochs[e].roles, {}, {}, {}, e};
    const int type = CV_8UC(int(epochs[e].roles.size()));
    for (int32_t y = range.y_min; y <= range.y_max; ++y)
      for (int32_t x = range.x_min; x <= range.x_max; ++x) {
        const tiles::TileIndex tile{rect.level, x, y};
        std::optional<std::vector<uint8_t>> data = read(e, tile);
        if (!data) continue;
        if (epoch.bands.empty()) {
          epoch.bands = cv::Mat::zeros(int(rect.height), int(rect.width), type);
          epoch.valid = cv::Mat::zeros(int(rect.height), int(rect.width), CV_8UC1);
        }
        const cv::Mat bands(kSide, kSide, type, data->data());
        const tiles::PixelRect all = pixels_of(tile, rect.level), common = intersection(all, rect);
        const cv::Rect from = region_of(common, all), to = region_of(common, rect);
        bands(from).copyTo(epoch.bands(to));
        if (const size_t size = bands.total() * bands.elemSize(); data->size() > size)
          cv::Mat(kSide, kSide, CV_8UC1, data->data() + size)(from).copyTo(epoch.valid(to));
        else
          epoch.valid(to).setTo(255);
      }
    if (!epoch.bands.empty() && cv::countNonZero(epoch.valid) > 0) out.epochs.push_back(std::move(epoch));
  }
  return out;
}

}  // namespace landfix::layers

#include "builder/ingest/image_set.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include "builder/error.h"
#include "builder/ingest/footprint.h"
#include "builder/ingest/hash.h"
#include "builder/ingest/provenance.h"
#include "builder/ingest/raster.h"
#include "builder/ingest/roles.h"
#include "builder/ingest/zone.h"

namespace landfix::ingest {
namespace {

/// Newest first, undated last; in the order of the command line where dates are equal.
std::vector<EpochInfo> group_by_date(const std::vector<Source>& sources) {
  std::vector<EpochInfo> groups;
  for (size_t i = 0; i < sources.size(); ++i) {
    const Source& s = sources[i];
    const auto same = [&](const EpochInfo& g) { return g.date == s.date && g.roles == s.bands; };
    auto group = std::find_if(groups.begin(), groups.end(), same);
    if (group == groups.end()) group = groups.insert(group, {s.date, s.bands, {}});
    group->sources.push_back(int(i));
  }
  // Dates as 2009-08-18 sort as texts; the empty one comes last.
  std::stable_sort(groups.begin(), groups.end(),
                   [](const EpochInfo& a, const EpochInfo& b) { return a.date > b.date; });
  return groups;
}

void require_bytes(GDALDataset& dataset, const std::string& path, const BandLayout& layout) {
  std::vector<int> bands = layout.bands;
  if (layout.alpha != 0) bands.push_back(layout.alpha);
  for (const int number : bands) {
    GDALRasterBand& band = *dataset.GetRasterBand(number);
    if (band.GetColorInterpretation() == GCI_PaletteIndex || band.GetColorTable() != nullptr) {
      throw Error(
          ExitCode::kBadInput,
          fmt::format("{}: band {} has a colour palette. Turn it into colours: gdal_translate -expand rgb IN OUT", path,
                      number));
    }
    const char* pixel_type = band.GetMetadataItem("PIXELTYPE", "IMAGE_STRUCTURE");
    if (band.GetRasterDataType() != GDT_Byte || (pixel_type && EQUAL(pixel_type, "SIGNEDBYTE"))) {
      throw Error(
          ExitCode::kBadInput,
          fmt::format(
              "{}: band {} has pixels of type {}; expected 8-bit (Byte). Convert it with a range that suits the image: "
              "gdal_translate -ot Byte -scale LOW HIGH 0 255 IN OUT",
              path, number, GDALGetDataTypeName(band.GetRasterDataType())));
    }
  }
}

/// How many corners of the image hold this value and nothing else, in all bands.
int corners_of(GDALDataset& dataset, std::vector<int> bands, uint8_t value) {
  constexpr int kSide = 4;
  const int right = dataset.GetRasterXSize() - kSide, bottom = dataset.GetRasterYSize() - kSide;
  if (right < kSide || bottom < kSide) return 0;
  int count = 0;
  for (const int x : {0, right})
    for (const int y : {0, bottom}) {
      std::vector<uint8_t> pixels(kSide * kSide * bands.size());
      const bool good = dataset.RasterIO(GF_Read, x, y, kSide, kSide, pixels.data(), kSide, kSide, GDT_Byte,
                                         int(bands.size()), bands.data(), 0, 0, 0, nullptr) == CE_None;
      count += good && std::ranges::all_of(pixels, [&](uint8_t pixel) { return pixel == value; });
    }
  return count;
}

/// Warps leave black or white where the image ends, and without a mask that is ground to whoever reads it: with edges,
/// which no camera sees. Two corners are no chance. Nothing where the file says what is no data.
std::string doubt_of_corners(Raster& raster, const Channels& channels) {
  if (channels.mask != Channels::Mask::kNone || !channels.nodata.empty()) return {};
  for (const uint8_t value : {0, 255})
    if (const int corners = corners_of(raster.dataset(), channels.bands, value); corners >= 2)
      return fmt::format(
          "{0}: {1} of its corners are {2} in all bands and count as ground; if the image shows nothing "
          "there, say so: --nodata {0}={2}",
          raster.name(), corners, value);
  return {};
}

/// What options, sidecar and file say, in this order.
struct Description {
  Source source;
  BandLayout layout;
};

Description describe(const SourceOptions& file, Raster& raster) {
  if (!file.date.empty() && !is_date(file.date)) {
    throw Error(ExitCode::kUsage, fmt::format("{}: date \"{}\": expected a day as 2009-08-18", file.path, file.date));
  }
  const Sidecar sidecar = read_sidecar(file.path);
  Description d;
  d.source.path = file.path;
  d.source.name = raster.name();
  d.source.date = file.date.empty() ? sidecar.date : file.date;
  d.source.licence = sidecar.licence;
  d.source.attribution = sidecar.attribution;
  d.source.georegistration_error_m = sidecar.georegistration_error_m;
  d.source.crs = raster.crs_text();
  d.layout = band_layout(raster.dataset(), file.path, file.bands.empty() ? sidecar.bands : file.bands,
                         file.bands.empty() ? ExitCode::kBadInput : ExitCode::kUsage);
  require_bytes(raster.dataset(), file.path, d.layout);
  d.source.bands = d.layout.roles;
  d.source.nodata = file.nodata ? file.nodata : sidecar.nodata;
  const std::optional<double> nodata = d.source.nodata;
  if (nodata && !(*nodata >= 0 && *nodata <= 255 && *nodata == std::floor(*nodata))) {
    throw Error(file.nodata ? ExitCode::kUsage : ExitCode::kBadInput,
                fmt::format("{}: nodata value {}: expected 0 to 255, pixels are 8-bit", file.path, *nodata));
  }
  return d;
}

/// The middle of all images: mean of their centres as directions, so that the antimeridian is no place of its own.
tiles::Zone zone_of_centre(const std::deque<Raster>& rasters) {
  cv::Vec3d sum(0, 0, 0);
  for (const Raster& r : rasters) {
    const tiles::Geodetic c = r.centre();
    sum += cv::Vec3d(std::cos(c.latitude_rad) * std::cos(c.longitude_rad),
                     std::cos(c.latitude_rad) * std::sin(c.longitude_rad), std::sin(c.latitude_rad));
  }
  const auto zone = tiles::standard_zone({std::atan2(sum[2], std::hypot(sum[0], sum[1])), std::atan2(sum[1], sum[0])});
  if (!zone) throw Error(ExitCode::kBadInput, "the images' centre lies in no zone: choose one with --zone");
  return *zone;
}

}  // namespace

struct ImageSet::Impl {
  tiles::Zone zone;
  std::shared_ptr<HandlePool> pool = std::make_shared<HandlePool>();
  std::deque<Raster> rasters;  // a deque: handles know rasters by address
  std::vector<Source> sources;
  std::vector<EpochInfo> groups;
  GridBounds bounds;
  std::vector<std::string> warnings;
};

ImageSet::ImageSet(std::span<const SourceOptions> files, std::optional<tiles::Zone> zone)
    : impl_(std::make_unique<Impl>()) {
  if (files.empty()) throw Error(ExitCode::kUsage, "no image given: expected at least one");
  std::vector<Channels> channels;
  for (const SourceOptions& file : files) {
    Raster& raster = impl_->rasters.emplace_back(file.path, impl_->pool);
    Description d = describe(file, raster);
    channels.push_back(Channels::bytes(raster.dataset(), d.layout.bands, d.layout.alpha, d.source.nodata));
    impl_->sources.push_back(std::move(d.source));
    if (std::string doubt = doubt_of_corners(raster, channels.back()); !doubt.empty())
      impl_->warnings.push_back(std::move(doubt));
  }
  impl_->zone = zone ? *zone : zone_of_centre(impl_->rasters);
  for (size_t i = 0; i < files.size(); ++i) {
    Raster& raster = impl_->rasters[i];
    raster.place(impl_->zone, channels[i]);
    impl_->sources[i].gsd_m = raster.gsd_m();
    impl_->sources[i].bounds = raster.bounds();
    impl_->bounds.extend(raster.bounds());
  }
  tbb::parallel_for(size_t(0), files.size(),
                    [&](size_t i) { impl_->sources[i].sha256 = raster_sha256(impl_->sources[i].path); });
  impl_->groups = group_by_date(impl_->sources);
}

ImageSet::~ImageSet() = default;
ImageSet::ImageSet(ImageSet&&) noexcept = default;
ImageSet& ImageSet::operator=(ImageSet&&) noexcept = default;

const tiles::Zone& ImageSet::zone() const { return impl_->zone; }
const std::vector<Source>& ImageSet::sources() const { return impl_->sources; }
const std::vector<EpochInfo>& ImageSet::epochs() const { return impl_->groups; }
const GridBounds& ImageSet::bounds() const { return impl_->bounds; }
const std::vector<std::string>& ImageSet::warnings() const { return impl_->warnings; }

double ImageSet::finest_gsd_m() const {
  const auto finest = std::min_element(impl_->sources.begin(), impl_->sources.end(),
                                       [](const Source& a, const Source& b) { return a.gsd_m < b.gsd_m; });
  return finest->gsd_m;
}

int ImageSet::derived_level() const {
  const auto level = tiles::nearest_level(finest_gsd_m());
  if (!level)
    throw Error(ExitCode::kBadInput,
                fmt::format("{} m per pixel is no ground sample distance of a pack", finest_gsd_m()));
  return *level;
}

bool ImageSet::touches(const GridBounds& b) const {
  return std::any_of(impl_->rasters.begin(), impl_->rasters.end(), [&](const Raster& r) { return r.may_touch(b); });
}

std::string ImageSet::footprints_wkt() const {
  std::vector<std::vector<cv::Point2d>> outlines;
  for (const Raster& r : impl_->rasters) outlines.push_back(r.outline());
  return multipolygon_wkt(outlines);
}

std::vector<Epoch> ImageSet::read(const PixelWindow& window) const {
  require_readable(window);
  std::vector<Epoch> epochs;
  const int width = int(window.width), height = int(window.height);
  for (const EpochInfo& group : impl_->groups) {
    Epoch epoch{group.date, group.roles, {}, {}, {}, size_t(&group - impl_->groups.data())};
    int64_t filled = 0;
    for (const int source : group.sources) {
      const Raster& raster = impl_->rasters[size_t(source)];
      if (filled == window.width * window.height) break;
      if (!raster.may_touch(window.bounds())) continue;
      if (epoch.bands.empty()) {
        epoch.bands = cv::Mat::zeros(height, width, CV_8UC(int(group.roles.size())));
        epoch.valid = cv::Mat::zeros(height, width, CV_8UC1);
      }
      const int64_t added = raster.fill(window, epoch.bands, epoch.valid);
      if (added > 0) epoch.sources.push_back(source);
      filled += added;
    }
    if (filled > 0) epochs.push_back(std::move(epoch));
  }
  return epochs;
}

std::optional<Epoch> ImageSet::read_source(size_t source, const PixelWindow& window) const {
  require_readable(window);
  const Raster& raster = impl_->rasters.at(source);
  if (!raster.may_touch(window.bounds())) return std::nullopt;
  const auto shows = [&](const EpochInfo& e) { return std::ranges::count(e.sources, int(source)) > 0; };
  const auto epoch = std::ranges::find_if(impl_->groups, shows);
  const cv::Size size(int(window.width), int(window.height));
  Epoch out{epoch->date,
            epoch->roles,
            cv::Mat::zeros(size, CV_8UC(int(epoch->roles.size()))),
            cv::Mat::zeros(size, CV_8UC1),
            {int(source)},
            size_t(epoch - impl_->groups.begin())};
  if (raster.fill(window, out.bands, out.valid) == 0) return std::nullopt;
  return out;
}

void ImageSet::move_source(size_t source, double east_m, double north_m) {
  impl_->rasters.at(source).move(east_m, north_m);
  impl_->sources[source].bounds = impl_->rasters[source].bounds();
  impl_->bounds = {};
  for (const Raster& raster : impl_->rasters) impl_->bounds.extend(raster.bounds());
}

Stack ImageSet::read(const tiles::PixelRect& rect) const { return {rect, read(window_of(rect))}; }

}  // namespace landfix::ingest

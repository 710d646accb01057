#include "tools/common/open_pack.h"

#include <cstring>

#include "tools/common/keys.h"

namespace landfix::tools {

ExitCode exit_code_of(Status status) {
  switch (status) {
    case LF_OK:
    case LF_END:
      return ExitCode::kOk;
    case LF_IO:
      return ExitCode::kIo;
    case LF_NOT_A_PACK:
    case LF_UNKNOWN_VERSION:
    case LF_TRUNCATED:
    case LF_DAMAGED:
      return ExitCode::kBadPack;
    case LF_UNSIGNED:
    case LF_UNTRUSTED:
      return ExitCode::kUntrusted;
    case LF_OUTSIDE_MAP:
    case LF_NO_SUCH_LAYER:
      return ExitCode::kNoData;
    case LF_INVALID_ARGUMENT:
    case LF_REGION_TOO_LARGE:
    case LF_WRONG_TYPE:
      return ExitCode::kBadInput;
    case LF_NOT_PREPARED:
    case LF_BUFFER_TOO_SMALL:
    case LF_OUT_OF_MEMORY:
      break;
  }
  return ExitCode::kInternal;
}

void check(Status status, const std::string& what) {
  if (status != LF_OK) throw Error(exit_code_of(status), what + ": " + lf_status_text(status));
}

Pack open_pack(const std::string& path, const std::vector<std::string>& key_files) {
  OpenOptions options;
  for (const std::string& file : key_files) options.trusted_keys.push_back(read_public_key(file));
  errno = 0;
  Result<Pack> pack = Pack::open(path.c_str(), options);
  if (!pack && pack.status() == LF_IO && errno != 0)
    throw Error(ExitCode::kIo, path + ": cannot be opened: " + std::strerror(errno));
  check(pack.status(), path);
  return std::move(*pack);
}

void prepare_layers(const Pack& pack, const std::string& path, std::span<const char* const> layers) {
  const lf_info info = pack.info();
  for (const char* name : layers) {
    const Result<uint32_t> layer = pack.find_layer(name);
    if (!layer) continue;
    for (uint32_t i = 0; const Result<lf_level_info> level = pack.level(*layer, i); ++i) {
      const Result<Region> all = pack.box(*layer, info.west_m, info.south_m, info.east_m, info.north_m, level->gsd_m);
      if (all) check(pack.prepare(*all), path);
    }
  }
}

features::GridImage read_region(const Pack& pack, const Region& region, const std::string& path) {
  const Result<lf_layer_info> layer = pack.layer(region.layer);
  check(layer.status(), path);
  const std::string what = path + ": layer '" + layer->name + "'";
  if (layer->channels == 0) check(LF_WRONG_TYPE, what);
  check(pack.prepare(region), what);
  features::GridImage image;
  image.west_m = region.west_m, image.north_m = region.north_m, image.gsd_m = region.gsd_m;
  const int rows = int(region.height), columns = int(region.width);
  if (layer->pixel_type == LF_I16) {
    image.pixels.create(rows, columns, CV_32FC1);
    check(pack.read_heights(region, {image.pixels.ptr<float>(), image.pixels.total()}, image.pixels.step[0]), what);
    image.valid = image.pixels == image.pixels;  // NaN differs from itself
    return image;
  }
  image.pixels.create(rows, columns, CV_8UC(layer->channels));
  check(pack.read(region, {image.pixels.ptr(), image.pixels.total() * layer->channels}, image.pixels.step[0]),
        layer->name);
  cv::Mat different;
  cv::compare(image.pixels.reshape(1), double(layer->nodata), different, cv::CMP_NE);
  cv::reduce(different.reshape(1, int(image.pixels.total())), image.valid, 1, cv::REDUCE_MAX);
  image.valid = image.valid.reshape(1, rows);
  return image;
}

}  // namespace landfix::tools

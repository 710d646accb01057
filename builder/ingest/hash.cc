#include "builder/ingest/hash.h"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal_priv.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "builder/error.h"
#include "builder/hex.h"
#include "builder/ingest/gdal.h"

namespace landfix::ingest {
namespace {

using Digest = std::array<unsigned char, crypto_hash_sha256_BYTES>;

/// Through GDAL's file system, so that what GDAL can open (in an archive, say) can be hashed, too.
Digest file_digest(const std::string& path) {
  const std::unique_ptr<VSILFILE, decltype(&VSIFCloseL)> file(VSIFOpenL(path.c_str(), "rb"), VSIFCloseL);
  if (!file) throw Error(ExitCode::kIo, fmt::format("{}: cannot be opened for reading", path));
  crypto_hash_sha256_state state;
  crypto_hash_sha256_init(&state);
  std::vector<unsigned char> buffer(1 << 20);
  for (size_t n; (n = VSIFReadL(buffer.data(), 1, buffer.size(), file.get())) > 0;)
    crypto_hash_sha256_update(&state, buffer.data(), n);
  if (!VSIFEofL(file.get())) throw Error(ExitCode::kIo, fmt::format("{}: reading failed", path));
  Digest d;
  crypto_hash_sha256_final(&state, d.data());
  return d;
}

bool has_extension(const std::string& path, const char* extension) {
  return EQUAL(CPLGetExtension(path.c_str()), extension);
}

/// Adds the files of a dataset, each once; those of a VRT inside a VRT as well.
void list_files(const std::string& path, unsigned kind, std::vector<std::string>& files) {
  const GDALDatasetUniquePtr dataset(GDALDataset::Open(path.c_str(), kind | GDAL_OF_READONLY));
  if (!dataset) throw Error(ExitCode::kIo, fmt::format("{}: cannot be opened", path));
  const CPLStringList list(dataset->GetFileList());
  for (int i = 0; i < list.size(); ++i) {
    const std::string file = list[i];
    if (has_extension(file, "ovr") || std::find(files.begin(), files.end(), file) != files.end()) continue;
    files.push_back(file);
    if (file != path && has_extension(file, "vrt")) list_files(file, kind, files);
  }
}

std::string dataset_sha256(const std::string& path, unsigned kind) {
  setup_gdal();
  const GdalMessages messages;
  std::vector<std::string> files;
  list_files(path, kind, files);
  if (files.empty())
    throw Error(ExitCode::kBadInput, fmt::format("{}: is not a file, so it cannot be identified by a hash", path));
  if (files.size() == 1) return hex(file_digest(files[0]));
  crypto_hash_sha256_state state;
  crypto_hash_sha256_init(&state);
  for (const std::string& file : files) {
    const Digest d = file_digest(file);
    crypto_hash_sha256_update(&state, d.data(), d.size());
  }
  Digest d;
  crypto_hash_sha256_final(&state, d.data());
  return hex(d);
}

}  // namespace

std::string raster_sha256(const std::string& path) { return dataset_sha256(path, GDAL_OF_RASTER); }

std::string vector_sha256(const std::string& path) { return dataset_sha256(path, GDAL_OF_VECTOR); }

}  // namespace landfix::ingest

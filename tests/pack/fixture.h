// The fixture beside the format's specification, and the seeds of the fuzzer: drawn by code, the same bytes every time.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace landfix::tests {

/// schemas/fixtures/small.lfpack: every kind of layer, codec and manifest field of version 1.2, signed with the
/// fixtures' key. The bytes of compressed tiles depend on the versions of libzstd and libjpeg-turbo.
std::vector<uint8_t> draw_fixture();

/// Small packs (no raw tile, which would be 64 kB) in the form that fuzz_pack.cc reads: name and bytes.
std::vector<std::pair<std::string, std::vector<uint8_t>>> draw_fuzz_seeds();

/// Every field of a pack as JSON, in the words of schemas/fixtures/read_pack.py: header, manifest, block table, tile
/// records and, decoded through the C API, the hash of each tile's pixels, or its landmarks and roads. Throws
/// std::runtime_error where the runtime refuses the pack.
std::string describe(const std::vector<uint8_t>& pack);

}  // namespace landfix::tests

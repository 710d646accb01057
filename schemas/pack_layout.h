// The fixed records of a pack file, byte for byte as FORMAT.md defines them. Little-endian hosts only, as the format is.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace landfix::schema {

static_assert(std::endian::native == std::endian::little, "packs are read in place on little-endian hosts");

inline constexpr uint8_t kMagic[8] = {0x89, 'L', 'F', 'P', '\r', '\n', 0x1A, '\n'};
inline constexpr uint16_t kVersionMajor = 1, kVersionMinor = 3;
inline constexpr uint32_t kPageSize = 4096;
inline constexpr uint32_t kBlockTiles = 256;   ///< most tile records in a directory block
inline constexpr uint32_t kSmallAlignment = 8; ///< of everything that is not page-aligned
inline constexpr uint64_t kMaxManifestBytes = 64u << 20;
inline constexpr uint32_t kMaxTileBytes = 16u << 20;
inline constexpr uint32_t kMaxEpochs = 65535;     ///< of a pack; as many sets of epochs

/// The bytes signed are this text (without a terminator) followed by the root.
inline constexpr char kSignatureContext[] = "landfix pack root v1";

struct Hash {
  uint8_t bytes[32];
  friend bool operator==(const Hash&, const Hash&) = default;
};

enum class SignatureKind : uint32_t { kNone = 0, kEd25519 = 1 };

struct Header {
  uint8_t magic[8];
  uint16_t version_major;
  uint16_t version_minor;
  uint32_t page_size;
  uint64_t file_length;
  uint64_t manifest_offset;
  uint64_t manifest_length;
  uint64_t block_table_offset;
  uint64_t block_count;
  uint64_t reserved_root;  ///< zero
  Hash manifest_hash;
  Hash block_table_hash;
  Hash root;               ///< BLAKE2b-256 of the 128 bytes before it
  uint32_t signature_kind;
  uint32_t reserved_signature;  ///< zero
  uint8_t public_key[32];
  uint8_t signature[64];
  uint8_t reserved[3800];  ///< zero
  Hash header_hash;        ///< BLAKE2b-256 of the 4064 bytes before it
};
static_assert(sizeof(Header) == kPageSize && std::is_trivially_copyable_v<Header> && std::is_standard_layout_v<Header>);
static_assert(offsetof(Header, manifest_hash) == 64 && offsetof(Header, root) == 128 && offsetof(Header, public_key) == 168 &&
              offsetof(Header, header_hash) == 4064);

/// One entry of the block table: a run of at most kBlockTiles tile records.
struct BlockRecord {
  uint64_t first_key;  ///< Hilbert key of the first tile
  uint64_t last_key;   ///< and of the last
  uint64_t offset;     ///< of the first tile record in the file
  uint32_t count;      ///< tile records
  uint32_t reserved;   ///< zero
  Hash hash;           ///< BLAKE2b-256 of the tile records
};
static_assert(sizeof(BlockRecord) == 64 && std::is_trivially_copyable_v<BlockRecord> && std::is_standard_layout_v<BlockRecord>);

/// One tile of a layer at a level. Value of an i16 pixel p: value_offset + value_step * p.
struct TileRecord {
  uint64_t key;     ///< Hilbert key
  uint64_t offset;  ///< of the data in the file
  uint32_t length;  ///< bytes of the data
  uint8_t codec;    ///< tiles::Codec
  uint8_t reserved;    ///< zero
  uint16_t epoch_set;  ///< which epochs went into it: counts from 1 in the manifest's epoch_sets; 0: not stated
  float value_offset;
  float value_step;
  Hash hash;        ///< BLAKE2b-256 of the data
};
static_assert(sizeof(TileRecord) == 64 && std::is_trivially_copyable_v<TileRecord> && std::is_standard_layout_v<TileRecord>);
static_assert(offsetof(TileRecord, codec) == 20 && offsetof(TileRecord, epoch_set) == 22 && offsetof(TileRecord, value_offset) == 24 && offsetof(TileRecord, hash) == 32);

}  // namespace landfix::schema

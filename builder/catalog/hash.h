// The hash of packs: BLAKE2b-256 of libsodium.
#pragma once

#include <cstdint>
#include <span>

#include "schemas/pack_layout.h"

namespace landfix::catalog {

/// BLAKE2b with a digest of 32 bytes, without key (schemas/FORMAT.md, section 1).
schema::Hash hash_of(std::span<const uint8_t> data);

}  // namespace landfix::catalog

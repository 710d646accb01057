// Lossless coding of bit planes by the neighbours of each pixel: the codec `context` of schemas/FORMAT.md section 3.4.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace landfix::tiles {

/// Codes whole planes of kPlaneBytes each (tiles/codec.h).
std::vector<uint8_t> encode_planes(std::span<const uint8_t> planes);

/// The inverse. Never reads outside of `data`; false where these are not the bytes that the planes are coded as.
bool decode_planes(std::span<const uint8_t> data, std::span<uint8_t> planes);

}  // namespace landfix::tiles

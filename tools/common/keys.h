// Key files of `landfix keygen`: one line of text, "landfix-public-key ed25519 <64 hex digits>" or "landfix-secret-key
// ed25519 <128>".
#pragma once

#include <array>
#include <string>

#include "landfix/landfix.hpp"

namespace landfix::tools {

using SecretKey = std::array<uint8_t, 64>;

/// Throw Error(kBadInput) naming the file where it is no such key, Error(kIo) where it cannot be read.
PublicKey read_public_key(const std::string& path);
SecretKey read_secret_key(const std::string& path);

/// The line for a public key file, with its end of line; likewise for a secret one.
std::string public_key_line(const PublicKey& key);
std::string secret_key_line(const SecretKey& key);

}  // namespace landfix::tools

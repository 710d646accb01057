#include "builder/catalog/hash.h"

#include <sodium.h>

namespace landfix::catalog {

schema::Hash hash_of(std::span<const uint8_t> data) {
  schema::Hash hash;
  crypto_generichash(hash.bytes, sizeof hash.bytes, data.data(), data.size(), nullptr, 0);
  return hash;
}

std::string hex(std::span<const uint8_t> bytes) {
  std::string text(bytes.size() * 2 + 1, '\0');  // with room for the terminator that libsodium writes
  sodium_bin2hex(text.data(), text.size(), bytes.data(), bytes.size());
  text.pop_back();
  return text;
}

}  // namespace landfix::catalog

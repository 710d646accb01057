#include "builder/catalog/hash.h"

#include <sodium.h>

namespace landfix::catalog {

schema::Hash hash_of(std::span<const uint8_t> data) {
  schema::Hash hash;
  crypto_generichash(hash.bytes, sizeof hash.bytes, data.data(), data.size(), nullptr, 0);
  return hash;
}

}  // namespace landfix::catalog

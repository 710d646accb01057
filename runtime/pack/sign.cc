// Making keys and filling the signature slot of a header page (FORMAT.md section 3.1).
#include <sodium.h>

#include <cstring>

#include "runtime/pack/pack.h"

lf_status lf_keygen(uint8_t public_key[32], uint8_t secret_key[64]) {
  if (public_key == nullptr || secret_key == nullptr) return LF_INVALID_ARGUMENT;
  if (sodium_init() < 0) return LF_OUT_OF_MEMORY;
  crypto_sign_keypair(public_key, secret_key);
  return LF_OK;
}

lf_status lf_sign_header(void* header_page, const uint8_t secret_key[64]) {
  using namespace landfix;
  if (header_page == nullptr || secret_key == nullptr) return LF_INVALID_ARGUMENT;
  if (sodium_init() < 0) return LF_OUT_OF_MEMORY;
  schema::Header h;
  std::memcpy(&h, header_page, sizeof h);
  if (std::memcmp(h.magic, schema::kMagic, sizeof h.magic) != 0) return LF_NOT_A_PACK;
  if (h.header_hash != pack::hash_of(&h, offsetof(schema::Header, header_hash))) return LF_DAMAGED;
  if (h.version_major != schema::kVersionMajor) return LF_UNKNOWN_VERSION;
  const pack::SignedMessage message = pack::signed_message(h.root);
  h.signature_kind = uint32_t(schema::SignatureKind::kEd25519);
  if (crypto_sign_detached(h.signature, nullptr, message.data(), message.size(), secret_key) != 0)
    return LF_INVALID_ARGUMENT;
  if (crypto_sign_ed25519_sk_to_pk(h.public_key, secret_key) != 0) return LF_INVALID_ARGUMENT;
  h.header_hash = pack::hash_of(&h, offsetof(schema::Header, header_hash));
  std::memcpy(header_page, &h, sizeof h);
  return LF_OK;
}

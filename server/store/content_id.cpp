#include "server/store/content_id.h"

#include <openssl/evp.h>

#include <array>
#include <new>

namespace isochor {

std::string content_id(std::string_view prefix, std::string_view content) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  if (EVP_Digest(content.data(), content.size(), digest.data(), nullptr, EVP_sha256(), nullptr) != 1)
    throw std::bad_alloc();  // nothing else makes the library fail
  std::string id(prefix);
  for (std::size_t i = 0; i < 16; ++i) {
    id += "0123456789abcdef"[digest[i] >> 4];
    id += "0123456789abcdef"[digest[i] & 15];
  }
  return id;
}

}  // namespace isochor

#include "server/store/content_id.h"

#include <openssl/evp.h>

#include <array>
#include <new>

namespace isochor {
namespace {

void require(bool done) {
  if (!done) throw std::bad_alloc();  // nothing else makes the library fail
}

}  // namespace

ContentHash::ContentHash() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
  require(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1);
}

void ContentHash::add(std::string_view piece) {
  require(EVP_DigestUpdate(context_.get(), piece.data(), piece.size()) == 1);
}

std::string ContentHash::id(std::string_view prefix) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  require(EVP_DigestFinal_ex(context_.get(), digest.data(), nullptr) == 1);
  std::string id(prefix);
  for (std::size_t i = 0; i < 16; ++i) {
    id += "0123456789abcdef"[digest[i] >> 4];
    id += "0123456789abcdef"[digest[i] & 15];
  }
  return id;
}

std::string content_id(std::string_view prefix, std::string_view content) {
  ContentHash hash;
  hash.add(content);
  return hash.id(prefix);
}

}  // namespace isochor

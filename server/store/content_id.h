#pragma once
#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace isochor {

/// prefix + 128 bits of SHA-256: the same content has the same id, and nobody can make two contents share
/// one.
std::string content_id(std::string_view prefix, std::string_view content);

/// The same of a content that comes a piece at a time.
class ContentHash {
 public:
  ContentHash();
  void add(std::string_view piece);
  std::string id(std::string_view prefix);  ///< of all that was added; the last call

 private:
  std::shared_ptr<evp_md_ctx_st> context_;
};

}  // namespace isochor

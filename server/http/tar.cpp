#include "server/http/tar.h"

#include <fmt/format.h>

namespace isochor {
namespace {

constexpr std::size_t block = 512;

/// Field offsets of the ustar header (POSIX.1-1988).
std::string tar_header(const std::string& name, std::size_t size) {
  std::string header(block, '\0');
  const auto put = [&](std::size_t at, const std::string& text) { header.replace(at, text.size(), text); };
  put(0, name.substr(0, 100));
  put(100, "0000644");
  put(108, "0000000");
  put(116, "0000000");
  put(124, fmt::format("{:011o}", size));
  put(136, "00000000000");
  put(148, "        ");
  put(156, "0");
  put(257, std::string("ustar\00000", 8));
  unsigned sum = 0;
  for (const char c : header) sum += static_cast<unsigned char>(c);
  put(148, fmt::format("{:06o}", sum) + std::string("\0 ", 2));
  return header;
}

}  // namespace

void TarWriter::begin(std::string_view name_suffix) {
  end_file();
  name_ = stem_ + std::string(name_suffix);
  start_ = out_.size();
  out_.append(std::string(block, '\0'));  // its size is not known yet
}

void TarWriter::end_file() {
  if (name_.empty()) return;
  const std::size_t size = out_.size() - start_ - block;
  out_.overwrite(start_, tar_header(name_, size));
  out_.append(std::string((block - size % block) % block, '\0'));
}

void TarWriter::finish() {
  end_file();
  out_.append(std::string(2 * block, '\0'));
}

}  // namespace isochor

#include "server/http/tar.h"

#include <fmt/format.h>

#include <numeric>

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

std::string make_tar(const std::vector<ExportFile>& files) {
  std::string tar;
  for (const ExportFile& file : files) {
    tar += tar_header(file.name_suffix, file.content.size());
    tar += file.content;
    tar.resize((tar.size() + block - 1) / block * block, '\0');
  }
  tar.resize(tar.size() + 2 * block, '\0');
  return tar;
}

}  // namespace isochor

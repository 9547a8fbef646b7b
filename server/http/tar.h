#pragma once
#include <string>
#include <string_view>

#include "core/export/export.h"
#include "server/http/large_answer.h"

namespace isochor {

/// POSIX ustar of the files, each `stem` and its suffix. The same bytes for the same files.
class TarWriter final : public ExportSink {
 public:
  TarWriter(std::string stem, LargeAnswer& out) : stem_(std::move(stem)), out_(out) {}
  void begin(std::string_view name_suffix) override;
  void write(std::string_view bytes) override { out_.append(bytes); }
  void finish();

 private:
  void end_file();

  std::string stem_, name_;
  LargeAnswer& out_;
  std::size_t start_ = 0;  ///< of the file's header
};

}  // namespace isochor

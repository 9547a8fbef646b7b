#pragma once
#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <utility>

#include "core/common/text_sink.h"
#include "server/messages/json_text.h"

namespace isochor {

/// JSON on its way to a sink; what is bulk in it stays here for a piece only.
class BulkText {
 public:
  explicit BulkText(TextSink sink) : sink_(std::move(sink)) {}
  BulkText(const BulkText&) = delete;
  BulkText& operator=(const BulkText&) = delete;

  std::string& text() { return text_; }
  void pass_on() {
    sink_(text_);
    text_.clear();
  }
  void pass_on_pieces() {
    if (text_.size() >= text_piece_bytes) pass_on();
  }

 private:
  TextSink sink_;
  std::string text_;
};

/// An object with typed arrays of any length.
class BulkObject : public ObjectWriter {
 public:
  explicit BulkObject(BulkText& out) : ObjectWriter(out.text()), out_(out) {}

  /// `write` gets a function that takes the values one by one: as many as there are rows of columns.
  template <class T, class Write>
  void array(std::string_view name, std::size_t count, int columns, const Write& write) {
    begin_typed_array(key(name), dtype_name<T>(), count, columns);
    std::array<T, slice_bytes / sizeof(T)> slice;
    std::size_t filled = 0;
    write([&](T value) {
      slice[filled++] = value;
      if (filled == slice.size()) append(std::as_bytes(std::span(slice))), filled = 0;
    });
    append(std::as_bytes(std::span(slice).first(filled)));
    end_typed_array(out_.text());
  }

  /// What lies in memory as it is sent.
  template <class T>
  void array(std::string_view name, std::span<const T> values, int columns) {
    begin_typed_array(key(name), dtype_name<T>(), values.size(), columns);
    for (std::span<const std::byte> rest = std::as_bytes(values); !rest.empty();
         rest = rest.subspan(std::min(rest.size(), slice_bytes)))
      append(rest.first(std::min(rest.size(), slice_bytes)));
    end_typed_array(out_.text());
  }

 private:
  /// Whole triples of bytes, so that the base64 of slices is that of all; whole numbers of each type.
  static constexpr std::size_t slice_bytes = 3 * 8 * 512;

  void append(std::span<const std::byte> bytes) {
    append_base64(out_.text(), bytes);
    out_.pass_on_pieces();
  }

  BulkText& out_;
};

}  // namespace isochor

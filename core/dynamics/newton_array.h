#pragma once
#include <algorithm>
#include <cstdint>
#include <memory>
#include <new>

#include "core/parallel/cancel_scope.h"

namespace isochor::newton {

/// Numbers that begin at a cache line, zero at first. The first touch of those of a large body takes a while,
/// within which it can be cancelled.
template <class T>
class AlignedArray {
 public:
  AlignedArray() = default;
  explicit AlignedArray(std::int64_t size)
      : data_(static_cast<T*>(::operator new (size * sizeof(T), std::align_val_t{64}))), size_(size) {
    constexpr std::int64_t portion = 1 << 20;
    for (std::int64_t begin = 0; begin < size; begin += portion) {
      throw_if_scope_cancelled();
      std::fill_n(data_.get() + begin, std::min(portion, size - begin), T{});
    }
  }
  T* data() const { return data_.get(); }
  T& operator[](std::int64_t i) const { return data_[i]; }
  std::int64_t size() const { return size_; }
  std::int64_t bytes() const { return size_ * static_cast<std::int64_t>(sizeof(T)); }

 private:
  struct Release {
    void operator()(T* data) const { ::operator delete (data, std::align_val_t{64}); }
  };
  std::unique_ptr<T[], Release> data_;
  std::int64_t size_ = 0;
};

}  // namespace isochor::newton

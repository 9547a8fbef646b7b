#pragma once
#include <algorithm>
#include <cstdint>
#include <memory>
#include <new>

namespace isochor::newton {

/// Numbers that begin at a cache line, zero at first.
template <class T>
class AlignedArray {
 public:
  AlignedArray() = default;
  explicit AlignedArray(std::int64_t size)
      : data_(static_cast<T*>(::operator new (size * sizeof(T), std::align_val_t{64}))), size_(size) {
    std::fill_n(data_.get(), size, T{});
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

#pragma once
#include <sys/mman.h>

#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace isochor {

inline constexpr std::size_t huge_page = std::size_t{2} << 20;

/// Asks for huge pages where memory is large enough for them. The first touch of a page of 4 KiB can cost ten
/// times what filling it costs, most of all on virtual machines. Call it before that touch.
inline void prefer_huge_pages(void* memory, std::size_t bytes) {
#ifdef MADV_HUGEPAGE
  if (!std::align(huge_page, huge_page, memory, bytes)) return;
  madvise(memory, bytes / huge_page * huge_page, MADV_HUGEPAGE);
#endif
}

/// A large array of plain values, not initialised, in huge pages where the system offers them.
template <class T>
class HugeArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  HugeArray() = default;
  explicit HugeArray(std::size_t size) : size_(size) {
    const std::size_t bytes = size * sizeof(T);
    alignment_ = std::align_val_t{bytes >= huge_page ? huge_page : 64};
    data_ = static_cast<T*>(::operator new(bytes, alignment_));
    prefer_huge_pages(data_, bytes);
  }
  ~HugeArray() {
    if (data_ != nullptr) ::operator delete(data_, alignment_);
  }
  HugeArray(HugeArray&& other) noexcept { swap(other); }
  HugeArray& operator=(HugeArray&& other) noexcept {
    swap(other);
    return *this;
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  T* begin() { return data_; }
  T* end() { return data_ + size_; }

 private:
  void swap(HugeArray& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(alignment_, other.alignment_);
  }

  T* data_ = nullptr;
  std::size_t size_ = 0;
  std::align_val_t alignment_{64};
};

/// Whole huge pages for what is as large as one, and what is not given a value keeps what it finds there.
template <class T>
struct HugeAllocator {
  using value_type = T;
  HugeAllocator() = default;
  template <class U>
  HugeAllocator(const HugeAllocator<U>&) {}
  T* allocate(std::size_t size) {
    const std::size_t bytes = size * sizeof(T);
    auto* const data = static_cast<T*>(::operator new(bytes, alignment(size)));
    prefer_huge_pages(data, bytes);
    return data;
  }
  void deallocate(T* data, std::size_t size) { ::operator delete(data, alignment(size)); }
  template <class U>
  void construct(U*) {}
  template <class U, class... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
  }
  bool operator==(const HugeAllocator&) const = default;

 private:
  static std::align_val_t alignment(std::size_t size) {
    return std::align_val_t{size * sizeof(T) >= huge_page ? huge_page : 64};
  }
};

/// A vector of plain values that are each written once it has its size, by whichever thread.
template <class T>
using HugeVector = std::vector<T, HugeAllocator<T>>;

}  // namespace isochor

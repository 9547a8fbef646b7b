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

/// Whole huge pages for what is as large as one, and what is not given a value keeps what it finds there.
template <class T>
struct HugeAllocator {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);
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

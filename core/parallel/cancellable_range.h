#pragma once
#include <algorithm>
#include <cstdint>
#include <ranges>
#include <span>
#include <vector>

#include "core/parallel/cancel_scope.h"

namespace isochor {

namespace detail {
/// Elements of some megabytes.
template <class T>
inline constexpr std::size_t portion = (std::size_t{4} << 20) / sizeof(T) + 1;
}  // namespace detail

/// The same elements for a long serial loop, which ends by throwing cancelled soon after the scope of this
/// thread is.
template <class Range>
class CancellableRange {
 public:
  explicit CancellableRange(Range& range) : range_(range) {}

  class Iterator {
   public:
    explicit Iterator(std::ranges::iterator_t<Range> at) : at_(at) {}
    decltype(auto) operator*() const { return *at_; }
    Iterator& operator++() {
      if (++passed_ % 4096 == 0) throw_if_scope_cancelled();
      ++at_;
      return *this;
    }
    bool operator==(const std::ranges::sentinel_t<Range>& end) const { return at_ == end; }

   private:
    std::ranges::iterator_t<Range> at_;
    std::uint32_t passed_ = 0;
  };
  Iterator begin() const { return Iterator(std::ranges::begin(range_)); }
  std::ranges::sentinel_t<Range> end() const { return std::ranges::end(range_); }

 private:
  Range& range_;
};

template <class Range>
CancellableRange<Range> cancellable(Range& range) {
  return CancellableRange<Range>(range);
}

/// values.resize(size), likewise: the first touch of a gigabyte takes a second.
template <class T>
void cancellable_resize(std::vector<T>& values, std::size_t size) {
  values.reserve(size);
  while (values.size() < size) {
    throw_if_scope_cancelled();
    values.resize(std::min(size, values.size() + detail::portion<T>));
  }
}

/// A copy of values, likewise.
template <class T>
std::vector<T> cancellable_copy(const std::vector<T>& values) {
  std::vector<T> copy;
  copy.reserve(values.size());
  while (copy.size() < values.size()) {
    throw_if_scope_cancelled();
    const auto rest = std::span(values).subspan(copy.size());
    copy.insert(copy.end(), rest.begin(), rest.begin() + std::min(rest.size(), detail::portion<T>));
  }
  return copy;
}

}  // namespace isochor

#pragma once
#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace isochor {

/// Numbers 0, 1, … in sets that can be joined; the smallest number of a set stands for it.
class DisjointSets {
 public:
  /// Each number in a set of its own.
  void reset(std::size_t count) {
    parents_.resize(count);
    std::iota(parents_.begin(), parents_.end(), 0);
  }
  void join(int a, int b) {
    a = root(a), b = root(b);
    parents_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  int root(int number) const {
    while (parents_[static_cast<std::size_t>(number)] != number)
      number = parents_[static_cast<std::size_t>(number)];
    return number;
  }

 private:
  std::vector<int> parents_;
};

}  // namespace isochor

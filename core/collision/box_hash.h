#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/common/box.h"

namespace isochor {

/// Boxes in a spatial hash [Teschner 2003]. Its cells are as large as the boxes are on average, so that a box
/// lies in a few. Built again, it allocates only when there is more than ever before.
class BoxHash {
 public:
  void build(std::span<const Box> boxes);
  /// For so many boxes of about one size, building allocates nothing.
  void reserve(std::size_t boxes);

  /// The boxes that overlap this one, ascending. The span lasts until the next call.
  std::span<const std::int32_t> find(const Box& box);

  std::int64_t bytes() const;

 private:
  struct Range {
    Vec3i min, max;
  };
  Range cells_of(const Box& box) const;
  std::size_t bucket(int i, int j, int k) const;
  template <class Visit>
  void visit_buckets(const Box& box, const Visit& visit) const;

  double spacing_ = 1.0;
  Box bounds_;
  std::vector<Box> boxes_;
  std::vector<std::int32_t> begin_, entries_;  ///< of each bucket; boxes, bucket by bucket
  std::vector<std::int32_t> found_;
  std::vector<std::uint32_t> seen_;  ///< a box: the query that has met it last
  std::uint32_t query_ = 0;
};

}  // namespace isochor

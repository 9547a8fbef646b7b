#include "core/collision/box_hash.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/parallel/cancel_scope.h"

namespace isochor {
namespace {

/// No box may lie in more cells than this along an axis.
constexpr double most_cells = 8.0;

}  // namespace

BoxHash::Range BoxHash::cells_of(const Box& box) const {
  const auto cell = [&](const Vec3& p) -> Vec3i {
    return ((p - bounds_.min) / spacing_).array().floor().cast<int>();
  };
  return {cell(box.min.cwiseMax(bounds_.min)), cell(box.max.cwiseMin(bounds_.max))};
}

std::size_t BoxHash::bucket(int i, int j, int k) const {
  const std::uint32_t hash = static_cast<std::uint32_t>(i) * 73856093U ^
                             static_cast<std::uint32_t>(j) * 19349663U ^
                             static_cast<std::uint32_t>(k) * 83492791U;
  return hash & (begin_.size() - 2);
}

template <class Visit>
void BoxHash::visit_buckets(const Box& box, const Visit& visit) const {
  const Range cells = cells_of(box);
  for (int k = cells.min.z(); k <= cells.max.z(); ++k)
    for (int j = cells.min.y(); j <= cells.max.y(); ++j)
      for (int i = cells.min.x(); i <= cells.max.x(); ++i) visit(bucket(i, j, k));
}

void BoxHash::reserve(std::size_t boxes) {
  constexpr std::size_t usual_cells = 16;  // that a box lies in
  boxes_.reserve(boxes);
  seen_.reserve(boxes);
  found_.reserve(boxes);
  begin_.reserve(std::bit_ceil(2 * boxes + 1) + 1);
  entries_.reserve(usual_cells * boxes);
}

void BoxHash::build(std::span<const Box> boxes) {
  boxes_.assign(boxes.begin(), boxes.end());
  bounds_ = Box();
  double sum = 0.0, largest = 0.0;
  for (const Box& box : boxes_) {
    bounds_.extend(box.min), bounds_.extend(box.max);
    sum += box.size().maxCoeff();
    largest = std::max(largest, box.size().maxCoeff());
  }
  spacing_ = boxes_.empty() ? 1.0 : std::max(sum / static_cast<double>(boxes_.size()), largest / most_cells);
  if (!boxes_.empty()) spacing_ = std::max(spacing_, 1e-6 * bounds_.size().maxCoeff());
  if (!(spacing_ > 0.0) || !std::isfinite(spacing_)) spacing_ = 1.0;
  begin_.assign(std::bit_ceil(2 * boxes_.size() + 1) + 1, 0);
  for (const Box& box : boxes_) {
    throw_if_scope_cancelled();
    visit_buckets(box, [&](std::size_t b) { ++begin_[b + 1]; });
  }
  for (std::size_t b = 1; b < begin_.size(); ++b) begin_[b] += begin_[b - 1];
  entries_.resize(static_cast<std::size_t>(begin_.back()));
  // One ahead, so that filling a bucket moves its begin_ to where the next one starts.
  for (std::size_t b = begin_.size() - 1; b > 0; --b) begin_[b] = begin_[b - 1];
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    throw_if_scope_cancelled();
    visit_buckets(boxes_[i],
                  [&](std::size_t b) { entries_[begin_[b + 1]++] = static_cast<std::int32_t>(i); });
  }
  seen_.assign(boxes_.size(), 0);
  query_ = 0;
}

std::span<const std::int32_t> BoxHash::find(const Box& box) {
  found_.clear();
  if (boxes_.empty() || !overlaps(box, bounds_)) return found_;
  ++query_;
  visit_buckets(box, [&](std::size_t b) {
    for (std::int32_t e = begin_[b]; e < begin_[b + 1]; ++e) {
      const std::int32_t i = entries_[e];
      if (seen_[i] == query_) continue;
      seen_[i] = query_;
      if (overlaps(box, boxes_[i])) found_.push_back(i);
    }
  });
  std::ranges::sort(found_);
  return found_;
}

std::int64_t BoxHash::bytes() const {
  return static_cast<std::int64_t>(
      boxes_.capacity() * sizeof(Box) + seen_.capacity() * sizeof(std::uint32_t) +
      (begin_.capacity() + entries_.capacity() + found_.capacity()) * sizeof(std::int32_t));
}

}  // namespace isochor

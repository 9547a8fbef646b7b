#include "core/mesh_input/self_intersections.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/parallel/cancellable_range.h"
#include "core/parallel/parallel.h"

namespace isochor {
namespace {

using Corners = std::array<Vec3, 3>;

/// Where the segment from p to q meets a triangle, its border included; not when it lies in its plane.
std::optional<Vec3> crossing(const Vec3& p, const Vec3& q, const Corners& t) {
  constexpr double round_off = 1e-12;  // of the product of the lengths
  const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]), d = q - p;
  const double above = normal.dot(p - t[0]), below = normal.dot(q - t[0]);
  const double slack = round_off * normal.norm() * std::max((p - t[0]).norm(), (q - t[0]).norm());
  if (std::min(above, below) > slack || std::max(above, below) < -slack) return std::nullopt;
  if (!(std::abs(above - below) > 2.0 * slack)) return std::nullopt;
  for (int i = 0; i < 3; ++i) {
    const Vec3 side = (t[i] - p).cross(t[(i + 1) % 3] - p);
    const double volume = (above > below ? -1.0 : 1.0) * side.dot(d);
    if (volume < -round_off * side.norm() * d.norm()) return std::nullopt;
  }
  return Vec3(p + above / (above - below) * d);
}

std::optional<Vec3> crossing(const Corners& a, const Corners& b) {
  for (int i = 0; i < 3; ++i) {
    if (auto at = crossing(a[i], a[(i + 1) % 3], b)) return at;
    if (auto at = crossing(b[i], b[(i + 1) % 3], a)) return at;
  }
  return std::nullopt;
}

struct Found {
  std::int64_t pairs = 0;
  std::vector<Vec3> locations;
};

/// Triangles in the cubes of a grid that their boxes meet.
class TriangleGrid {
 public:
  TriangleGrid(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles)
      : positions_(positions), triangles_(triangles) {
    boxes_.reserve(triangles.size());
    for (const Triangle& t : cancellable(triangles)) {
      Box& box = boxes_.emplace_back();
      for (const std::int32_t v : t) box.extend(positions[v]);
      all_.extend(box.min), all_.extend(box.max);
    }
    choose_spacing();
    fill();
  }

  std::int64_t cubes() const { return grid_.count(); }

  /// The most triangles of a cube that can be tried against the others so that at most max_pairs are.
  std::int64_t fitting_crowd(std::int64_t max_pairs) const {
    for (std::int64_t crowd = std::int64_t{1} << 31;; crowd /= 2) {
      std::int64_t sum = 0;
      for (std::int64_t c = 0; c < cubes(); ++c) sum += size_of(c) * std::min(crowd, size_of(c));
      if (sum <= max_pairs || crowd == 1) return crowd;
    }
  }
  std::int64_t largest_crowd() const {
    std::int64_t most = 0;
    for (std::int64_t c = 0; c < cubes(); ++c) most = std::max(most, size_of(c));
    return most;
  }

  void search(std::int64_t cube, std::int64_t crowd, std::size_t max_locations, Found& found) const {
    const std::int64_t end = first_[cube + 1], tried = std::min(end, first_[cube] + crowd);
    for (std::int64_t m = first_[cube]; m < tried; ++m)
      for (std::int64_t n = m + 1; n < end; ++n) {
        const std::int32_t a = entries_[m], b = entries_[n];
        if (!is_owner(cube, a, b) || share_vertex(triangles_[a], triangles_[b])) continue;
        const auto at = crossing(corners(a), corners(b));
        if (!at) continue;
        ++found.pairs;
        if (found.locations.size() < max_locations) found.locations.push_back(*at);
      }
  }

 private:
  std::int64_t size_of(std::int64_t cube) const { return first_[cube + 1] - first_[cube]; }

  Vec3i cube_of(const Vec3& p) const {
    const Vec3 last = (grid_.size - Vec3i::Ones()).cast<double>();
    return ((p - grid_.origin) / grid_.spacing).cwiseMax(0.0).cwiseMin(last).cast<int>();
  }
  template <class Visit>
  void for_cubes(const Box& box, Visit&& visit) const {
    const Vec3i low = cube_of(box.min), high = cube_of(box.max);
    for (int k = low.z(); k <= high.z(); ++k)
      for (int j = low.y(); j <= high.y(); ++j)
        for (int i = low.x(); i <= high.x(); ++i) visit(grid_.index(i, j, k));
  }

  /// As fine as the triangles allow that each is listed a few times on average.
  void choose_spacing() {
    const auto count = static_cast<double>(boxes_.size());
    const double longest = std::clamp(all_.size().maxCoeff(), 1e-300, 1e300);
    const Vec3 extent = all_.size().cwiseMax(1e-3 * longest).cwiseMin(longest);
    grid_.origin = all_.min;
    grid_.spacing = longest * std::cbrt((extent / longest).prod() / (8.0 * count));
    for (;; grid_.spacing *= 1.5) {
      grid_.size = (extent / grid_.spacing).cast<int>() + Vec3i::Ones();
      double entries = 0.0;
      for (const Box& box : cancellable(boxes_))
        entries += (cube_of(box.max) - cube_of(box.min) + Vec3i::Ones()).cast<double>().prod();
      if (entries <= 6.0 * count || grid_.count() == 1) return;
    }
  }

  void fill() {
    first_.assign(grid_.count() + 1, 0);
    for (const Box& box : cancellable(boxes_)) for_cubes(box, [&](std::int64_t cube) { ++first_[cube + 1]; });
    for (std::int64_t c = 0; c < grid_.count(); ++c) first_[c + 1] += first_[c];
    cancellable_resize(entries_, static_cast<std::size_t>(first_.back()));
    std::vector<std::int64_t> next(first_.begin(), first_.end() - 1);
    std::int32_t t = 0;
    for (const Box& box : cancellable(boxes_)) {
      for_cubes(box, [&](std::int64_t cube) { entries_[next[cube]++] = t; });
      ++t;
    }
  }

  /// Whether the boxes meet, and their common part begins in this cube: so a pair is tried once.
  bool is_owner(std::int64_t cube, std::int32_t a, std::int32_t b) const {
    const Vec3 low = boxes_[a].min.cwiseMax(boxes_[b].min), high = boxes_[a].max.cwiseMin(boxes_[b].max);
    if ((low.array() > high.array()).any()) return false;
    const Vec3i at = cube_of(low);
    return grid_.index(at.x(), at.y(), at.z()) == cube;
  }
  static bool share_vertex(const Triangle& a, const Triangle& b) {
    return std::ranges::any_of(a, [&](std::int32_t v) { return v == b[0] || v == b[1] || v == b[2]; });
  }
  Corners corners(std::int32_t t) const {
    return {positions_[triangles_[t][0]], positions_[triangles_[t][1]], positions_[triangles_[t][2]]};
  }

  const std::vector<Vec3>& positions_;
  const std::vector<Triangle>& triangles_;
  std::vector<Box> boxes_;
  Box all_;
  Grid grid_;
  std::vector<std::int64_t> first_;  ///< entries of cube c stand at [first_[c], first_[c+1])
  std::vector<std::int32_t> entries_;
};

}  // namespace

SelfIntersections find_self_intersections(const std::vector<Vec3>& positions,
                                          const std::vector<Triangle>& triangles, std::size_t max_locations) {
  constexpr std::int64_t pairs_a_triangle = 100, least_pairs = 2'000'000, grain = 4096;
  SelfIntersections result;
  if (triangles.empty()) return result;
  const TriangleGrid grid(positions, triangles);
  const std::int64_t crowd =
      grid.fitting_crowd(least_pairs + pairs_a_triangle * static_cast<std::int64_t>(triangles.size()));
  result.complete = crowd >= grid.largest_crowd();
  std::vector<Found> chunks((grid.cubes() + grain - 1) / grain);
  parallel_for(grid.cubes(), grain, [&](std::int64_t begin, std::int64_t end) {
    for (auto cube = begin; cube < end; ++cube)
      grid.search(cube, crowd, max_locations, chunks[begin / grain]);
  });
  for (const Found& found : chunks) {
    result.pairs += found.pairs;
    for (const Vec3& at : found.locations)
      if (result.locations.size() < max_locations) result.locations.push_back(at);
  }
  return result;
}

}  // namespace isochor

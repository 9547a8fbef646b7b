#include "core/embedding/embedding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/embedding/tet_locator.h"
#include "core/parallel/cancellable_range.h"
#include "core/parallel/parallel.h"

namespace isochor {
namespace {

/// Multiples of 2⁻⁴⁴ add without rounding up to 2⁹, far beyond any weight of a vertex near its tet.
double fixed_point(double weight) {
  constexpr double unit = 17592186044416.0;  // 2⁴⁴
  return std::round(weight * unit) / unit;
}

std::array<double, 4> exact_sum(const std::array<double, 4>& w) {
  const double b = fixed_point(w[1]), c = fixed_point(w[2]), d = fixed_point(w[3]);
  return {1.0 - (b + c + d), b, c, d};
}

/// Vertices sorted by a coarse grid, so that each is near the one before: files need not be in such an order.
std::vector<std::int32_t> spatial_order(std::span<const Vec3> points) {
  constexpr int bins = 16;  // along the longest edge
  Box box;
  for (const Vec3& p : cancellable(points)) box.extend(p);
  const double width = std::max(box.size().maxCoeff() / bins, std::numeric_limits<double>::min());
  const Vec3i size = (box.size() / width).array().floor().min(bins - 1.0).cast<int>() + 1;
  const auto bin = [&](const Vec3& p) {
    const Vec3i at = ((p - box.min) / width).cast<int>().cwiseMin(size - Vec3i::Ones());
    return at.x() + size.x() * (at.y() + size.y() * at.z());
  };
  std::vector<std::int32_t> next(size.prod() + 1, 0), order(points.size());
  for (const Vec3& p : cancellable(points)) ++next[bin(p) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::int32_t v = 0;
  for (const Vec3& p : cancellable(points)) order[next[bin(p)]++] = v++;
  return order;
}

}  // namespace

Embedding make_embedding(const TriangleSoup& soup, const TetMesh& mesh, Progress& progress) {
  constexpr std::int64_t grain = 512;
  progress.report("embedding", 0.0);
  const TetLocator locator(mesh, progress);
  const auto count = static_cast<std::int64_t>(soup.positions.size());
  const std::vector<std::int32_t> order = spatial_order(soup.positions);
  Embedding embedding;
  embedding.tet.resize(count), embedding.distance.resize(count);
  cancellable_resize(embedding.weights, static_cast<std::size_t>(count));
  parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    progress.throw_if_cancelled();
    TetLocator::Hint hint;
    for (auto n = begin; n < end; ++n) {
      const std::int32_t v = order[n];
      const TetLocator::Location found = locator.locate(soup.positions[v], hint);
      embedding.tet[v] = found.tet;
      embedding.weights[v] = exact_sum(found.weights);
      embedding.distance[v] = static_cast<float>(found.distance);
    }
  });
  for (const float d : cancellable(embedding.distance)) {
    embedding.outside += d > 0.0F;
    embedding.largest_distance = std::max<double>(embedding.largest_distance, d);
  }
  return embedding;
}

void apply_embedding(const Embedding& embedding, const TetMesh& mesh, std::span<const Vec3> positions,
                     std::span<Vec3> out) {
  const auto count = static_cast<std::int64_t>(embedding.tet.size());
  parallel_for(count, 4096, [&](std::int64_t begin, std::int64_t end) {
    for (auto v = begin; v < end; ++v) {
      const Tet& t = mesh.tets[embedding.tet[v]];
      const auto& w = embedding.weights[v];
      out[v] =
          w[0] * positions[t[0]] + w[1] * positions[t[1]] + w[2] * positions[t[2]] + w[3] * positions[t[3]];
    }
  });
}

}  // namespace isochor

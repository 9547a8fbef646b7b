#include <algorithm>
#include <cmath>
#include <optional>

#include "core/embedding/tet_locator.h"
#include "core/parallel/parallel.h"
#include "core/quality/quality.h"

namespace isochor {
namespace {

double area(const std::array<Vec3, 3>& t) {
  return 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm();
}

double longest_edge(const std::array<Vec3, 3>& t) {
  return std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
}

/// Calls visit(centroid) for the n² equal parts of a triangle.
template <class Visit>
void for_parts(const std::array<Vec3, 3>& t, int n, Visit&& visit) {
  const Vec3 u = (t[1] - t[0]) / n, v = (t[2] - t[0]) / n;
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      visit(t[0] + (i + 1.0 / 3.0) * u + (j + 1.0 / 3.0) * v);
      if (i + j + 1 < n) visit(t[0] + (i + 2.0 / 3.0) * u + (j + 2.0 / 3.0) * v);
    }
}

struct Coverage {
  double area = 0.0, covered = 0.0, farthest = 0.0;
};

/// Judges the soup against the model: small triangles by the distances of their vertices, which the embedding
/// knows, others by samples a spacing apart.
class CoverageMeter {
 public:
  CoverageMeter(const TetMesh& mesh, const TriangleSoup& soup, const Embedding& embedding)
      : soup_(soup), embedding_(embedding), reach_(mesh.grid.spacing) {
    double total = 0.0, longest = 0.0;
    for (const Triangle& t : soup.triangles) {
      total += area(corners(t));
      longest = std::max(longest, longest_edge(corners(t)));
    }
    spacing_ = std::max(0.5 * reach_, std::sqrt(total) / 150.0);  // some 50,000 samples at most
    if (longest > spacing_) locator_.emplace(mesh);
  }

  Coverage measure(const Triangle& triangle) const {
    const std::array<Vec3, 3> t = corners(triangle);
    Coverage result{area(t), 0.0, 0.0};
    int hits = 0, samples = 0;
    const auto add = [&](double distance) {
      ++samples;
      hits += distance <= reach_;
      result.farthest = std::max(result.farthest, distance);
    };
    if (const double edge = longest_edge(t); edge <= spacing_) {
      for (const std::int32_t v : triangle) add(embedding_.distance[v]);
    } else {
      const int n = static_cast<int>(std::min(256.0, std::ceil(edge / spacing_)));
      for_parts(t, n, [&](const Vec3& p) { add(locator_->distance(p)); });
    }
    result.covered = result.area * hits / samples;
    return result;
  }

 private:
  std::array<Vec3, 3> corners(const Triangle& t) const {
    return {soup_.positions[t[0]], soup_.positions[t[1]], soup_.positions[t[2]]};
  }

  const TriangleSoup& soup_;
  const Embedding& embedding_;
  std::optional<TetLocator> locator_;  ///< made when a triangle needs samples
  double reach_, spacing_ = 0.0;
};

/// Sums body(i) over [0, count) in chunks that no thread count changes; add combines two results.
template <class Value, class Body, class Add>
Value reduce(std::int64_t count, std::int64_t grain, const Progress& progress, Body&& body, Add&& add) {
  std::vector<Value> chunks((count + grain - 1) / grain);
  parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    progress.throw_if_cancelled();
    Value sum{};
    for (auto i = begin; i < end; ++i) sum = add(sum, body(i));
    chunks[begin / grain] = sum;
  });
  Value sum{};
  for (const Value& chunk : chunks) sum = add(sum, chunk);
  return sum;
}

Coverage measure_coverage(const TetMesh& mesh, const TriangleSoup& soup, const Embedding& embedding,
                          const Progress& progress) {
  const CoverageMeter meter(mesh, soup, embedding);
  return reduce<Coverage>(
      static_cast<std::int64_t>(soup.triangles.size()), 1024, progress,
      [&](std::int64_t t) { return meter.measure(soup.triangles[t]); },
      [](const Coverage& a, const Coverage& b) {
        return Coverage{a.area + b.area, a.covered + b.covered, std::max(a.farthest, b.farthest)};
      });
}

double boundary_distance(const TetMesh& mesh, const TriangleTree& soup_tree, const Progress& progress) {
  std::vector<std::uint8_t> on_boundary(mesh.positions.size(), 0);
  for (const Triangle& t : mesh.surface)
    for (const std::int32_t v : t) on_boundary[v] = 1;
  std::vector<double> squared(mesh.positions.size(), 0.0);
  parallel_for(static_cast<std::int64_t>(squared.size()), 256, [&](std::int64_t begin, std::int64_t end) {
    progress.throw_if_cancelled();
    std::int32_t hint = -1;  // the triangle nearest to the vertex before bounds the search
    for (auto v = begin; v < end; ++v) {
      if (on_boundary[v] == 0) continue;
      const Vec3& p = mesh.positions[v];
      squared[v] = hint < 0 ? 1e300 : soup_tree.squared_distance(p, hint);
      const TriangleTree::Nearest nearest = soup_tree.nearest(p, squared[v]);
      if (nearest.triangle >= 0) hint = nearest.triangle, squared[v] = nearest.squared_distance;
    }
  });
  return std::sqrt(*std::ranges::max_element(squared));
}

}  // namespace

QualitySummary summarize_quality(const TetMesh& mesh, const TriangleSoup& soup, const TriangleTree& soup_tree,
                                 const Embedding& embedding, Progress& progress) {
  QualitySummary summary;
  summary.volume = total_volume(mesh);
  const TetQuality tets = tet_quality(mesh.positions, mesh.tets);
  summary.min_dihedral_deg = std::ranges::min(tets.min_dihedral_deg);
  summary.min_scaled_jacobian = std::ranges::min(tets.scaled_jacobian);
  summary.inverted = std::ranges::count_if(tets.scaled_jacobian, [](float j) { return !(j > 0.0F); });
  progress.throw_if_cancelled();
  const Coverage coverage = measure_coverage(mesh, soup, embedding, progress);
  // Collinear triangles have no area; then all of their vertices must be covered.
  summary.coverage = coverage.area > 0.0 ? coverage.covered / coverage.area
                                         : (embedding.largest_distance <= mesh.grid.spacing ? 1.0 : 0.0);
  summary.input_to_boundary = std::max(coverage.farthest, embedding.largest_distance);
  summary.boundary_to_input = boundary_distance(mesh, soup_tree, progress);
  return summary;
}

}  // namespace isochor

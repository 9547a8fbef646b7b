#include <algorithm>
#include <cmath>
#include <optional>

#include "core/embedding/tet_locator.h"
#include "core/parallel/parallel.h"
#include "core/quality/quality.h"

namespace isochor {
namespace {

std::array<Vec3, 3> corners(const TriangleSoup& soup, std::int64_t triangle) {
  const Triangle& t = soup.triangles[triangle];
  return {soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]]};
}

double triangle_area(const std::array<Vec3, 3>& t) {
  return 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm();
}

double longest_side(const std::array<Vec3, 3>& t) {
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
  CoverageMeter(const TetMesh& mesh, const MeasuredSoup& input, const Embedding& embedding,
                const Progress& progress)
      : input_(input), embedding_(embedding), reach_(mesh.grid.spacing) {
    spacing_ = std::max(0.5 * reach_, std::sqrt(input.total_area) / 150.0);  // some 50,000 samples at most
    if (input.longest > spacing_) locator_.emplace(mesh, progress);
  }

  Coverage measure(std::int64_t triangle, TetLocator::Hint& hint) const {
    Coverage result{input_.area[triangle], 0.0, 0.0};
    int hits = 0, samples = 0;
    const auto add = [&](double distance) {
      ++samples;
      hits += distance <= reach_;
      result.farthest = std::max(result.farthest, distance);
    };
    for (const std::int32_t v : input_.soup.triangles[triangle])
      result.farthest = std::max<double>(result.farthest, embedding_.distance[v]);
    if (const double edge = input_.longest_edge[triangle]; edge <= spacing_) {
      for (const std::int32_t v : input_.soup.triangles[triangle]) add(embedding_.distance[v]);
    } else {
      const int n = static_cast<int>(std::min(256.0, std::ceil(edge / spacing_)));
      for_parts(corners(input_.soup, triangle), n, [&](const Vec3& p) { add(locator_->distance(p, hint)); });
    }
    result.covered = result.area * hits / samples;
    return result;
  }

 private:
  const MeasuredSoup& input_;
  const Embedding& embedding_;
  std::optional<TetLocator> locator_;  ///< made when a triangle needs samples
  double reach_, spacing_ = 0.0;
};

// Summed in chunks that no thread count changes.
Coverage measure_coverage(const TetMesh& mesh, const MeasuredSoup& input, const Embedding& embedding,
                          const Progress& progress) {
  constexpr std::int64_t grain = 1024;
  const CoverageMeter meter(mesh, input, embedding, progress);
  const auto add = [](Coverage& sum, const Coverage& part) {
    sum.area += part.area, sum.covered += part.covered;
    sum.farthest = std::max(sum.farthest, part.farthest);
  };
  const auto count = static_cast<std::int64_t>(input.soup.triangles.size());
  std::vector<Coverage> chunks((count + grain - 1) / grain);
  parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    progress.throw_if_cancelled();
    TetLocator::Hint hint;
    for (auto t = begin; t < end; ++t) add(chunks[begin / grain], meter.measure(t, hint));
  });
  Coverage sum;
  for (const Coverage& chunk : chunks) add(sum, chunk);
  return sum;
}

struct Bounds {
  double lower, upper;
};

/// Of the distance at p, from the voxel centres around it: distances change by at most 1 a unit of length.
Bounds distance_bounds(const DistanceField& field, const Vec3& p) {
  const Grid& grid = field.grid;
  const double round_off = 1e-4 * grid.spacing;  // of the field: 1e-5 voxels or half an ulp
  const Vec3i last = grid.size - Vec3i::Ones();
  const Vec3 at = (p - grid.origin) / grid.spacing - Vec3::Constant(0.5);
  const Vec3i low = at.cwiseMax(0.0).cwiseMin(last.cast<double>()).cast<int>();
  Bounds bounds{0.0, 1e300};
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3i voxel = (low + Vec3i(corner & 1, corner >> 1 & 1, corner >> 2 & 1)).cwiseMin(last);
    const double away = grid.spacing * (at - voxel.cast<double>()).norm() + round_off;
    const double distance = field.distance[grid.index(voxel.x(), voxel.y(), voxel.z())];
    bounds.lower = std::max(bounds.lower, distance - away);
    bounds.upper = std::min(bounds.upper, distance + away);
  }
  return bounds;
}

/// Sets both figures of the boundary. Only vertices whose bounds leave something open are measured.
void measure_boundary(const TetMesh& mesh, const TriangleTree& soup_tree, const DistanceField& field,
                      const Progress& progress, QualitySummary& summary) {
  const std::vector<std::int32_t> vertices = boundary_vertices(mesh);
  const auto count = static_cast<std::int64_t>(vertices.size());
  std::vector<Bounds> bounds(count);
  parallel_for(count, 1024, [&](std::int64_t begin, std::int64_t end) {
    for (auto n = begin; n < end; ++n) bounds[n] = distance_bounds(field, mesh.positions[vertices[n]]);
  });
  double least = 0.0;  // that the largest distance can be
  for (const Bounds& b : bounds) least = std::max(least, b.lower);
  const double diagonal = std::sqrt(3.0) * mesh.grid.spacing;
  std::int64_t beyond = 0;
  std::vector<std::int32_t> candidates;
  for (std::int64_t n = 0; n < count; ++n) {
    const auto& [lower, upper] = bounds[n];
    if (upper >= least || (lower <= diagonal && upper > diagonal))
      candidates.push_back(vertices[n]);
    else
      beyond += lower > diagonal;
  }
  std::vector<double> squared(candidates.size());
  parallel_for(static_cast<std::int64_t>(candidates.size()), 64, [&](std::int64_t begin, std::int64_t end) {
    progress.throw_if_cancelled();
    for (auto n = begin; n < end; ++n)
      squared[n] = soup_tree.nearest(mesh.positions[candidates[n]]).squared_distance;
  });
  beyond += std::ranges::count_if(squared, [&](double d2) { return d2 > diagonal * diagonal; });
  summary.boundary_to_input = std::sqrt(*std::ranges::max_element(squared));
  summary.boundary_beyond = static_cast<double>(beyond) / static_cast<double>(count);
}

}  // namespace

MeasuredSoup::MeasuredSoup(const TriangleSoup& measured)
    : soup(measured), tree(measured.positions, measured.triangles) {
  const auto count = static_cast<std::int64_t>(soup.triangles.size());
  area.resize(count), longest_edge.resize(count);
  parallel_for(count, 4096, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = begin; t < end; ++t) {
      const std::array<Vec3, 3> x = corners(soup, t);
      area[t] = triangle_area(x), longest_edge[t] = longest_side(x);
    }
  });
  for (std::int64_t t = 0; t < count; ++t)
    total_area += area[t], longest = std::max(longest, longest_edge[t]);
}

QualitySummary summarize_tets(const TetMesh& mesh, const Progress& progress) {
  QualitySummary summary;
  summary.volume = total_volume(mesh);
  progress.throw_if_cancelled();
  const WorstTets worst = worst_tets(mesh.positions, mesh.tets);
  summary.min_dihedral_deg = worst.min_dihedral_deg;
  summary.min_scaled_jacobian = worst.min_scaled_jacobian;
  summary.inverted = worst.inverted;
  return summary;
}

QualitySummary summarize_quality(const TetMesh& mesh, const MeasuredSoup& input, const Embedding& embedding,
                                 const DistanceField& field, Progress& progress) {
  QualitySummary summary = summarize_tets(mesh, progress);
  progress.throw_if_cancelled();
  const Coverage coverage = measure_coverage(mesh, input, embedding, progress);
  // Collinear triangles have no area; then all of their vertices must be covered.
  summary.coverage = coverage.area > 0.0 ? coverage.covered / coverage.area
                                         : (coverage.farthest <= mesh.grid.spacing ? 1.0 : 0.0);
  summary.input_to_boundary = coverage.farthest;
  measure_boundary(mesh, input.tree, field, progress, summary);
  return summary;
}

}  // namespace isochor

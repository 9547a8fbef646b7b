#include "core/distance_field/distance_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/common/error.h"
#include "core/distance_field/closest_point.h"
#include "core/parallel/parallel.h"

namespace isochor {
namespace {

/// Coordinates in voxels, the grid's corner at the origin.
struct FlatTriangle {
  Vec3 a, b, c;
  double radius2 = 0.0;  ///< of the smallest enclosing circle, or more
};

struct Block {
  Vec3 center;
  double half;  ///< of its edge, between the outermost voxel centres
};

/// Least value over a triangle of F(q) = |q−c|² − |p−c|² − 2Σh|qᵢ−pᵢ|, or less. F(q) > 0 says that p is
/// closer than q to every point of the block; the concave part is least at a vertex, the convex one sinks by
/// at most radius² below the vertices.
double least_dominance(const FlatTriangle& triangle, const Vec3& p, const Block& block) {
  double least = 1e300;
  for (const Vec3* q : {&triangle.a, &triangle.b, &triangle.c})
    least = std::min(least, (*q - block.center).squaredNorm() - 2.0 * block.half * (*q - p).lpNorm<1>());
  return least - (p - block.center).squaredNorm() - triangle.radius2;
}

class FieldBuilder {
 public:
  FieldBuilder(const TriangleSoup& soup, DistanceField& field) : field_(field) {
    for (const Triangle& t : soup.triangles) {
      FlatTriangle flat{local(soup.positions[t[0]]), local(soup.positions[t[1]]),
                        local(soup.positions[t[2]])};
      const Vec3 middle = (flat.a + flat.b + flat.c) / 3.0;
      flat.radius2 = std::max({(flat.a - middle).squaredNorm(), (flat.b - middle).squaredNorm(),
                               (flat.c - middle).squaredNorm()});
      triangles_.push_back(flat);
    }
  }

  void fill(const Vec3i& corner, int edge, const std::vector<std::int32_t>& candidates) {
    const Vec3i end = (corner.array() + edge).min(field_.grid.size.array());
    if ((corner.array() >= end.array()).any()) return;
    const Block block{(0.5 * (corner + end).cast<double>()), 0.5 * edge - 0.5};
    std::vector<std::pair<double, std::int32_t>> kept = cull(candidates, block);
    if (edge == leaf_edge) return evaluate(corner, end, block, kept);
    std::vector<std::int32_t> indices;
    for (const auto& [distance, index] : kept) indices.push_back(index);
    for (int child = 0; child < 8; ++child)
      fill(corner + edge / 2 * Vec3i(child & 1, child >> 1 & 1, child >> 2 & 1), edge / 2, indices);
  }

  std::int32_t triangle_count() const { return static_cast<std::int32_t>(triangles_.size()); }

 private:
  static constexpr int leaf_edge = 4;

  Vec3 local(const Vec3& p) const { return (p - field_.grid.origin) / field_.grid.spacing; }

  Vec3 closest(const Vec3& x, std::int32_t index) const {
    const FlatTriangle& t = triangles_[index];
    return closest_point_on_triangle(x, t.a, t.b, t.c);
  }

  std::vector<std::pair<double, std::int32_t>> cull(const std::vector<std::int32_t>& candidates,
                                                    const Block& block) const {
    std::vector<std::pair<double, std::int32_t>> kept;
    Vec3 nearest = Vec3::Constant(1e150);
    for (std::int32_t index : candidates) {
      const Vec3 point = closest(block.center, index);
      const double distance = (point - block.center).norm();
      if (kept.empty() || distance < (nearest - block.center).norm()) nearest = point;
      kept.emplace_back(distance, index);
    }
    std::erase_if(kept, [&](const auto& candidate) {
      return least_dominance(triangles_[candidate.second], nearest, block) > 1e-6;
    });
    return kept;
  }

  void evaluate(const Vec3i& begin, const Vec3i& end, const Block& block,
                std::vector<std::pair<double, std::int32_t>>& kept) {
    std::sort(kept.begin(), kept.end());
    for (int k = begin.z(); k < end.z(); ++k)
      for (int j = begin.y(); j < end.y(); ++j)
        for (int i = begin.x(); i < end.x(); ++i) {
          const Vec3 x(i + 0.5, j + 0.5, k + 0.5);
          const double reach = (x - block.center).norm();
          double least = 1e300;
          for (const auto& [distance, index] : kept) {
            if (distance - reach > least) break;
            least = std::min(least, (closest(x, index) - x).norm());
          }
          field_.distance[field_.grid.index(i, j, k)] = static_cast<float>(least * field_.grid.spacing);
        }
  }

  DistanceField& field_;
  std::vector<FlatTriangle> triangles_;
};

constexpr std::int64_t most_bytes = std::int64_t{2} << 30;

void check_budget(const Grid& grid, const DistanceFieldOptions& options) {
  const std::int64_t bytes = grid.count() * static_cast<std::int64_t>(sizeof(float));
  if (bytes <= most_bytes) return;
  const double scale = std::cbrt(static_cast<double>(most_bytes) / static_cast<double>(bytes));
  throw Error(ErrorCode::over_budget, fmt::format("the distance field would take {} MB", bytes >> 20),
              fmt::format("voxels up to {} fit", static_cast<int>(scale * options.voxels)));
}

}  // namespace

DistanceField make_distance_field(const TriangleSoup& soup, const DistanceFieldOptions& options,
                                  Progress& progress) {
  DistanceField field;
  field.grid = distance_grid(soup, options);
  check_budget(field.grid, options);
  field.distance.resize(field.grid.count());
  FieldBuilder builder(soup, field);
  std::vector<std::int32_t> all(builder.triangle_count());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::int32_t>(i);
  constexpr int edge = 32;
  const Vec3i blocks = (field.grid.size.array() + edge - 1) / edge;
  parallel_for(blocks.prod(), 1, [&](std::int64_t begin, std::int64_t) {
    progress.throw_if_cancelled();
    const auto b = static_cast<int>(begin);
    builder.fill(edge * Vec3i(b % blocks.x(), b / blocks.x() % blocks.y(), b / blocks.x() / blocks.y()), edge,
                 all);
  });
  field.max_distance = *std::max_element(field.distance.begin(), field.distance.end());
  progress.report("distance_field", 1.0);
  return field;
}

}  // namespace isochor

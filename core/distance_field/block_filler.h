#pragma once
#include "core/distance_field/leaf_cube.h"

namespace isochor {
namespace {

/// Descends from cubes of 32³ voxels over 16³ to 8³, each with the clusters that may hold a closest point.
template <class Simd>
class BlockFiller {
  using F = typename Simd::F;
  using D = typename Simd::D;
  static constexpr int lanes = Simd::width;
  static constexpr int levels = 3;  ///< 32, 16, 8

  /// Fixed part of the scratch memory; lists and boxes of clusters follow it.
  struct Fixed {
    LocalFeatures<Simd> local;
    LeafCube<Simd> leaves[8];
  };
  static std::int64_t padded(std::int32_t clusters) { return (std::int64_t{clusters} + 31) / 16 * 16; }

 public:
  static std::int64_t scratch_bytes(std::int32_t clusters) {
    constexpr auto fixed = static_cast<std::int64_t>((sizeof(Fixed) + 63) / 64 * 64);
    return fixed + (levels + 1 + 7) * padded(clusters) * static_cast<std::int64_t>(sizeof(float));
  }

  static bool fill(const BlockTask& task, const int* corner, float& largest) {
    BlockFiller filler(task);
    for (std::int32_t i = 0; i < task.clusters.count; ++i) filler.lists_[0][i] = i;
    const double far_away[3] = {1e9, 1e9, 1e9};
    const bool finished = filler.descend(corner, BlockKernel::root_edge, 0, task.clusters.count, far_away);
    if (filler.largest_ > largest) largest = filler.largest_;
    return finished;
  }

 private:
  explicit BlockFiller(const BlockTask& task) : task_(task), fixed_(*static_cast<Fixed*>(task.scratch)) {
    char* memory = static_cast<char*>(task.scratch) + (sizeof(Fixed) + 63) / 64 * 64;
    const std::int64_t row = padded(task.clusters.count) * static_cast<std::int64_t>(sizeof(float));
    for (auto& list : lists_) list = reinterpret_cast<std::int32_t*>(memory), memory += row;
    for (auto& array : low_) array = reinterpret_cast<float*>(memory), memory += row;
    for (auto& array : high_) array = reinterpret_cast<float*>(memory), memory += row;
    bound_ = reinterpret_cast<float*>(memory);
  }

  bool outside(const int* corner) const {
    return corner[0] >= task_.size[0] || corner[1] >= task_.size[1] || corner[2] >= task_.size[2];
  }

  bool descend(const int* corner, int edge, int level, int count, const double* parent_point) {
    if (outside(corner)) return true;
    Cube cube;
    for (int axis = 0; axis < 3; ++axis) cube.center[axis] = corner[axis] + 0.5 * edge;
    cube.half = 0.5 * (edge - 1);
    double point[3] = {parent_point[0], parent_point[1], parent_point[2]};
    find_nearest(cube, lists_[level], count, point);
    const int kept = cull_clusters(cube, point, lists_[level], count, lists_[level + 1]);
    if (edge == 8) return fill_cube(corner, cube, point, lists_[level + 1], kept);
    for (int child = 0; child < 8; ++child) {
      int at[3];
      for (int axis = 0; axis < 3; ++axis) at[axis] = corner[axis] + (child >> axis & 1) * edge / 2;
      if (!descend(at, edge / 2, level + 1, kept, point)) return false;
    }
    return true;
  }

  // ── the point closest to a cube's centre ────────────────────────────────────────────────────────────────

  /// Boxes of the listed clusters about the cube's centre, and the squared distances to them.
  void load_boxes(const Cube& cube, const std::int32_t* list, int count) {
    for (int i = 0; i < count; i += lanes) {
      F squared = Simd::set(0.0F);
      for (int axis = 0; axis < 3; ++axis) {
        const F center = Simd::set(static_cast<float>(cube.center[axis]));
        const F low = Simd::gather(task_.clusters.min[axis], list + i) - center;
        const F high = Simd::gather(task_.clusters.max[axis], list + i) - center;
        Simd::store(low_[axis] + i, low);
        Simd::store(high_[axis] + i, high);
        const F gap = Simd::max(Simd::set(0.0F), Simd::max(low, Simd::set(0.0F) - high));
        squared = Simd::fma(gap, gap, squared);
      }
      Simd::store(bound_ + i, squared);
    }
  }

  /// Branch and bound over the clusters, closest box first. It may stop early: any point of the surface will
  /// do as the reference, a closer one culls more.
  void find_nearest(const Cube& cube, std::int32_t* list, int count, double* point) {
    constexpr int most_visits = 12;
    for (int i = count; i < count + lanes; ++i) list[i] = 0;  // whole vectors are gathered
    load_boxes(cube, list, count);
    double best = 0.0;
    for (int axis = 0; axis < 3; ++axis)
      best += (point[axis] - cube.center[axis]) * (point[axis] - cube.center[axis]);
    for (int visit = 0; visit < most_visits; ++visit) {
      int closest = 0;
      for (int i = 1; i < count; ++i)
        if (bound_[i] < bound_[closest]) closest = i;
      if (bound_[closest] >= best) return;
      bound_[closest] = 3e38F;
      nearest_in_cluster(cube, list[closest], best, point);
    }
  }

  void nearest_in_cluster(const Cube& cube, int cluster, double& best, double* point) const {
    const BlockTask::Clusters& c = task_.clusters;
    constexpr int half_lanes = lanes / 2;
    for (int i = c.first_vertex[cluster]; i < c.first_vertex[cluster + 1]; i += half_lanes)
      offer_vertices(cube, i, c.first_vertex[cluster + 1] - i, best, point);
    for (int i = c.first_edge[cluster]; i < c.first_edge[cluster + 1]; i += half_lanes)
      offer_edges(cube, i, c.first_edge[cluster + 1] - i, best, point);
    for (int i = c.first_face[cluster]; i < c.first_face[cluster + 1]; i += half_lanes)
      offer_faces(cube, i, c.first_face[cluster + 1] - i, best, point);
  }

  void offer_vertices(const Cube& cube, int i, int left, double& best, double* point) const {
    D q[3];
    for (int axis = 0; axis < 3; ++axis)
      q[axis] = Simd::load(task_.vertices.position[axis] + i) - Simd::set(cube.center[axis]);
    offer(cube, q, ~0U, left, best, point);
  }

  void offer_edges(const Cube& cube, int i, int left, double& best, double* point) const {
    D q[3], along[3], t = Simd::set(0.0);
    for (int axis = 0; axis < 3; ++axis) {
      q[axis] = Simd::load(task_.edges.start[axis] + i) - Simd::set(cube.center[axis]);
      along[axis] = Simd::load(task_.edges.direction[axis] + i);
      t = Simd::fnma(along[axis], q[axis], t);
    }
    t = Simd::min(Simd::max(t, Simd::set(0.0)), Simd::load(task_.edges.length + i));
    for (int axis = 0; axis < 3; ++axis) q[axis] = Simd::fma(t, along[axis], q[axis]);
    offer(cube, q, ~0U, left, best, point);
  }

  void offer_faces(const Cube& cube, int i, int left, double& best, double* point) const {
    unsigned mask = ~0U;
    for (int side = 0; side < 3 && mask != 0; ++side) {
      D value = Simd::set(0.0) - Simd::load(task_.faces.offset[side] + i);
      for (int axis = 0; axis < 3; ++axis)
        value = Simd::fma(Simd::load_wide(task_.faces.inward[side][axis] + i), Simd::set(cube.center[axis]),
                          value);
      mask &= ~Simd::less(value, Simd::set(0.0));
    }
    D q[3], height = Simd::set(0.0) - Simd::load(task_.faces.plane + i);
    for (int axis = 0; axis < 3; ++axis) {
      q[axis] = Simd::load(task_.faces.normal[axis] + i);
      height = Simd::fma(q[axis], Simd::set(cube.center[axis]), height);
    }
    for (int axis = 0; axis < 3; ++axis) q[axis] = Simd::set(0.0) - height * q[axis];
    offer(cube, q, mask, left, best, point);
  }

  void offer(const Cube& cube, const D* q, unsigned mask, int left, double& best, double* point) const {
    const D squared = Simd::fma(q[0], q[0], Simd::fma(q[1], q[1], q[2] * q[2]));
    mask &= Simd::less(squared, Simd::set(best));
    if (left < lanes / 2) mask &= (1U << left) - 1;
    if (mask == 0) return;
    double values[lanes / 2], coordinates[3][lanes / 2];
    Simd::store(values, squared);
    for (int axis = 0; axis < 3; ++axis) Simd::store(coordinates[axis], q[axis]);
    for (; mask != 0; mask &= mask - 1) {
      const int lane = __builtin_ctz(mask);
      if (!(values[lane] < best)) continue;
      best = values[lane];
      for (int axis = 0; axis < 3; ++axis) point[axis] = cube.center[axis] + coordinates[axis][lane];
    }
  }

  // ── clusters that matter to a cube ──────────────────────────────────────────────────────────────────────

  /// F(q) = |q−c|² − |p−c|² − 2Σh|qᵢ−pᵢ| is a sum over the axes, so its least value over a box is exact: on
  /// each axis at c+h or c−h, clamped to the box. A box where it is positive is farther than p from all of
  /// the cube.
  int cull_clusters(const Cube& cube, const double* point, const std::int32_t* list, int count,
                    std::int32_t* kept) const {
    float p[3], norm2 = 0.0F;
    for (int axis = 0; axis < 3; ++axis) {
      p[axis] = static_cast<float>(point[axis] - cube.center[axis]);
      norm2 += p[axis] * p[axis];
    }
    const F h = Simd::set(static_cast<float>(cube.half)), minus_h = Simd::set(-static_cast<float>(cube.half));
    const F limit = Simd::set(norm2 + 1e-3F * (__builtin_sqrtf(norm2) + 32.0F));
    int number = 0;
    for (int i = 0; i < count; i += lanes) {
      F least = Simd::set(0.0F);
      for (int axis = 0; axis < 3; ++axis) {
        const F low = Simd::load(low_[axis] + i), high = Simd::load(high_[axis] + i), at = Simd::set(p[axis]);
        const F up = Simd::min(Simd::max(h, low), high), down = Simd::min(Simd::max(minus_h, low), high);
        const F from_up = Simd::fnma(h + h, up - at, up * up),
                from_down = Simd::fma(h + h, down - at, down * down);
        least = least + Simd::min(from_up, from_down);
      }
      unsigned mask = ~Simd::less(limit, least);
      mask &= count - i >= lanes ? (1ULL << lanes) - 1 : (1U << (count - i)) - 1;
      for (; mask != 0; mask &= mask - 1) kept[number++] = list[i + __builtin_ctz(mask)];
    }
    return number;
  }

  // ── a cube of 8³ voxels ─────────────────────────────────────────────────────────────────────────────────

  bool fill_cube(const int* corner, const Cube& cube, const double* point, const std::int32_t* list,
                 int count) {
    if (task_.cancelled(task_.owner)) return false;
    Reference reference{{}, 0.0};
    for (int axis = 0; axis < 3; ++axis) {
      reference.point[axis] = point[axis] - cube.center[axis];
      reference.norm2 += reference.point[axis] * reference.point[axis];
    }
    for (int leaf = 0; leaf < 8; ++leaf) {
      const float center[3] = {leaf_offset(leaf, 0), leaf_offset(leaf, 1), leaf_offset(leaf, 2)};
      fixed_.leaves[leaf].start(center, reference);
    }
    FeatureGatherer<Simd> gatherer(task_, cube, reference, fixed_.local);
    fixed_.local.clear();
    for (int i = 0; i < count; ++i) {
      if (!fixed_.local.has_room()) flush(corner);
      gatherer.add_cluster(list[i]);
    }
    flush(corner);
    for (int leaf = 0; leaf < 8; ++leaf) write(leaf, corner);
    return true;
  }

  static float leaf_offset(int leaf, int axis) { return (leaf >> axis & 1) != 0 ? 2.0F : -2.0F; }
  static void leaf_corner(int leaf, const int* corner, int* at) {
    for (int axis = 0; axis < 3; ++axis) at[axis] = corner[axis] + 4 * (leaf >> axis & 1);
  }

  void flush(const int* corner) {
    for (int leaf = 0; leaf < 8; ++leaf) {
      int at[3];
      leaf_corner(leaf, corner, at);
      if (!outside(at)) fixed_.leaves[leaf].take(fixed_.local);
    }
    fixed_.local.clear();
  }

  void write(int leaf, const int* corner) {
    int at[3];
    leaf_corner(leaf, corner, at);
    if (outside(at)) return;
    float values[LeafCube<Simd>::voxels];
    const double* squared = fixed_.leaves[leaf].squared_distances();
    for (int i = 0; i < LeafCube<Simd>::voxels; i += lanes / 2)
      Simd::store_narrow(values + i, Simd::sqrt(Simd::max(Simd::load(squared + i), Simd::set(0.0))) *
                                         Simd::set(task_.spacing));
    for (int row = 0; row < 16; ++row) {
      const int y = at[1] + row % 4, z = at[2] + row / 4;
      if (y >= task_.size[1] || z >= task_.size[2]) continue;
      float* out =
          task_.distance + at[0] + std::int64_t{task_.size[0]} * (y + std::int64_t{task_.size[1]} * z);
      for (int x = 0; x < 4 && at[0] + x < task_.size[0]; ++x) {
        out[x] = values[4 * row + x];
        if (out[x] > largest_) largest_ = out[x];
      }
    }
  }

  const BlockTask& task_;
  Fixed& fixed_;
  std::int32_t* lists_[levels + 1];
  float *low_[3], *high_[3], *bound_;
  float largest_ = 0.0F;
};

}  // namespace
}  // namespace isochor

#pragma once
#include "core/distance_field/cluster_list.h"
#include "core/distance_field/leaf_cube.h"

namespace isochor {
namespace {

/// Descends from cubes of 32³ voxels over 16³ to 8³, each with the clusters that may hold a closest point.
template <class Simd>
class BlockFiller {
  static constexpr int lanes = Simd::width;
  static constexpr int levels = 3;  ///< 32, 16, 8

  /// Fixed part of the scratch memory; the lists of clusters follow it.
  struct alignas(64) Fixed {
    LocalFeatures<Simd> local;
    LeafCube<Simd> leaves[8];
  };

 public:
  static std::int64_t scratch_bytes(std::int32_t clusters) {
    return static_cast<std::int64_t>(sizeof(Fixed)) + (levels + 1) * ClusterList<Simd>::bytes(clusters);
  }

  static bool fill(const BlockTask& task, const int* corner, float& largest) {
    BlockFiller filler(task);
    filler.lists_[0].take_all(task);
    const double far_away[3] = {1e9, 1e9, 1e9};
    const bool finished = filler.descend(corner, BlockKernel::root_edge, 0, far_away);
    if (filler.largest_ > largest) largest = filler.largest_;
    return finished;
  }

 private:
  explicit BlockFiller(const BlockTask& task) : task_(task), fixed_(*static_cast<Fixed*>(task.scratch)) {
    char* memory = static_cast<char*>(task.scratch) + sizeof(Fixed);
    for (ClusterList<Simd>& list : lists_) {
      list.place(memory, task.cluster_count);
      memory += ClusterList<Simd>::bytes(task.cluster_count);
    }
  }

  bool outside(const int* corner) const {
    return corner[0] >= task_.size[0] || corner[1] >= task_.size[1] || corner[2] >= task_.size[2];
  }

  bool descend(const int* corner, int edge, int level, const double* parent_point) {
    if (outside(corner)) return true;
    Cube cube;
    for (int axis = 0; axis < 3; ++axis) cube.center[axis] = corner[axis] + 0.5 * edge;
    cube.half = 0.5 * (edge - 1);
    double point[3] = {parent_point[0], parent_point[1], parent_point[2]};
    lists_[level].find_nearest(task_, cube, point);
    lists_[level].cull(task_, cube, point, lists_[level + 1]);
    if (edge == 8) return fill_cube(corner, cube, point, lists_[level + 1]);
    for (int child = 0; child < 8; ++child) {
      int at[3];
      for (int axis = 0; axis < 3; ++axis) at[axis] = corner[axis] + (child >> axis & 1) * edge / 2;
      if (!descend(at, edge / 2, level + 1, point)) return false;
    }
    return true;
  }

  bool fill_cube(const int* corner, const Cube& cube, const double* point,
                 const ClusterList<Simd>& clusters) {
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
    for (int i = 0; i < clusters.count(); ++i) {
      if (!fixed_.local.has_room()) flush(corner);
      gatherer.add_cluster(clusters[i]);
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
  ClusterList<Simd> lists_[levels + 1];
  float largest_ = 0.0F;
};

}  // namespace
}  // namespace isochor

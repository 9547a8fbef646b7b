#pragma once
#include "core/distance_field/local_features.h"

namespace isochor {
namespace {

/// Clusters that may hold a closest point of some cube, with room for their boxes about its centre.
template <class Simd>
class ClusterList {
  using F = typename Simd::F;
  using D = typename Simd::D;
  static constexpr int lanes = Simd::width;

 public:
  static std::int64_t bytes(std::int32_t clusters) { return 8 * row(clusters); }

  void place(char* memory, std::int32_t clusters) {
    const std::int64_t size = row(clusters);
    list_ = reinterpret_cast<std::int32_t*>(memory);
    bound_ = reinterpret_cast<float*>(memory + size);
    for (int axis = 0; axis < 3; ++axis) {
      low_[axis] = reinterpret_cast<float*>(memory + (2 + axis) * size);
      high_[axis] = reinterpret_cast<float*>(memory + (5 + axis) * size);
    }
  }

  void take_all(const BlockTask& task) {
    for (count_ = 0; count_ < task.cluster_count; ++count_) list_[count_] = count_;
  }

  int count() const { return count_; }
  int operator[](int i) const { return list_[i]; }

  /// Moves the point to the surface, as close to the cube's centre as a short search finds: branch and bound,
  /// closest box first. Any point of the surface serves as the reference; a closer one culls more.
  void find_nearest(const BlockTask& task, const Cube& cube, double* point) {
    constexpr int most_visits = 8;
    load_boxes(task, cube);
    double best = 0.0;
    for (int axis = 0; axis < 3; ++axis)
      best += (point[axis] - cube.center[axis]) * (point[axis] - cube.center[axis]);
    for (int visit = 0; visit < most_visits; ++visit) {
      const int closest = closest_box();
      if (bound_[closest] >= best) return;
      bound_[closest] = 3e38F;
      visit_cluster(task, cube, list_[closest], best, point);
    }
  }

  /// Leaves the clusters that the reference does not dominate over the cube: F(q) = |q−c|² − |p−c|² −
  /// 2Σh|qᵢ−pᵢ| is positive where q is farther than p from every point of the cube. find_nearest comes first.
  void cull(const BlockTask& task, const Cube& cube, const double* point, ClusterList& kept) const {
    Dominance dominance;
    float norm2 = 0.0F;
    for (int axis = 0; axis < 3; ++axis) {
      const auto p = static_cast<float>(point[axis] - cube.center[axis]);
      dominance.center[axis] = Simd::set(static_cast<float>(cube.center[axis]));
      dominance.point[axis] = Simd::set(p);
      norm2 += p * p;
    }
    dominance.half = Simd::set(static_cast<float>(cube.half));
    const float limit = norm2 + 1e-3F * (__builtin_sqrtf(norm2) + 32.0F);
    kept.count_ = 0;
    for (int i = 0; i < count_; i += lanes) {
      unsigned mask = ~Simd::less(Simd::set(limit), least_over_boxes(dominance, i));
      mask &= count_ - i >= lanes ? (1ULL << lanes) - 1 : (1U << (count_ - i)) - 1;
      for (; mask != 0; mask &= mask - 1) {
        const int cluster = list_[i + __builtin_ctz(mask)];
        kept.list_[kept.count_] = cluster;
        if (least_over_corners_below(task, cluster, dominance, limit)) ++kept.count_;
      }
    }
  }

 private:
  struct Dominance {
    F center[3], point[3], half;
  };

  static std::int64_t row(std::int32_t clusters) {
    return (std::int64_t{clusters} + 31) / 16 * 16 * static_cast<std::int64_t>(sizeof(float));
  }

  /// Boxes about the cube's centre, and the squared distances to them.
  void load_boxes(const BlockTask& task, const Cube& cube) {
    for (int i = count_; i < count_ + lanes; ++i) list_[i] = 0;  // whole vectors are gathered
    for (int i = 0; i < count_; i += lanes) {
      F squared = Simd::set(0.0F);
      for (int axis = 0; axis < 3; ++axis) {
        const F center = Simd::set(static_cast<float>(cube.center[axis]));
        const F low = Simd::gather(task.box_min[axis], list_ + i) - center;
        const F high = Simd::gather(task.box_max[axis], list_ + i) - center;
        Simd::store(low_[axis] + i, low);
        Simd::store(high_[axis] + i, high);
        const F gap = Simd::max(Simd::set(0.0F), Simd::max(low, Simd::set(0.0F) - high));
        squared = Simd::fma(gap, gap, squared);
      }
      Simd::store(bound_ + i, squared);
    }
    for (int i = count_; i < count_ + lanes; ++i) bound_[i] = 3e38F;
  }

  int closest_box() const {
    F least = Simd::load(bound_);
    for (int i = lanes; i < count_; i += lanes) least = Simd::min(least, Simd::load(bound_ + i));
    float values[lanes], smallest = 3e38F;
    Simd::store(values, least);
    for (float value : values)
      if (value < smallest) smallest = value;
    int i = 0;
    while (i < count_ - 1 && bound_[i] > smallest) ++i;
    return i;
  }

  // Over a box F is a sum over the axes, so its least value is exact: on each axis at c+h or c−h, clamped.
  F least_over_boxes(const Dominance& d, int i) const {
    F least = Simd::set(0.0F);
    const F minus_half = Simd::set(0.0F) - d.half, twice = d.half + d.half;
    for (int axis = 0; axis < 3; ++axis) {
      const F low = Simd::load(low_[axis] + i), high = Simd::load(high_[axis] + i);
      const F up = Simd::min(Simd::max(d.half, low), high),
              down = Simd::min(Simd::max(minus_half, low), high);
      least = least + Simd::min(Simd::fnma(twice, up - d.point[axis], up * up),
                                Simd::fma(twice, down - d.point[axis], down * down));
    }
    return least;
  }

  // Over a triangle F sinks by at most ρ² below its corners: its concave part is least at one of them, and
  // its convex one |q−c|² is at least their mean weighted like q, less the mean of |corner−q|² ≤ ρ².
  bool least_over_corners_below(const BlockTask& task, int cluster, const Dominance& d, float limit) const {
    const F bound = Simd::set(limit + task.clusters[cluster].slack), twice = d.half + d.half;
    for (int tile = task.clusters[cluster].corners; tile < task.clusters[cluster + 1].corners; ++tile)
      for (int lane = 0; lane < CornerTile::lanes; lane += lanes) {
        F value = Simd::set(0.0F);
        for (int axis = 0; axis < 3; ++axis) {
          const F q = Simd::load(task.corners[tile].position[axis] + lane) - d.center[axis];
          value = Simd::fma(q, q, Simd::fnma(twice, Simd::abs(q - d.point[axis]), value));
        }
        if (Simd::less(value, bound) != 0) return true;
      }
    return false;
  }

  void visit_cluster(const BlockTask& task, const Cube& cube, int cluster, double& best,
                     double* point) const {
    const Cluster &begin = task.clusters[cluster], &end = task.clusters[cluster + 1];
    constexpr int step = lanes / 2;
    for (int tile = begin.vertices; tile < end.vertices; ++tile)
      for (int lane = 0; lane < tile_lanes; lane += step)
        offer_vertices(task.vertices[tile], lane, cube, best, point);
    for (int tile = begin.edges; tile < end.edges; ++tile)
      for (int lane = 0; lane < tile_lanes; lane += step)
        offer_edges(task.edges[tile], lane, cube, best, point);
    for (int tile = begin.faces; tile < end.faces; ++tile)
      for (int lane = 0; lane < tile_lanes; lane += step)
        offer_faces(task.faces[tile], lane, cube, best, point);
  }

  void offer_vertices(const VertexTile& tile, int lane, const Cube& cube, double& best, double* point) const {
    D q[3];
    for (int axis = 0; axis < 3; ++axis)
      q[axis] = Simd::load(tile.position[axis] + lane) - Simd::set(cube.center[axis]);
    offer(q, ~0U, cube, best, point);
  }

  void offer_edges(const EdgeTile& tile, int lane, const Cube& cube, double& best, double* point) const {
    D q[3], along[3], t = Simd::set(0.0);
    for (int axis = 0; axis < 3; ++axis) {
      q[axis] = Simd::load(tile.start[axis] + lane) - Simd::set(cube.center[axis]);
      along[axis] = Simd::load(tile.direction[axis] + lane);
      t = Simd::fnma(along[axis], q[axis], t);
    }
    t = Simd::min(Simd::max(t, Simd::set(0.0)), Simd::load(tile.length + lane));
    for (int axis = 0; axis < 3; ++axis) q[axis] = Simd::fma(t, along[axis], q[axis]);
    offer(q, ~0U, cube, best, point);
  }

  void offer_faces(const FaceTile& tile, int lane, const Cube& cube, double& best, double* point) const {
    unsigned mask = ~0U;
    for (int side = 0; side < 3 && mask != 0; ++side) {
      D value = Simd::set(0.0) - Simd::load(tile.region.offset[side] + lane);
      for (int axis = 0; axis < 3; ++axis)
        value = Simd::fma(Simd::load_wide(tile.region.direction[side][axis] + lane),
                          Simd::set(cube.center[axis]), value);
      mask &= ~Simd::less(value, Simd::set(0.0));
    }
    D q[3], height = Simd::set(0.0) - Simd::load(tile.plane + lane);
    for (int axis = 0; axis < 3; ++axis) {
      q[axis] = Simd::load(tile.normal[axis] + lane);
      height = Simd::fma(q[axis], Simd::set(cube.center[axis]), height);
    }
    for (int axis = 0; axis < 3; ++axis) q[axis] = Simd::set(0.0) - height * q[axis];
    offer(q, mask, cube, best, point);
  }

  /// q: candidates about the cube's centre.
  void offer(const D* q, unsigned mask, const Cube& cube, double& best, double* point) const {
    const D squared = Simd::fma(q[0], q[0], Simd::fma(q[1], q[1], q[2] * q[2]));
    mask &= Simd::less(squared, Simd::set(best));
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

  std::int32_t* list_ = nullptr;
  float *bound_ = nullptr, *low_[3] = {}, *high_[3] = {};
  int count_ = 0;
};

}  // namespace
}  // namespace isochor

#pragma once
#include "core/distance_field/block_kernel.h"

namespace isochor {
namespace {

/// A cube of voxel centres: from its centre, half that far along each axis.
struct Cube {
  double center[3];
  double half;
};

/// A point of the surface near a cube, relative to the cube's centre. Squared distances are kept relative to
/// it, G(x) = d²(x) − |x−p|², which is small for all that matters however far the surface is, so that floats
/// hold it.
struct Reference {
  double point[3];
  double norm2;

  /// By how much G may be off from rounding, with a wide margin: its terms reach 16·(2|p|+16) on a cube of 8.
  double tolerance() const { return 2e-5 * (2.0 * __builtin_sqrt(norm2) + 16.0); }
};

/// A region test may keep what is this far out, in voxels: far above the rounding of float offsets.
constexpr float region_tolerance = 1e-3F;

/// Conditions direction·x + offset ≥ 0; reach is how much the first term varies over a cube of half size 1.
template <int conditions, int capacity>
struct alignas(64) LocalRegion {
  float direction[conditions][3][capacity];
  float offset[conditions][capacity];
  float reach[conditions][capacity];
};

/// The features that matter to a cube of 8³ voxels, relative to its centre and its reference p. Each has an
/// anchor a, the point of its line or plane closest to the centre (a vertex is its own), and is the affine
/// function linear·x + constant = |x−a|² − |x−p|², with linear = 2(p−a), constant = |a|² − |p|².
///   vertex: G(x) = linear·x + constant
///   edge:   G(x) = linear·x + constant − (along·x)²           where begin ≤ along·x ≤ end
///   face:   G(x) = linear·x + constant + (normal·x)² − |x|²   where the three conditions hold
template <class Simd>
struct LocalFeatures {
  static constexpr int capacity = 1024;
  static constexpr int padded = capacity + 16;  ///< whole vectors are written

  struct alignas(64) Affine {
    float linear[3][padded], constant[padded];
  };
  struct Vertices {
    int count;
    Affine affine;
    LocalRegion<4, padded> region;
  } vertices;
  struct Edges {
    int count;
    Affine affine;
    float along[3][padded], begin[padded], end[padded], reach[padded];
    LocalRegion<2, padded> region;
  } edges;
  struct Faces {
    int count;
    Affine affine;
    float normal[3][padded], distance[padded];  ///< of the plane from the centre, signed
    LocalRegion<3, padded> region;
  } faces;

  void clear() { vertices.count = edges.count = faces.count = 0; }
  bool has_room() const {
    constexpr int most = 48;  // vertices or edges of 16 triangles
    return vertices.count + most <= capacity && edges.count + most <= capacity &&
           faces.count + most <= capacity;
  }
};

/// Adds a cluster's features that may be closest to some point of the cube.
template <class Simd>
class FeatureGatherer {
  using D = typename Simd::D;
  static constexpr int lanes = Simd::width / 2;

 public:
  FeatureGatherer(const BlockTask& task, const Cube& cube, const Reference& reference,
                  LocalFeatures<Simd>& local)
      : task_(task),
        half_(Simd::set(cube.half)),
        tolerance_(Simd::set(reference.tolerance())),
        local_(local) {
    for (int axis = 0; axis < 3; ++axis) {
      center_[axis] = Simd::set(cube.center[axis]);
      point_[axis] = Simd::set(reference.point[axis]);
    }
    norm2_ = Simd::set(reference.norm2);
  }

  void add_cluster(int cluster) {
    const Cluster &begin = task_.clusters[cluster], &end = task_.clusters[cluster + 1];
    for (int tile = begin.vertices; tile < end.vertices; ++tile)
      for (int lane = 0; lane < tile_lanes; lane += lanes) add_vertices(task_.vertices[tile], lane);
    for (int tile = begin.edges; tile < end.edges; ++tile)
      for (int lane = 0; lane < tile_lanes; lane += lanes) add_edges(task_.edges[tile], lane);
    for (int tile = begin.faces; tile < end.faces; ++tile)
      for (int lane = 0; lane < tile_lanes; lane += lanes) add_faces(task_.faces[tile], lane);
  }

 private:
  struct Affine {
    D linear[3], constant;
  };
  template <int n>
  struct Region {
    D direction[n][3], offset[n], reach[n];
  };

  static constexpr unsigned all = (1U << lanes) - 1;
  static D dot(const D* a, const D* b) { return Simd::fma(a[0], b[0], Simd::fma(a[1], b[1], a[2] * b[2])); }
  static D norm1(const D* a) { return Simd::abs(a[0]) + Simd::abs(a[1]) + Simd::abs(a[2]); }
  static D load_offset(const float* p) { return Simd::load_wide(p); }
  static D load_offset(const double* p) { return Simd::load(p); }

  Affine affine(const D* anchor) const {
    Affine result;
    for (int axis = 0; axis < 3; ++axis) {
      const D difference = point_[axis] - anchor[axis];
      result.linear[axis] = difference + difference;
    }
    result.constant = dot(anchor, anchor) - norm2_;
    return result;
  }

  /// Loads the conditions of the features from a lane on and drops those whose region misses the cube.
  template <int n, class Offset>
  unsigned test_region(const RegionTile<n, Offset>& tile, int lane, Region<n>& region, unsigned mask) const {
    for (int j = 0; j < n; ++j) {
      for (int axis = 0; axis < 3; ++axis)
        region.direction[j][axis] = Simd::load_wide(tile.direction[j][axis] + lane);
      region.offset[j] = dot(region.direction[j], center_) - load_offset(tile.offset[j] + lane);
      region.reach[j] = norm1(region.direction[j]);
      const D largest = Simd::fma(region.reach[j], half_, region.offset[j]);
      mask &= ~Simd::less(largest, Simd::set(-double{region_tolerance}));
    }
    return mask;
  }

  /// Least value over the cube's corners of an affine function ± the square of a linear one. As G − 0 is
  /// concave in x, a lane whose least value is positive is farther than the reference all over the cube.
  template <bool add_square>
  D least_at_corners(const Affine& f, const D* direction) const {
    D least = Simd::set(1e300);
    for (int corner = 0; corner < 4; ++corner) {  // and the four opposite ones
      D linear = f.linear[2] * half_, along = direction[2] * half_;
      linear =
          (corner & 1) != 0 ? Simd::fma(f.linear[0], half_, linear) : Simd::fnma(f.linear[0], half_, linear);
      along =
          (corner & 1) != 0 ? Simd::fma(direction[0], half_, along) : Simd::fnma(direction[0], half_, along);
      linear =
          (corner & 2) != 0 ? Simd::fma(f.linear[1], half_, linear) : Simd::fnma(f.linear[1], half_, linear);
      along =
          (corner & 2) != 0 ? Simd::fma(direction[1], half_, along) : Simd::fnma(direction[1], half_, along);
      const D even = add_square ? Simd::fma(along, along, f.constant) : Simd::fnma(along, along, f.constant);
      least = Simd::min(least, even - Simd::abs(linear));
    }
    return least;
  }

  void add_vertices(const VertexTile& tile, int lane) {
    D anchor[3];
    for (int axis = 0; axis < 3; ++axis)
      anchor[axis] = Simd::load(tile.position[axis] + lane) - center_[axis];
    const Affine f = affine(anchor);
    unsigned mask = all & ~Simd::less(tolerance_, Simd::fnma(norm1(f.linear), half_, f.constant));
    if (mask == 0) return;
    Region<4> region;
    mask = test_region(tile.region, lane, region, mask);
    if (mask == 0) return;
    store(local_.vertices, f, region, mask);
    local_.vertices.count += __builtin_popcount(mask);
  }

  void add_edges(const EdgeTile& tile, int lane) {
    D start[3], along[3], anchor[3];
    for (int axis = 0; axis < 3; ++axis) {
      start[axis] = Simd::load(tile.start[axis] + lane) - center_[axis];
      along[axis] = Simd::load(tile.direction[axis] + lane);
    }
    const D begin = dot(along, start);
    const D end = begin + Simd::load(tile.length + lane);
    const D reach = norm1(along);
    const D slack = Simd::fma(reach, half_, Simd::set(double{region_tolerance}));
    unsigned mask = all & ~Simd::less(slack, begin) & ~Simd::less(end, Simd::set(0.0) - slack);
    if (mask == 0) return;
    Region<2> region;
    mask = test_region(tile.region, lane, region, mask);
    if (mask == 0) return;
    for (int axis = 0; axis < 3; ++axis) anchor[axis] = Simd::fnma(begin, along[axis], start[axis]);
    const Affine f = affine(anchor);
    mask &= ~Simd::less(tolerance_, least_at_corners<false>(f, along));
    if (mask == 0) return;
    auto& edges = local_.edges;
    store(edges, f, region, mask);
    for (int axis = 0; axis < 3; ++axis) put(edges.along[axis], edges.count, along[axis], mask);
    put(edges.begin, edges.count, begin, mask);
    put(edges.end, edges.count, end, mask);
    put(edges.reach, edges.count, reach, mask);
    edges.count += __builtin_popcount(mask);
  }

  void add_faces(const FaceTile& tile, int lane) {
    Region<3> region;
    unsigned mask = test_region(tile.region, lane, region, all);
    if (mask == 0) return;
    D normal[3], anchor[3];
    for (int axis = 0; axis < 3; ++axis) normal[axis] = Simd::load(tile.normal[axis] + lane);
    const D distance = dot(normal, center_) - Simd::load(tile.plane + lane);
    for (int axis = 0; axis < 3; ++axis) anchor[axis] = Simd::set(0.0) - distance * normal[axis];
    const Affine f = affine(anchor);
    const D corner2 = Simd::set(3.0) * half_ * half_;  // |x|² at a corner
    mask &= ~Simd::less(tolerance_ + corner2, least_at_corners<true>(f, normal));
    if (mask == 0) return;
    auto& faces = local_.faces;
    store(faces, f, region, mask);
    for (int axis = 0; axis < 3; ++axis) put(faces.normal[axis], faces.count, normal[axis], mask);
    put(faces.distance, faces.count, distance, mask);
    faces.count += __builtin_popcount(mask);
  }

  static void put(float* array, int at, D value, unsigned mask) {
    Simd::compress_narrow(array + at, value, mask);
  }

  template <class Local, int n>
  static void store(Local& local, const Affine& f, const Region<n>& region, unsigned mask) {
    const int at = local.count;
    put(local.affine.constant, at, f.constant, mask);
    for (int axis = 0; axis < 3; ++axis) put(local.affine.linear[axis], at, f.linear[axis], mask);
    for (int j = 0; j < n; ++j) {
      for (int axis = 0; axis < 3; ++axis)
        put(local.region.direction[j][axis], at, region.direction[j][axis], mask);
      put(local.region.offset[j], at, region.offset[j], mask);
      put(local.region.reach[j], at, region.reach[j], mask);
    }
  }

  const BlockTask& task_;
  D center_[3], point_[3], norm2_, half_, tolerance_;
  LocalFeatures<Simd>& local_;
};

}  // namespace
}  // namespace isochor

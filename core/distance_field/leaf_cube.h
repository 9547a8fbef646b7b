#pragma once
#include "core/distance_field/local_features.h"

namespace isochor {
namespace {

/// One of the eight cubes of 4³ voxels in a cube of 8³: culls the local features once more and takes the
/// least squared distance at each voxel. All coordinates are relative to the larger cube's centre.
template <class Simd>
class LeafCube {
  using F = typename Simd::F;
  using Local = LocalFeatures<Simd>;
  static constexpr int lanes = Simd::width;
  static constexpr float half = 1.5F;
  static constexpr int slices = 4;           ///< along z, in registers at once
  static constexpr int passes = 16 / lanes;  ///< to cover a slice

 public:
  static constexpr int voxels = 64;

  void start(const float* center, const Reference& block) {
    for (int axis = 0; axis < 3; ++axis) center_[axis] = center[axis], shift_[axis] = 0.0F;
    constant_ = 0.0F, nearest_ = 0.0F;
    for (double& value : squared_) value = 1e300;
    block_ = &block;
  }

  /// Takes these features into account; a cube may get them in several portions.
  void take(const Local& local) {
    move_reference(local);
    cull(local);
    if (vertices_ + edges_ + faces_ == 0) return;
    // Near the surface squares are computed as such, far from it relative to the reference: each keeps the
    // distance exact to a few millionths of a voxel where the other does not.
    const bool near = block_->norm2 < 24.0 * 24.0;
    for (int pass = 0; pass < passes; ++pass) near ? evaluate_near(local, pass) : evaluate_far(local, pass);
  }

  /// Voxels in the order x, y, z; squared.
  const double* squared_distances() const { return squared_; }

 private:
  static unsigned lane_mask(int left) { return left >= lanes ? (1ULL << lanes) - 1 : (1U << left) - 1; }

  /// Sum of the three products with the centre.
  F at_center(const float (*array)[Local::padded], int i) const {
    return Simd::fma(Simd::load(array[0] + i), Simd::set(center_[0]),
                     Simd::fma(Simd::load(array[1] + i), Simd::set(center_[1]),
                               Simd::load(array[2] + i) * Simd::set(center_[2])));
  }
  F affine_at_center(const typename Local::Affine& f, int i) const {
    return at_center(f.linear, i) + Simd::load(f.constant + i);
  }
  float center_norm2() const {
    return center_[0] * center_[0] + center_[1] * center_[1] + center_[2] * center_[2];
  }

  template <int n>
  unsigned test_region(const LocalRegion<n, Local::padded>& region, int i, float reach, unsigned mask) const {
    for (int j = 0; j < n && mask != 0; ++j) {
      const F value = at_center(region.direction[j], i) + Simd::load(region.offset[j] + i);
      const F largest = Simd::fma(Simd::load(region.reach[j] + i), Simd::set(reach), value);
      mask &= ~Simd::less(largest, Simd::set(-region_tolerance));
    }
    return mask;
  }

  /// The closest point found so far, to the leaf's centre, becomes the reference of this leaf's culling:
  /// |x−q|² − |x−p|² = shift·x + constant.
  void move_reference(const Local& local) {
    for (int i = 0; i < local.vertices.count; i += lanes)
      offer(affine_at_center(local.vertices.affine, i), lane_mask(local.vertices.count - i),
            local.vertices.affine, i, [](int, float*) {});
    move_to_edges(local);
    move_to_faces(local);
  }

  void move_to_edges(const Local& local) {
    const auto& edges = local.edges;
    for (int i = 0; i < edges.count; i += lanes) {
      const F t = at_center(edges.along, i);
      const unsigned mask = lane_mask(edges.count - i) & ~Simd::less(t, Simd::load(edges.begin + i)) &
                            ~Simd::less(Simd::load(edges.end + i), t);
      if (mask == 0) continue;
      offer(Simd::fnma(t, t, affine_at_center(edges.affine, i)), mask, edges.affine, i, [&](int e, float* q) {
        const float along = dot_center(edges.along, e);
        for (int axis = 0; axis < 3; ++axis) q[axis] += along * edges.along[axis][e];
      });
    }
  }

  void move_to_faces(const Local& local) {
    const auto& faces = local.faces;
    for (int i = 0; i < faces.count; i += lanes) {
      const unsigned mask = test_region(faces.region, i, 0.0F, lane_mask(faces.count - i));
      if (mask == 0) continue;
      const F height = at_center(faces.normal, i);
      const F value =
          Simd::fma(height, height, affine_at_center(faces.affine, i)) - Simd::set(center_norm2());
      offer(value, mask, faces.affine, i, [&](int f, float* q) {
        const float above = dot_center(faces.normal, f);
        for (int axis = 0; axis < 3; ++axis) q[axis] += center_[axis] - above * faces.normal[axis][f];
      });
    }
  }

  float dot_center(const float (*array)[Local::padded], int i) const {
    return array[0][i] * center_[0] + array[1][i] * center_[1] + array[2][i] * center_[2];
  }

  /// value: G at the leaf's centre. from_anchor(feature, q) moves q from the anchor to the closest point.
  template <class FromAnchor>
  void offer(F value, unsigned mask, const typename Local::Affine& f, int i, FromAnchor&& from_anchor) {
    mask &= Simd::less(value, Simd::set(nearest_));
    if (mask == 0) return;
    float values[lanes];
    Simd::store(values, value);
    int best = -1;
    for (; mask != 0; mask &= mask - 1) {
      const int lane = __builtin_ctz(mask);
      if (values[lane] < nearest_) best = lane, nearest_ = values[lane];
    }
    if (best >= 0) set_reference(f, i + best, from_anchor);
  }

  template <class FromAnchor>
  void set_reference(const typename Local::Affine& f, int feature, FromAnchor&& from_anchor) {
    float q[3];
    for (int axis = 0; axis < 3; ++axis)
      q[axis] = static_cast<float>(block_->point[axis] - 0.5 * double{f.linear[axis][feature]});
    from_anchor(feature, q);
    double constant = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double step = q[axis] - block_->point[axis];
      constant += step * (q[axis] + block_->point[axis]);
      shift_[axis] = static_cast<float>(-2.0 * step);
    }
    constant_ = static_cast<float>(constant);
  }

  /// The affine part of G relative to this leaf's own reference: its value at the centre and how much each
  /// axis adds towards a corner.
  struct Corners {
    F center, step[3];
  };
  Corners relative(const typename Local::Affine& f, int i) const {
    Corners c;
    c.center = Simd::load(f.constant + i) - Simd::set(constant_);
    for (int axis = 0; axis < 3; ++axis) {
      c.step[axis] = Simd::load(f.linear[axis] + i) - Simd::set(shift_[axis]);
      c.center = Simd::fma(c.step[axis], Simd::set(center_[axis]), c.center);
    }
    return c;
  }

  template <bool add_square>
  static F least_at_corners(const Corners& f, F height, const F* step) {
    F least = Simd::set(1e30F);
    for (int corner = 0; corner < 8; ++corner) {
      F value = f.center, h = height;
      for (int axis = 0; axis < 3; ++axis) {
        const F sign = Simd::set((corner >> axis & 1) != 0 ? half : -half);
        value = Simd::fma(f.step[axis], sign, value);
        h = Simd::fma(step[axis], sign, h);
      }
      least = Simd::min(least, add_square ? Simd::fma(h, h, value) : Simd::fnma(h, h, value));
    }
    return least;
  }

  void cull(const Local& local) {
    tolerance_ = static_cast<float>(block_->tolerance());
    vertices_ = edges_ = faces_ = 0;
    for (int i = 0; i < local.vertices.count; i += lanes) cull_vertices(local, i);
    for (int i = 0; i < local.edges.count; i += lanes) cull_edges(local, i);
    for (int i = 0; i < local.faces.count; i += lanes) cull_faces(local, i);
  }

  void cull_vertices(const Local& local, int i) {
    const auto& vertices = local.vertices;
    const Corners f = relative(vertices.affine, i);
    const F swing = Simd::abs(f.step[0]) + Simd::abs(f.step[1]) + Simd::abs(f.step[2]);
    unsigned mask = lane_mask(vertices.count - i);
    mask &= ~Simd::less(Simd::set(tolerance_), Simd::fnma(swing, Simd::set(half), f.center));
    mask = test_region(vertices.region, i, half, mask);
    keep(vertex_list_, vertices_, i, mask);
  }

  void cull_edges(const Local& local, int i) {
    const auto& edges = local.edges;
    const F t = at_center(edges.along, i);
    const F slack = Simd::fma(Simd::load(edges.reach + i), Simd::set(half), Simd::set(region_tolerance));
    unsigned mask = lane_mask(edges.count - i);
    mask &= ~Simd::less(t + slack, Simd::load(edges.begin + i)) &
            ~Simd::less(Simd::load(edges.end + i), t - slack);
    mask = test_region(edges.region, i, half, mask);
    if (mask == 0) return;
    const F step[3] = {Simd::load(edges.along[0] + i), Simd::load(edges.along[1] + i),
                       Simd::load(edges.along[2] + i)};
    const F least = least_at_corners<false>(relative(edges.affine, i), t, step);
    keep(edge_list_, edges_, i, mask & ~Simd::less(Simd::set(tolerance_), least));
  }

  void cull_faces(const Local& local, int i) {
    const auto& faces = local.faces;
    const unsigned mask = test_region(faces.region, i, half, lane_mask(faces.count - i));
    if (mask == 0) return;
    Corners f = relative(faces.affine, i);  // and −|x|², x the centre plus a corner's offset
    f.center = f.center - Simd::set(center_norm2() + 3.0F * half * half);
    for (int axis = 0; axis < 3; ++axis) f.step[axis] = f.step[axis] - Simd::set(2.0F * center_[axis]);
    const F step[3] = {Simd::load(faces.normal[0] + i), Simd::load(faces.normal[1] + i),
                       Simd::load(faces.normal[2] + i)};
    const F least = least_at_corners<true>(f, at_center(faces.normal, i), step);
    keep(face_list_, faces_, i, mask & ~Simd::less(Simd::set(tolerance_), least));
  }

  static void keep(std::int32_t* list, int& count, int i, unsigned mask) {
    if (mask == 0) return;
    Simd::compress_indices(list + count, i, mask);
    count += __builtin_popcount(mask);
  }

  /// The voxels of a pass: lanes over x and y, then slices along z.
  struct Points {
    F x, y, z[slices];
  };
  Points points(int pass) const {
    float x[lanes], y[lanes];
    for (int lane = 0; lane < lanes; ++lane) {
      x[lane] = center_[0] - half + static_cast<float>(lane % 4);
      const int row = (pass * lanes + lane) / 4;
      y[lane] = center_[1] - half + static_cast<float>(row);
    }
    Points p{Simd::load(x), Simd::load(y), {}};
    for (int k = 0; k < slices; ++k) p.z[k] = Simd::set(center_[2] - half + static_cast<float>(k));
    return p;
  }

  /// An affine function on the points, in a plane first.
  struct Plane {
    F base, slope;
    F at(const Points& p, int k) const { return Simd::fma(slope, p.z[k], base); }
  };
  static Plane plane(const float (*linear)[Local::padded], float constant, int i, const Points& p) {
    return {
        Simd::fma(Simd::set(linear[0][i]), p.x, Simd::fma(Simd::set(linear[1][i]), p.y, Simd::set(constant))),
        Simd::set(linear[2][i])};
  }

  /// A foot counts as inside this far out, so that rounding leaves no gap between neighbours; the error of
  /// the distance is less.
  static constexpr float inside_tolerance = 2e-6F;

  static F inside(const Plane* side, const Points& p, int k) {
    return Simd::min(side[0].at(p, k), Simd::min(side[1].at(p, k), side[2].at(p, k)));
  }
  static void sides(const Local& local, int f, const Points& p, Plane* side) {
    for (int j = 0; j < 3; ++j)
      side[j] = plane(local.faces.region.direction[j], local.faces.region.offset[j][f], f, p);
  }

  void evaluate_far(const Local& local, int pass) {
    const Points p = points(pass);
    F least[slices], least_of_faces[slices];
    for (int k = 0; k < slices; ++k) least[k] = least_of_faces[k] = Simd::set(1e30F);
    far_vertices(local, p, least);
    far_edges(local, p, least);
    far_faces(local, p, least_of_faces);
    for (int k = 0; k < slices; ++k) {
      const F norm2 = Simd::fma(p.x, p.x, Simd::fma(p.y, p.y, p.z[k] * p.z[k]));
      const F relative = Simd::min(least[k], least_of_faces[k] - norm2);
      const int at = k * 16 + pass * lanes;
      lower(at, reference_distance(Simd::low(p.x), Simd::low(p.y), Simd::low(p.z[k])) + Simd::low(relative));
      lower(at + lanes / 2,
            reference_distance(Simd::high(p.x), Simd::high(p.y), Simd::high(p.z[k])) + Simd::high(relative));
    }
  }

  typename Simd::D reference_distance(typename Simd::D x, typename Simd::D y, typename Simd::D z) const {
    const auto dx = x - Simd::set(block_->point[0]), dy = y - Simd::set(block_->point[1]),
               dz = z - Simd::set(block_->point[2]);
    return Simd::fma(dx, dx, Simd::fma(dy, dy, dz * dz));
  }

  void far_vertices(const Local& local, const Points& p, F* least) {
    const auto& f = local.vertices.affine;
    for (int n = 0; n < vertices_; ++n) {
      const int i = vertex_list_[n];
      const Plane value = plane(f.linear, f.constant[i], i, p);
      for (int k = 0; k < slices; ++k) least[k] = Simd::min(least[k], value.at(p, k));
    }
  }

  void far_edges(const Local& local, const Points& p, F* least) {
    const auto& edges = local.edges;
    for (int n = 0; n < edges_; ++n) {
      const int i = edge_list_[n];
      const Plane value = plane(edges.affine.linear, edges.affine.constant[i], i, p);
      const Plane along = plane(edges.along, 0.0F, i, p);
      const F begin = Simd::set(edges.begin[i] - inside_tolerance),
              end = Simd::set(edges.end[i] + inside_tolerance);
      for (int k = 0; k < slices; ++k) {
        const F t = along.at(p, k);
        least[k] = Simd::min_if_between(least[k], Simd::fnma(t, t, value.at(p, k)), t, begin, end);
      }
    }
  }

  void far_faces(const Local& local, const Points& p, F* least) {
    const auto& faces = local.faces;
    for (int n = 0; n < faces_; ++n) {
      const int i = face_list_[n];
      const Plane value = plane(faces.affine.linear, faces.affine.constant[i], i, p);
      const Plane height = plane(faces.normal, 0.0F, i, p);
      Plane side[3];
      sides(local, i, p, side);
      for (int k = 0; k < slices; ++k) {
        const F h = height.at(p, k);
        least[k] = Simd::min_if_above(least[k], Simd::fma(h, h, value.at(p, k)), inside(side, p, k),
                                      Simd::set(-inside_tolerance));
      }
    }
  }

  void evaluate_near(const Local& local, int pass) {
    const Points p = points(pass);
    F least[slices];
    for (int k = 0; k < slices; ++k) least[k] = Simd::set(1e30F);
    near_vertices(local, p, least);
    near_edges(local, p, least);
    near_faces(local, p, least);
    for (int k = 0; k < slices; ++k) {
      const int at = k * 16 + pass * lanes;
      lower(at, Simd::low(least[k]));
      lower(at + lanes / 2, Simd::high(least[k]));
    }
  }

  float anchor(const typename Local::Affine& f, int axis, int i) const {
    return static_cast<float>(block_->point[axis]) - 0.5F * f.linear[axis][i];
  }

  void near_vertices(const Local& local, const Points& p, F* least) {
    const auto& f = local.vertices.affine;
    for (int n = 0; n < vertices_; ++n) {
      const int i = vertex_list_[n];
      const F dx = p.x - Simd::set(anchor(f, 0, i)), dy = p.y - Simd::set(anchor(f, 1, i));
      const F az = Simd::set(anchor(f, 2, i)), in_plane = Simd::fma(dx, dx, dy * dy);
      for (int k = 0; k < slices; ++k) {
        const F dz = p.z[k] - az;
        least[k] = Simd::min(least[k], Simd::fma(dz, dz, in_plane));
      }
    }
  }

  void near_edges(const Local& local, const Points& p, F* least) {
    const auto& edges = local.edges;
    for (int n = 0; n < edges_; ++n) {
      const int i = edge_list_[n];
      const Plane along = plane(edges.along, 0.0F, i, p);
      const F ux = Simd::set(edges.along[0][i]), uy = Simd::set(edges.along[1][i]),
              uz = Simd::set(edges.along[2][i]);
      const F dx = p.x - Simd::set(anchor(edges.affine, 0, i)),
              dy = p.y - Simd::set(anchor(edges.affine, 1, i));
      const F az = Simd::set(anchor(edges.affine, 2, i));
      const F begin = Simd::set(edges.begin[i] - inside_tolerance),
              end = Simd::set(edges.end[i] + inside_tolerance);
      for (int k = 0; k < slices; ++k) {
        const F t = along.at(p, k);
        const F x = Simd::fnma(t, ux, dx), y = Simd::fnma(t, uy, dy), z = Simd::fnma(t, uz, p.z[k] - az);
        least[k] = Simd::min_if_between(least[k], Simd::fma(x, x, Simd::fma(y, y, z * z)), t, begin, end);
      }
    }
  }

  void near_faces(const Local& local, const Points& p, F* least) {
    const auto& faces = local.faces;
    for (int n = 0; n < faces_; ++n) {
      const int i = face_list_[n];
      const Plane height = plane(faces.normal, faces.distance[i], i, p);
      Plane side[3];
      sides(local, i, p, side);
      for (int k = 0; k < slices; ++k) {
        const F h = height.at(p, k);
        least[k] = Simd::min_if_above(least[k], h * h, inside(side, p, k), Simd::set(-inside_tolerance));
      }
    }
  }

  void lower(int at, typename Simd::D value) {
    Simd::store(squared_ + at, Simd::min(Simd::load(squared_ + at), value));
  }

  alignas(64) double squared_[voxels];
  const Reference* block_ = nullptr;
  float center_[3], shift_[3], constant_ = 0.0F;
  float nearest_ = 0.0F;  ///< G at the centre, of the reference
  float tolerance_ = 0.0F;
  int vertices_ = 0, edges_ = 0, faces_ = 0;
  std::int32_t vertex_list_[Local::padded], edge_list_[Local::padded], face_list_[Local::padded];
};

}  // namespace
}  // namespace isochor

#pragma once
#include "core/dynamics/cell_volume.h"
#include "core/dynamics/newton_stencil_solver.h"
#include "core/dynamics/newton_system.h"

namespace isochor::newton {

/// Three arrays over the slots.
class PointArray {
 public:
  PointArray() = default;
  explicit PointArray(std::int64_t size)
      : values_{AlignedArray<double>(size), AlignedArray<double>(size), AlignedArray<double>(size)} {}
  Points view() const { return {axis(0), axis(1), axis(2)}; }
  double* axis(int i) const { return values_[i].data(); }
  Vec3 at(std::int64_t slot) const { return {values_[0][slot], values_[1][slot], values_[2][slot]}; }
  void set(std::int64_t slot, const Vec3& p) {
    for (int i = 0; i < 3; ++i) values_[i][slot] = p[i];
  }
  void add(std::int64_t slot, const Vec3& d) {
    for (int i = 0; i < 3; ++i) values_[i][slot] += d[i];
  }
  std::int64_t bytes() const { return 3 * values_[0].bytes(); }

 private:
  std::array<AlignedArray<double>, 3> values_;
};

/// The cells of one body on their lattice, in arrays over its slots. Inside, lengths are in cells and inverse
/// masses in their mean, so that float serves the linear solve at any scale.
class LatticeSystem final : public NewtonSystem {
 public:
  LatticeSystem(VolumeModel model, LatticeLayout layout);

  void load(const ProjectionRequest& request, const Coordinates& positions) override;
  void store(Coordinates& positions) const override;
  VolumeErrors evaluate(double t) override;
  void accept(double t) override;
  void linearize(Directions directions) override;
  int solve(double tolerance) override;
  void set_step(Directions directions) override;
  void begin_step(const Coordinates& start, double length, Coordinates& positions) override;
  void set_dilation() override;
  bool is_free() const override { return pinned_ == 0 && blocked_.empty() && carriers_.empty(); }
  std::int64_t rowless_cells() const override { return rowless_; }
  std::int64_t worst_cell() const override;
  std::optional<bool> any_inverted() const override { return !(smallest_tet_ > 0.0); }
  std::int64_t bytes() const override;

 private:
  struct Blocked {
    std::int32_t slot;
    Eigen::Matrix3d inverse_mass;
    Vec3 force;  ///< Jᵀμ
  };
  /// A corner of a cell at a particle that a rigid body carries.
  struct CarriedCorner {
    std::int32_t cell, corner;  ///< slot, 0 to 7
    std::int32_t carried;       ///< index into the carrier's particles
  };
  using StridedVector = Eigen::Map<Eigen::Vector3f, 0, Eigen::InnerStride<>>;
  using CarrierSide = std::vector<CarrierRows::Row> CarrierRows::*;

  void set_rest_volumes();
  void set_masses();
  void choose_preconditioner();
  std::int32_t slot(std::int32_t particle) const { return layout_.vertex_slots[particle]; }
  void gather(const Coordinates& from, PointArray& to) const;
  bool stands_at(const Coordinates& from, const PointArray& points) const;
  CellCorners corners(std::int64_t cell, const PointArray& points) const;
  /// In the units of the linear solve.
  CellCorners scaled_gradient(std::int64_t cell, const PointArray& points) const;
  Cells cells(const LatticeLayout::Slab& slab, const PointArray& points) const;
  std::array<double, 3> face_areas(const PointArray& points) const;
  void weigh_gradients(const PointArray& points);

  // newton_lattice_contacts.cpp: all that is not the same for every cell.
  void block(std::span<const BlockedParticle> blocked);
  void unblock();
  bool carry_on_multipliers(double length);
  void load_carriers(std::span<RigidCarrier> carriers);
  std::int64_t count_rowless(std::int32_t held) const;
  StridedVector weighted_gradient(std::int64_t cell, int corner);
  void weigh_irregular_gradients(const PointArray& points);
  void weigh_blocked_gradients();
  void restore_blocked_gradients();
  void set_carrier_rows(const PointArray& points, CarrierSide side);
  void set_irregular_rows(const PointArray& points);
  void add_irregular_forces(const PointArray& points, double factor, const float* multipliers);
  void set_step(Directions directions, const float* multipliers);
  void read_blocked_forces();
  void move_blocked_particles();

  VolumeModel model_;
  LatticeLayout layout_;
  const CellKernels& kernels_ = cell_kernels();
  double total_rest_volume_ = 0.0, mean_rest_volume_ = 0.0, length_ = 1.0, mean_inverse_mass_ = 0.0;
  std::vector<double> masses_;  ///< a particle
  std::size_t pinned_ = 0;
  std::vector<std::uint8_t> immovable_;  ///< a slot
  std::int64_t rowless_ = 0, rowless_when_free_ = 0;

  PointArray start_, x_, trial_, direction_, forces_;
  std::vector<ErrorSums> slab_sums_;
  double smallest_tet_ = 0.0;  ///< where errors were evaluated last, over its cell's volume
  double trial_t_ = -1.0;      ///< trial_ = x_ + trial_t_·direction_, unless negative
  AlignedArray<double> inverse_volumes_, errors_, inverse_masses_;
  AlignedArray<float> sign_, weights_;  ///< inverse masses over their mean
  StencilSolver solver_;
  AlignedArray<float> multipliers_, last_multipliers_;  ///< of this step, of the one before
  bool lifting_ = false;                                ///< of the request
  const float* stepping_along_ = nullptr;               ///< the multipliers of direction_

  /// W Jᵀ, where it was taken last; of the corners of irregular cells behind the lattice apart from the rest.
  AlignedArray<float> weighted_values_;
  Gradients weighted_{};
  std::vector<Eigen::Matrix<float, 3, 8>> weighted_irregular_;
  bool weighted_at_start_ = false;
  /// What blocked particles have replaced there.
  struct FreeGradient {
    std::int64_t cell;
    int corner;
    Eigen::Vector3f value;
  };
  std::vector<FreeGradient> replaced_;
  bool blocked_are_weighed_ = false;
  std::vector<double> irregular_rest_volumes_;

  std::vector<Blocked> blocked_;
  std::span<Vec3> blocked_forces_;                           ///< of the request
  std::span<RigidCarrier> carriers_;                         ///< of the request
  std::vector<std::vector<CarriedCorner>> carried_corners_;  ///< a carrier, by cell
  std::vector<Eigen::Matrix<double, 6, 1>> carrier_steps_;
};

}  // namespace isochor::newton

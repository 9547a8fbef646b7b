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
  void set_dilation() override;
  bool is_free() const override { return pinned_ == 0 && blocked_.empty() && carriers_.empty(); }
  std::int64_t rowless_cells() const override { return rowless_; }
  std::int64_t worst_cell() const override;
  std::int64_t bytes() const override;

 private:
  struct Blocked {
    std::int32_t slot, particle;
    Eigen::Matrix3d inverse_mass;
    Eigen::Matrix3f root;  ///< of inverse_mass over the mean
    Vec3 force;            ///< Jᵀμ
  };

  /// Times the roots of the inverse masses.
  struct WeightedGradients {
    AlignedArray<float> values;
    Gradients view{};
    std::vector<Eigen::Matrix<float, 3, 8>> irregular;  ///< a column a corner
  };

  void set_rest_volumes();
  void set_masses();
  std::int32_t slot(std::int32_t particle) const { return layout_.vertex_slots[particle]; }
  void gather(const Coordinates& from, PointArray& to) const;
  void set_gradients(const PointArray& points, WeightedGradients& gradients,
                     std::vector<CarrierRows::Row> CarrierRows::*carrier_rows);
  CellCorners corners(const LatticeLayout::IrregularCell& cell, const PointArray& points) const;
  std::array<double, 3> face_areas(const PointArray& points) const;

  // newton_lattice_contacts.cpp: all that is not the same for every cell.
  void block(std::span<const BlockedParticle> blocked);
  void unblock();
  void load_carriers(std::span<RigidCarrier> carriers);
  std::int64_t count_rowless() const;
  template <class Visit>
  void visit_gradients(WeightedGradients& gradients, std::int32_t vertex_slot, const Visit& visit);
  void set_irregular_gradients(const PointArray& points, WeightedGradients& gradients);
  void set_carrier_rows(WeightedGradients& gradients, std::vector<CarrierRows::Row> CarrierRows::*rows);
  void weigh_blocked_gradients(WeightedGradients& gradients);
  void couple_extra_vertices(const WeightedGradients& own, const WeightedGradients& neighbors);
  void add_irregular_forces(const PointArray& points, double factor);
  void read_blocked_forces();
  void move_blocked_particles();

  VolumeModel model_;
  LatticeLayout layout_;
  const CellKernels& kernels_ = cell_kernels();
  double total_rest_volume_ = 0.0, mean_rest_volume_ = 0.0, length_ = 1.0, mean_inverse_mass_ = 0.0;
  std::size_t pinned_ = 0;
  std::vector<std::uint8_t> immovable_;  ///< a slot
  std::int64_t rowless_ = 0, rowless_when_free_ = 0;

  PointArray start_, x_, trial_, direction_, lower_, upper_;
  AlignedArray<double> inverse_sixfold_, errors_, inverse_masses_;
  AlignedArray<float> sign_, root_weights_, residual_weights_;
  WeightedGradients start_gradients_, gradients_;
  bool start_gradients_valid_ = false;
  StencilSolver solver_;

  std::vector<double> irregular_rest_volumes_;
  std::vector<Blocked> blocked_;
  std::span<Vec3> blocked_forces_;    ///< of the request
  std::span<RigidCarrier> carriers_;  ///< of the request
  std::vector<Eigen::Matrix<double, 6, 1>> carrier_steps_;
};

}  // namespace isochor::newton

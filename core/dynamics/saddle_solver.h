#pragma once
#include "core/dynamics/carrier_space.h"
#include "core/dynamics/saddle_preconditioner.h"
#include "core/dynamics/soft_body.h"
#include "core/dynamics/spring_tangent.h"
#include "core/dynamics/volume_rows.h"

namespace isochor {

/// A displacement a particle and a multiplier a cell.
struct SaddleVector {
  Coordinates nodes;
  std::vector<double> cells;

  SaddleVector() = default;
  SaddleVector(std::size_t particles, std::size_t rows) : nodes(particles), cells(rows) {}
};

/// Solves (A −Jᵀ; J 0)·(u, μ) = (f, g) with A = M + T, T = aK + bC of the springs (SpringTangent) and J of
/// the cell volumes: stiff springs and constant volume at once. u stays zero where particles are pinned and
/// along blocked directions (filtered [Baraff & Witkin 1998]), except as rigid bodies carry them there, whose
/// resistance A has in addition. Flexible GMRES [Saad 1993], since the
/// preconditioner rounds to float, with the lower triangle (A 0; J S), S = J A⁻¹ Jᵀ, from the right: inverses
/// of A and S by BoxPreconditioner or by their diagonals, and A's exact on the six rigid modes, whose
/// stiffness is M alone and may be 1e-10 of the rest.
class SaddleSolver {
 public:
  explicit SaddleSolver(const SoftBody& body);

  /// Takes A and J at these positions. blocked, and what carries them, until the next call.
  void linearize(const SoftBody& body, const Coordinates& positions, double stiffness_weight,
                 double damping_weight, std::span<const BlockedParticle> blocked,
                 const CarrierSpace& carriers);
  /// Until the residual is tolerance times the right-hand side, both in norm(). Returns the iterations.
  int solve(const SoftBody& body, const SaddleVector& right_side, SaddleVector& solution, double tolerance,
            int max_iterations);
  /// √(Σ f²/diag A + Σ g²/diag S), f without what pins and blocked directions take.
  double norm(const SoftBody& body, const SaddleVector& residual);
  /// right_side −= what a displacement that is not solved for does: A·d and J·d.
  void subtract(const SoftBody& body, const Coordinates& displacement, SaddleVector& right_side);
  /// Takes the volumes, and only them, at these positions.
  void measure(const SoftBody& body, const Coordinates& positions) { rows_.measure(*body.mesh, positions); }
  /// m³ a cell, at the positions given last.
  const std::vector<double>& volumes() const { return rows_.volumes(); }
  /// sum += factor·Jᵀ·multipliers.
  void add_pressure(const std::vector<double>& multipliers, double factor, Coordinates& sum) const {
    rows_.add_transposed(multipliers, factor, sum);
  }

  std::int64_t bytes() const;

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  static constexpr std::size_t longest_cycle = 80;

  void filter(const SoftBody& body, Coordinates& v) const;
  void multiply(const SoftBody& body, const Coordinates& p, Coordinates& product) const;
  void invert_diagonals(const SoftBody& body);
  void build_rigid(const SoftBody& body);
  void expand(const Vector6& coefficients, Coordinates& v) const;
  Vector6 restrict_to_rigid(const Coordinates& v) const;
  void precondition_nodes(const SoftBody& body, const Coordinates& from, Coordinates& to);
  void precondition(const SoftBody& body, const SaddleVector& from, SaddleVector& to);
  void apply(const SoftBody& body, const SaddleVector& from, SaddleVector& preconditioned,
             SaddleVector& image);
  int run_cycle(const SoftBody& body, double length, double goal, int most, SaddleVector& solution);
  double round_off(const SoftBody& body) const;
  double dot(const SaddleVector& a, const SaddleVector& b) const;
  /// A part of one of a SaddleVector's arrays.
  struct Slice {
    int array;
    std::size_t begin, size;
  };
  template <class Body>
  void for_slices(const Body& body) const;
  void add_combination(const double* factors, const std::vector<SaddleVector>& vectors, int count,
                       SaddleVector& to) const;
  void orthogonalize(int count, SaddleVector& next, double* parts);
  void choose_preconditioner(const SoftBody& body, const SaddleVector& right_side);

  SpringTangent tangent_;
  VolumeRows rows_;
  std::optional<BoxPreconditioner> box_;
  bool chosen_ = false;
  std::span<const BlockedParticle> blocked_;
  const CarrierSpace* carriers_ = nullptr;
  SpringTangent::Blocks inverse_blocks_;
  SaddleVector weights_;  ///< 1/diagonals; of the nodes in x
  Eigen::Matrix<double, 6, 6> rigid_inverse_;
  Vec3 center_ = Vec3::Zero();
  Coordinates arms_;  ///< positions about the centre
  SaddleVector residual_;
  Coordinates rigid_;
  std::vector<double> divergence_;  ///< J·u of the last preconditioned vector
  std::vector<Slice> slices_;
  std::vector<std::array<double, 4>> sums_;  ///< a slice
  int cycle_ = 0;
  std::vector<SaddleVector> basis_, preconditioned_;
  Eigen::MatrixXd hessenberg_;
  Eigen::VectorXd projected_, cosines_, sines_, coefficients_;
};

}  // namespace isochor

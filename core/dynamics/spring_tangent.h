#pragma once
#include "core/dynamics/spring_stencil.h"

namespace isochor {

/// The mean coefficients of A = M + T over a lattice body, T a SpringTangent: a particle of one cell weighs
/// `mass`, a spring of one cell has `axial` along itself and `isotropic` in all directions.
struct MeanStiffness {
  double mass = 0.0, edge_axial = 0.0, edge_isotropic = 0.0, diagonal_axial = 0.0, diagonal_isotropic = 0.0;
};

/// T = aK + bC of a body's springs at one configuration, K without its negative (buckling) part so that it
/// stays positive semidefinite: for a spring of direction u, length l, rest length L and damping τ,
/// α(I − uuᵀ) + (a + bτ)k·uuᵀ with α = a·k·max(0, 1 − L/l) [Baraff & Witkin 1998].
class SpringTangent {
 public:
  SpringTangent() = default;
  explicit SpringTangent(const SpringStencil& stencil);

  void linearize(const SpringStencil& stencil, const SpringMaterial& material, const Coordinates& positions,
                 double stiffness_weight, double damping_weight);
  /// product += T·p.
  void add_product(const SpringStencil& stencil, const Coordinates& p, Coordinates& product) const;

  /// The diagonal blocks of the particles, symmetric, an array an entry: xx, yy, zz, xy, xz, yz.
  using Blocks = std::array<std::vector<double>, 6>;
  void add_diagonal(const SpringStencil& stencil, Blocks& blocks) const;

  /// Without the mass.
  MeanStiffness mean(const SpringStencil& stencil) const;

  std::int64_t bytes() const { return edges_.bytes() + diagonals_.bytes(); }

 private:
  struct Family {
    std::vector<double> isotropic, wx, wy, wz;  ///< α·I + w·wᵀ
    double axial = 0.0;                         ///< (a + bτ)k
    void resize(std::size_t size);
    std::int64_t bytes() const { return static_cast<std::int64_t>(4 * isotropic.size() * sizeof(double)); }
  };
  Family edges_, diagonals_;
};

}  // namespace isochor

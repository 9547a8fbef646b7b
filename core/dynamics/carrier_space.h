#pragma once
#include <span>
#include <vector>

#include "core/dynamics/coordinates.h"
#include "core/dynamics/volume_projector.h"

namespace isochor {

/// A rigid body that gives way to the particles blocked on it.
struct CompliantBody {
  std::span<const CarriedParticle> particles;
  Eigen::Matrix<double, 6, 6> compliance;  ///< motion for a wrench (kg m, about the body's centre)
  Eigen::Matrix<double, 6, 1> owed;        ///< wrench that it lacks when nothing presses on it, kg m
};

/// The displacements along blocked directions that rigid bodies allow, Δx = B·q, with q their motions: as
/// E·y, with E orthonormal over the particles, so that E·Eᵀ projects on them. Of all motions that move the
/// particles alike, y stands for that of the least work.
class CarrierSpace {
 public:
  void build(std::span<const CompliantBody> bodies);
  bool empty() const { return rank_ == 0; }

  /// y = Eᵀ·v.
  const Eigen::VectorXd& restricted(const Coordinates& v) const;
  /// v += E·y.
  void expand(const Eigen::VectorXd& y, Coordinates& v) const;
  /// v += E·D·Eᵀ·u, D the bodies' resistance (kg).
  void add_resistance(const Coordinates& u, Coordinates& v) const;
  /// v −= E·(D·y + what the bodies are owed).
  void subtract_imbalance(const Eigen::VectorXd& y, Coordinates& v) const;
  int size() const { return rank_; }

 private:
  int rank_ = 0;
  std::vector<std::int32_t> particles_;
  std::vector<Vec3> columns_;  ///< rank_ a particle
  Eigen::VectorXd resistance_, owed_;
  mutable Eigen::VectorXd coefficients_, scaled_;
};

}  // namespace isochor

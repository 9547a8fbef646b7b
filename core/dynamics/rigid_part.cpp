#include "core/dynamics/rigid_part.h"

#include <Eigen/Eigenvalues>

#include "core/parallel/cancel_scope.h"

namespace isochor {

Vec3 mass_center(const SoftBody& body, const Coordinates& x) {
  throw_if_scope_cancelled();
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < body.size(); ++i) sum += body.masses[i] * x.at(i);
  return sum / body.total_mass;
}

Vec3 moment(const SoftBody& body, const Coordinates& a, const Coordinates& b) {
  const Vec3 a_center = mass_center(body, a), b_center = mass_center(body, b);
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < body.size(); ++i)
    sum += body.masses[i] * (a.at(i) - a_center).cross(b.at(i) - b_center);
  return sum;
}

Vec3 spin_of(const SoftBody& body, const Coordinates& x, const Vec3& angular_momentum) {
  const Vec3 center = mass_center(body, x);
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Vec3 r = x.at(i) - center;
    inertia += body.masses[i] * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  return spin_of(inertia, angular_momentum);
}

Vec3 spin_of(const Eigen::Matrix3d& inertia, const Vec3& angular_momentum) {
  constexpr double least_inertia = 1e-12;  // relative: a body flattened to a line does not turn about it
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(inertia);
  Vec3 spin = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    if (axes.eigenvalues()[k] > least_inertia * axes.eigenvalues()[2])
      spin += axes.eigenvectors().col(k) *
              (axes.eigenvectors().col(k).dot(angular_momentum) / axes.eigenvalues()[k]);
  return spin;
}

RigidPart rigid_part(const SoftBody& body, const Coordinates& x, const Coordinates& v) {
  return {mass_center(body, x), mass_center(body, v), spin_of(body, x, moment(body, x, v))};
}

}  // namespace isochor

#pragma once
#include <span>
#include <vector>

#include "core/dynamics/volume_projector.h"

namespace isochor {

/// W of one projection: 1/m for a free particle, a 3×3 matrix for a blocked one, plus the rank-six terms of
/// the rigid bodies that carry particles.
class Mobility {
 public:
  explicit Mobility(std::vector<double> inverse_masses);

  void begin(const ProjectionRequest& request);
  void end();  ///< forgets the request

  bool blocked(std::int32_t particle) const { return slot_[particle] >= 0; }
  double inverse_mass(std::int32_t particle) const { return inverse_masses_[particle]; }
  Vec3 apply(std::int32_t particle, const Vec3& force) const {
    const std::int32_t slot = slot_[particle];
    return slot < 0 ? Vec3(inverse_masses_[particle] * force)
                    : Vec3(request_->blocked[slot].inverse_mass * force);
  }
  /// Adds up what the constraints press on a blocked particle.
  void record(std::int32_t particle, const Vec3& force) const {
    if (slot_[particle] >= 0 && !request_->blocked_forces.empty())
      request_->blocked_forces[slot_[particle]] += force;
  }

  std::size_t carriers() const { return request_->carriers.size(); }
  const RigidCarrier& carrier(std::size_t c) const { return request_->carriers[c]; }
  /// The carrier's share of the force on a particle: mapᵀ·f, zero when it does not carry it.
  Eigen::Matrix<double, 6, 1> pull(std::size_t carrier, std::int32_t particle, const Vec3& force) const;
  /// Moves the carrier and all that it carries.
  void move(std::size_t carrier, const Eigen::Matrix<double, 6, 1>& motion, Coordinates& positions) const;

  std::int64_t bytes() const;

 private:
  std::vector<double> inverse_masses_;
  std::vector<std::int32_t> slot_;  ///< into request.blocked, or −1
  const ProjectionRequest* request_ = nullptr;
};

}  // namespace isochor

#include "core/dynamics/mobility.h"

#include <algorithm>

namespace isochor {

Mobility::Mobility(std::vector<double> inverse_masses)
    : inverse_masses_(std::move(inverse_masses)), slot_(inverse_masses_.size(), -1) {}

void Mobility::begin(const ProjectionRequest& request) {
  request_ = &request;
  for (std::size_t b = 0; b < request.blocked.size(); ++b)
    slot_[request.blocked[b].particle] = static_cast<std::int32_t>(b);
  std::ranges::fill(request.blocked_forces, Vec3::Zero());
  for (RigidCarrier& carrier : request.carriers) carrier.motion.setZero();
}

void Mobility::end() {
  for (const BlockedParticle& blocked : request_->blocked) slot_[blocked.particle] = -1;
  request_ = nullptr;
}

Eigen::Matrix<double, 6, 1> Mobility::pull(std::size_t carrier, std::int32_t particle,
                                           const Vec3& force) const {
  Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
  if (slot_[particle] < 0) return sum;
  for (const CarriedParticle& carried : request_->carriers[carrier].particles) {
    if (carried.particle == particle) sum += carried.map.transpose() * force;
  }
  return sum;
}

void Mobility::move(std::size_t carrier, const Eigen::Matrix<double, 6, 1>& motion,
                    Coordinates& positions) const {
  RigidCarrier& body = request_->carriers[carrier];
  body.motion += motion;
  for (const CarriedParticle& carried : body.particles) positions.add(carried.particle, carried.map * motion);
}

std::int64_t Mobility::bytes() const {
  return static_cast<std::int64_t>(inverse_masses_.capacity() * sizeof(double) +
                                   slot_.capacity() * sizeof(std::int32_t));
}

}  // namespace isochor

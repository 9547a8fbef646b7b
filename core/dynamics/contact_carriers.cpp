#include "core/dynamics/contact_carriers.h"

#include <Eigen/LU>

namespace isochor {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Motion = Eigen::Matrix<double, 3, 6>;

Eigen::Matrix3d cross(const Vec3& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// Displacement of the body's material at the arm, of its translation and rotation.
Motion motion_at(const Vec3& arm) {
  Motion j;
  j << Eigen::Matrix3d::Identity(), -cross(arm);
  return j;
}

/// Of the particle, by plane k's body: along the normals so that all planes stay met, and while it sticks
/// with the mean of the bodies.
Eigen::Matrix3d follow(const ParticleContact& contact, const ContactDirections& directions, int k) {
  Eigen::Matrix3d follow = directions.dual[k] * contact.plane[k].normal.transpose();
  if (contact.sticking) follow += (Eigen::Matrix3d::Identity() - directions.normal_space) / contact.planes;
  return follow;
}

/// r = m(x − x̂) − g.
Vec3 reaction_of(const SoftBody& body, const ParticleContact& contact, const Coordinates& predicted) {
  const std::int32_t i = contact.particle;
  return body.masses[i] * (body.positions.at(i) - predicted.at(i)) - contact.push;
}

}  // namespace

void ContactCarriers::begin(std::span<const MassiveBody> bodies) {
  bodies_.resize(bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    bodies_[b].at_start = bodies[b];
    bodies_[b].given.setZero();
    bodies_[b].pushed = false;
    bodies_[b].touching = 0.0;
    bodies_[b].particles.clear();
  }
  carriers_.clear();
}

void ContactCarriers::weigh(std::span<const MassiveBody> bodies) {
  for (std::size_t b = 0; b < bodies.size(); ++b) bodies_[b].at_start = bodies[b];
}

ContactCarriers::Body* ContactCarriers::find(int source) {
  const auto found = std::ranges::lower_bound(bodies_, source, {}, &source_of);
  return found == bodies_.end() || source_of(*found) != source ? nullptr : &*found;
}

double ContactCarriers::friction_share(const ParticleContact& contact, double mass) const {
  double share = 1.0;
  for (int k = 0; k < contact.planes; ++k)
    if (const Body* body = find(contact.plane[k].source))
      share = std::min(share, body->at_start.mass / (body->at_start.mass + std::max(body->touching, mass)));
  return share;
}

Eigen::Matrix<double, 6, 6> ContactCarriers::combined_mass(const SoftBody& body, const Body& of) const {
  Eigen::Matrix<double, 6, 6> mass = Eigen::Matrix<double, 6, 6>::Zero();
  mass.diagonal().head<3>().setConstant(of.at_start.mass);
  mass.bottomRightCorner<3, 3>() = of.at_start.inertia;
  for (const CarriedParticle& p : of.particles) mass += body.masses[p.particle] * p.map.transpose() * p.map;
  return mass;
}

// (C⁻¹ + K)⁻¹ as C·(I + K·C)⁻¹: joints leave C without an inverse. By its own mass a jointed body would give
// way to a heavy load where its joints do not, a little in every substep, and be set back by them: the finer
// the substeps, the stiffer.
Eigen::Matrix<double, 6, 6> ContactCarriers::combined_compliance(const SoftBody& body, const Body& of,
                                                                 const ComplianceOf& compliance_of) const {
  if (!of.at_start.jointed) return combined_mass(body, of).inverse();
  Eigen::Matrix<double, 6, 6> carried = Eigen::Matrix<double, 6, 6>::Zero();
  for (const CarriedParticle& p : of.particles)
    carried += body.masses[p.particle] * p.map.transpose() * p.map;
  const Eigen::Matrix<double, 6, 6> compliance = compliance_of(source_of(of));
  return compliance * (Eigen::Matrix<double, 6, 6>::Identity() + carried * compliance).inverse();
}

std::span<const DueWrench> ContactCarriers::bounce(SoftBody& body, std::span<const BounceGain> gains) {
  due_.clear();
  for (Body& b : bodies_) {
    b.particles.clear();
    Vector6 sum = Vector6::Zero();
    for (const BounceGain& gain : gains) {
      if (gain.source != b.at_start.source) continue;
      const Vec3 arm = body.positions.at(gain.particle) - b.at_start.center;
      const Motion along = gain.normal * gain.normal.transpose() * motion_at(arm);
      b.particles.push_back({gain.particle, along});
      sum += body.masses[gain.particle] * gain.speed * (along.transpose() * gain.normal);
    }
    if (b.particles.empty()) continue;
    const Vector6 q = -(combined_mass(body, b).inverse() * sum);
    Vector6 given = Vector6::Zero();
    auto carried = b.particles.begin();
    for (const BounceGain& gain : gains) {
      if (gain.source != b.at_start.source) continue;
      const Vec3 gained = gain.speed * gain.normal + carried->map * q;
      body.velocities.add(gain.particle, gained);
      const Vec3 arm = body.positions.at(gain.particle) - b.at_start.center;
      given -= body.masses[gain.particle] * (motion_at(arm).transpose() * gained);
      ++carried;
    }
    due_.push_back({b.at_start.source, b.at_start.center, given.head<3>(), given.tail<3>()});
  }
  return due_;
}

void ContactCarriers::load(SoftBody& body, std::span<const ParticleContact> contacts,
                           const Coordinates& predicted, const ComplianceOf& compliance_of) {
  carriers_.clear();
  if (empty()) return;
  sum_reactions(body, contacts, predicted);
  list_particles(body, contacts);
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& b = bodies_[i];
    if (b.particles.empty()) continue;
    RigidCarrier carrier;
    carrier.particles = b.particles;
    carrier.inverse_mass = combined_compliance(body, b, compliance_of);
    const Vector6 q = -(carrier.inverse_mass * (reactions_[i] + b.given));
    for (const CarriedParticle& p : b.particles) body.positions.add(p.particle, p.map * q);
    carriers_.push_back(carrier);
  }
}

void ContactCarriers::list_particles(const SoftBody& body, std::span<const ParticleContact> contacts) {
  for (Body& b : bodies_) b.touching = 0.0, b.rubbed.setZero(), b.particles.clear();
  for (const ParticleContact& contact : contacts) {
    const ContactDirections directions = directions_of(contact);
    for (int k = 0; k < contact.planes; ++k) {
      Body* b = find(contact.plane[k].source);
      if (!b) continue;
      const Vec3 arm = body.start_positions.at(contact.particle) - b->at_start.center;
      b->particles.push_back({contact.particle, follow(contact, directions, k) * motion_at(arm)});
      b->touching += body.masses[contact.particle];
      if (contact.sticking) continue;  // its friction is in what blocks it
      const Vec3 friction = share_of(contact, directions, k, contact.friction);
      b->rubbed.head<3>() += friction;
      b->rubbed.tail<3>() += arm.cross(friction);
    }
  }
}

const CarrierSpace& ContactCarriers::yielding(const SoftBody& body, std::span<const ParticleContact> contacts,
                                              const ComplianceOf& compliance_of) {
  list_particles(body, contacts);
  std::vector<CompliantBody> touched;
  for (const Body& b : bodies_)
    if (!b.particles.empty())
      touched.push_back({b.particles, compliance_of(source_of(b)), b.given + b.rubbed});
  space_.build(touched);
  return space_;
}

void ContactCarriers::sum_reactions(const SoftBody& body, std::span<const ParticleContact> contacts,
                                    const Coordinates& predicted) {
  reactions_.assign(bodies_.size(), Vector6::Zero());
  for (const ParticleContact& contact : contacts) {
    const ContactDirections directions = directions_of(contact);
    for (int k = 0; k < contact.planes; ++k) {
      const Body* b = find(contact.plane[k].source);
      if (!b) continue;
      const Vec3 force = share_of(contact, directions, k, reaction_of(body, contact, predicted));
      const Vec3 arm = body.start_positions.at(contact.particle) - b->at_start.center;
      Vector6& sum = reactions_[static_cast<std::size_t>(b - bodies_.data())];
      sum.head<3>() += force;
      sum.tail<3>() += arm.cross(force);
    }
  }
}

std::span<const DueWrench> ContactCarriers::take_due(const SoftBody& body,
                                                     std::span<const ParticleContact> contacts,
                                                     const Coordinates& predicted) {
  due_.clear();
  if (empty()) return due_;
  sum_reactions(body, contacts, predicted);
  for (std::size_t i = 0; i < bodies_.size(); ++i) give(bodies_[i], -(reactions_[i] + bodies_[i].given));
  return due_;
}

std::span<const DueWrench> ContactCarriers::take_back() {
  due_.clear();
  for (Body& body : bodies_) give(body, -body.given);
  return due_;
}

bool ContactCarriers::has_pushed(int source) const {
  const Body* body = find(source);
  return body && body->pushed;
}

void ContactCarriers::give(Body& body, const Vector6& due) {
  body.given += due;
  if (due.isZero(0.0)) return;
  body.pushed = true;
  due_.push_back({source_of(body), body.at_start.center, due.head<3>(), due.tail<3>()});
}

}  // namespace isochor

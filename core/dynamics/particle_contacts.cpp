#include "core/dynamics/particle_contacts.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace isochor {
namespace {

/// Friction is iterated until it changes by less than this part of itself.
constexpr double friction_tolerance = 0.02;
/// A bounce slower than what gravity adds in a few substeps is rest, m/s.
constexpr double rest_speed = 0.05;

/// Orthonormal normals of the planes; a plane that lies in the span of those before adds nothing.
struct Basis {
  std::array<Vec3, 3> axis;
  int size = 0;

  void add(const Vec3& normal) {
    Vec3 rest = normal;
    for (int k = 0; k < size; ++k) rest -= axis[k].dot(rest) * axis[k];
    if (rest.norm() > 1e-6) axis[size++] = rest.normalized();
  }
  Vec3 tangential(Vec3 v) const {
    for (int k = 0; k < size; ++k) v -= axis[k].dot(v) * axis[k];
    return v;
  }
  Eigen::Matrix3d projector() const {
    Eigen::Matrix3d p = Eigen::Matrix3d::Identity();
    for (int k = 0; k < size; ++k) p -= axis[k] * axis[k].transpose();
    return p;
  }
};

template <class Contact>
Basis basis_of(const Contact& contact) {
  Basis basis;
  for (int k = 0; k < contact.planes; ++k) basis.add(contact.plane[k].normal);
  return basis;
}

/// The point nearest to x on all planes of the contact at once (on their intersection).
template <class Contact>
Vec3 onto_planes(const Contact& contact, Vec3 x) {
  Basis basis;
  for (int k = 0; k < contact.planes; ++k) {
    const ContactPlane& plane = contact.plane[k];
    const int before = basis.size;
    basis.add(plane.normal);
    if (basis.size == before) continue;
    // Along the new axis only, so that the planes before stay met.
    const Vec3& axis = basis.axis[before];
    x += axis * ((plane.offset - plane.normal.dot(x)) / plane.normal.dot(axis));
  }
  return x;
}

template <class Contact>
double mean_friction(const Contact& contact) {
  double sum = 0.0;
  for (int k = 0; k < contact.planes; ++k) sum += contact.plane[k].friction;
  return contact.planes ? sum / contact.planes : 0.0;
}

template <class Contact>
Vec3 mean_shift(const Contact& contact) {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < contact.planes; ++k) sum += contact.plane[k].surface_shift;
  return contact.planes ? Vec3(sum / contact.planes) : sum;
}

}  // namespace

ParticleContacts::ParticleContacts(const SoftBody& body) : predicted_(body.size()), slot_(body.size(), -1) {
  const std::size_t surface_particles = body.surface_particles.size();
  particles_.reserve(surface_particles);
  blocked_.reserve(surface_particles);
  forces_.reserve(surface_particles);
}

void ParticleContacts::begin(const SoftBody& body) {
  for (const Contact& contact : particles_) slot_[contact.particle] = -1;
  particles_.clear();
  blocked_.clear();
  forces_.clear();
  predicted_ = body.positions;
}

bool ParticleContacts::touches(std::int32_t particle) const {
  return slot_[particle] >= 0 && particles_[slot_[particle]].planes > 0;
}

void ParticleContacts::set_plane(const SoftBody& body, std::int32_t particle, const ContactPlane& plane) {
  if (slot_[particle] < 0) {
    slot_[particle] = static_cast<std::int32_t>(particles_.size());
    particles_.emplace_back().particle = particle;
  }
  Contact& contact = particles_[slot_[particle]];
  if (contact.planes == 0)
    contact.push = body.masses[particle] * (body.positions.at(particle) - predicted_.at(particle));
  int k = 0;
  while (k < contact.planes && contact.plane[k].source != plane.source) ++k;
  if (k == 3) return;
  contact.plane[k] = plane;
  contact.planes = std::max(contact.planes, k + 1);
  contact.moved = true;
  // First guess: the friction of the contact alone, before the volume presses.
  const Basis basis = basis_of(contact);
  const Vec3 free = predicted_.at(particle) + body.inverse_masses[particle] * contact.push;
  const double depth = (onto_planes(contact, free) - free).norm();
  const Vec3 slip = basis.tangential(free - body.start_positions.at(particle) - mean_shift(contact));
  const double limit = mean_friction(contact) * depth, length = slip.norm();
  contact.sticking = length <= limit;
  contact.friction = contact.sticking ? Vec3::Zero() : Vec3(-slip * (limit / length));
}

Vec3 ParticleContacts::target(const SoftBody& body, const Contact& contact) const {
  const std::int32_t i = contact.particle;
  if (contact.planes > 0 && contact.sticking)
    return onto_planes(contact, body.start_positions.at(i) + mean_shift(contact));
  const Vec3 free = predicted_.at(i) + body.inverse_masses[i] * contact.push;
  return contact.planes > 0 ? onto_planes(contact, free + contact.friction) : free;
}

void ParticleContacts::place(SoftBody& body) {
  blocked_.clear();
  forces_.clear();
  for (Contact& contact : particles_) {
    if (contact.moved) body.positions.set(contact.particle, target(body, contact));
    contact.moved = false;
    if (contact.planes == 0) continue;
    const Eigen::Matrix3d free = contact.sticking ? Eigen::Matrix3d::Zero() : basis_of(contact).projector();
    blocked_.push_back({contact.particle, body.inverse_masses[contact.particle] * free});
    forces_.push_back(Vec3::Zero());
  }
}

bool ParticleContacts::update(const SoftBody& body, bool may_release) {
  bool changed = false;
  for (std::size_t b = 0; b < blocked_.size(); ++b) {
    const std::int32_t i = blocked_[b].particle;
    Contact& contact = particles_[slot_[i]];
    contact.push += forces_[b];
    const Vec3 reaction = body.masses[i] * (body.positions.at(i) - predicted_.at(i)) - contact.push;
    if (may_release && release(contact, reaction)) {
      changed = true;
      continue;
    }
    changed |= rub(body, contact, reaction);
  }
  return changed;
}

// r = Σ N_k n_k + tangential; the plane with the most negative N_k lets go.
bool ParticleContacts::release(Contact& contact, const Vec3& reaction) {
  Eigen::Matrix3d gram = Eigen::Matrix3d::Identity();
  Vec3 pressed = Vec3::Zero();
  for (int a = 0; a < contact.planes; ++a) {
    pressed[a] = contact.plane[a].normal.dot(reaction);
    for (int b = 0; b < contact.planes; ++b)
      gram(a, b) = contact.plane[a].normal.dot(contact.plane[b].normal);
  }
  const Vec3 forces = contact.planes > 1 ? Vec3(gram.ldlt().solve(pressed)) : pressed;
  int worst = 0;
  for (int k = 1; k < contact.planes; ++k)
    if (forces[k] < forces[worst]) worst = k;
  contact.pressing = forces[worst] > 0.0;
  if (!(forces[worst] < 0.0)) return false;
  for (int k = worst; k + 1 < contact.planes; ++k) contact.plane[k] = contact.plane[k + 1];
  --contact.planes;
  contact.sticking = false;
  contact.friction.setZero();
  contact.moved = true;
  return true;
}

// Coulomb: a sticking particle whose reaction leaves the cone slips; a slipping one is opposed by μN, and
// sticks when that would turn its slip around.
bool ParticleContacts::rub(const SoftBody& body, Contact& contact, const Vec3& reaction) {
  const double friction = mean_friction(contact);
  if (friction == 0.0) return false;
  const Basis basis = basis_of(contact);
  const std::int32_t i = contact.particle;
  const Vec3 tangential = basis.tangential(reaction);
  const double pressure = (reaction - tangential).norm(), w = body.inverse_masses[i];
  if (contact.sticking) {
    if (tangential.norm() <= friction * pressure * (1.0 + friction_tolerance)) return false;
    contact.sticking = false;
    contact.friction = tangential.normalized() * (friction * pressure * w);
    return contact.moved = true;
  }
  const Vec3 slip = basis.tangential(body.positions.at(i) - body.start_positions.at(i) - mean_shift(contact));
  const double length = slip.norm();
  const Vec3 wanted = length > 0.0 ? Vec3(-slip * (friction * pressure * w / length)) : Vec3::Zero();
  if (slip.dot(contact.friction) > 0.0 && length > 0.0) {
    contact.sticking = true;
    return contact.moved = true;
  }
  const double change = (wanted - contact.friction).norm();
  if (change <= friction_tolerance * wanted.norm()) return false;
  // What friction could take at most is the slip itself.
  contact.sticking = wanted.norm() - contact.friction.norm() >= length;
  contact.friction = contact.sticking ? Vec3::Zero() : wanted;
  return contact.moved = true;
}

void ParticleContacts::bounce(SoftBody& body, double h) const {
  for (const Contact& contact : particles_) {
    for (int k = 0; k < contact.planes; ++k) {
      const ContactPlane& plane = contact.plane[k];
      if (plane.restitution == 0.0 || plane.approach > -rest_speed) continue;
      const Vec3 surface = plane.surface_shift / h;
      const double now = plane.normal.dot(body.velocities.at(contact.particle) - surface);
      const double wanted = -plane.restitution * plane.approach;
      if (now < wanted) body.velocities.add(contact.particle, (wanted - now) * plane.normal);
    }
  }
}

std::int64_t ParticleContacts::bytes() const {
  return static_cast<std::int64_t>(
      3 * predicted_.size() * sizeof(double) + particles_.capacity() * sizeof(Contact) +
      blocked_.capacity() * sizeof(BlockedParticle) + forces_.capacity() * sizeof(Vec3) +
      slot_.capacity() * sizeof(std::int32_t));
}

}  // namespace isochor

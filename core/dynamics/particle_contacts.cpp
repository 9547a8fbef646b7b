#include "core/dynamics/particle_contacts.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/collision/contact_response.h"

namespace isochor {
namespace {

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
  constexpr int passes = 2;  // from 1e17 m away, round-off leaves the first one anywhere
  for (int pass = 0; pass < passes; ++pass) {
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

/// N_k of r = Σ N_k n_k + tangential.
Vec3 normal_forces(const ParticleContact& contact, const Vec3& reaction) {
  Eigen::Matrix3d gram = Eigen::Matrix3d::Identity();
  Vec3 pressed = Vec3::Zero();
  for (int a = 0; a < contact.planes; ++a) {
    pressed[a] = contact.plane[a].normal.dot(reaction);
    for (int b = 0; b < contact.planes; ++b)
      gram(a, b) = contact.plane[a].normal.dot(contact.plane[b].normal);
  }
  return contact.planes > 1 ? Vec3(gram.ldlt().solve(pressed)) : pressed;
}

}  // namespace

ContactDirections directions_of(const ParticleContact& contact) {
  ContactDirections directions;
  Basis basis;
  std::array<int, 3> kept{};
  for (int k = 0; k < contact.planes; ++k) {
    const int before = basis.size;
    basis.add(contact.plane[k].normal);
    if (basis.size > before) kept[before] = k;
  }
  Eigen::Matrix3d gram = Eigen::Matrix3d::Identity();
  for (int a = 0; a < basis.size; ++a)
    for (int b = 0; b < basis.size; ++b)
      gram(a, b) = contact.plane[kept[a]].normal.dot(contact.plane[kept[b]].normal);
  directions.normal_space = Eigen::Matrix3d::Identity() - basis.projector();
  if (basis.size == 1) {  // nearly all
    const Vec3& normal = contact.plane[kept[0]].normal;
    directions.dual[kept[0]] = (1.0 / normal.dot(normal)) * normal;
    return directions;
  }
  const Eigen::Matrix3d inverse = gram.inverse();
  for (int a = 0; a < basis.size; ++a)
    for (int b = 0; b < basis.size; ++b)
      directions.dual[kept[a]] += inverse(a, b) * contact.plane[kept[b]].normal;
  return directions;
}

ParticleContacts::ParticleContacts(const SoftBody& body)
    : predicted_(body.size()), slot_(body.size(), -1), memory_slot_(body.size(), -1) {
  const std::size_t surface_particles = body.surface_particles.size();
  particles_.reserve(surface_particles);
  blocked_.reserve(surface_particles);
  forces_.reserve(surface_particles);
  frictions_.reserve(surface_particles);
  memory_.reserve(surface_particles);
  held_back_.reserve(surface_particles);
}

void ParticleContacts::begin(const SoftBody& body, double h, std::span<const MassiveBody> bodies,
                             bool with_body) {
  with_body_ = with_body;
  carriers_.begin(bodies);
  for (const Contact& contact : particles_) slot_[contact.particle] = -1;
  particles_.clear();
  blocked_.clear();
  forces_.clear();
  predicted_ = body.positions;
  h_ = h;
}

void ParticleContacts::remember() {
  for (const Memory& memory : memory_) memory_slot_[memory.particle] = -1;
  memory_.clear();
  for (const Contact& contact : particles_) {
    if (contact.planes == 0 || contact.attached) continue;
    memory_slot_[contact.particle] = static_cast<std::int32_t>(memory_.size());
    memory_.push_back({contact.particle, contact.friction / (h_ * h_), contact.sticking});
  }
}

const ParticleContacts::Memory* ParticleContacts::recall(std::int32_t particle) const {
  return memory_slot_[particle] < 0 ? nullptr : &memory_[memory_slot_[particle]];
}

bool ParticleContacts::touches(std::int32_t particle) const {
  return slot_[particle] >= 0 && particles_[slot_[particle]].planes > 0;
}

const ContactPlane* ParticleContacts::plane_of(std::int32_t particle, int source) const {
  if (slot_[particle] < 0) return nullptr;
  const Contact& contact = particles_[slot_[particle]];
  for (int k = 0; k < contact.planes; ++k)
    if (contact.plane[k].source == source) return &contact.plane[k];
  return nullptr;
}

bool ParticleContacts::attach(const SoftBody& body, std::int32_t particle, int source, const Vec3& anchor,
                              double slop) {
  if (slot_[particle] < 0) {
    slot_[particle] = static_cast<std::int32_t>(particles_.size());
    Contact& contact = particles_.emplace_back();
    contact.particle = particle;
    contact.plane[0].source = source;
    contact.planes = 1;
    contact.sticking = contact.attached = true;
    contact.push = body.masses[particle] * (body.positions.at(particle) - predicted_.at(particle));
  }
  Contact& contact = particles_[slot_[particle]];
  contact.anchor = anchor;
  return contact.moved = (anchor - body.positions.at(particle)).norm() > slop;
}

bool ParticleContacts::renew_plane(const SoftBody& body, std::int32_t particle, const ContactPlane& plane,
                                   double slop) {
  Contact& contact = particles_[slot_[particle]];
  for (int k = 0; k < contact.planes; ++k)
    if (contact.plane[k].source == plane.source) contact.plane[k] = plane;
  const Vec3 x = body.positions.at(particle);
  const Vec3 off = contact.sticking ? target(body, contact) - x : onto_planes(contact, x) - x;
  if (off.norm() <= slop) return false;
  return contact.moved = true;
}

void ParticleContacts::set_plane(const SoftBody& body, std::int32_t particle, const ContactPlane& plane) {
  if (slot_[particle] < 0) {
    slot_[particle] = static_cast<std::int32_t>(particles_.size());
    particles_.emplace_back().particle = particle;
    particles_.back().moved = false;
  }
  Contact& contact = particles_[slot_[particle]];
  // Of one just released, still where the contact held it, the push is known, and bodies with a mass must not
  // feel more. Against the others the whole displacement counts, or impacts at 100 m/s on a thin plate pass
  // through it: released and found in turn, particles would be set back to where their speed has carried
  // them.
  const bool known = contact.moved && carriers_.carries(plane.source);
  if (contact.planes == 0 && !known)
    contact.push = body.masses[particle] * (body.positions.at(particle) - predicted_.at(particle));
  int k = 0;
  while (k < contact.planes && contact.plane[k].source != plane.source) ++k;
  if (k == 3) return;
  contact.plane[k] = plane;
  contact.planes = std::max(contact.planes, k + 1);
  contact.moved = true;
  guess_friction(body, contact);
}

// As in the substep before. A new contact is pressed by what it pushes out of the way alone, and held by it.
void ParticleContacts::guess_friction(const SoftBody& body, Contact& contact) const {
  const std::int32_t i = contact.particle;
  if (const Memory* memory = recall(i)) {
    contact.sticking = memory->sticking;
    contact.friction = h_ * h_ * basis_of(contact).tangential(memory->friction);
    return;
  }
  const Vec3 free = predicted_.at(i) + body.inverse_masses[i] * contact.push;
  const double mass = carriers_.friction_share(contact, body.masses[i]) * body.masses[i];
  const double pressure = mass * (onto_planes(contact, free) - free).norm();
  const Vec3 slip = basis_of(contact).tangential(free - body.start_positions.at(i) - mean_shift(contact));
  const Vec3 holding = -mass * slip;
  contact.friction = clamp_to_cone(holding, mean_friction(contact), pressure);
  contact.sticking = holding.norm() <= mean_friction(contact) * pressure;
}

Vec3 ParticleContacts::target(const SoftBody& body, const Contact& contact) const {
  const std::int32_t i = contact.particle;
  if (contact.attached) return contact.anchor;
  if (contact.planes > 0 && contact.sticking)
    return onto_planes(contact, body.start_positions.at(i) + mean_shift(contact));
  if (with_body_) return onto_planes(contact, body.positions.at(i));
  const Vec3 free = predicted_.at(i) + body.inverse_masses[i] * contact.push;
  return contact.planes > 0 ? onto_planes(contact, free + body.inverse_masses[i] * contact.friction) : free;
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

void ParticleContacts::let_slide(const SoftBody& body) {
  for (BlockedParticle& blocked : blocked_) {
    const Contact& contact = particles_[slot_[blocked.particle]];
    if (!contact.attached)
      blocked.inverse_mass = body.inverse_masses[blocked.particle] * basis_of(contact).projector();
  }
}

std::span<const Vec3> ParticleContacts::frictions() {
  frictions_.clear();
  for (const BlockedParticle& blocked : blocked_) {
    const Contact& contact = particles_[slot_[blocked.particle]];
    frictions_.push_back(contact.sticking ? Vec3(Vec3::Zero()) : contact.friction);
  }
  return frictions_;
}

void ParticleContacts::set_reactions(const SoftBody& body, std::span<const Vec3> reactions) {
  predicted_ = body.positions;
  for (std::size_t b = 0; b < blocked_.size(); ++b) {
    const std::int32_t i = blocked_[b].particle;
    particles_[slot_[i]].push.setZero();
    predicted_.add(i, -body.inverse_masses[i] * reactions[b]);
  }
}

Vec3 ParticleContacts::respond(const SoftBody& body, std::int32_t particle, const Vec3& force) const {
  Vec3 free = body.inverse_masses[particle] * force;
  if (!touches(particle)) return free;
  const Contact& contact = particles_[slot_[particle]];
  return contact.sticking ? Vec3(Vec3::Zero()) : basis_of(contact).tangential(free);
}

void ParticleContacts::take_forces(double scale) {
  for (std::size_t b = 0; b < blocked_.size(); ++b) {
    particles_[slot_[blocked_[b].particle]].push += scale * forces_[b];
    forces_[b].setZero();
  }
}

bool ParticleContacts::update(const SoftBody& body, bool may_release) {
  bool changed = false;
  double rubbed = 0.0, limits = 0.0;  // of friction
  take_forces();
  for (std::size_t b = 0; b < blocked_.size(); ++b) {
    const std::int32_t i = blocked_[b].particle;
    Contact& contact = particles_[slot_[i]];
    if (contact.attached) continue;
    const Vec3 reaction = this->reaction(body, contact);
    if (may_release && release(contact, reaction)) {
      changed = true;
      continue;
    }
    const double coefficient = mean_friction(contact);
    if (coefficient == 0.0) continue;
    const Vec3 tangential = basis_of(contact).tangential(reaction);
    const double limit = coefficient * (reaction - tangential).norm();
    limits += limit;
    rubbed += rub(body, contact, tangential, limit);
  }
  return changed || rubbed > friction_tolerance * limits;
}

// The plane with the most negative N_k lets go.
bool ParticleContacts::release(Contact& contact, const Vec3& reaction) {
  const Vec3 forces = normal_forces(contact, reaction);
  int worst = 0;
  for (int k = 1; k < contact.planes; ++k)
    if (forces[k] < forces[worst]) worst = k;
  if (!(forces[worst] < 0.0)) return false;
  for (int k = worst; k + 1 < contact.planes; ++k) contact.plane[k] = contact.plane[k + 1];
  --contact.planes;
  contact.sticking = false;
  contact.friction.setZero();
  contact.moved = true;
  return true;
}

// Coulomb's cone |t| ≤ μN. A sticking particle whose reaction leaves it is torn off. A slipping one gets the
// friction that would have held it, t − m·slip, cut to the cone (projected Jacobi; m is at most the mass that
// the slip moves, so this never overshoots); within the cone it sticks, unless it was torn off before.
// Returns by how much the friction has changed.
double ParticleContacts::rub(const SoftBody& body, Contact& contact, const Vec3& tangential, double limit) {
  if (contact.sticking) {
    contact.friction = clamp_to_cone(tangential, 1.0, limit);
    if (tangential.norm() <= limit * (1.0 + friction_tolerance)) return 0.0;
    contact.sticking = false;
    contact.torn = contact.moved = true;
    return tangential.norm() - limit;
  }
  const std::int32_t i = contact.particle;
  const Vec3 slip =
      basis_of(contact).tangential(body.positions.at(i) - body.start_positions.at(i) - mean_shift(contact));
  const Vec3 holding =
      contact.friction - carriers_.friction_share(contact, body.masses[i]) * body.masses[i] * slip;
  const Vec3 before = contact.friction;
  contact.friction = clamp_to_cone(holding, 1.0, limit);
  contact.sticking = !contact.torn && holding.norm() < limit;
  contact.moved = true;
  return (contact.friction - before).norm();
}

std::span<const DueWrench> ParticleContacts::bounce(SoftBody& body, double h) {
  gains_.clear();
  for (const Contact& contact : particles_) {
    for (int k = 0; k < contact.planes && !contact.attached; ++k) {
      const ContactPlane& plane = contact.plane[k];
      if (plane.restitution == 0.0 || plane.approach > -rest_speed) continue;
      const Vec3 surface = plane.surface_shift / h;
      const double now = plane.normal.dot(body.velocities.at(contact.particle) - surface);
      const double wanted = -plane.restitution * plane.approach;
      if (now >= wanted) continue;
      if (carriers_.carries(plane.source))
        gains_.push_back({contact.particle, plane.source, plane.normal, wanted - now});
      else
        body.velocities.add(contact.particle, (wanted - now) * plane.normal);
    }
  }
  return carriers_.bounce(body, gains_);
}

void ParticleContacts::hold_back(SoftBody& body, double seconds, const Vec3& gravity) {
  held_back_.clear();
  if (!carriers_.empty()) return;
  for (const auto& [i, inverse_mass] : blocked_) {
    Vec3 kick = seconds * gravity;
    if (body.forces.size() > 0) kick += seconds * body.inverse_masses[i] * body.forces.at(i);
    held_back_.push_back({i, kick - body.masses[i] * (inverse_mass * kick)});
    body.velocities.add(i, -held_back_.back().velocity);
  }
}

void ParticleContacts::give_back(SoftBody& body) const {
  for (const HeldKick& held : held_back_) body.velocities.add(held.particle, held.velocity);
}

Vec3 ParticleContacts::reaction(const SoftBody& body, const Contact& contact) const {
  const std::int32_t i = contact.particle;
  return body.masses[i] * (body.positions.at(i) - predicted_.at(i)) - contact.push;
}

Vec3 ParticleContacts::push(const SoftBody& body) const {
  Vec3 sum = Vec3::Zero();
  for (const Contact& contact : particles_)
    if (contact.planes > 0) sum += reaction(body, contact);
  return sum;
}

bool ParticleContacts::emerging() const {
  return std::ranges::any_of(particles_, [](const Contact& contact) {
    return std::any_of(contact.plane.begin(), contact.plane.begin() + contact.planes,
                       [](const ContactPlane& plane) { return plane.emerging > 0.0; });
  });
}

bool ParticleContacts::on_the_move() const {
  return std::ranges::any_of(particles_,
                             [](const Contact& contact) { return !mean_shift(contact).isZero(0.0); });
}

double ParticleContacts::work(const SoftBody& body) const {
  double sum = 0.0;
  for (const Contact& contact : particles_)
    if (contact.planes > 0) sum += reaction(body, contact).dot(mean_shift(contact));
  return sum / (h_ * h_);
}

double ParticleContacts::emerging_work(const SoftBody& body) const {
  double sum = 0.0;
  for (const Contact& contact : particles_) {
    const ContactDirections directions = directions_of(contact);
    const Vec3 pushed = reaction(body, contact);
    for (int k = 0; k < contact.planes; ++k)
      sum += contact.plane[k].emerging * std::max(directions.dual[k].dot(pushed), 0.0);
  }
  return sum / (h_ * h_);
}

std::int64_t ParticleContacts::bytes() const {
  return static_cast<std::int64_t>(
      3 * predicted_.size() * sizeof(double) + particles_.capacity() * sizeof(Contact) +
      blocked_.capacity() * sizeof(BlockedParticle) +
      (forces_.capacity() + frictions_.capacity()) * sizeof(Vec3) + memory_.capacity() * sizeof(Memory) +
      held_back_.capacity() * sizeof(HeldKick) +
      (slot_.capacity() + memory_slot_.capacity()) * sizeof(std::int32_t));
}

}  // namespace isochor

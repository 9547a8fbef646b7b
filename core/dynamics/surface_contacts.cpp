#include "core/dynamics/surface_contacts.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/collision/contact_response.h"

namespace isochor {
namespace {

/// Contacts share particles: of the friction that would hold each of them alone, this part a round.
constexpr double friction_share = 0.3;
constexpr int bounce_sweeps = 50;
constexpr int most_iterations = 60;

// In cells. A probe is large enough for the volumes' tolerance not to matter and small enough to be linear.
constexpr double most_recalled = 0.2, least_probe = 0.01, largest_probe = 0.1, longest_step = 0.3;
/// Of the volume that a probe changes, this part may be left of it.
constexpr double probe_accuracy = 0.02;

template <class Visit>
void for_particles(const SurfaceContact& contact, const Visit& visit) {
  visit(contact.owner, contact.vertex, 1.0);
  for (int k = 0; k < 3; ++k) visit(contact.other, contact.triangle[k], -contact.weights[k]);
}

void extrapolate(const Coordinates& base, double factor, Coordinates& x) {
  const auto along = [&](const std::vector<double>& from, std::vector<double>& to) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = from[i] + factor * (to[i] - from[i]);
  };
  along(base.x, x.x), along(base.y, x.y), along(base.z, x.z);
}

double largest_difference(const Coordinates& a, const Coordinates& b) {
  double square = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) square = std::max(square, (a.at(i) - b.at(i)).squaredNorm());
  return std::sqrt(square);
}

}  // namespace

SurfaceContacts::SurfaceContacts(std::span<const std::size_t> particles) {
  for (const std::size_t count : particles) {
    slots_.emplace_back(count, -1);
    base_.emplace_back(count);
  }
}

void SurfaceContacts::reserve(std::size_t vertices) {
  contacts_.reserve(2 * vertices);
  rows_.reserve(2 * vertices);
  memory_.reserve(2 * vertices);
  bounces_.reserve(2 * vertices);
}

void SurfaceContacts::begin(std::span<SurfaceBody> bodies, double h) {
  for (const SurfaceContact& contact : contacts_) slots_[contact.owner][contact.vertex] = -1;
  contacts_.clear();
  bodies_ = bodies;
  h_ = h;
  for (SurfaceBody& body : bodies_) body.touched = false;
}

void SurfaceContacts::remember() {
  memory_.clear();
  for (const SurfaceContact& contact : contacts_) {
    if (!(contact.pressure() > 0.0)) continue;
    memory_.push_back({contact.owner, contact.other, contact.vertex, contact.pressure() / (h_ * h_),
                       contact.tangential(contact.impulse) / (h_ * h_)});
  }
  std::ranges::sort(memory_, {}, [](const Memory& m) { return std::tie(m.owner, m.vertex, m.other); });
}

const SurfaceContacts::Memory* SurfaceContacts::recall(int owner, std::int32_t vertex, int other) const {
  const auto key = [](const Memory& m) { return std::tuple(m.owner, m.vertex, m.other); };
  const auto found = std::ranges::lower_bound(memory_, std::tuple(owner, vertex, other), {}, key);
  return found != memory_.end() && key(*found) == std::tuple(owner, vertex, other) ? &*found : nullptr;
}

bool SurfaceContacts::knows(int owner, std::int32_t vertex, int other) const {
  return recall(owner, vertex, other) != nullptr;
}

void SurfaceContacts::add(SurfaceContact contact) {
  contact.mobility = 0.0;
  contact.approach = 0.0;
  for_particles(contact, [&](int b, std::int32_t i, double c) {
    SurfaceBody& body = bodies_[b];
    body.touched = true;
    contact.mobility += c * c * body.body->inverse_masses[i];
    contact.approach += c * contact.normal.dot(body.body->start_velocities.at(i));
  });
  if (!(contact.mobility > 0.0)) return;
  std::int32_t& slot = slots_[contact.owner][contact.vertex];
  contact.next = slot;
  slot = static_cast<std::int32_t>(contacts_.size());
  contacts_.push_back(contact);
}

void SurfaceContacts::renew(std::int32_t index, const Triangle& triangle, const Vec3& normal,
                            const Vec3& weights, double least_gap) {
  SurfaceContact& contact = contacts_[index];
  const double pressure = contact.pressure();
  const Vec3 friction = contact.tangential(contact.impulse);
  const bool loaded = !contact.impulse.isZero(0.0);
  if (loaded) push(contact, -contact.impulse);
  contact.triangle = triangle;
  contact.normal = normal;
  contact.weights = weights;
  contact.least_gap = least_gap;
  contact.mobility = 0.0;
  for_particles(contact, [&](int b, std::int32_t i, double c) {
    contact.mobility += c * c * bodies_[b].body->inverse_masses[i];
  });
  contact.impulse = pressure * normal + contact.tangential(friction);
  if (loaded) push(contact, contact.impulse);
}

void SurfaceContacts::recall() {
  double farthest = 0.0;
  for (SurfaceContact& contact : contacts_) {
    const Memory* memory = recall(contact.owner, contact.vertex, contact.other);
    if (!memory || contact.next >= 0) continue;
    contact.impulse = h_ * h_ * (memory->pressure * contact.normal + contact.tangential(memory->friction));
    for_particles(contact, [&](int b, std::int32_t i, double c) {
      const SoftBody& body = *bodies_[b].body;
      const double moved = std::abs(c) * body.inverse_masses[i] * contact.impulse.norm();
      farthest = std::max(farthest, moved / body.cell_size);
    });
  }
  const double scale = farthest > most_recalled ? most_recalled / farthest : 1.0;
  for (SurfaceContact& contact : contacts_) {
    contact.impulse *= scale;
    push(contact, contact.impulse);
  }
}

Vec3 SurfaceContacts::arm(const SurfaceContact& contact, Coordinates SoftBody::*positions) const {
  Vec3 sum = Vec3::Zero();
  for_particles(contact,
                [&](int b, std::int32_t i, double c) { sum += c * (bodies_[b].body->*positions).at(i); });
  return sum;
}

Vec3 SurfaceContacts::slip(const SurfaceContact& contact) const {
  return contact.tangential(arm(contact, &SoftBody::positions) - arm(contact, &SoftBody::start_positions));
}

void SurfaceContacts::displace(const SurfaceContact& contact, const Vec3& impulse) {
  for_particles(contact, [&](int b, std::int32_t i, double c) {
    const SurfaceBody& body = bodies_[b];
    const Vec3 force = c * impulse;
    body.body->positions.add(i, body.contacts ? body.contacts->respond(*body.body, i, force)
                                              : Vec3(body.body->inverse_masses[i] * force));
  });
}

void SurfaceContacts::load(const SurfaceContact& contact, const Vec3& impulse) {
  for_particles(contact, [&](int b, std::int32_t i, double c) {
    const SurfaceBody& body = bodies_[b];
    if (body.contacts) body.contacts->shift(i, c * body.body->inverse_masses[i] * impulse);
  });
}

void SurfaceContacts::push(const SurfaceContact& contact, const Vec3& impulse) {
  displace(contact, impulse);
  load(contact, impulse);
}

double SurfaceContacts::find_lack() {
  double worst = 0.0;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const SurfaceContact& contact = contacts_[c];
    const double lack = contact.least_gap - gap(contact);
    rows_[c].lack = lack > 0.0 || contact.pressure() > 0.0 ? lack : 0.0;
    worst = std::max(worst, std::abs(rows_[c].lack) / bodies_[contact.owner].body->cell_size);
  }
  return worst;
}

// p = z + βp, z = e/Σc²w, β after Polak and Ribière.
void SurfaceContacts::choose_direction(bool restart) {
  double gain = 0.0, size = 0.0;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Row& row = rows_[c];
    gain += row.lack * (row.lack - row.lack_before) / contacts_[c].mobility;
    size += row.lack * row.lack / contacts_[c].mobility;
  }
  const double beta = restart || !(size_before_ > 0.0) ? 0.0 : std::max(0.0, gain / size_before_);
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    Row& row = rows_[c];
    row.direction = row.lack == 0.0 ? 0.0 : row.lack / contacts_[c].mobility + beta * row.direction;
    row.lack_before = row.lack;
  }
  size_before_ = size;
}

bool SurfaceContacts::solve(BodyProjector& projector, double volume_tolerance, double tolerance) {
  rows_.assign(contacts_.size(), Row{});
  bool restart = true;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    if (find_lack() <= tolerance) return true;
    choose_direction(restart);
    const Step taken = step(projector, volume_tolerance);
    if (taken == Step::none) return false;
    restart = taken == Step::bounded;
  }
  return find_lack() <= tolerance;
}

bool SurfaceContacts::holds(double tolerance) {
  rows_.resize(contacts_.size());
  return find_lack() <= tolerance;
}

double SurfaceContacts::farthest_from_base() const {
  double farthest = 0.0;
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (bodies_[b].touched)
      farthest = std::max(
          farthest, largest_difference(bodies_[b].body->positions, base_[b]) / bodies_[b].body->cell_size);
  return farthest;
}

void SurfaceContacts::scale_from_base(double factor) {
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (bodies_[b].touched) extrapolate(base_[b], factor, bodies_[b].body->positions);
}

void SurfaceContacts::back_to_base() {
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (bodies_[b].touched) bodies_[b].body->positions = base_[b];
}

/// Probes how the gaps respond to the direction, volumes kept.
double SurfaceContacts::probe(BodyProjector& projector, double volume_tolerance) {
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (bodies_[b].touched) base_[b] = bodies_[b].body->positions;
  for (std::size_t c = 0; c < contacts_.size(); ++c)
    displace(contacts_[c], rows_[c].direction * contacts_[c].normal);
  const double size = farthest_from_base();
  if (!(size > 0.0) || !std::isfinite(size)) {
    back_to_base();
    return 0.0;
  }
  const double probe = std::clamp(size, least_probe, largest_probe);
  scale_from_base(probe / size);
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (bodies_[b].touched)
      projector.project(static_cast<int>(b), std::max(volume_tolerance, probe_accuracy * probe));
  return probe / size;
}

SurfaceContacts::Step SurfaceContacts::step(BodyProjector& projector, double volume_tolerance) {
  const double scale = probe(projector, volume_tolerance);
  if (scale == 0.0) return Step::none;
  double curvature = 0.0, slope = 0.0;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    double response = 0.0;
    for_particles(contacts_[c], [&](int b, std::int32_t i, double weight) {
      response += weight * contacts_[c].normal.dot(bodies_[b].body->positions.at(i) - base_[b].at(i));
    });
    curvature += rows_[c].direction * response / scale;
    slope += rows_[c].direction * rows_[c].lack;
  }
  if (!(curvature > 0.0) || !(slope > 0.0)) {
    back_to_base();
    return Step::none;
  }
  const double longest = longest_step * scale / farthest_from_base();
  Step taken = slope / curvature > longest ? Step::bounded : Step::whole;
  const double length = std::min(slope / curvature, longest);
  scale_from_base(length / scale);
  take_forces(length / scale);
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    SurfaceContact& contact = contacts_[c];
    const Vec3 wanted = contact.impulse + length * rows_[c].direction * contact.normal;
    const bool pulls = contact.normal.dot(wanted) < 0.0;
    const Vec3 allowed = pulls ? Vec3(Vec3::Zero()) : wanted;
    load(contact, allowed - contact.impulse);
    if (pulls) displace(contact, -wanted), taken = Step::bounded;
    contact.impulse = allowed;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (bodies_[b].touched) projector.project(static_cast<int>(b), volume_tolerance);
  take_forces(1.0);
  return taken;
}

void SurfaceContacts::take_forces(double scale) {
  for (const SurfaceBody& body : bodies_)
    if (body.touched && body.contacts) body.contacts->take_forces(scale);
}

// Projected Jacobi: t − share·slip/Σc²w, cut to the cone. Where surfaces stick it converges over a few
// substeps, each starting from the last one's. Rows that hold both surfaces' vertices in all directions would
// lock: there are more of them than tangential motions.
bool SurfaceContacts::rub() {
  bool changed = false;
  for (SurfaceContact& contact : contacts_) {
    if (contact.friction == 0.0) continue;
    const double pressure = std::max(contact.pressure(), 0.0);
    const Vec3 before = contact.tangential(contact.impulse);
    const Vec3 holding = before - friction_share * slip(contact) / contact.mobility;
    const Vec3 after = clamp_to_cone(holding, contact.friction, pressure);
    changed |= (after - before).norm() > friction_tolerance * contact.friction * pressure;
    push(contact, after - before);
    contact.impulse += after - before;
  }
  return changed;
}

// Pressures between velocities alone, each contact in turn; none pulls.
void SurfaceContacts::bounce() {
  bounces_.assign(contacts_.size(), 0.0);
  for (int sweep = 0; sweep < bounce_sweeps; ++sweep) {
    double largest = 0.0;
    for (std::size_t c = 0; c < contacts_.size(); ++c) {
      const SurfaceContact& contact = contacts_[c];
      if (contact.restitution == 0.0 || contact.approach > -rest_speed || !(contact.pressure() > 0.0))
        continue;
      double now = 0.0;
      for_particles(contact, [&](int b, std::int32_t i, double weight) {
        now += weight * contact.normal.dot(bodies_[b].body->velocities.at(i));
      });
      const double wanted = -contact.restitution * contact.approach;
      const double gain = std::max((wanted - now) / contact.mobility, -bounces_[c]);
      bounces_[c] += gain;
      largest = std::max(largest, std::abs(gain) * contact.mobility / wanted);
      for_particles(contact, [&](int b, std::int32_t i, double weight) {
        SoftBody& body = *bodies_[b].body;
        body.velocities.add(i, weight * gain * body.inverse_masses[i] * contact.normal);
      });
    }
    if (largest < 1e-3) return;
  }
}

std::int64_t SurfaceContacts::bytes() const {
  std::size_t sum = contacts_.capacity() * sizeof(SurfaceContact) + rows_.capacity() * sizeof(Row) +
                    memory_.capacity() * sizeof(Memory) + bounces_.capacity() * sizeof(double);
  for (const auto& slots : slots_) sum += slots.size() * (sizeof(std::int32_t) + 3 * sizeof(double));
  return static_cast<std::int64_t>(sum);
}

}  // namespace isochor

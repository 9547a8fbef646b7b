#include "core/dynamics/soft_body.h"

#include <cmath>

#include "core/common/wide.h"
#include "core/dynamics/volume_elements.h"
#include "core/parallel/cancel_scope.h"

namespace isochor {
namespace {

ISOCHOR_MULTIVERSION void add_where_free(double* __restrict v, const double* w, std::size_t size, double dv) {
  for (std::size_t i = 0; i < size; ++i) v[i] += w[i] > 0.0 ? dv : 0.0;
}

ISOCHOR_MULTIVERSION void add_scaled(double* __restrict v, const double* w, const double* f, std::size_t size,
                                     double h) {
  for (std::size_t i = 0; i < size; ++i) v[i] += h * w[i] * f[i];
}

ISOCHOR_MULTIVERSION void add_scaled(double* __restrict x, const double* v, std::size_t size, double h) {
  for (std::size_t i = 0; i < size; ++i) x[i] += h * v[i];
}

ISOCHOR_MULTIVERSION void difference_quotient(const double* x, const double* start, double* v,
                                              std::size_t size, double h) {
  for (std::size_t i = 0; i < size; ++i) v[i] = (x[i] - start[i]) / h;
}

double kinetic_energy(const SoftBody& body, const Coordinates& v) {
  throw_if_scope_cancelled();
  double sum = 0.0;
  for (std::size_t i = 0; i < body.size(); ++i) sum += 0.5 * body.masses[i] * v.at(i).squaredNorm();
  return sum;
}

double gravity_energy(const SoftBody& body, const Coordinates& x, const Vec3& gravity) {
  throw_if_scope_cancelled();
  double sum = 0.0;
  for (std::size_t i = 0; i < body.size(); ++i) sum -= body.masses[i] * gravity.dot(x.at(i));
  return sum;
}

double total_energy(const SoftBody& body, const Coordinates& x, const Coordinates& v, const Vec3& gravity) {
  return kinetic_energy(body, v) + spring_energy(body.springs, body.material, x) +
         gravity_energy(body, x, gravity);
}

}  // namespace

Momentum momentum(const SoftBody& body) {
  throw_if_scope_cancelled();
  Momentum sum;
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Vec3 p = body.masses[i] * body.velocities.at(i);
    sum.linear += p;
    sum.angular += body.positions.at(i).cross(p);
  }
  return sum;
}

double kinetic_energy(const SoftBody& body) {
  return kinetic_energy(body, body.velocities);
}

double gravity_energy(const SoftBody& body, const Vec3& gravity) {
  return gravity_energy(body, body.positions, gravity);
}

double total_energy(const SoftBody& body, const Vec3& gravity) {
  return total_energy(body, body.positions, body.velocities, gravity);
}

double start_energy(const SoftBody& body, const Vec3& gravity) {
  return total_energy(body, body.start_positions, body.start_velocities, gravity);
}

CellVolumeErrors volume_errors(const SoftBody& body) {
  throw_if_scope_cancelled();
  const VolumeElements cells(*body.mesh, false);
  CellVolumeErrors errors;
  for (std::int64_t c = 0; c < cells.count(); ++c) {
    const double volume = cells.volume(c, body.positions);
    const double error = std::abs(volume - body.rest_volumes[c]) / body.rest_volumes[c];
    errors.volume += volume;
    if (error > errors.max_cell_error) errors.max_cell_error = error, errors.worst_cell = c;
  }
  return errors;
}

void keep_start(SoftBody& body) {
  throw_if_scope_cancelled();
  body.start_positions = body.positions;
  body.start_velocities = body.velocities;
}

void kick_by_gravity(SoftBody& body, double h, const Vec3& gravity) {
  const double* w = body.inverse_masses.data();
  Coordinates& v = body.velocities;
  add_where_free(v.x.data(), w, body.size(), h * gravity.x());
  add_where_free(v.y.data(), w, body.size(), h * gravity.y());
  add_where_free(v.z.data(), w, body.size(), h * gravity.z());
}

void kick_by_forces(SoftBody& body, double h) {
  const double* w = body.inverse_masses.data();
  Coordinates &v = body.velocities, &f = body.forces;
  add_scaled(v.x.data(), w, f.x.data(), body.size(), h);
  add_scaled(v.y.data(), w, f.y.data(), body.size(), h);
  add_scaled(v.z.data(), w, f.z.data(), body.size(), h);
}

void drift(SoftBody& body, double h) {
  Coordinates &x = body.positions, &v = body.velocities;
  add_scaled(x.x.data(), v.x.data(), body.size(), h);
  add_scaled(x.y.data(), v.y.data(), body.size(), h);
  add_scaled(x.z.data(), v.z.data(), body.size(), h);
}

void velocities_from_positions(SoftBody& body, double h) {
  const Coordinates &x = body.positions, &start = body.start_positions;
  Coordinates& v = body.velocities;
  difference_quotient(x.x.data(), start.x.data(), v.x.data(), body.size(), h);
  difference_quotient(x.y.data(), start.y.data(), v.y.data(), body.size(), h);
  difference_quotient(x.z.data(), start.z.data(), v.z.data(), body.size(), h);
}

void restore_start(SoftBody& body) {
  body.positions = body.start_positions;
  body.velocities = body.start_velocities;
}

}  // namespace isochor

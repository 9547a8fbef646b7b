#pragma once
#include <memory>
#include <string>

#include "core/dynamics/masses.h"
#include "core/dynamics/spring_stencil.h"
#include "core/dynamics/volume_projector.h"

namespace isochor {

/// A deformable body: what is made once, and below it what steps.
struct SoftBody {
  std::shared_ptr<const TetMesh> mesh;
  std::vector<Vec3> rest_positions;    ///< in the world
  std::vector<double> rest_volumes;    ///< m³ a cell
  double rest_volume = 0.0;            ///< their sum
  double cell_size = 0.0;              ///< m
  double total_mass = 0.0;             ///< kg
  bool has_pins = false;               ///< some inverse mass is 0
  std::vector<double> masses;          ///< kg
  std::vector<double> inverse_masses;  ///< 0 where pinned
  SpringMaterial material;
  SpringStencil springs;
  std::vector<std::int32_t> surface_particles;  ///< those of mesh->surface, ascending
  std::unique_ptr<VolumeProjector> projector;
  double friction = 0.3, restitution = 0.0;

  Coordinates positions, velocities;
  Coordinates start_positions, start_velocities;  ///< at the start of the substep
  Coordinates forces;                             ///< empty without springs

  std::size_t size() const { return positions.size(); }
};

struct Momentum {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();  ///< angular: about the world's origin
};
Momentum momentum(const SoftBody& body);
double kinetic_energy(const SoftBody& body);
/// Of motion, springs and gravity.
double total_energy(const SoftBody& body, const Vec3& gravity);
double start_energy(const SoftBody& body, const Vec3& gravity);    ///< that of the substep's start
double gravity_energy(const SoftBody& body, const Vec3& gravity);  ///< −Σ m g·x

/// Errors of the volumes that the body has now, cell by cell.
struct CellVolumeErrors {
  double volume = 0.0;  ///< ΣV
  double max_cell_error = 0.0;
  std::int64_t worst_cell = -1;
};
CellVolumeErrors volume_errors(const SoftBody& body);

/// A substep begins: start_* take what is now.
void keep_start(SoftBody& body);
/// v += h·g for the particles that are not pinned.
void kick_by_gravity(SoftBody& body, double h, const Vec3& gravity);
/// v += h·w·f.
void kick_by_forces(SoftBody& body, double h);
/// x += h·v.
void drift(SoftBody& body, double h);

/// v = (x − x_start)/h.
void velocities_from_positions(SoftBody& body, double h);

/// x, v of the substep's start.
void restore_start(SoftBody& body);

}  // namespace isochor

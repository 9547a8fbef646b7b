#pragma once
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/dynamics/coordinates.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// What a volume solver needs to know of a body, made once: its cells, rest volumes and inverse masses.
struct VolumeModel {
  const TetMesh* mesh = nullptr;       ///< outlives the solver; cells[c].corners index the particles
  std::vector<double> rest_volumes;    ///< m³ a cell (or a tet, when per_tet)
  std::vector<double> inverse_masses;  ///< 1/kg a particle; 0 where pinned
  bool per_tet = false;                ///< five constraints a cell instead of one, to show that it locks
};

/// A particle that cannot move freely within this projection: W = w·(I − Σ n·nᵀ) for contact normals n,
/// zero when nothing is left. Directions in the kernel of W keep the position they come in with.
struct BlockedParticle {
  std::int32_t particle;
  Eigen::Matrix3d inverse_mass;
};

/// A particle in contact with a rigid body that is free to move: along the contact its displacement is that
/// of the body, Δx = map·q, with q the body's small translation and rotation about its centre of mass.
struct CarriedParticle {
  std::int32_t particle;
  Eigen::Matrix<double, 3, 6> map;  ///< (n·nᵀ)·(I, −[r]×) for a contact, (I, −[r]×) for an attachment
};
/// Adds B·W₆·Bᵀ to W, a term of rank six: the volume pushes the body as well as the particles, momentum kept.
struct RigidCarrier {
  std::span<const CarriedParticle> particles;  ///< their own W is blocked along map; they stand in `blocked`
  Eigen::Matrix<double, 6, 6> inverse_mass;    ///< of the body with Σ mapᵀ·m·map of its particles added
  Eigen::Matrix<double, 6, 1> motion = Eigen::Matrix<double, 6, 1>::Zero();  ///< out: q, summed
};

struct ProjectionRequest {
  const Coordinates* start =
      nullptr;  ///< start-of-step positions: constraint directions are taken here (SHAKE)
  std::span<const BlockedParticle> blocked = {};
  /// Out, one a blocked particle, or empty: Jᵀμ summed over the iterations (kg·m). Contacts read from it what
  /// the volume presses on them, for friction and release.
  std::span<Vec3> blocked_forces = {};
  std::span<RigidCarrier> carriers = {};
  double tolerance = 1e-6;  ///< largest |V − V0|/V0 of a cell
  int max_iterations = 40;
  /// Takes back what the inequality of tets has lifted: the next step does not begin with these multipliers.
  bool lifting = false;
};

struct ProjectionResult {
  double max_error = 0.0;        ///< largest |V − V0|/V0 of a cell at the end
  std::int64_t worst_cell = -1;  ///< where it did not converge
  int iterations = 0;
  int linear_iterations = 0;  ///< of all linear solves together
  bool converged = false;
  bool kept_directions =
      true;  ///< false: it fell back to the current gradients, so angular momentum is not kept
  std::int64_t rowless_cells = 0;  ///< cells whose particles are all pinned
  std::optional<bool> inverted;    ///< a tet has no volume at the end, where the solver has seen it
};

/// Moves positions by Δx = W Jᵀ μ until every cell has its rest volume. Always ends, always finite. One per
/// body; keeps its work arrays, so a warm call allocates nothing.
class VolumeProjector {
 public:
  virtual ~VolumeProjector() = default;
  /// Before the first projection of a step of h seconds: moves positions by what the volume pressed in the
  /// steps before, while that changes little. Does nothing where nothing is remembered.
  virtual void begin_step(const Coordinates& start, double h, Coordinates& positions);
  virtual ProjectionResult project(const ProjectionRequest& request, Coordinates& positions) = 0;
  virtual std::int64_t bytes() const = 0;
};

/// Inexact Newton on the whole body, J W Jᵀ μ = −C [Goldenthal 2007], then the total volume to round-off.
std::unique_ptr<VolumeProjector> make_newton_projector(VolumeModel model);
/// The paper's solver: each cell in turn is scaled about its centre of mass by cbrt(V0/V) [Diziol 2009, Eq.
/// 4].
std::unique_ptr<VolumeProjector> make_scaling_projector(VolumeModel model);
/// Each cell in turn takes μ = −(V−V0)/Σw|∇V|² along its gradient.
std::unique_ptr<VolumeProjector> make_gradient_projector(VolumeModel model);

}  // namespace isochor

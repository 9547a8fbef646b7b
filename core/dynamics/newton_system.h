#pragma once
#include <memory>
#include <optional>

#include "core/dynamics/volume_projector.h"

namespace isochor::newton {

/// Volume errors C = V/V0 − 1 of all rows (cells, or tets when per_tet).
struct VolumeErrors {
  double sum_of_squares = 0.0;
  double max = 0.0;
  double total = 0.0;  ///< (ΣV − ΣV0) / ΣV0

  bool finite() const;
};

/// Where constraint gradients are taken.
enum class Directions { start, current };

/// The linear algebra of one body's projection. It holds the positions x and a direction d; the iteration
/// (newton_projector.cpp) decides how far to go along d.
class NewtonSystem {
 public:
  virtual ~NewtonSystem() = default;

  virtual void load(const ProjectionRequest& request, const Coordinates& positions) = 0;
  virtual void store(Coordinates& positions) const = 0;

  /// Errors at x + t·d; accept makes that point, the one evaluated last, the new x.
  virtual VolumeErrors evaluate(double t) = 0;
  virtual void accept(double t) = 0;

  /// Assembles J(x) W Jᵀ with Jᵀ taken at the directions; from the start it is not symmetric.
  virtual void linearize(Directions directions) = 0;
  /// Solves that times μ = −C(x) until the largest residual is tolerance times the largest error. Returns the
  /// iterations.
  virtual int solve(double tolerance) = 0;
  /// d = W Jᵀ μ.
  virtual void set_step(Directions directions) = 0;
  /// A step of a length over that of the last one: moves positions by W J₀ᵀ μ, J₀ at the start and μ carried
  /// on from the last two steps. Nothing where the system does not remember them.
  virtual void begin_step(const Coordinates& /*start*/, double /*length*/, Coordinates& /*positions*/) {}
  /// d = start − its centre of mass: changes the volume, not the momentum about the start positions.
  virtual void set_dilation() = 0;

  virtual bool is_free() const = 0;  ///< no particle is pinned or blocked
  virtual std::int64_t rowless_cells() const = 0;
  virtual std::int64_t worst_cell() const = 0;  ///< at x
  /// Whether a tet at x has no volume, where that was seen in passing.
  virtual std::optional<bool> any_inverted() const { return std::nullopt; }
  virtual std::int64_t bytes() const = 0;
};

/// One constraint a cell, on the lattice; nothing when the mesh does not fit one.
std::unique_ptr<NewtonSystem> make_lattice_system(const VolumeModel& model);
/// Any mesh and scope, by lists of vertices, in double throughout.
std::unique_ptr<NewtonSystem> make_general_system(VolumeModel model);

}  // namespace isochor::newton

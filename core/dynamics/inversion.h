#pragma once
#include "core/dynamics/mobility.h"
#include "core/dynamics/soft_body.h"
#include "core/dynamics/volume_elements.h"

namespace isochor {

/// Tets of negative or zero volume.
std::int64_t count_inverted(const TetMesh& mesh, const Coordinates& positions);
bool any_inverted(const TetMesh& mesh, const Coordinates& positions);

/// The per-tet inequality V_t ≥ 0.05·V_t0, for when a tet of a cell that has its volume inverts.
class TetInequality {
 public:
  explicit TetInequality(const SoftBody& body);

  /// Up to 20 Gauss–Seidel sweeps, each displacement at most 0.3 cell. With start positions in the request
  /// the directions are taken there, so that momentum is kept [as SHAKE]. What the projection takes back
  /// between rounds, the next round lifts in excess [Aitken]; round 0 begins with half of the excess. What
  /// contacts hold in all corners gets its force alone, if they may let go. True when no tet was left below.
  bool lift(const SoftBody& body, const ProjectionRequest& request, int round, bool may_let_go,
            Coordinates& positions);

  std::int64_t bytes() const;

 private:
  struct Lift {
    std::int32_t tet = 0;
    double multiplier = 0.0;
  };

  bool sweep(const SoftBody& body, const Coordinates* start, bool may_let_go, Coordinates& positions);
  bool raise(const SoftBody& body, std::int64_t tet, const Coordinates* start, bool may_let_go,
             Coordinates& positions);
  void exceed(const SoftBody& body, const Coordinates& start, Coordinates& positions);
  void displace(const Tet& tet, double mu, const VolumeElements::Gradient& along, Coordinates& positions);
  void mark_around(const Tet& tet);

  Mobility mobility_;
  std::vector<double> least_volumes_;               ///< 0.05·V_t0
  std::vector<std::int32_t> tets_begin_, tets_of_;  ///< the tets of a particle
  std::vector<std::uint64_t> pending_;              ///< a bit a tet: a particle of it has moved
  std::vector<Lift> lifts_;                         ///< of the last round
  double missing_ = 0.0;     ///< before it: volume over that of the bound, summed over the tets below
  double excess_ = 1.0;      ///< factor of its lifts
  double letting_go_ = 1.0;  ///< factor of the forces on contacts that hold a tet in all corners
};

/// Pulls cells whose ‖∇V‖ has fallen under 1e-6 of its rest value (flattened to a line or a point, where no
/// gradient leads out) towards the rest pose that fits them best [Müller 2005]; axes that the cell has lost
/// are completed deterministically. Returns how many there were.
std::int64_t pull_flattened_cells(const SoftBody& body, Coordinates& positions);

/// A body most of whose cells are inside out is a mirror image, from which no gradient leads back: it takes
/// the rest pose that fits it best. True when it was.
bool turn_right_side_out(const SoftBody& body, Coordinates& positions);

}  // namespace isochor

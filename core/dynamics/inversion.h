#pragma once
#include "core/dynamics/soft_body.h"

namespace isochor {

/// Tets of negative or zero volume.
std::int64_t count_inverted(const TetMesh& mesh, const Coordinates& positions);
bool any_inverted(const TetMesh& mesh, const Coordinates& positions);

/// Up to 20 Gauss–Seidel sweeps of the inequality V_t ≥ 0.05·V_t0, each displacement at most 0.3 cell. True
/// when no tet was left below.
bool lift_inverted_tets(const SoftBody& body, Coordinates& positions);

/// Pulls cells whose ‖∇V‖ has fallen under 1e-6 of its rest value (flattened to a line or a point, where no
/// gradient leads out) towards the rest pose that fits them best [Müller 2005]; axes that the cell has lost
/// are completed deterministically. Returns how many there were.
std::int64_t pull_flattened_cells(const SoftBody& body, Coordinates& positions);

}  // namespace isochor

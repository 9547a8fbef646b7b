#pragma once
#include <span>
#include <vector>

#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// How a cell's mass is shared out to its particles.
enum class MassLumping {
  lumped,  ///< in proportion to |∂V/∂x|: 1/6 to each vertex of the central tet, 1/12 to each of its apexes
  equal,   ///< the paper's: every particle of a body of one density weighs the same
};

/// Volume of each cell's five tets, signed.
std::vector<double> cell_volumes(const TetMesh& mesh, std::span<const Vec3> positions);
/// Signed volume of each tet.
std::vector<double> tet_volumes(const TetMesh& mesh, std::span<const Vec3> positions);

/// Masses in kg; volumes and densities are those of the cells. The total is Σ density·volume either way.
std::vector<double> particle_masses(const TetMesh& mesh, std::span<const double> volumes,
                                    std::span<const double> densities, MassLumping lumping);

}  // namespace isochor

#pragma once
#include <span>
#include <string>

#include "core/export/text.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// The text of a VTK XML unstructured grid with the mesh at these positions and its data a tet: the lattice
/// cell, its i, j, k, volume, smallest dihedral angle and scaled Jacobian.
void write_vtu_text(Text& text, const TetMesh& mesh, std::span<const Vec3> positions,
                    const std::string& comment);

}  // namespace isochor

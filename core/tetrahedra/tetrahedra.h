#pragma once
#include "core/common/progress.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// As make_tetrahedra(lattice), and can be cancelled: a lattice of 256 cells has millions of tets.
TetMesh make_tetrahedra(const Lattice& lattice, const Progress& progress);

}  // namespace isochor

#pragma once
#include <random>

#include "core/lattice/lattice.h"
#include "core/lattice/topology.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor::test {

/// Tets of the cells of an even grid around the origin for whose centre is_inside holds; cells of size 1.
template <class Inside>
TetMesh tets_of(const Vec3i& cells, Inside&& is_inside, Contacts contacts = Contacts::keep) {
  Lattice lattice;
  lattice.grid = Grid{cells, 1.0, -0.5 * cells.cast<double>()};
  lattice.contacts = contacts;
  for (int k = 0; k < cells.z(); ++k)
    for (int j = 0; j < cells.y(); ++j)
      for (int i = 0; i < cells.x(); ++i) {
        const bool inside = is_inside(lattice.grid.center(i, j, k));
        lattice.kept.push_back(inside);
        lattice.kept_count += inside;
      }
  return make_tetrahedra(lattice);
}

inline TetMesh ball_of_cells(int cells) {
  return tets_of(Vec3i::Constant(cells), [&](const Vec3& x) { return x.norm() < 0.5 * cells; });
}

inline TetMesh torus_of_cells(int cells) {
  return tets_of(Vec3i::Constant(cells), [&](const Vec3& x) {
    const double ring = std::hypot(x.x(), x.y()) - 0.32 * cells;
    return std::hypot(ring, x.z()) < 0.16 * cells;
  });
}

/// Cells kept at random: every kind of contact, sliver and single cell.
inline TetMesh random_cells(unsigned seed, double share, Contacts contacts = Contacts::keep) {
  std::mt19937 random(seed);
  return tets_of(
      {8, 8, 8}, [&](const Vec3&) { return std::bernoulli_distribution(share)(random); }, contacts);
}

}  // namespace isochor::test

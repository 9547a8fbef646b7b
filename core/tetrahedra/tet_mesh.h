#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/common/types.h"

namespace isochor {

struct Lattice;

/// A lattice cube of five tetrahedra. Corner b of a cell at (i,j,k) is the lattice node
/// (i + (b&1), j + (b>>1&1), k + (b>>2&1)); parity (i+j+k)&1 selects the pattern or its mirror.
struct Cell {
  std::array<std::int32_t, 8> corners;
  std::array<std::int32_t, 3> coord;
  int parity() const { return (coord[0] + coord[1] + coord[2]) & 1; }
};

/// The model. Tets 5c … 5c+4 belong to cell c: first the central one, then its four apexes. All volumes are
/// positive. Vertices and cells are in lattice order (x fastest), without orphans.
struct TetMesh {
  std::vector<Vec3> positions;
  std::vector<Tet> tets;
  std::vector<Cell> cells;
  std::vector<std::array<std::int32_t, 3>>
      nodes;                      ///< lattice node of each vertex; separated hinges repeat it
  Grid grid;                      ///< the lattice
  std::vector<Triangle> surface;  ///< boundary triangles, outward, in a fixed order
};

/// Corners of the five tets of a cell of the given parity, as bits of Cell::corners.
const std::array<std::array<int, 4>, 5>& five_tets(int parity);

/// Five tets a kept cell, by parity, so that faces match. Throws empty_result when no cell is kept.
TetMesh make_tetrahedra(const Lattice& lattice);

/// A full box of cells with its lowest corner at origin; the lattice bodies of scenes.
TetMesh make_box_lattice(const Vec3i& cells, double cell_size, const Vec3& origin);

double total_volume(const TetMesh& mesh);

}  // namespace isochor

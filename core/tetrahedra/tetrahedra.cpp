#include "core/tetrahedra/tetrahedra.h"

#include <algorithm>

#include "core/common/compensated_sum.h"
#include "core/common/error.h"
#include "core/lattice/lattice.h"
#include "core/lattice/node_link.h"
#include "core/parallel/cancel_scope.h"

namespace isochor {
namespace {

/// Two triangles, as corner bits, outward, on face f of a cube: f = 2·axis + side.
using FaceTriangles = std::array<std::array<std::array<int, 3>, 2>, 6>;

// A face of a tet lies on face f of the cube when its three corners agree in the bit of the axis. A face
// opposite vertex v of a positive tet, with the other three in this order, points outward.
FaceTriangles make_face_triangles(int parity) {
  static constexpr std::array<std::array<int, 3>, 4> outward{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
  FaceTriangles faces{};
  std::array<int, 6> filled{};
  for (const auto& tet : five_tets(parity)) {
    for (const auto& local : outward) {
      const std::array<int, 3> corners{tet[local[0]], tet[local[1]], tet[local[2]]};
      for (int axis = 0; axis < 3; ++axis) {
        const int side = corners[0] >> axis & 1;
        if ((corners[1] >> axis & 1) != side || (corners[2] >> axis & 1) != side) continue;
        const int face = 2 * axis + side;
        faces[face][filled[face]++] = corners;
      }
    }
  }
  return faces;
}

const FaceTriangles& face_triangles(int parity) {
  static const std::array<FaceTriangles, 2> tables{make_face_triangles(0), make_face_triangles(1)};
  return tables[parity];
}

/// Vertices of the lattice's nodes: one, or with `separate` one for each face-connected group of kept cells.
class NodeVertices {
 public:
  NodeVertices(const Grid& grid, const std::vector<std::uint8_t>& kept, bool separate)
      : nodes_{grid.size + Vec3i::Ones(), grid.spacing, grid.origin}, separate_(separate) {
    mask_.resize(nodes_.count());
    first_.resize(nodes_.count());
    for (int k = 0; k < nodes_.size.z(); ++k) {
      throw_if_scope_cancelled();
      for (int j = 0; j < nodes_.size.y(); ++j)
        for (int i = 0; i < nodes_.size.x(); ++i)
          mask_[nodes_.index(i, j, k)] = node_mask(grid, kept, i, j, k);
    }
  }

  void create(TetMesh& mesh) {
    std::int64_t n = 0;
    for (int k = 0; k < nodes_.size.z(); ++k) {
      throw_if_scope_cancelled();
      for (int j = 0; j < nodes_.size.y(); ++j)
        for (int i = 0; i < nodes_.size.x(); ++i, ++n) {
          if (mask_[n] == 0) continue;
          first_[n] = static_cast<std::int32_t>(mesh.positions.size());
          for (int copies = separate_ ? node_link(mask_[n]).count : 1; copies > 0; --copies) {
            mesh.positions.push_back(nodes_.origin + nodes_.spacing * Vec3(i, j, k));
            mesh.nodes.push_back({i, j, k});
          }
        }
    }
  }

  /// Vertex at corner b of the cell at c.
  std::int32_t at(const std::array<std::int32_t, 3>& c, int b) const {
    const std::int64_t n = nodes_.index(c[0] + (b & 1), c[1] + (b >> 1 & 1), c[2] + (b >> 2 & 1));
    return first_[n] + (separate_ ? node_link(mask_[n]).label[b ^ 7] : 0);
  }

 private:
  Grid nodes_;
  bool separate_;
  std::vector<std::uint8_t> mask_;
  std::vector<std::int32_t> first_;
};

void add_tets(const Cell& cell, TetMesh& mesh) {
  const auto& c = cell.corners;
  for (const auto& tet : five_tets(cell.parity()))
    mesh.tets.push_back({c[tet[0]], c[tet[1]], c[tet[2]], c[tet[3]]});
}

void add_surface(const Cell& cell, int face, TetMesh& mesh) {
  const auto& c = cell.corners;
  for (const auto& triangle : face_triangles(cell.parity())[face])
    mesh.surface.push_back({c[triangle[0]], c[triangle[1]], c[triangle[2]]});
}

TetMesh assemble(const Grid& grid, const std::vector<std::uint8_t>& kept, bool separate) {
  TetMesh mesh;
  mesh.grid = grid;
  NodeVertices vertices(grid, kept, separate);
  vertices.create(mesh);
  const auto cells = std::ranges::count_if(kept, [](std::uint8_t cell) { return cell != 0; });
  mesh.cells.reserve(cells);
  mesh.tets.reserve(5 * cells);
  const auto is_kept = [&](int i, int j, int k) {
    return grid.contains(i, j, k) && kept[grid.index(i, j, k)] != 0;
  };
  for (int k = 0; k < grid.size.z(); ++k) {
    throw_if_scope_cancelled();
    for (int j = 0; j < grid.size.y(); ++j)
      for (int i = 0; i < grid.size.x(); ++i) {
        if (!is_kept(i, j, k)) continue;
        Cell cell{{}, {i, j, k}};
        for (int b = 0; b < 8; ++b) cell.corners[b] = vertices.at(cell.coord, b);
        add_tets(cell, mesh);
        for (int face = 0; face < 6; ++face) {
          std::array<int, 3> neighbor{i, j, k};
          neighbor[face / 2] += face % 2 == 0 ? -1 : 1;
          if (!is_kept(neighbor[0], neighbor[1], neighbor[2])) add_surface(cell, face, mesh);
        }
        mesh.cells.push_back(cell);
      }
  }
  return mesh;
}

}  // namespace

TetMesh make_tetrahedra(const Lattice& lattice) {
  return make_tetrahedra(lattice, {});
}

TetMesh make_tetrahedra(const Lattice& lattice, const Progress& progress) {
  if (lattice.kept_count == 0)
    throw Error(ErrorCode::empty_result, "no lattice cell is kept, so there are no tetrahedra",
                "lower the density threshold or raise p_in_voxels");
  const CancelScope scope(progress);
  progress.report("tetrahedra", 0.0);
  TetMesh mesh = assemble(lattice.grid, lattice.kept, lattice.contacts == Contacts::separate);
  if (lattice.stretch != Vec3::Ones())
    for (Vec3& p : mesh.positions) p = lattice.centroid + lattice.stretch.cwiseProduct(p - lattice.centroid);
  return mesh;
}

TetMesh make_box_lattice(const Vec3i& cells, double cell_size, const Vec3& origin) {
  if ((cells.array() < 1).any() || !(cell_size > 0.0))
    throw Error(ErrorCode::invalid_argument, "a lattice body needs at least one cell of positive size");
  const Grid grid{cells, cell_size, origin};
  return assemble(grid, std::vector<std::uint8_t>(grid.count(), 1), false);
}

double total_volume(const TetMesh& mesh) {
  CompensatedSum sum;
  for (const Tet& t : mesh.tets)
    sum.add(
        tet_volume(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]], mesh.positions[t[3]]));
  return sum.value();
}

}  // namespace isochor

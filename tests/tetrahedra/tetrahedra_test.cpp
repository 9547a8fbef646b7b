#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "core/common/error.h"
#include "core/lattice/lattice.h"
#include "core/tetrahedra/tetrahedra.h"
#include "tests/support/lattices.h"

namespace isochor {
namespace {

TEST(FiveTets, FillTheCubeWithPositiveVolumes) {
  const TetMesh mesh = make_box_lattice({2, 1, 1}, 2.0, Vec3::Zero());
  ASSERT_EQ(mesh.tets.size(), 10u);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const Tet& v = mesh.tets[t];
    const double volume =
        tet_volume(mesh.positions[v[0]], mesh.positions[v[1]], mesh.positions[v[2]], mesh.positions[v[3]]);
    EXPECT_DOUBLE_EQ(volume, t % 5 == 0 ? 8.0 / 3.0 : 8.0 / 6.0);
  }
  EXPECT_DOUBLE_EQ(total_volume(mesh), 16.0);
}

TEST(Tetrahedra, NeighbouringCellsShareWholeFaces) {
  const TetMesh mesh = make_box_lattice({3, 4, 2}, 1.0, Vec3(1, 2, 3));
  std::map<std::array<int, 3>, int> uses;
  for (const Tet& t : mesh.tets)
    for (int skip = 0; skip < 4; ++skip) {
      std::array<int, 3> face{};
      for (int i = 0, n = 0; i < 4; ++i)
        if (i != skip) face[n++] = t[i];
      std::ranges::sort(face);
      ++uses[face];
    }
  std::size_t boundary = 0;
  for (const auto& [face, count] : uses) {
    EXPECT_LE(count, 2);
    boundary += count == 1;
  }
  EXPECT_EQ(boundary, 2u * 2 * (3 * 4 + 4 * 2 + 3 * 2));
  EXPECT_EQ(mesh.surface.size(), boundary);
}

TEST(Tetrahedra, SurfaceIsClosedAndPointsOutward) {
  const TetMesh mesh = make_box_lattice({3, 2, 2}, 0.5, Vec3::Zero());
  std::map<std::pair<int, int>, int> directed;
  double volume = 0.0;
  for (const Triangle& t : mesh.surface) {
    for (int e = 0; e < 3; ++e) ++directed[{t[e], t[(e + 1) % 3]}];
    volume += mesh.positions[t[0]].dot(mesh.positions[t[1]].cross(mesh.positions[t[2]])) / 6.0;
  }
  for (const auto& [edge, count] : directed) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(directed.count({edge.second, edge.first}), 1u);
  }
  EXPECT_NEAR(volume, total_volume(mesh), 1e-12);
}

TEST(Tetrahedra, SeparatePartsAHinge) {
  const auto edge = [](const Vec3& x) { return x.z() > 0 && x.x() * x.y() > 0; };
  const auto corner = [](const Vec3& x) { return x.x() * x.y() > 0 && x.y() * x.z() > 0; };
  EXPECT_EQ(test::tets_of({2, 2, 2}, edge).positions.size(), 14u);
  EXPECT_EQ(test::tets_of({2, 2, 2}, edge, Contacts::separate).positions.size(), 16u);
  EXPECT_EQ(test::tets_of({2, 2, 2}, corner).positions.size(), 15u);
  EXPECT_EQ(test::tets_of({2, 2, 2}, corner, Contacts::separate).positions.size(), 16u);
}

TEST(Tetrahedra, SeparateChangesNoShapeAndLeavesEachVertexOneGroupOfCells) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const TetMesh whole = test::random_cells(seed, 0.4);
    const TetMesh parted = test::random_cells(seed, 0.4, Contacts::separate);
    ASSERT_EQ(parted.tets.size(), whole.tets.size());
    EXPECT_GT(parted.positions.size(), whole.positions.size());
    for (std::size_t t = 0; t < whole.tets.size(); ++t)
      for (int c = 0; c < 4; ++c) {
        EXPECT_EQ(parted.positions[parted.tets[t][c]], whole.positions[whole.tets[t][c]]);
        EXPECT_EQ(parted.nodes[parted.tets[t][c]], whole.nodes[whole.tets[t][c]]);
      }
    std::map<int, std::vector<Vec3i>> cells_of_vertex;
    for (const Cell& cell : parted.cells)
      for (const int v : cell.corners)
        cells_of_vertex[v].emplace_back(cell.coord[0], cell.coord[1], cell.coord[2]);
    EXPECT_EQ(cells_of_vertex.size(), parted.positions.size());
    for (auto& [vertex, cells] : cells_of_vertex) {
      // Grow a group from the first cell through shared faces: it must take all of them.
      std::vector<Vec3i> group{cells.front()};
      for (std::size_t i = 0; i < group.size(); ++i)
        for (const Vec3i& c : cells)
          if ((c - group[i]).lpNorm<1>() == 1 && std::ranges::find(group, c) == group.end())
            group.push_back(c);
      EXPECT_EQ(group.size(), cells.size());
    }
  }
}

TEST(Tetrahedra, AnEmptyLatticeIsNamed) {
  Lattice lattice;
  lattice.grid = Grid{{2, 2, 2}, 1.0, Vec3::Zero()};
  lattice.kept.assign(8, 0);
  try {
    make_tetrahedra(lattice);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::empty_result);
    EXPECT_FALSE(error.hint().empty());
  }
}

TEST(Tetrahedra, CanBeCancelled) {
  Lattice lattice;
  lattice.grid = Grid{{2, 2, 2}, 1.0, Vec3::Zero()};
  lattice.kept.assign(8, 1);
  lattice.kept_count = 8;
  const std::atomic<bool> cancel{true};
  try {
    make_tetrahedra(lattice, Progress({}, &cancel));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
  }
}

}  // namespace
}  // namespace isochor

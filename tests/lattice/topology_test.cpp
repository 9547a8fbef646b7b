#include "core/lattice/topology.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/lattice/node_link.h"

namespace isochor {
namespace {

Grid cube_grid(int n) {
  return Grid{Vec3i::Constant(n), 1.0, Vec3::Zero()};
}

CellSet set_of(const Grid& grid, std::initializer_list<Vec3i> cells) {
  CellSet set(grid.count(), 0);
  for (const Vec3i& c : cells) set[grid.index(c[0], c[1], c[2])] = 1;
  return set;
}

std::int64_t size_of(const CellSet& set) {
  return std::ranges::count(set, 1);
}

TEST(FillHoles, ThreeNeighboursAreNotEnough) {
  const Grid grid = cube_grid(3);
  CellSet set = set_of(grid, {{0, 1, 1}, {2, 1, 1}, {1, 0, 1}});
  fill_holes(grid, set);
  EXPECT_EQ(size_of(set), 3);
}

TEST(FillHoles, FourNeighboursAre) {
  const Grid grid = cube_grid(3);
  CellSet set = set_of(grid, {{0, 1, 1}, {2, 1, 1}, {1, 0, 1}, {1, 2, 1}});
  fill_holes(grid, set);
  EXPECT_EQ(size_of(set), 5);
  EXPECT_EQ(set[grid.index(1, 1, 1)], 1);
}

TEST(FillHoles, AFilledCellFillsTheNext) {
  // A pit two deep: its bottom has five neighbours kept, its mouth four walls only once the bottom is filled.
  const Grid grid{{3, 3, 3}, 1.0, Vec3::Zero()};
  CellSet set = set_of(grid, {{1, 1, 0}, {0, 1, 1}, {2, 1, 1}, {1, 0, 1}, {0, 1, 2}, {2, 1, 2}, {1, 0, 2}});
  EXPECT_EQ(size_of(set), 7);
  fill_holes(grid, set);
  EXPECT_EQ(set[grid.index(1, 1, 1)], 1);
  EXPECT_EQ(set[grid.index(1, 1, 2)], 1);
  EXPECT_EQ(size_of(set), 9);
}

TEST(FillHoles, AgreesWithPassesUntilNothingChanges) {
  const Grid grid{{7, 6, 5}, 1.0, Vec3::Zero()};
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    CellSet set(grid.count());
    for (auto& cell : set) cell = std::bernoulli_distribution(0.45)(random);
    CellSet expected = set;
    for (bool changed = true; changed;) {
      changed = false;
      for (int k = 0; k < 5; ++k)
        for (int j = 0; j < 6; ++j)
          for (int i = 0; i < 7; ++i) {
            int kept = 0;
            for (const Vec3i& d : {Vec3i(1, 0, 0), Vec3i(0, 1, 0), Vec3i(0, 0, 1)})
              for (const int s : {-1, 1}) {
                const Vec3i n = Vec3i(i, j, k) + s * d;
                kept += grid.contains(n[0], n[1], n[2]) && expected[grid.index(n[0], n[1], n[2])] != 0;
              }
            auto& cell = expected[grid.index(i, j, k)];
            if (cell == 0 && kept > 3) cell = 1, changed = true;
          }
    }
    fill_holes(grid, set);
    EXPECT_EQ(set, expected) << "seed " << seed;
  }
}

TEST(Components, AreJoinedByFacesOnly) {
  const Grid grid = cube_grid(4);
  const CellSet set = set_of(grid, {{0, 0, 0}, {1, 0, 0}, {2, 1, 0}, {3, 2, 1}, {3, 3, 1}, {3, 3, 2}});
  const Components components = label_components(grid, set);
  EXPECT_EQ(components.size, (std::vector<std::int64_t>{2, 1, 3}));
  CellSet largest = set;
  keep_largest(components, largest);
  EXPECT_EQ(size_of(largest), 3);
  EXPECT_EQ(largest[grid.index(3, 2, 1)], 1);
}

TEST(Contacts, AnEdgeAndAVertexAreCountedOnce) {
  const Grid grid = cube_grid(3);
  const ContactCounts edge = count_contacts(grid, set_of(grid, {{0, 0, 1}, {1, 1, 1}}));
  EXPECT_EQ(edge.edges, 1);
  EXPECT_EQ(edge.nodes, 0);
  const ContactCounts vertex = count_contacts(grid, set_of(grid, {{2, 0, 0}, {1, 1, 1}}));
  EXPECT_EQ(vertex.edges, 0);
  EXPECT_EQ(vertex.nodes, 1);
  const ContactCounts face = count_contacts(grid, set_of(grid, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}));
  EXPECT_EQ(face.edges + face.nodes, 0);
}

TEST(Contacts, FillingAddsTheCellsAround) {
  const Grid grid = cube_grid(4);
  CellSet edge = set_of(grid, {{1, 1, 1}, {2, 1, 2}});
  EXPECT_EQ(fill_contacts(grid, edge), 1);
  EXPECT_EQ(size_of(edge), 4);
  CellSet vertex = set_of(grid, {{1, 1, 1}, {2, 2, 2}});
  EXPECT_EQ(fill_contacts(grid, vertex), 1);
  EXPECT_EQ(size_of(vertex), 8);
  EXPECT_EQ(fill_contacts(grid, vertex), 0);
}

TEST(NodeLink, GroupsCellsByTheFacesTheyShare) {
  EXPECT_EQ(node_link(0).count, 0);
  EXPECT_EQ(node_link(0xFF).count, 1);
  EXPECT_EQ(node_link(0b00001001).count, 2);  // diagonal across an edge
  EXPECT_EQ(node_link(0b10000001).count, 2);  // antipodal
  EXPECT_EQ(node_link(0b00001011).count, 1);  // joined by the cell between
  EXPECT_EQ(node_link(0b01101001).count, 4);  // alternate cells
}

}  // namespace
}  // namespace isochor

#include "core/dynamics/spring_stencil.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "core/lattice/lattice.h"
#include "core/parallel/parallel.h"

namespace isochor {

// In the namespace of the type, where GoogleTest looks for it.
static void PrintTo(const SpringMaterial& material, std::ostream* out) {
  *out << "edge " << material.edge << ", diagonal " << material.diagonal << ", damping " << material.damping;
}

namespace {

/// A lattice with holes, so that runs are cut.
TetMesh sponge(const Vec3i& size, std::uint32_t seed) {
  Lattice lattice;
  lattice.grid = Grid{size, 0.5, Vec3::Zero()};
  std::mt19937 random(seed);
  for (std::int64_t c = 0; c < lattice.grid.count(); ++c) lattice.kept.push_back(random() % 4 != 0);
  lattice.kept_count = lattice.grid.count();
  return make_tetrahedra(lattice);
}

Coordinates shaken(const TetMesh& mesh, double amount, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-amount, amount);
  Coordinates x(mesh.positions);
  for (std::size_t i = 0; i < x.size(); ++i) x.add(i, {noise(random), noise(random), noise(random)});
  return x;
}

struct Reference {
  std::vector<Vec3> forces;
  double energy = 0.0;
  std::int64_t springs = 0;
};

/// Every cell's 16 springs one by one, unmerged.
Reference spring_by_spring(const TetMesh& mesh, const SpringMaterial& material, const Coordinates& x,
                           const Coordinates& v) {
  Reference sum{std::vector<Vec3>(x.size(), Vec3::Zero())};
  for (const Cell& cell : mesh.cells) {
    for (int a = 0; a < 8; ++a) {
      for (int b = a + 1; b < 8; ++b) {
        const int bits = __builtin_popcount(a ^ b);
        if (bits == 2) continue;
        const double k = bits == 1 ? material.edge : material.diagonal;
        const auto i = cell.corners[a], j = cell.corners[b];
        const Vec3 d = x.at(j) - x.at(i), rate = v.at(j) - v.at(i);
        const double l = d.norm(), rest = (mesh.positions[j] - mesh.positions[i]).norm();
        const Vec3 force = k * (l - rest + material.damping * rate.dot(d) / l) * d / l;
        sum.forces[i] += force;
        sum.forces[j] -= force;
        sum.energy += 0.5 * k * (l - rest) * (l - rest);
        ++sum.springs;
      }
    }
  }
  return sum;
}

class Springs : public testing::TestWithParam<SpringMaterial> {};

TEST_P(Springs, TheStencilEqualsTheListOfSprings) {
  const TetMesh mesh = sponge({9, 7, 6}, 3);
  const Coordinates x = shaken(mesh, 0.2, 1), v = shaken(mesh, 2.0, 2);
  const SpringStencil stencil = make_spring_stencil(mesh, mesh.positions, GetParam());
  Coordinates forces(x.size());
  add_spring_forces(stencil, GetParam(), x, v, forces);
  const Reference reference = spring_by_spring(mesh, GetParam(), x, v);
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_LT((forces.at(i) - reference.forces[i]).norm(), 1e-9);
  EXPECT_NEAR(spring_energy(stencil, GetParam(), x), reference.energy, 1e-12 * (1.0 + reference.energy));
}

INSTANTIATE_TEST_SUITE_P(Materials, Springs,
                         testing::Values(SpringMaterial{100.0, 10.0, 0.0}, SpringMaterial{100.0, 10.0, 0.05},
                                         SpringMaterial{100.0, 0.0, 0.0}, SpringMaterial{0.0, 10.0, 0.0},
                                         SpringMaterial{0.0, 0.0, 0.0}));

TEST(SpringStencil, ACellHasSixteenSprings) {
  const TetMesh mesh = make_box_lattice({1, 1, 1}, 1.0, Vec3::Zero());
  const SpringStencil stencil = make_spring_stencil(mesh, mesh.positions, {});
  EXPECT_EQ(stencil.edges.rest_lengths.size(), 12u);
  EXPECT_EQ(stencil.diagonals.rest_lengths.size(), 4u);
}

TEST(SpringStencil, SharedEdgesAreMergedAndTheirConstantsAdd) {
  const TetMesh mesh = make_box_lattice({2, 2, 2}, 1.0, Vec3::Zero());
  const SpringStencil stencil = make_spring_stencil(mesh, mesh.positions, {});
  std::map<double, int> sharing;
  for (const double cells : stencil.edges.cells) ++sharing[cells];
  EXPECT_EQ(sharing, (std::map<double, int>{{1.0, 24}, {2.0, 24}, {4.0, 6}}));
}

TEST(SpringStencil, AFamilyOfConstantZeroIsLeftOut) {
  const TetMesh mesh = make_box_lattice({2, 2, 2}, 1.0, Vec3::Zero());
  const SpringStencil stencil = make_spring_stencil(mesh, mesh.positions, {1.0, 0.0, 0.0});
  EXPECT_TRUE(stencil.diagonals.empty());
  EXPECT_EQ(stencil.diagonals.bytes(), 0);
}

TEST(SpringStencil, ForcesAreTheGradientOfTheEnergy) {
  const TetMesh mesh = make_box_lattice({2, 2, 1}, 1.0, Vec3::Zero());
  const SpringMaterial material{3.0, 2.0, 0.0};
  const SpringStencil stencil = make_spring_stencil(mesh, mesh.positions, material);
  Coordinates x = shaken(mesh, 0.3, 5), forces(x.size());
  add_spring_forces(stencil, material, x, x, forces);
  const double step = 1e-6;
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 d = Vec3::Zero();
      d[axis] = step;
      x.add(i, d);
      const double ahead = spring_energy(stencil, material, x);
      x.add(i, -2.0 * d);
      const double behind = spring_energy(stencil, material, x);
      x.add(i, d);
      EXPECT_NEAR(forces.at(i)[axis], -(ahead - behind) / (2.0 * step), 1e-6);
    }
  }
}

TEST(SpringStencil, ForcesAreTheSameBitsForAnyNumberOfThreads) {
  const TetMesh mesh = make_box_lattice({40, 40, 12}, 1.0, Vec3::Zero());
  const SpringStencil stencil = make_spring_stencil(mesh, mesh.positions, {});
  ASSERT_GT(stencil.edges.chunks(), 3);
  const Coordinates x = shaken(mesh, 0.3, 5);
  std::vector<Coordinates> runs;
  for (const int threads : {1, 2, 5}) {
    set_thread_count(threads);
    add_spring_forces(stencil, {}, x, x, runs.emplace_back(x.size()));
  }
  set_thread_count(0);
  for (const Coordinates& run : runs) {
    EXPECT_EQ(run.x, runs[0].x);
    EXPECT_EQ(run.y, runs[0].y);
    EXPECT_EQ(run.z, runs[0].z);
  }
}

// Two particles and one spring: λ = k(1/m + 1/M), while the bound is k(1/m + 1/√(mM)) for m < M.
TEST(Gershgorin, BoundsTheFrequencyOfASingleSpring) {
  SpringStencil stencil;
  stencil.edges = {{{0, 1, 0, 1}}, {0, 1}, {1.0}, {1.0}};
  for (const double ratio : {1.0, 10.0, 1e6}) {
    const std::vector<double> inverse_masses{1.0, 1.0 / ratio};
    const double exact = 50.0 * (1.0 + 1.0 / ratio);
    const double bound = gershgorin_bound(stencil, {50.0, 0.0, 0.0}, inverse_masses);
    EXPECT_GE(bound, exact * (1.0 - 1e-15));
    EXPECT_LE(bound, 2.0 * exact);
  }
}

TEST(Gershgorin, SymplecticEulerIsStableBelowTheStepAndNotAbove) {
  for (const double damping : {0.0, 0.01, 1.0}) {
    const double lambda = 400.0, limit = stable_substep(lambda, damping);
    const auto end_of_run = [&](double h) {
      double x = 1.0, v = 0.0;
      for (int i = 0; i < 2000; ++i) v -= h * lambda * (x + damping * v), x += h * v;
      return std::abs(x);
    };
    EXPECT_LT(end_of_run(0.99 * limit), 100.0);
    EXPECT_FALSE(end_of_run(1.01 * limit) < 1e6);
  }
}

}  // namespace
}  // namespace isochor

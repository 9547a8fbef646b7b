#include "core/dynamics/saddle_solver.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "tests/newton/body.h"

namespace isochor {
namespace {

using namespace testing;

Coordinates shaken(const Body& body, double amount, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-amount, amount);
  Coordinates x(body.mesh.positions);
  for (std::size_t i = 0; i < x.size(); ++i) x.add(i, Vec3(noise(random), noise(random), noise(random)));
  return x;
}

SoftBody make_soft(const Body& source, const SpringMaterial& material) {
  SoftBody body;
  body.mesh = std::make_shared<TetMesh>(source.mesh);
  body.rest_positions = source.mesh.positions;
  body.rest_volumes = cell_volumes(source.mesh, source.mesh.positions);
  body.cell_size = source.mesh.grid.spacing;
  body.masses = source.masses;
  for (const double mass : body.masses) {
    body.total_mass += mass;
    body.inverse_masses.push_back(1.0 / mass);
  }
  body.material = material;
  body.springs = make_spring_stencil(*body.mesh, body.rest_positions, material);
  body.positions = Coordinates(body.rest_positions);
  return body;
}

/// J of the volumes against central differences of them, by both products.
TEST(VolumeRows, AreTheDerivativeOfTheVolumes) {
  const Body body = make_masked(5, [](const Vec3& p) { return p.norm() < 0.95; });
  const Coordinates x = shaken(body, 0.05, 1), p = shaken(body, 0.3, 2);
  VolumeRows rows(body.mesh), ahead(body.mesh), behind(body.mesh);
  rows.linearize(body.mesh, x);
  constexpr double step = 1e-6;
  Coordinates plus = x, minus = x;
  for (std::size_t i = 0; i < x.size(); ++i) plus.add(i, step * p.at(i)), minus.add(i, -step * p.at(i));
  ahead.measure(body.mesh, plus);
  behind.measure(body.mesh, minus);
  std::vector<double> product(rows.size());
  rows.multiply(p, product);
  Coordinates transposed(x.size());
  rows.add_transposed(product, 2.0, transposed);
  double of_rows = 0.0, of_nodes = 0.0;
  for (std::size_t c = 0; c < rows.size(); ++c) {
    EXPECT_NEAR(product[c], (ahead.volumes()[c] - behind.volumes()[c]) / (2.0 * step), 1e-8);
    of_rows += product[c] * product[c];
  }
  for (std::size_t i = 0; i < x.size(); ++i) of_nodes += transposed.at(i).dot(p.at(i));
  EXPECT_NEAR(of_nodes, 2.0 * of_rows, 1e-12 * of_rows);
}

/// The dense matrix (A −Jᵀ; J 0), a column a unit vector.
Eigen::MatrixXd dense_matrix(const SoftBody& body, const Coordinates& at, double stiffness) {
  const auto nodes = static_cast<Eigen::Index>(3 * body.size()),
             cells = static_cast<Eigen::Index>(body.rest_volumes.size());
  SpringTangent tangent(body.springs);
  tangent.linearize(body.springs, body.material, at, stiffness, 0.0);
  VolumeRows rows(*body.mesh);
  rows.linearize(*body.mesh, at);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(nodes + cells, nodes + cells);
  for (std::size_t i = 0; i < body.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      Coordinates unit(body.size()), image(body.size());
      unit.set(i, Vec3::Unit(axis));
      image.set(i, body.masses[i] * Vec3::Unit(axis));
      tangent.add_product(body.springs, unit, image);
      std::vector<double> volumes(rows.size());
      rows.multiply(unit, volumes);
      const auto column = static_cast<Eigen::Index>(3 * i + axis);
      for (std::size_t j = 0; j < body.size(); ++j)
        matrix.block<3, 1>(static_cast<Eigen::Index>(3 * j), column) = image.at(j);
      for (Eigen::Index c = 0; c < cells; ++c) matrix(nodes + c, column) = volumes[c];
    }
  }
  matrix.topRightCorner(nodes, cells) = -matrix.bottomLeftCorner(cells, nodes).transpose();
  return matrix;
}

struct Case {
  const char* name;
  bool box;
  double stiffness;  ///< h²k over a particle's mass, roughly
  bool held;         ///< a pinned and a sliding particle
};
void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

class SaddleSolverCases : public ::testing::TestWithParam<Case> {};

/// By the residual of the dense matrix with the held directions taken out and by its own solve; and in few
/// iterations.
TEST_P(SaddleSolverCases, AgreesWithADenseSolve) {
  const Case& c = GetParam();
  const Body source =
      c.box ? make_box({4, 4, 3}) : make_masked(5, [](const Vec3& p) { return p.norm() < 0.9; });
  SoftBody body = make_soft(source, {1.0, 0.7, 0.0});
  const Coordinates at = shaken(source, 0.02 * body.cell_size, 3);
  std::vector<BlockedParticle> blocked;
  Eigen::MatrixXd matrix = dense_matrix(body, at, c.stiffness * body.masses[0]);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  SaddleVector right(body.size(), body.rest_volumes.size()), solution = right;
  for (std::size_t i = 0; i < body.size(); ++i)
    right.nodes.set(i, body.masses[i] * Vec3(normal(random), normal(random), normal(random)));
  for (double& g : right.cells) g = 1e-2 * std::pow(body.cell_size, 3) * normal(random);
  if (c.held) {
    body.has_pins = true;
    body.inverse_masses[7] = 0.0;
    const Vec3 n = Vec3(1.0, 2.0, -1.0).normalized();
    blocked.push_back({11, body.inverse_masses[11] * (Eigen::Matrix3d::Identity() - n * n.transpose())});
    for (const auto& [particle, direction] :
         {std::pair{7, Vec3(Vec3::UnitX())}, {7, Vec3::UnitY()}, {7, Vec3::UnitZ()}, {11, n}}) {
      Eigen::VectorXd held = Eigen::VectorXd::Zero(matrix.rows());
      held.segment<3>(Eigen::Index{3} * particle) = direction;
      const Eigen::MatrixXd keep =
          Eigen::MatrixXd::Identity(matrix.rows(), matrix.rows()) - held * held.transpose();
      matrix = (keep * matrix * keep + held * held.transpose()).eval();
      right.nodes.add(particle, -direction * direction.dot(right.nodes.at(particle)));
    }
  }
  const CarrierSpace nothing;
  SaddleSolver solver(body);
  solver.linearize(body, at, c.stiffness * body.masses[0], 0.0, blocked, nothing);
  const int iterations = solver.solve(body, right, solution, 1e-9, 400);
  const auto nodes = static_cast<Eigen::Index>(3 * body.size());
  const auto flatten = [&](const SaddleVector& v) {
    Eigen::VectorXd flat(matrix.rows());
    for (std::size_t i = 0; i < body.size(); ++i)
      flat.segment<3>(static_cast<Eigen::Index>(3 * i)) = v.nodes.at(i);
    flat.tail(flat.size() - nodes) = Eigen::Map<const Eigen::VectorXd>(v.cells.data(), flat.size() - nodes);
    return flat;
  };
  const Eigen::VectorXd wanted = flatten(right), found = flatten(solution);
  EXPECT_LT((matrix * found - wanted).norm(), 1e-6 * wanted.norm());
  if (c.stiffness < 1e4) {  // beyond, the dense solve is the less exact one
    const Eigen::VectorXd dense = matrix.fullPivLu().solve(wanted);
    EXPECT_LT((found - dense).head(nodes).norm(), 1e-5 * dense.head(nodes).norm());
  }
  EXPECT_LT(iterations, c.box && !c.held ? 60 : 200);
}
INSTANTIATE_TEST_SUITE_P(
    Bodies, SaddleSolverCases,
    ::testing::Values(Case{"SoftBox", true, 0.1, false}, Case{"StiffBox", true, 1e3, false},
                      Case{"VeryStiffBox", true, 1e5, false}, Case{"HeldStiffBox", true, 1e3, true},
                      Case{"StiffBall", false, 1e3, false}, Case{"HeldStiffBall", false, 1e3, true}),
    [](const auto& param) { return std::string(param.param.name); });

/// The discrete gradient: the work of the mean forces is the energy lost, whatever the two ends.
TEST(StepForces, OfTheMiddleDoTheWorkOfTheEnergy) {
  const Body body = make_box({3, 2, 2});
  const SpringMaterial material{700.0, 300.0, 0.0};
  const SpringStencil springs = make_spring_stencil(body.mesh, body.mesh.positions, material);
  const Coordinates start = shaken(body, 0.04, 1), end = shaken(body, 0.04, 2);
  Coordinates forces(start.size());
  add_step_forces(springs, material, {0.5, 0.1}, start, end, forces);
  double work = 0.0;
  for (std::size_t i = 0; i < start.size(); ++i) work += forces.at(i).dot(end.at(i) - start.at(i));
  const double lost = spring_energy(springs, material, start) - spring_energy(springs, material, end);
  EXPECT_NEAR(work, lost, 1e-12 * spring_energy(springs, material, start));
}

/// At the end alone they are the forces there.
TEST(StepForces, OfTheEndAreTheForcesThere) {
  const Body body = make_box({3, 2, 2});
  const SpringMaterial material{700.0, 300.0, 0.0};
  const SpringStencil springs = make_spring_stencil(body.mesh, body.mesh.positions, material);
  const Coordinates start = shaken(body, 0.04, 1), end = shaken(body, 0.04, 2);
  Coordinates forces(start.size()), there(start.size());
  add_step_forces(springs, material, {1.0, 0.1}, start, end, forces);
  add_spring_forces(springs, material, end, start, there);
  for (std::size_t i = 0; i < start.size(); ++i) EXPECT_LT((forces.at(i) - there.at(i)).norm(), 1e-10);
}

}  // namespace
}  // namespace isochor

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <numbers>

#include "core/dynamics/cell_volume.h"
#include "core/dynamics/inversion.h"
#include "tests/newton/body.h"

namespace isochor {
namespace {

using namespace testing;

double largest_error(const Body& body, const Coordinates& points) {
  const VolumeModel model = body.model();
  double largest = 0.0;
  for (std::size_t c = 0; c < body.mesh.cells.size(); ++c) {
    CellCorners corners;
    for (int b = 0; b < 8; ++b) corners[b] = points.at(body.mesh.cells[c].corners[b]);
    const double volume = cell_volume(corners, body.mesh.cells[c].parity());
    largest = std::max(largest, std::abs(volume / model.rest_volumes[c] - 1.0));
  }
  return largest;
}

double total_error(const Body& body, const Coordinates& points) {
  const VolumeModel model = body.model();
  double excess = 0.0, total = 0.0;
  for (std::size_t c = 0; c < body.mesh.cells.size(); ++c) {
    CellCorners corners;
    for (int b = 0; b < 8; ++b) corners[b] = points.at(body.mesh.cells[c].corners[b]);
    excess += cell_volume(corners, body.mesh.cells[c].parity()) - model.rest_volumes[c];
    total += model.rest_volumes[c];
  }
  return std::abs(excess) / total;
}

struct Drift {
  double linear = 0.0, angular = 0.0;
};

/// Σ m Δx and Σ m x_start × Δx, relative to what the rounding of positions may make of them.
Drift drift(const Body& body, const Coordinates& start, const Coordinates& before, const Coordinates& after) {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  double linear_size = 0.0, angular_size = 0.0;
  for (std::size_t i = 0; i < start.size(); ++i) {
    const Vec3 impulse = body.masses[i] * (after.at(i) - before.at(i));
    const double size = body.masses[i] * start.at(i).norm();
    linear += impulse;
    angular += start.at(i).cross(impulse);
    linear_size += size;
    angular_size += start.at(i).norm() * size;
  }
  return {linear.norm() / linear_size, angular.norm() / angular_size};
}

/// Two boxes of cells that share no vertex where they touch: a lattice node of theirs has two vertices.
Body make_separated() {
  TetMesh mesh = make_box_lattice({4, 3, 3}, 0.125, Vec3::Zero());
  std::vector<std::int32_t> copies(mesh.positions.size(), -1);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    Cell& cell = mesh.cells[c];
    if (cell.coord[0] < 2) continue;
    for (int b = 0; b < 8; ++b) {
      const std::int32_t vertex = cell.corners[b];
      if (mesh.nodes[vertex][0] != 2 || mesh.nodes[vertex][1] == 3) continue;  // stays joined along an edge
      if (copies[vertex] < 0) {
        copies[vertex] = static_cast<std::int32_t>(mesh.positions.size());
        mesh.positions.push_back(mesh.positions[vertex]);
        mesh.nodes.push_back(mesh.nodes[vertex]);
      }
      for (int t = 0; t < 5; ++t)
        for (std::int32_t& corner : mesh.tets[5 * c + t])
          if (corner == vertex) corner = copies[vertex];
      cell.corners[b] = copies[vertex];
    }
  }
  return make_body(std::move(mesh));
}

struct State {
  const char* name;
  Body body;
  Coordinates start, predicted;
};

Eigen::Matrix3d squash(double height) {
  return Vec3(1.0, height, 1.0).asDiagonal();
}

State make_state(const std::string& name) {
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
  shear(0, 1) = 0.4;
  shear(2, 0) = 0.2;
  const auto from_rest = [](const char* label, Body body, const auto& predict) {
    Coordinates start(body.mesh.positions), predicted = predict(body);
    return State{label, std::move(body), std::move(start), std::move(predicted)};
  };
  const auto squashed = [](const Body& body) { return transformed(body, squash(0.8)); };
  const auto random = [](const Body& body) { return randomized(body, 0.1); };
  if (name == "squash") return from_rest("squash", make_box({6, 7, 8}), squashed);
  if (name == "random") return from_rest("random", make_box({8, 5, 4}), random);
  if (name == "shear")
    return from_rest("shear", make_box({4, 4, 4}),
                     [&](const Body& body) { return transformed(body, 1.05 * shear); });
  if (name == "rod") return from_rest("rod", make_box({20, 2, 3}), random);
  if (name == "ball") return from_rest("ball", make_ball(8), squashed);
  if (name == "torus") return from_rest("torus", make_torus(12), random);
  if (name == "ell") return from_rest("ell", make_ell(6), squashed);
  if (name == "separated") return from_rest("separated", make_separated(), random);
  return from_rest("one cell", make_box({1, 1, 1}), random);
}

class NewtonConvergence : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(States, NewtonConvergence,
                         ::testing::Values("squash", "random", "shear", "rod", "ball", "torus", "ell",
                                           "separated", "one cell"));

TEST_P(NewtonConvergence, MeetsEveryToleranceAndKeepsTheMomenta) {
  const State state = make_state(GetParam());
  const auto projector = make_newton_projector(state.body.model());
  for (const double tolerance : {1e-3, 1e-6, 1e-9, 1e-10, 1e-12}) {
    Coordinates points = state.predicted;
    ProjectionRequest request;
    request.start = &state.start;
    request.tolerance = tolerance;
    const ProjectionResult result = projector->project(request, points);
    EXPECT_TRUE(result.converged) << tolerance << " got " << result.max_error;
    EXPECT_TRUE(result.kept_directions) << tolerance;
    EXPECT_NEAR(result.max_error, largest_error(state.body, points), 1e-14);
    EXPECT_LE(largest_error(state.body, points), tolerance * (1.0 + 1e-6));
    EXPECT_LT(total_error(state.body, points), 1e-14);
    const Drift moved = drift(state.body, state.start, state.predicted, points);
    EXPECT_LT(moved.linear, 1e-15);
    EXPECT_LT(moved.angular, 1e-15);
  }
}

TEST(Newton, SeesInvertedTets) {
  int inverted = 0;
  for (const Body& body : {make_box({3, 4, 2}), make_separated()}) {
    const auto projector = make_newton_projector(body.model());
    for (unsigned seed = 1; seed <= 30; ++seed) {
      Coordinates points = randomized(body, 0.02 * seed, seed);
      const ProjectionResult result = projector->project({}, points);
      ASSERT_TRUE(result.inverted);
      EXPECT_EQ(*result.inverted, any_inverted(body.mesh, points)) << seed;
      inverted += *result.inverted;
    }
  }
  EXPECT_GT(inverted, 10);
  EXPECT_LT(inverted, 50);
}

TEST(Newton, HoldsPinnedParticlesAndCountsCellsWithoutARow) {
  const Body body = make_box({4, 5, 6});
  VolumeModel model = body.model();
  for (std::size_t i = 0; i < model.inverse_masses.size(); ++i)
    if (body.mesh.nodes[i][1] <= 1) model.inverse_masses[i] = 0.0;
  const Coordinates start(body.mesh.positions);
  Coordinates points = randomized(body, 0.05);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (model.inverse_masses[i] == 0.0) points.set(i, start.at(i));
  const Coordinates predicted = points;
  ProjectionRequest request{.start = &start, .tolerance = 1e-10};
  const ProjectionResult result = make_newton_projector(model)->project(request, points);
  EXPECT_TRUE(result.converged) << result.max_error;
  EXPECT_EQ(result.rowless_cells, 4 * 6);
  EXPECT_LE(largest_error(body, points), 1e-10);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_TRUE(model.inverse_masses[i] > 0.0 || points.at(i) == predicted.at(i));
}

TEST(Newton, NamesTheCellThatCannotMove) {
  const Body body = make_box({3, 3, 3});
  VolumeModel model = body.model();
  Coordinates points(body.mesh.positions);
  const Cell& held = body.mesh.cells[13];
  for (const std::int32_t corner : held.corners) model.inverse_masses[corner] = 0.0;
  points.add(held.corners[0], Vec3(0.01, 0.0, 0.0));
  const Coordinates start = points;
  ProjectionRequest request{.start = &start, .tolerance = 1e-8};
  const ProjectionResult result = make_newton_projector(model)->project(request, points);
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.worst_cell, 13);
  EXPECT_EQ(result.rowless_cells, 1);
  EXPECT_NEAR(result.max_error, largest_error(body, points), 1e-14);
}

TEST(Newton, BlockedParticlesStayOnTheirPlane) {
  const Body body = make_box({5, 6, 4});
  const VolumeModel model = body.model();
  const Coordinates start(body.mesh.positions);
  Coordinates points = transformed(body, squash(0.9));
  const Vec3 normal = Vec3(0.1, 1.0, -0.2).normalized();
  std::vector<BlockedParticle> blocked;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (const int level = body.mesh.nodes[i][1]; level == 0 || level == 6)
      blocked.push_back(
          {static_cast<std::int32_t>(i),
           model.inverse_masses[i] * (Eigen::Matrix3d::Identity() - normal * normal.transpose())});
  blocked.push_back({body.mesh.cells[60].corners[0], Eigen::Matrix3d::Zero()});
  const Coordinates predicted = points;
  const auto projector = make_newton_projector(model);
  ProjectionRequest request{.start = &start, .blocked = blocked, .tolerance = 1e-10};
  const ProjectionResult result = projector->project(request, points);
  EXPECT_TRUE(result.converged) << result.max_error;
  EXPECT_LE(largest_error(body, points), 1e-10);
  double moved = 0.0;
  for (const BlockedParticle& particle : blocked) {
    const Vec3 displacement = points.at(particle.particle) - predicted.at(particle.particle);
    EXPECT_LT(std::abs(displacement.dot(normal)), 1e-15);
    moved = std::max(moved, displacement.norm());
  }
  EXPECT_GT(moved, 1e-3);
  EXPECT_EQ(points.at(blocked.back().particle), predicted.at(blocked.back().particle));

  request.blocked = {};
  points = predicted;
  projector->project(request, points);
  EXPECT_GT(std::abs((points.at(0) - predicted.at(0)).dot(normal)), 1e-3) << "a block outlived its call";
}

// A rigid plate lies on the body: its particles follow it along the normal and slide across it. What the
// volume gives to the plate it takes from the rest of the body.
TEST(Newton, CarriesARigidBodyAndKeepsTheMomentum) {
  const Body body = make_box({4, 5, 4});
  const VolumeModel model = body.model();
  const Coordinates start(body.mesh.positions);
  const Vec3 normal = Vec3::UnitY(), center(-0.1, 1.2, 1.3);
  const double plate_mass = 3.0;
  Eigen::Matrix<double, 6, 6> mass = Eigen::Matrix<double, 6, 6>::Identity() * plate_mass;
  std::vector<BlockedParticle> blocked;
  std::vector<CarriedParticle> carried;
  for (std::size_t i = 0; i < start.size(); ++i) {
    if (body.mesh.nodes[i][1] != 5) continue;
    const Vec3 r = start.at(i) - center;
    Eigen::Matrix<double, 3, 6> map;
    map << Eigen::Matrix3d::Identity(),
        (Eigen::Matrix3d() << 0, r.z(), -r.y(), -r.z(), 0, r.x(), r.y(), -r.x(), 0).finished();
    map = (normal * normal.transpose() * map).eval();
    const auto particle = static_cast<std::int32_t>(i);
    carried.push_back({particle, map});
    blocked.push_back(
        {particle, model.inverse_masses[i] * (Eigen::Matrix3d::Identity() - normal * normal.transpose())});
    mass += body.masses[i] * map.transpose() * map;
  }
  std::vector<RigidCarrier> carriers{{carried, mass.inverse()}};
  std::vector<Vec3> forces(blocked.size());
  Coordinates points = transformed(body, squash(0.9));
  const Coordinates predicted = points;
  ProjectionRequest request;
  request.start = &start;
  request.blocked = blocked;
  request.blocked_forces = forces;
  request.carriers = carriers;
  request.tolerance = 1e-10;
  const ProjectionResult result = make_newton_projector(model)->project(request, points);
  EXPECT_TRUE(result.converged) << result.max_error;

  const Vec3 plate = carriers[0].motion.head<3>(), turn = carriers[0].motion.tail<3>();
  EXPECT_GT(plate.y(), 1e-3);
  for (const CarriedParticle& particle : carried) {
    const Vec3 moved = points.at(particle.particle) - predicted.at(particle.particle);
    const Vec3 expected = plate + turn.cross(start.at(particle.particle) - center);
    EXPECT_NEAR(moved.dot(normal), expected.dot(normal), 1e-14);
  }
  Vec3 linear = plate_mass * plate, angular = plate_mass * (turn + center.cross(plate));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 impulse = body.masses[i] * (points.at(i) - predicted.at(i));
    linear += impulse;
    angular += start.at(i).cross(impulse);
  }
  EXPECT_LT(linear.norm(), 1e-12);
  EXPECT_LT(angular.norm(), 1e-12);

  // M Δx = W-weighted force: tangentially the blocked forces are the particles' own impulses.
  for (std::size_t i = 0; i < blocked.size(); ++i) {
    const std::int32_t p = blocked[i].particle;
    const Vec3 impulse = body.masses[p] * (points.at(p) - predicted.at(p));
    EXPECT_NEAR(impulse.x(), forces[i].x(), 1e-12);
    EXPECT_NEAR(impulse.z(), forces[i].z(), 1e-12);
  }
}

TEST(Newton, EndsFiniteWhereNoSolutionIs) {
  const Body body = make_box({4, 4, 4});
  const VolumeModel model = body.model();
  const Coordinates start = transformed(body, squash(0.5));
  std::vector<BlockedParticle> blocked;
  for (std::size_t i = 0; i < start.size(); ++i) {
    Vec3 free = Vec3::Ones();
    for (int axis = 0; axis < 3; ++axis)
      if (body.mesh.nodes[i][axis] % 4 == 0) free[axis] = 0.0;
    if (free.sum() < 3.0)
      blocked.push_back(
          {static_cast<std::int32_t>(i), model.inverse_masses[i] * free.asDiagonal().toDenseMatrix()});
  }
  Coordinates points = start;
  ProjectionRequest request{.start = &start, .blocked = blocked, .tolerance = 1e-6};
  const ProjectionResult result = make_newton_projector(model)->project(request, points);
  EXPECT_FALSE(result.converged);
  EXPECT_NEAR(total_error(body, points), 0.5, 1e-12);
  EXPECT_NEAR(result.max_error, largest_error(body, points), 1e-14);
  EXPECT_LE(result.iterations, request.max_iterations);
}

// 91 with the box's diagonal as it is beneath the ball's faces.
TEST(Newton, RoundBodiesTakeFewIterations) {
  const Body body = make_ball(32);
  const Coordinates start(body.mesh.positions);
  Coordinates points = transformed(body, squash(0.8));
  const ProjectionResult result =
      make_newton_projector(body.model())->project({.start = &start, .tolerance = 1e-9}, points);
  EXPECT_TRUE(result.converged) << result.max_error;
  EXPECT_LT(result.linear_iterations, 80);
}

TEST(Newton, SurvivesAnyNumbers) {
  const Body body = make_box({3, 3, 3});
  const auto projector = make_newton_projector(body.model());
  const Coordinates start(body.mesh.positions);
  for (const double value : {std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity(), 1e308, 1e120, 1e30}) {
    Coordinates points = start;
    points.x[7] = value;
    const ProjectionResult result = projector->project({.start = &start}, points);
    EXPECT_TRUE(std::isfinite(result.max_error)) << value;
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_TRUE(points.at(i).allFinite() || (i == 7 && !std::isfinite(value))) << value;
  }
  for (const Vec3& scale : {Vec3(1, 1, 0), Vec3(1, 0, 0), Vec3(0, 0, 0), Vec3(1e-9, 1, 1), Vec3(-1, 1, 1)}) {
    Coordinates points = transformed(body, scale.asDiagonal());
    const Coordinates flat = points;
    const ProjectionResult result = projector->project({.start = &flat}, points);
    EXPECT_TRUE(std::isfinite(result.max_error)) << scale.transpose();
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_TRUE(points.at(i).allFinite()) << scale.transpose();
  }
  Coordinates squashed = transformed(body, squash(0.9));  // what overflowed before must not stay
  EXPECT_TRUE(projector->project({.start = &start}, squashed).converged);
}

/// Turned by that much within the step, gradients at its start lead nowhere: the linear solve sees it in tens
/// of iterations, not in a hundred, and the current ones lead to the volume.
TEST(Newton, SoonLeavesDirectionsThatLeadNowhere) {
  const Body body = make_box(Vec3i::Constant(4));
  const Coordinates start(body.mesh.positions);
  for (const double degrees : {90.0, 120.0}) {
    Coordinates points = randomized(body, 0.3);
    const Eigen::AngleAxisd turn(degrees * std::numbers::pi / 180.0, Vec3(1.0, 2.0, 3.0).normalized());
    for (std::size_t i = 0; i < points.size(); ++i) points.set(i, turn * points.at(i));
    ProjectionRequest request;
    request.start = &start;
    request.tolerance = 1e-6;
    const ProjectionResult result = make_newton_projector(body.model())->project(request, points);
    EXPECT_TRUE(result.converged);
    EXPECT_FALSE(result.kept_directions);
    EXPECT_LT(result.linear_iterations, 80) << degrees;
  }
}

TEST(Newton, MeetsOneConstraintATet) {
  const Body body = make_box({2, 2, 2});
  const Coordinates start(body.mesh.positions);
  Coordinates points = randomized(body, 0.05);
  ProjectionRequest request{.start = &start, .tolerance = 1e-9};
  const ProjectionResult result = make_newton_projector(body.model(true))->project(request, points);
  EXPECT_TRUE(result.converged) << result.max_error;
  for (const Tet& t : body.mesh.tets) {
    const double volume = tet_volume(points.at(t[0]), points.at(t[1]), points.at(t[2]), points.at(t[3]));
    const double rest = tet_volume(start.at(t[0]), start.at(t[1]), start.at(t[2]), start.at(t[3]));
    ASSERT_NEAR(volume / rest, 1.0, 1e-9);
  }
}

}  // namespace
}  // namespace isochor

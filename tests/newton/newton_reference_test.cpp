#include <gtest/gtest.h>

#include <Eigen/LU>

#include "core/dynamics/cell_volume.h"
#include "core/parallel/parallel.h"
#include "tests/newton/body.h"

namespace isochor {
namespace {

using namespace testing;

CellCorners corners_of(const Cell& cell, const Coordinates& points) {
  CellCorners corners;
  for (int b = 0; b < 8; ++b) corners[b] = points.at(cell.corners[b]);
  return corners;
}

Eigen::MatrixXd jacobian(const Body& body, const Coordinates& points) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(body.mesh.cells.size(), 3 * points.size());
  for (std::size_t c = 0; c < body.mesh.cells.size(); ++c) {
    const Cell& cell = body.mesh.cells[c];
    const CellCorners gradient = cell_volume_gradient(corners_of(cell, points), cell.parity());
    for (int b = 0; b < 8; ++b) result.row(c).segment<3>(3 * cell.corners[b]) += gradient[b];
  }
  return result;
}

Eigen::VectorXd volume_errors(const Body& body, const Coordinates& points) {
  const VolumeModel model = body.model();
  Eigen::VectorXd result(body.mesh.cells.size());
  for (std::size_t c = 0; c < body.mesh.cells.size(); ++c)
    result[c] = cell_volume(corners_of(body.mesh.cells[c], points), body.mesh.cells[c].parity()) -
                model.rest_volumes[c];
  return result;
}

/// Full Newton steps with a dense factorization of J(x) W J(start)ᵀ.
Coordinates dense_solution(const Body& body, const Coordinates& start, Coordinates points) {
  const Eigen::MatrixXd at_start = jacobian(body, start);
  Eigen::VectorXd weights(3 * points.size());
  for (std::size_t i = 0; i < points.size(); ++i) weights.segment<3>(3 * i).setConstant(1.0 / body.masses[i]);
  const Eigen::MatrixXd directions = weights.asDiagonal() * at_start.transpose();
  for (int i = 0; i < 20; ++i) {
    const Eigen::MatrixXd matrix = jacobian(body, points) * directions;
    const Eigen::VectorXd step = directions * matrix.partialPivLu().solve(-volume_errors(body, points));
    for (std::size_t p = 0; p < points.size(); ++p) points.add(p, step.segment<3>(3 * p));
  }
  return points;
}

double distance(const Coordinates& a, const Coordinates& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a.at(i) - b.at(i)).norm());
  return largest;
}

bool same_bits(const Coordinates& a, const Coordinates& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

Coordinates projected(VolumeProjector& projector, const Coordinates& start, Coordinates points,
                      double tolerance) {
  ProjectionRequest request;
  request.start = &start;
  request.tolerance = tolerance;
  const ProjectionResult result = projector.project(request, points);
  EXPECT_TRUE(result.converged) << result.max_error;
  return points;
}

TEST(NewtonReference, FindsTheSolutionOfADenseSolver) {
  for (const Body& body : {make_box({4, 3, 5}), make_ball(6), make_ell(4)}) {
    const Coordinates start = randomized(body, 0.05, 7), predicted = randomized(body, 0.1, 3);
    const auto projector = make_newton_projector(body.model());
    const Coordinates expected = dense_solution(body, start, predicted);
    const Coordinates found = projected(*projector, start, predicted, 1e-12);
    EXPECT_LT(distance(found, expected), 1e-9 * body.mesh.grid.spacing);
    EXPECT_GT(distance(found, predicted), 1e-2 * body.mesh.grid.spacing);
  }
}

// The solvers take different ways to different points, but all of them to the rest volumes.
TEST(NewtonReference, AgreesWithTheSweepsOnTheVolumes) {
  const Body body = make_box({3, 3, 3});
  const Coordinates start(body.mesh.positions), predicted = randomized(body, 0.03);
  std::vector<std::unique_ptr<VolumeProjector>> projectors;
  projectors.push_back(make_newton_projector(body.model()));
  projectors.push_back(make_scaling_projector(body.model()));
  projectors.push_back(make_gradient_projector(body.model()));
  const double rest = body.model().rest_volumes.front();
  for (const auto& projector : projectors) {
    Coordinates points = predicted;
    ProjectionRequest request;
    request.start = &start;
    request.tolerance = 1e-6;
    request.max_iterations = 2000;
    const ProjectionResult result = projector->project(request, points);
    EXPECT_TRUE(result.converged) << result.max_error;
    EXPECT_LT(volume_errors(body, points).cwiseAbs().maxCoeff() / rest, 1.01e-6);
  }
}

TEST(NewtonReference, GivesTheSameBitsForAnyNumberOfThreadsAndEveryTime) {
  const Body body = make_box({22, 21, 23});
  const Coordinates start(body.mesh.positions), predicted = randomized(body, 0.05);
  set_thread_count(1);
  const Coordinates expected = projected(*make_newton_projector(body.model()), start, predicted, 1e-9);
  const auto used = make_newton_projector(body.model());
  for (const int threads : {1, 2, 3}) {
    set_thread_count(threads);
    EXPECT_TRUE(same_bits(expected, projected(*used, start, predicted, 1e-9))) << threads;
  }
  set_thread_count(0);
}

// The rank of J W Jᵀ is lost along some modes when masses differ by six orders; the tolerance is not.
TEST(NewtonReference, MeetsTheToleranceWithMassRatiosOfAMillion) {
  Body body = make_box({6, 6, 6});
  for (std::size_t i = 0; i < body.masses.size(); ++i)
    if (body.mesh.nodes[i][1] > 3) body.masses[i] *= 1e6;
  const Coordinates start(body.mesh.positions), predicted = randomized(body, 0.05);
  projected(*make_newton_projector(body.model()), start, predicted, 1e-9);
}

}  // namespace
}  // namespace isochor

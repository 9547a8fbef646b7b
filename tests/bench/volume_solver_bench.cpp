// Time of one volume projection to 1e-9 in the worst cell, from the same state: Newton against the sweeps
// (counter max_error says what was reached). The growth over the number of cells is fitted for each shape.
#include <benchmark/benchmark.h>

#include "core/parallel/parallel.h"
#include "tests/newton/body.h"

namespace isochor {
namespace {

using namespace testing;

enum Shape : std::int64_t { box, ball, torus };
enum State : std::int64_t { squash, drop };
enum Solver : std::int64_t { newton, scaling, gradient };
constexpr const char* shape_names[] = {"box", "ball", "torus"};
constexpr const char* state_names[] = {"squash", "drop"};
constexpr const char* solver_names[] = {"newton", "scaling", "gradient"};

Body make_shape(std::int64_t shape, int n) {
  if (shape == ball) return make_ball(n);
  if (shape == torus) return make_torus(n);
  return make_masked(n, [](const Vec3&) { return true; });
}

struct Problem {
  Coordinates start, predicted;
  std::vector<BlockedParticle> blocked;
};

/// At rest, then 80 % of its height within the step.
Problem squashed(const Body& body) {
  return {Coordinates(body.mesh.positions), transformed(body, Vec3(1.0, 0.8, 1.0).asDiagonal()), {}};
}

/// At rest on a sphere of half its width, hit at 3 m/s with 60 steps a second.
Problem dropped(const Body& body) {
  Problem problem{Coordinates(body.mesh.positions), Coordinates(body.mesh.positions), {}};
  const VolumeModel model = body.model();
  const double lowest = *std::min_element(problem.start.y.begin(), problem.start.y.end());
  const Vec3 center(0.05, lowest - 1.0, 0.03);
  for (std::size_t i = 0; i < problem.start.size(); ++i) {
    Vec3 p = problem.start.at(i) - Vec3(0.0, 3.0 / 60.0, 0.0);
    if ((p - center).norm() < 1.0) {
      const Vec3 normal = (p - center).normalized();
      p = center + normal;
      problem.blocked.push_back(
          {static_cast<std::int32_t>(i),
           model.inverse_masses[i] * (Eigen::Matrix3d::Identity() - normal * normal.transpose())});
    }
    problem.predicted.set(i, p);
  }
  return problem;
}

std::unique_ptr<VolumeProjector> make_projector(std::int64_t solver, const Body& body) {
  if (solver == scaling) return make_scaling_projector(body.model());
  if (solver == gradient) return make_gradient_projector(body.model());
  return make_newton_projector(body.model());
}

void project(benchmark::State& state) {
  const std::int64_t solver = state.range(0);
  set_thread_count(static_cast<int>(state.range(4)));
  const Body body = make_shape(state.range(1), static_cast<int>(state.range(3)));
  const Problem problem = state.range(2) == squash ? squashed(body) : dropped(body);
  const auto projector = make_projector(solver, body);
  ProjectionResult result;
  Coordinates points = problem.predicted;
  for (auto _ : state) {
    points = problem.predicted;
    ProjectionRequest request;
    request.start = &problem.start;
    request.blocked = problem.blocked;
    request.tolerance = 1e-9;
    result = projector->project(request, points);
  }
  set_thread_count(0);
  state.SetLabel(std::string(solver_names[solver]) + " " + shape_names[state.range(1)] + " " +
                 state_names[state.range(2)]);
  state.SetComplexityN(static_cast<std::int64_t>(body.mesh.cells.size()));
  state.counters["cells"] = static_cast<double>(body.mesh.cells.size());
  state.counters["max_error"] = result.max_error;
  state.counters["iterations"] = result.iterations;
  state.counters["linear_iterations"] = result.linear_iterations;
}

void add(Solver solver, Shape shape, State start, std::initializer_list<std::int64_t> sizes, int threads) {
  auto* entry = benchmark::RegisterBenchmark("volume", project)
                    ->ArgNames({"solver", "shape", "state", "n", "threads"})
                    ->Unit(benchmark::kMillisecond);
  if (threads > 1) entry->UseRealTime();
  for (const std::int64_t n : sizes) entry->Args({solver, shape, start, n, threads});
  if (sizes.size() > 2) entry->Complexity();
}

const bool registered = [] {
  for (const State start : {squash, drop}) {
    for (const Shape shape : {box, ball, torus})
      if (start == squash || shape != torus)  // whose hole the sphere would enter
        add(newton, shape, start, {8, 16, 32}, 1);
    add(newton, box, start, {16, 32}, 2);
    for (const Solver solver : {scaling, gradient}) add(solver, box, start, {4, 6, 8}, 1);
  }
  return true;
}();

}  // namespace
}  // namespace isochor

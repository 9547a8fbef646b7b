// A frame of 1/60 s: each spring integrator, contacts, recovery from inverted cells, and rigid bodies alone,
// with the growth over the number of cells (of bodies for the rigid ones). One thread; CPU time.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/parallel/parallel.h"
#include "core/scene/simulation.h"

namespace isochor {
namespace {

SceneBody named(std::string name, std::variant<DeformableBody, RigidBody> kind, const Vec3& position) {
  SceneBody body;
  body.name = std::move(name);
  body.kind = std::move(kind);
  body.position = position;
  return body;
}

/// A cube of 1 m and n³ cells; its springs make one material at every n.
DeformableBody cube(int n) {
  DeformableBody body;
  body.shape = LatticeShape{Vec3i::Constant(n), 1.0 / n, Vec3::Constant(-0.5)};
  body.edge_modulus = body.diagonal_modulus = 1e5;
  return body;
}

SceneBody ground() {
  RigidBody plane;
  plane.shape = PlaneShape{};
  plane.is_static = true;
  return named("ground", plane, Vec3::Zero());
}

Scene endless(std::vector<SceneBody> bodies) {
  Scene scene;
  scene.duration = std::nullopt;
  scene.bodies = std::move(bodies);
  return scene;
}

/// Swinging freely from 5 % of strain.
Scene swinging(int n, SpringIntegrator springs) {
  DeformableBody body = cube(n);
  body.start.affine = Vec3(1.05, 1.0 / std::sqrt(1.05), 1.0 / std::sqrt(1.05)).asDiagonal();
  Scene scene = endless({named("cube", body, Vec3::Zero())});
  scene.gravity = Vec3::Zero();
  scene.solver.springs = springs;
  return scene;
}

Scene resting(int n) {
  return endless({named("cube", cube(n), Vec3(0.0, 0.5, 0.0)), ground()});
}

Scene stacked(int boxes) {
  Scene scene = endless({ground()});
  RigidBody box;
  box.shape = BoxShape{Vec3(0.5, 0.25, 0.5)};
  box.mass = 1.0;
  for (int i = 0; i < boxes; ++i)  // five high, side by side
    scene.bodies.push_back(named("box " + std::to_string(i), box,
                                 Vec3(2.0 * static_cast<double>(i / 5), 0.25 + 0.5 * (i % 5), 0.0)));
  return scene;
}

/// Hanging links between ball joints.
Scene chained(int links) {
  Scene scene = endless({});
  RigidBody link;
  link.shape = CapsuleShape{0.05, 0.1};
  for (int i = 0; i <= links; ++i) {
    link.is_static = i == 0;
    link.mass = i == 0 ? std::nullopt : std::optional(1.0);
    scene.bodies.push_back(named("link " + std::to_string(i), link, Vec3(0.4 * i, 0.0, 0.0)));
    if (i > 0)
      scene.joints.push_back({JointType::ball, "link " + std::to_string(i - 1), "link " + std::to_string(i),
                              Vec3(0.4 * i - 0.2, 0.0, 0.0), Vec3::UnitY()});
  }
  return scene;
}

void step(benchmark::State& state, const Scene& scene, std::int64_t size) {
  set_thread_count(1);
  Progress quiet;
  const auto simulation = compile(scene, quiet);
  for (int i = 0; i < 5; ++i) simulation->advance(quiet);
  for (auto _ : state) simulation->advance(quiet);
  set_thread_count(0);
  const Metrics metrics = simulation->snapshot().metrics;
  state.SetComplexityN(size);
  state.counters["size"] = static_cast<double>(size);
  state.counters["max_cell_error"] = metrics.max_cell_volume_error;
  state.counters["substeps"] = metrics.substeps;
}

void frame_of_springs(benchmark::State& state, SpringIntegrator springs) {
  const int n = static_cast<int>(state.range(0));
  step(state, swinging(n, springs), state.range(0) * state.range(0) * state.range(0));
}

/// The first frame after every particle was moved by up to a cell.
void recovery(benchmark::State& state) {
  set_thread_count(1);
  Progress quiet;
  const int n = static_cast<int>(state.range(0));
  Scene scene = swinging(n, SpringIntegrator::automatic);
  std::get<DeformableBody>(scene.bodies[0].kind).start = StartState{.randomize = 1.0};
  for (auto _ : state) {
    state.PauseTiming();
    const auto simulation = compile(scene, quiet);
    state.ResumeTiming();
    simulation->advance(quiet);
  }
  set_thread_count(0);
  state.SetComplexityN(state.range(0) * state.range(0) * state.range(0));
  state.counters["size"] = static_cast<double>(n) * n * n;
}

template <class Function>
void over(const char* name, const char* unit, std::initializer_list<std::int64_t> sizes, Function function) {
  auto* entry = benchmark::RegisterBenchmark(name, function)
                    ->ArgName(unit)
                    ->Unit(benchmark::kMillisecond)
                    ->MinTime(0.2)
                    ->Complexity();
  for (const std::int64_t size : sizes) entry->Arg(size);
}

const bool registered = [] {
  const auto springs = [](const char* name, SpringIntegrator integrator) {
    over(name, "n", {4, 8, 16}, [=](benchmark::State& state) { frame_of_springs(state, integrator); });
  };
  springs("springs/symplectic", SpringIntegrator::symplectic);
  springs("springs/implicit", SpringIntegrator::implicit);
  springs("springs/energy_momentum", SpringIntegrator::energy_momentum);
  over("contact/cube_on_the_ground", "n", {4, 8, 16}, [](benchmark::State& state) {
    step(state, resting(static_cast<int>(state.range(0))), state.range(0) * state.range(0) * state.range(0));
  });
  over("recovery/randomised", "n", {2, 4, 8}, recovery);
  over("rigid/stacks_of_five", "boxes", {5, 20, 80}, [](benchmark::State& state) {
    step(state, stacked(static_cast<int>(state.range(0))), state.range(0));
  });
  over("rigid/chain", "links", {4, 16, 64}, [](benchmark::State& state) {
    step(state, chained(static_cast<int>(state.range(0))), state.range(0));
  });
  return true;
}();

}  // namespace
}  // namespace isochor

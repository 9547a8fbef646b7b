// count_step SCENE FRAMES: steps a cube of 8³ cells so often, on one thread, and prints a hash of where its
// particles end. For tests/bench/instructions.py, which counts the instructions of a frame. SCENE is one of:
//   by_hand   the step as a person would write it who needs nothing else
//   plain     the same by the scene's stepper
//   and plain with one thing more, which it names.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <string>

#include "core/parallel/parallel.h"
#include "core/scene/build_world.h"
#include "core/scene/plan.h"
#include "core/scene/stepper.h"

namespace isochor {
namespace {

constexpr int cells = 8;
/// Of every substep: what is asked for below 1e-7 is never left for the last one of a frame.
constexpr double tolerance = 5e-8;

DeformableBody& cube_of(Scene& scene) {
  return std::get<DeformableBody>(scene.bodies[0].kind);
}

/// Swinging freely on its edges, without gravity.
Scene plain() {
  DeformableBody body;
  body.shape = LatticeShape{Vec3i::Constant(cells), 1.0 / cells, Vec3::Constant(-0.5)};
  body.edge_modulus = 1e5;
  body.diagonal_modulus = 0.0;
  body.start.affine = Vec3(1.05, 1.0 / std::sqrt(1.05), 1.0 / std::sqrt(1.05)).asDiagonal();
  Scene scene;
  scene.duration = std::nullopt;
  scene.gravity = Vec3::Zero();
  scene.solver.tolerance = tolerance;
  scene.solver.springs = SpringIntegrator::symplectic;
  scene.solver.substeps = 8;
  scene.bodies.emplace_back().name = "cube";
  scene.bodies[0].kind = std::move(body);
  scene.bodies[0].position = Vec3(0.0, 2.0, 0.0);
  return scene;
}

void add_rigid(Scene& scene, const Vec3& position, std::optional<double> mass) {
  RigidBody ball;
  ball.shape = SphereShape{0.25};
  ball.is_static = !mass;
  ball.mass = mass;
  SceneBody& body = scene.bodies.emplace_back();
  body.name = "ball " + std::to_string(scene.bodies.size());
  body.kind = ball;
  body.position = position;
}

const std::map<std::string, std::function<void(Scene&)>> additions{
    {"gravity", [](Scene& s) { s.gravity = Vec3(0.0, -9.81, 0.0); }},
    {"diagonals", [](Scene& s) { cube_of(s).diagonal_modulus = 1e4; }},
    {"damping", [](Scene& s) { cube_of(s).damping = 1e-4; }},
    {"a_rigid_body_far_away", [](Scene& s) { add_rigid(s, Vec3(0.0, -50.0, 0.0), std::nullopt); }},
    {"one_with_a_mass_far_away", [](Scene& s) { add_rigid(s, Vec3(0.0, -50.0, 0.0), 1.0); }},
    {"self_contact", [](Scene& s) { cube_of(s).self_contact = true; }},
};

void forces(SoftBody& body) {
  for (auto* axis : {&body.forces.x, &body.forces.y, &body.forces.z})
    std::fill(axis->begin(), axis->end(), 0.0);
  add_spring_forces(body.springs.edges, body.material.edge, 0.0, body.positions, body.velocities,
                    body.forces);
}

void frames_by_hand(World& world, int frames) {
  SoftBody& body = world.soft[0].body;
  const int substeps = world.substeps * frames;
  const double h = 1.0 / (world.scene.frame_rate * world.substeps);
  forces(body);
  for (int i = 0; i < substeps; ++i) {
    keep_start(body);
    kick_by_forces(body, 0.5 * h);
    drift(body, h);
    body.projector->begin_step(body.start_positions, h, body.positions);
    ProjectionRequest request;
    request.start = &body.start_positions;
    request.tolerance = tolerance;
    body.projector->project(request, body.positions);
    velocities_from_positions(body, h);
    forces(body);
    kick_by_forces(body, 0.5 * h);
  }
}

void frames_of_stepper(World& world, int frames) {
  const Progress quiet;
  Stepper stepper(world);
  for (int i = 0; i < frames; ++i) stepper.frame(1.0 / world.scene.frame_rate, quiet);
}

/// FNV-1a.
std::uint64_t hash_of(const Coordinates& points) {
  std::uint64_t hash = 14695981039346656037U;
  for (const auto* axis : {&points.x, &points.y, &points.z})
    for (const double value : *axis) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, &value, sizeof bits);
      hash = (hash ^ bits) * 1099511628211U;
    }
  return hash;
}

int run(const std::string& name, int frames) {
  Scene scene = plain();
  const auto addition = additions.find(name);
  if (addition != additions.end())
    addition->second(scene);
  else if (name != "plain" && name != "by_hand")
    return std::fprintf(stderr, "no scene %s\n", name.c_str()), 2;
  set_thread_count(1);
  Progress quiet;
  World world = build_world(scene, quiet);
  plan_phases(world);
  (name == "by_hand" ? frames_by_hand : frames_of_stepper)(world, frames);
  std::printf("%016llx\n", static_cast<unsigned long long>(hash_of(world.soft[0].body.positions)));
  return 0;
}

}  // namespace
}  // namespace isochor

int main(int count, char** arguments) {
  if (count != 3) return std::fprintf(stderr, "count_step SCENE FRAMES\n"), 2;
  return isochor::run(arguments[1], std::stoi(arguments[2]));
}

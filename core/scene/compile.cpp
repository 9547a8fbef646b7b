#include <chrono>
#include <cmath>

#include "core/parallel/cancel_scope.h"
#include "core/scene/build_world.h"
#include "core/scene/metrics.h"
#include "core/scene/plan.h"
#include "core/scene/simulation.h"
#include "core/scene/stepper.h"

namespace isochor {
namespace {

class CompiledSimulation final : public Simulation {
 public:
  explicit CompiledSimulation(World world) : world_(std::move(world)), stepper_(world_) {
    plan_phases(world_);
    metrics_ = measure(world_, StepStats{});
  }
  CompiledSimulation(const CompiledSimulation&) = delete;
  CompiledSimulation& operator=(const CompiledSimulation&) = delete;

  Snapshot snapshot() const override {
    Snapshot frame;
    frame.seq = seq_;
    frame.t = static_cast<double>(seq_) / world_.scene.frame_rate;
    frame.metrics = metrics_;
    frame.bodies.resize(world_.scene.bodies.size());
    for (std::size_t i = 0; i < frame.bodies.size(); ++i) frame.bodies[i].id = static_cast<int>(i);
    for (const SceneSoftBody& soft : world_.soft) {
      auto& positions = frame.bodies[soft.id].positions;
      positions.resize(soft.body.size());
      for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = soft.body.positions.at(i);
    }
    for (int r = 0; r < world_.rigid.size(); ++r) {
      frame.bodies[world_.rigid_ids[r]].position = world_.rigid.pose(r).to_world(-world_.rigid_centers[r]);
      frame.bodies[world_.rigid_ids[r]].orientation = world_.rigid.pose(r).orientation;
    }
    return frame;
  }

  Snapshot step(const Progress& progress) override {
    advance(progress);
    return snapshot();
  }

  void advance(const Progress& progress) override {
    const CancelScope scope(progress);
    const auto begin = std::chrono::steady_clock::now();
    const StepStats stats = stepper_.frame(1.0 / world_.scene.frame_rate, progress);
    const auto end = std::chrono::steady_clock::now();
    metrics_ = measure(world_, stats);
    metrics_.step_ms = std::chrono::duration<double, std::milli>(end - begin).count();
    ++seq_;
  }

  // Frame n stands at n/frame_rate; the last one is the first that reaches the duration.
  bool finished() const override {
    if (!world_.scene.duration) return false;
    return static_cast<double>(seq_) >= *world_.scene.duration * world_.scene.frame_rate - 1e-9;
  }

  void continue_from(const Simulation& simulation) override {
    const auto& before = dynamic_cast<const CompiledSimulation&>(simulation);  // compile() makes no others
    continue_state(world_, before.world_);
    seq_ = before.seq_;
    plan_phases(world_);
    metrics_ = measure(world_, StepStats{});
  }

  const Scene& scene() const override { return world_.scene; }
  std::vector<PlannedPhase> plan() const override {
    PhaseList phases = world_.phases;
    measure_phases(world_, phases);
    return phases.plan();
  }

  std::vector<BodyTopology> topology() const override {
    std::vector<BodyTopology> bodies(world_.scene.bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const SceneBody& source = world_.scene.bodies[i];
      bodies[i].id = static_cast<int>(i);
      bodies[i].name = source.name;
      bodies[i].scale = source.scale;
      if (const auto* rigid = std::get_if<RigidBody>(&source.kind)) bodies[i].shape = rigid->shape;
    }
    for (int r = 0; r < world_.rigid.size(); ++r) {
      if (world_.rigid.shape(r).type() == ShapeType::plane) continue;
      const Box bounds = world_.rigid.shape(r).bounds();
      const Vec3& center = world_.rigid_centers[r];
      bodies[world_.rigid_ids[r]].bounds = Box{bounds.min + center, bounds.max + center};
    }
    for (const SceneSoftBody& soft : world_.soft) {
      BodyTopology& body = bodies[soft.id];
      body.deformable = true;
      body.mesh = soft.body.mesh;
      body.rest_positions = soft.body.rest_positions;
      body.masses = soft.body.masses;
      body.model = soft.model;
    }
    return bodies;
  }

  void grab(std::optional<Grab> grab) override {
    world_.grab = grab;
    plan_phases(world_);
  }

  void move_body(int body, const Vec3& position, const Eigen::Quaterniond& orientation) override {
    for (int r = 0; r < world_.rigid.size(); ++r)
      if (world_.rigid_ids[r] == body)
        world_.rigid.move_body(r, {position, orientation.normalized()}, 1.0 / world_.scene.frame_rate);
  }

  void set_gravity(const Vec3& gravity) override {
    world_.scene.gravity = gravity;
    world_.rigid.set_gravity(gravity);
    plan_phases(world_);
  }

  void set_solver(const SolverOptions& solver) override {
    const bool rebuild =
        solver.volume != world_.scene.solver.volume || solver.constraint != world_.scene.solver.constraint;
    world_.scene.solver = solver;
    if (rebuild)
      for (SceneSoftBody& soft : world_.soft) build_projector(soft, solver);
    plan_phases(world_);
  }

  void set_material(int body, const SpringSettings& springs) override {
    for (SceneSoftBody& soft : world_.soft) {
      if (soft.id != body) continue;
      soft.body.material = spring_material(springs, soft.body.cell_size);
      build_springs(soft);
    }
    plan_phases(world_);
  }

 private:
  World world_;
  Stepper stepper_;
  Metrics metrics_;
  std::int64_t seq_ = 0;
};

}  // namespace

std::unique_ptr<Simulation> compile(const Scene& scene, Progress& progress) {
  const CancelScope scope(progress);
  return std::make_unique<CompiledSimulation>(build_world(scene, progress));
}

}  // namespace isochor

#pragma once
#include <cmath>
#include <memory>
#include <vector>

#include "core/scene/simulation.h"

namespace isochor::test {

/// A simulation whose state is known in closed form: a box of cells that moves up by `lift` a frame. For
/// tests of what stands around a simulation (codec, streams), not of physics.
class FakeSimulation final : public Simulation {
 public:
  FakeSimulation(const Vec3i& cells, double cell_size, std::int64_t frames)
      : mesh_(std::make_shared<TetMesh>(make_box_lattice(cells, cell_size, Vec3::Zero()))), frames_(frames) {
    scene_.name = "lift";
    scene_.frame_rate = 60.0;
    scene_.duration.reset();
  }

  static constexpr double lift = 0.5;

  Snapshot snapshot() const override {
    Snapshot frame;
    frame.seq = seq_;
    frame.t = static_cast<double>(seq_) / scene_.frame_rate;
    frame.bodies.resize(2);
    frame.bodies[0].positions = mesh_->positions;
    for (Vec3& p : frame.bodies[0].positions) p.y() += lift * static_cast<double>(seq_);
    frame.bodies[1].id = 1;
    frame.bodies[1].position = Vec3(0.0, -1.0, 0.25);
    return frame;
  }
  Snapshot step(const Progress& progress) override {
    progress.throw_if_cancelled();
    ++seq_;
    return snapshot();
  }
  bool finished() const override { return seq_ >= frames_; }
  void continue_from(const Simulation& before) override { seq_ = before.snapshot().seq; }
  const Scene& scene() const override { return scene_; }
  std::vector<PlannedPhase> plan() const override {
    return {{"springs", true, "the scene has \"springs\"", 128, 0.5},
            {"contacts", false, "no rigid body", 0, 0.0}};
  }
  std::vector<BodyTopology> topology() const override {
    std::vector<BodyTopology> bodies(2);
    bodies[0].name = "box";
    bodies[0].deformable = true;
    bodies[0].mesh = mesh_;
    bodies[0].rest_positions = mesh_->positions;
    bodies[0].masses.assign(mesh_->positions.size(), 0.1);
    bodies[1].id = 1;
    bodies[1].name = "ball";
    bodies[1].shape = SphereShape{0.5};
    bodies[1].bounds = Box{Vec3::Constant(-0.5), Vec3::Constant(0.5)};
    return bodies;
  }
  void grab(std::optional<Grab> grab) override { grab_ = grab; }
  void move_body(int, const Vec3&, const Eigen::Quaterniond&) override {}
  void set_gravity(const Vec3& gravity) override { scene_.gravity = gravity; }
  void set_solver(const SolverOptions& solver) override { scene_.solver = solver; }
  void set_material(int, const SpringSettings&) override {}

 private:
  std::shared_ptr<const TetMesh> mesh_;
  Scene scene_;
  std::optional<Grab> grab_;
  std::int64_t seq_ = 0, frames_;
};

}  // namespace isochor::test

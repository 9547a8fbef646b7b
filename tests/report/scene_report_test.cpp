#include "core/report/scene_report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/report/stability.h"
#include "core/scene/simulation.h"

namespace isochor {
namespace {

DeformableBody cube(int cells, double size) {
  DeformableBody body;
  body.shape = LatticeShape{Vec3i::Constant(cells), size / cells, Vec3::Constant(-0.5 * size)};
  return body;
}

Scene one_body(DeformableBody body, double duration) {
  Scene scene;
  scene.name = "one body";
  scene.duration = duration;
  SceneBody cube;
  cube.name = "cube";
  cube.kind = std::move(body);
  scene.bodies.push_back(std::move(cube));
  return scene;
}

/// All else as the scene has it.
SceneAxes only_substeps(std::vector<int> substeps) {
  SceneAxes axes;
  axes.solvers.emplace(), axes.springs.emplace(), axes.tolerances.emplace(), axes.resolutions.emplace();
  axes.substeps = std::move(substeps);
  return axes;
}

/// Half kicks at both ends of a substep are exact under constant acceleration. What is left is round-off: a
/// velocity is a difference of positions over h, ε·x/h ≈ 1e-12 m/s a substep, over 480 substeps of the
/// reference and more.
TEST(SceneReport, FreeFallIsExactAtEveryStep) {
  const Scene scene = one_body(cube(2, 1.0), 0.5);
  SceneReportOptions options;
  options.axes = only_substeps({1, 2, 4, 8});
  options.repeats = 1;
  Progress quiet;
  const SceneReport report = report_scene(scene, options, quiet);
  ASSERT_EQ(report.points.size(), 4u);
  for (const ScenePoint& point : report.points) {
    EXPECT_EQ(point.outcome, Outcome::converged) << point.reason;
    EXPECT_LT(point.errors.trajectory_max, 1e-9);
    EXPECT_LT(point.errors.linear_momentum, 1e-9);
    EXPECT_LT(point.errors.max_cell_volume, point.settings.tolerance);
  }
}

/// A cube stretched a little along one axis at constant volume swings; the error falls with the square of the
/// step.
TEST(SceneReport, AnOscillationConvergesWithTheSecondOrder) {
  DeformableBody body = cube(2, 1.0);
  body.edge_stiffness = body.diagonal_stiffness = 1e4;
  body.start.affine = Vec3(1.02, 1.0 / std::sqrt(1.02), 1.0 / std::sqrt(1.02)).asDiagonal();
  Scene scene = one_body(body, 0.25);
  scene.gravity = Vec3::Zero();
  SceneReportOptions options;
  options.axes = only_substeps({8, 16, 32});
  options.axes.tolerances = {1e-10};
  options.repeats = 1;
  Progress quiet;
  const SceneReport report = report_scene(scene, options, quiet);
  ASSERT_EQ(report.points.size(), 3u);
  bool seen = false;
  for (const FittedOrder& order : fitted_orders(report))
    if (order.error == "trajectory_rms" && order.axis == "h") {
      seen = true;
      EXPECT_NEAR(order.order, 2.0, 0.2);
    }
  EXPECT_TRUE(seen);
}

/// One cell of mass M, its edges of stiffness k, swinging by x(1 + e), y and z(1 − e/2): springs store
/// 3kL²e², motion (3/16)ML²ė², so ω² = 16k/M; diagonals and volume are at rest to first order. Half kicks at
/// both ends keep ½mω²x²(1 − ((ωh)² / 4)sin²) of the energy, so that its error is (ωh)²/4.
TEST(SceneReport, ASpringsOscillationHasTheEnergyErrorOfItsStep) {
  DeformableBody body = cube(1, 1.0);
  body.masses = MassLumping::equal;
  body.edge_stiffness = 1e4;
  body.start.affine = Vec3(1.001, 1.0 / std::sqrt(1.001), 1.0 / std::sqrt(1.001)).asDiagonal();
  Scene scene = one_body(body, 0.5);
  scene.gravity = Vec3::Zero();
  SceneReportOptions options;
  options.axes = only_substeps({1, 2, 4, 8});
  options.axes.tolerances = {1e-12};
  options.reference_tolerance = 1e-12;
  options.repeats = 1;
  Progress quiet;
  const SceneReport report = report_scene(scene, options, quiet);
  ASSERT_EQ(report.points.size(), 4u);
  for (const ScenePoint& point : report.points) {
    const double omega = std::sqrt(16.0 * 1e4 / 1000.0), h = 1.0 / (60.0 * point.settings.substeps);
    EXPECT_NEAR(point.errors.energy / (omega * omega * h * h / 4.0), 1.0, 0.02) << point.settings.substeps;
  }
  int seen = 0;
  for (const FittedOrder& order : fitted_orders(report))
    if (order.axis == "h" && (order.error == "trajectory_rms" || order.error == "energy")) {
      ++seen;
      EXPECT_NEAR(order.order, 2.0, 0.1);
    }
  EXPECT_EQ(seen, 2);
}

/// Another simulation, of which every frame after the first is changed.
class Planted : public Simulation {
 public:
  using Change = std::function<void(Snapshot&)>;
  Planted(std::unique_ptr<Simulation> inner, Change change)
      : inner_(std::move(inner)), change_(std::move(change)) {}
  Snapshot snapshot() const override { return inner_->snapshot(); }
  Snapshot step(const Progress& progress) override {
    Snapshot frame = inner_->step(progress);
    change_(frame);
    return frame;
  }
  bool finished() const override { return inner_->finished(); }
  void continue_from(const Simulation& before) override { inner_->continue_from(before); }
  const Scene& scene() const override { return inner_->scene(); }
  std::vector<PlannedPhase> plan() const override { return inner_->plan(); }
  std::vector<BodyTopology> topology() const override { return inner_->topology(); }
  void grab(std::optional<Grab> grab) override { inner_->grab(grab); }
  void move_body(int body, const Vec3& p, const Eigen::Quaterniond& q) override {
    inner_->move_body(body, p, q);
  }
  void set_gravity(const Vec3& gravity) override { inner_->set_gravity(gravity); }
  void set_solver(const SolverOptions& solver) override { inner_->set_solver(solver); }
  void set_material(int body, const SpringSettings& springs) override { inner_->set_material(body, springs); }

 private:
  std::unique_ptr<Simulation> inner_;
  Change change_;
};

class Endless : public Planted {
 public:
  explicit Endless(std::unique_ptr<Simulation> inner) : Planted(std::move(inner), {}) {}
  Snapshot step(const Progress& progress) override {
    for (;;) progress.throw_if_cancelled();
  }
};

/// Leaves the reference as it is.
auto planting(Planted::Change change) {
  return [change](const Scene& part, Progress& progress) -> std::unique_ptr<Simulation> {
    auto simulation = compile(part, progress);
    if (part.solver.tolerance == SceneReportOptions().reference_tolerance) return simulation;
    return std::make_unique<Planted>(std::move(simulation), change);
  };
}

/// In flight without gravity, where all else is exact.
TEST(SceneReport, APlantedErrorIsSeenAsWhatItIs) {
  Scene scene = one_body(cube(2, 1.0), 0.1);
  scene.gravity = Vec3::Zero();
  scene.bodies[0].velocity =
      Vec3(40.0, 0.0, 0.0);  // faster than its size over the duration: that is the scale
  SceneReportOptions options;
  options.axes = only_substeps({1});
  options.repeats = 1;
  options.build = planting([](Snapshot& frame) {
    for (Vec3& position : frame.bodies[0].positions) position += Vec3(0.03, 0.0, 0.04);
    frame.metrics.kinetic_energy *= 1.25;
    frame.metrics.linear_momentum *= 1.5;
    frame.metrics.max_cell_volume_error = 0.125;
  });
  Progress quiet;
  const SceneErrors errors = report_scene(scene, options, quiet).points.at(0).errors;
  EXPECT_NEAR(errors.trajectory_rms, 0.05, 1e-9);
  EXPECT_NEAR(errors.trajectory_max, 0.05, 1e-9);
  EXPECT_NEAR(errors.energy, 0.25, 1e-9);
  EXPECT_NEAR(errors.linear_momentum, 0.5, 1e-9);
  EXPECT_EQ(errors.max_cell_volume, 0.125);
}

/// Two that meet head-on have no momentum together, which an error could be relative to.
TEST(SceneReport, WithoutDeformableBodiesTheRigidOnesSetTheScale) {
  Scene scene;
  scene.duration = 0.5;
  scene.gravity = Vec3::Zero();
  for (const double side : {-1.0, 1.0}) {
    SceneBody ball;
    ball.name = side < 0.0 ? "left" : "right";
    RigidBody rigid;
    rigid.shape = SphereShape{0.1};
    rigid.mass = 2.0;
    ball.kind = rigid;
    ball.position = Vec3(0.5 * side, 0.0, 0.0), ball.velocity = Vec3(-side, 0.0, 0.0);
    scene.bodies.push_back(ball);
  }
  SceneReportOptions options;
  options.axes = only_substeps({1});
  options.repeats = 1;
  options.build = planting([](Snapshot& frame) { frame.metrics.linear_momentum += Vec3(0.8, 0.0, 0.0); });
  Progress quiet;
  const SceneErrors errors = report_scene(scene, options, quiet).points.at(0).errors;
  EXPECT_NEAR(errors.linear_momentum, 0.1, 1e-9);  // of 4 kg · 1 m / 0.5 s
}

/// Of 20 frames one may take longer; of three repeats the slowest counts.
TEST(SceneReport, PlantedTimesFitTheBudgetThatTheyTake) {
  SceneReportOptions options;
  options.axes = only_substeps({1});
  int frames = -1;  // the first asks for the substeps
  options.build = planting([&frames](Snapshot& frame) {
    const int repeat = frames++ / 20;
    frame.metrics.step_ms = frame.seq == 5 ? 100.0 : frame.seq == 6 ? 4.0 : 1.0 + repeat;
  });
  const Scene scene = one_body(cube(1, 1.0), 20.0 / 60.0);
  Progress quiet;
  const SceneReport report = report_scene(scene, options, quiet);
  ASSERT_EQ(report.points.size(), 1u);
  const ScenePoint& point = report.points[0];
  EXPECT_EQ(point.ms_per_step.median, 2.0);
  EXPECT_EQ(point.ms_per_step.max, 3.0);
  EXPECT_EQ(point.ms_p95, 4.0);
  EXPECT_EQ(fit_budget(report, 5.0), &point);
  EXPECT_EQ(fit_budget(report, 4.99), nullptr);
}

/// Three quick points, and a way to cancel them.
struct CancelledReport : ::testing::Test {
  const Scene scene = one_body(cube(1, 1.0), 0.1);
  std::atomic<bool> cancel{false};
  Progress progress{{}, &cancel};
  SceneReportOptions options;

  CancelledReport() {
    options.axes = only_substeps({1, 2, 4});
    options.repeats = 1;
  }
};

TEST_F(CancelledReport, KeepsWhatIsDoneAndResumingTakesItOver) {
  options.on_point = [&](const SceneReport& report) { cancel = report.points.size() == 2; };
  const SceneReport part = report_scene(scene, options, progress);
  EXPECT_FALSE(part.complete);
  ASSERT_EQ(part.points.size(), 2u);

  cancel = false;
  options.on_point = {};
  options.earlier = part;
  options.earlier.points[0].seconds = 12345.0;  // planted, to see that it is taken over and not run again
  const SceneReport whole = report_scene(scene, options, progress);
  EXPECT_TRUE(whole.complete);
  ASSERT_EQ(whole.points.size(), 3u);
  EXPECT_EQ(whole.points[0].seconds, 12345.0);

  options.reference_refinement /= 2;  // the finer reference serves as well
  EXPECT_EQ(report_scene(scene, options, progress).points[0].seconds, 12345.0);
  options.reference_refinement *= 4;  // errors against two references stand in no one report
  EXPECT_THROW(report_scene(scene, options, progress), Error);
}

TEST_F(CancelledReport, ResumedOverNarrowerAxesKeepsEveryPoint) {
  options.on_point = [&](const SceneReport& report) { cancel = report.points.size() == 2; };
  options.earlier = report_scene(scene, options, progress);
  ASSERT_EQ(options.earlier.points.size(), 2u);
  options.earlier.points[1].outcome = Outcome::failed;  // as for want of memory: tried again
  cancel = false;
  options.on_point = {};
  options.axes = only_substeps({2});
  const SceneReport whole = report_scene(scene, options, progress);
  EXPECT_TRUE(whole.complete);
  EXPECT_EQ(whole.reference.settings, options.earlier.reference.settings);
  for (const ScenePoint& known : options.earlier.points) {
    const auto kept = std::ranges::find(whole.points, known.settings, &ScenePoint::settings);
    ASSERT_NE(kept, whole.points.end());
    EXPECT_EQ(kept->outcome, Outcome::converged);
  }
}

TEST_F(CancelledReport, APointThatFailsHasNoTimesAndNoErrors) {
  options.axes = only_substeps({1});
  options.build = [](const Scene& part, Progress& quiet) {
    if (part.solver.tolerance != SceneReportOptions().reference_tolerance && part.gravity != Vec3::Zero())
      throw Error(ErrorCode::over_budget, "planted");  // not the probe, which is weightless
    return compile(part, quiet);
  };
  const ScenePoint failed = report_scene(scene, options, progress).points.at(0);
  EXPECT_EQ(failed.outcome, Outcome::failed);
  EXPECT_TRUE(std::isnan(failed.ms_per_step.median) && std::isnan(failed.fits_ms()));
  EXPECT_TRUE(std::isnan(failed.errors.trajectory_rms) && std::isnan(failed.errors.energy));
}

TEST_F(CancelledReport, LosesNothingOfAResumedRun) {
  const SceneReport whole = report_scene(scene, options, progress);
  options.axes = only_substeps({1, 2, 4, 3});  // none finer: the same reference
  options.earlier = whole;
  options.on_start = [&](const auto&, const Simulation&) { cancel = true; };  // in the reference
  const SceneReport part = report_scene(scene, options, progress);
  EXPECT_FALSE(part.complete);
  EXPECT_EQ(part.points.size(), 3u);
}

TEST(SceneReport, PointsThatWouldBeTheSameRunStandThereOnce) {
  DeformableBody body = cube(2, 1.0);
  body.edge_stiffness = 1e7;
  SceneReportOptions options;
  options.axes = only_substeps({0, 1, 2, 100, 200});
  options.axes.springs = {SpringIntegrator::symplectic, SpringIntegrator::automatic};
  options.repeats = options.reference_refinement = 1;
  Progress quiet;
  const SceneReport report = report_scene(one_body(body, 0.05), options, quiet);
  // Symplectic: what it needs, 100 and 200; implicit by the scene's choice: 1 (as 0) and 2.
  ASSERT_EQ(report.points.size(), 5u);
  for (const ScenePoint& point : report.points) {
    EXPECT_EQ(point.substeps, point.settings.substeps);
    EXPECT_EQ(point.settings.springs == SpringIntegrator::implicit, point.substeps < 3);
  }
}

/// Rigid bodies have no volume error and no springs, but a step.
TEST(SceneReport, OfRigidBodiesComparesTheirStepsOnly) {
  Scene scene;
  scene.duration = 0.3;
  SceneBody ball;
  RigidBody rigid;
  rigid.shape = SphereShape{0.1};
  rigid.mass = 2.0;
  ball.kind = rigid;
  ball.velocity = Vec3(1.0, 0.0, 0.0);
  scene.bodies.push_back(ball);
  SceneReportOptions options;
  options.axes.substeps = {1, 4};
  options.repeats = 1;
  Progress quiet;
  const SceneReport report = report_scene(scene, options, quiet);
  ASSERT_EQ(report.points.size(), 2u);
  for (const ScenePoint& point : report.points) {
    EXPECT_EQ(point.settings.solver, scene.solver.volume);
    EXPECT_EQ(point.settings.tolerance, scene.solver.tolerance);
    EXPECT_EQ(point.substeps, point.settings.substeps);
  }
  EXPECT_EQ(report.points[1].settings.substeps, 4);
}

TEST(SceneReport, ResolutionKeepsTheMaterial) {
  DeformableBody body = cube(2, 1.0);
  body.edge_stiffness = 300.0;
  SceneSettings settings;
  settings.resolution = 2.0;
  const Scene refined = apply_settings(one_body(body, 0.1), settings);
  const auto& fine = std::get<DeformableBody>(refined.bodies[0].kind);
  EXPECT_EQ(std::get<LatticeShape>(fine.shape).cells, Vec3i::Constant(4));
  EXPECT_DOUBLE_EQ(std::get<LatticeShape>(fine.shape).cell_size, 0.25);
  EXPECT_DOUBLE_EQ(fine.edge_modulus.value(), 600.0);
}

/// Turned by half a radian about its middle, which stays.
TEST(SceneReport, APlantedTurnOfARigidBodyIsSeen) {
  Scene scene;
  scene.duration = 0.1;
  scene.gravity = Vec3::Zero();
  SceneBody stone;
  stone.name = "stone";
  stone.kind = RigidBody{BoxShape{{0.1, 0.2, 0.3}}, false, 2.0, {}};
  scene.bodies.push_back(stone);
  SceneReportOptions options;
  options.axes = only_substeps({1});
  options.repeats = 1;
  options.build = [](const Scene& part, Progress& progress) -> std::unique_ptr<Simulation> {
    auto simulation = compile(part, progress);
    if (part.solver.substeps != 1) return simulation;  // the reference
    return std::make_unique<Planted>(std::move(simulation), [](Snapshot& frame) {
      frame.bodies[0].orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vec3::UnitZ()));
    });
  };
  Progress quiet;
  const SceneErrors errors = report_scene(scene, options, quiet).points.at(0).errors;
  const double chord = 2.0 * std::sin(0.25);
  EXPECT_NEAR(errors.trajectory_max, 0.2 * chord, 1e-12);  // the middles of its sides
  EXPECT_NEAR(errors.trajectory_rms, chord * std::sqrt((0.01 + 0.04) * 2.0 / 6.0), 1e-12);
}

TEST(SceneReport, ResolutionKeepsTheBody) {
  DeformableBody body = cube(2, 1.0);
  auto& lattice = std::get<LatticeShape>(body.shape);
  const auto usual = [&](const Vec3i& cells) {
    lattice.cells = cells;
    const Scene scene = one_body(body, 0.1);
    std::vector<double> resolutions;
    for (const SceneSettings& settings : scene_grid(scene, {}, [](const SceneSettings& s) { return s; }))
      if (std::ranges::find(resolutions, settings.resolution) == resolutions.end())
        resolutions.push_back(settings.resolution);
    for (double resolution : resolutions) {
      const Scene changed = apply_settings(scene, {.resolution = resolution});
      const auto& coarse = std::get<LatticeShape>(std::get<DeformableBody>(changed.bodies[0].kind).shape);
      EXPECT_LT((coarse.cells.cast<double>() * coarse.cell_size - cells.cast<double>() * lattice.cell_size)
                    .cwiseAbs()
                    .maxCoeff(),
                1e-12);
    }
    EXPECT_EQ(why_one_lattice(scene).empty(), resolutions.size() == 2);
    return resolutions;
  };
  EXPECT_EQ(usual({4, 2, 6}), (std::vector{0.5, 1.0}));
  EXPECT_EQ(usual({9, 3, 6}), (std::vector{2.0 / 3.0, 1.0}));
  EXPECT_EQ(usual({5, 5, 10}), (std::vector{0.6, 1.0}));
  EXPECT_EQ(usual({4, 3, 4}), (std::vector{1.0}));
  EXPECT_THROW(apply_settings(one_body(body, 0.1), {.resolution = 0.5}), Error);
}

/// Every one of its six frames takes a thousand seconds.
TEST_F(CancelledReport, APointThatIsTooSlowIsStoppedAndNamed) {
  options.axes = only_substeps({1});
  options.repeats = 3;
  options.point_limit = 3500.0;
  int runs = 0;
  options.build = planting([](Snapshot& frame) { frame.metrics.step_ms = 1e6; });
  options.on_start = [&](const auto& settings, const Simulation&) { runs += settings ? 1 : 0; };
  SceneReport report = report_scene(scene, options, progress);
  ASSERT_EQ(report.points.size(), 1u);
  EXPECT_EQ(report.points[0].outcome, Outcome::too_slow);
  EXPECT_EQ(report.points[0].seconds, options.point_limit);
  EXPECT_EQ(report.points[0].ms_per_step.median, 1e6);
  EXPECT_TRUE(std::isnan(report.points[0].errors.trajectory_rms));
  EXPECT_NE(report.points[0].reason.find("after 3500 s, at t = 0.06667 s"), std::string::npos)
      << report.points[0].reason;
  EXPECT_EQ(fit_budget(report, 1e6), nullptr);
  EXPECT_EQ(runs, 1);

  options.earlier = report;  // the same limit: it would be stopped again
  EXPECT_EQ(report_scene(scene, options, progress).points[0].outcome, Outcome::too_slow);
  EXPECT_EQ(runs, 1);
  options.point_limit = 1e5;
  EXPECT_EQ(report_scene(scene, options, progress).points[0].outcome, Outcome::converged);
  EXPECT_EQ(runs, 2);
}

/// A frame that would never end.
TEST_F(CancelledReport, APointIsStoppedWithinAFrame) {
  options.axes = only_substeps({1});
  options.point_limit = 0.01;
  options.build = [](const Scene& part, Progress& quiet) -> std::unique_ptr<Simulation> {
    auto simulation = compile(part, quiet);
    if (part.solver.substeps != 1 || part.gravity == Vec3::Zero()) return simulation;
    return std::make_unique<Endless>(std::move(simulation));
  };
  const ScenePoint point = report_scene(scene, options, progress).points.at(0);
  EXPECT_EQ(point.outcome, Outcome::too_slow);
  EXPECT_EQ(point.seconds, options.point_limit);
  EXPECT_TRUE(std::isnan(point.ms_per_step.median));
}

TEST(Stability, APlantedShortfallIsSeen) {
  StabilityCase test;
  test.group = "planted", test.name = "free fall that is asked to stay up";
  test.scene = one_body(cube(1, 1.0), 0.5);
  Progress quiet;
  EXPECT_TRUE(run_stability_case(test, quiet).passed);
  test.stops_at = 0.0;
  const StabilityResult fallen = run_stability_case(test, quiet);
  EXPECT_FALSE(fallen.passed);
  EXPECT_EQ(fallen.outcome, "passed through");
  test.stops_at = -1e300;
  test.feasible = false;
  EXPECT_EQ(run_stability_case(test, quiet).outcome, "infeasible, not named");
}

}  // namespace
}  // namespace isochor

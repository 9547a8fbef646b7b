#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/parallel/parallel.h"
#include "core/scene/simulation.h"
#include "tests/scene/scenes.h"

namespace isochor {
namespace {

using isochor::testing::stretched_cube;

Scene cube_at_rest(int cells) {
  Scene scene = stretched_cube(cells, 1e4, 1.0 / 60.0, SpringIntegrator::automatic);
  std::get<DeformableBody>(scene.bodies[0].kind).start = StartState{};
  return scene;
}

void add_fixed(Scene& scene, const char* name, RigidShape shape, const Vec3& position) {
  RigidBody rigid;
  rigid.shape = std::move(shape);
  rigid.is_static = true;
  SceneBody body;
  body.name = name;
  body.kind = std::move(rigid);
  body.position = position;
  scene.bodies.push_back(std::move(body));
}

bool all_finite(const Snapshot& frame) {
  for (const BodySnapshot& body : frame.bodies)
    for (const Vec3& p : body.positions)
      if (!p.allFinite()) return false;
  return true;
}

struct Start {
  const char* name;
  void (*change)(StartState&);
};
void PrintTo(const Start& start, std::ostream* out) {
  *out << start.name;
}

class Starts : public ::testing::TestWithParam<Start> {};

/// From a start that is not a body any more: cured within a few frames, the volume kept from the first on.
TEST_P(Starts, AreCured) {
  Progress quiet;
  Scene scene = cube_at_rest(4);
  GetParam().change(std::get<DeformableBody>(scene.bodies[0].kind).start);
  const auto simulation = compile(scene, quiet);
  Snapshot frame;
  for (int i = 0; i < 60; ++i) {
    frame = simulation->step(quiet);
    ASSERT_TRUE(all_finite(frame)) << i;
  }
  EXPECT_LE(frame.metrics.max_cell_volume_error, 1e-6);
  EXPECT_EQ(frame.metrics.inverted, 0);
}
INSTANTIATE_TEST_SUITE_P(
    Extremes, Starts,
    ::testing::Values(Start{"randomised", [](StartState& s) { s.randomize = 1.0; }},
                      Start{"inverted", [](StartState& s) { s.invert = true; }},
                      Start{"plane", [](StartState& s) { s.flatten = StartState::Flatten::plane; }},
                      Start{"line", [](StartState& s) { s.flatten = StartState::Flatten::line; }},
                      Start{"point", [](StartState& s) { s.flatten = StartState::Flatten::point; }},
                      Start{"twisted", [](StartState& s) { s.twist_deg = 360.0; }},
                      Start{"squashed", [](StartState& s) { s.affine(1, 1) = 0.5; }}),
    [](const auto& test) { return test.param.name; });

/// Volumes that a start lacks are no motion: no energy comes of them, and the body turns as it did.
TEST(Extremes, WrongVolumesOfAStartMakeNoSpeed) {
  for (const auto& change : std::initializer_list<void (*)(StartState&)>{
           [](StartState& s) { s.affine(0, 0) = 1.05; }, [](StartState& s) { s.affine *= 0.9; },
           [](StartState& s) { s.randomize = 0.3; }, [](StartState& s) { s.randomize = 1.0; },
           [](StartState& s) { s.flatten = StartState::Flatten::plane; }})
    for (const SpringIntegrator springs :
         {SpringIntegrator::symplectic, SpringIntegrator::implicit, SpringIntegrator::energy_momentum}) {
      Progress quiet;
      Scene scene = stretched_cube(4, 1e2, 1.0 / 60.0, springs);
      scene.bodies[0].angular_velocity = Vec3(0.1, 0.2, 0.3);
      StartState& start = std::get<DeformableBody>(scene.bodies[0].kind).start;
      start = StartState{};
      change(start);
      const auto simulation = compile(scene, quiet);
      const Metrics before = simulation->snapshot().metrics, m = simulation->step(quiet).metrics;
      EXPECT_LE(m.max_cell_volume_error, 1e-6);
      EXPECT_LE(m.kinetic_energy + m.potential_energy,
                1.02 * (before.kinetic_energy + before.potential_energy));
      EXPECT_LE((m.angular_momentum - before.angular_momentum).norm(),
                1e-10 * before.angular_momentum.norm());
    }
}

/// What a start leaves within walls is out of them by its first frame.
TEST(Extremes, ARandomStartBetweenWallsKeepsOutOfThem) {
  Progress quiet;
  Scene scene = cube_at_rest(4);
  std::get<DeformableBody>(scene.bodies[0].kind).start.randomize = 1.0;
  for (const Vec3& normal :
       {Vec3(1.0, 0.0, 0.0), Vec3(-1.0, 0.0, 0.0), Vec3(0.0, 0.0, 1.0), Vec3(0.0, 0.0, -1.0)})
    add_fixed(scene, "wall", PlaneShape{normal, -0.505}, Vec3::Zero());
  const auto simulation = compile(scene, quiet);
  EXPECT_GT(simulation->snapshot().metrics.max_penetration, 0.1);
  for (int frame = 0; frame < 5; ++frame) {
    const Metrics m = simulation->step(quiet).metrics;
    EXPECT_LE(m.max_penetration, 1e-3 * 0.25) << frame;
    EXPECT_LE(m.max_cell_volume_error, 1e-6) << frame;
    EXPECT_EQ(m.inverted, 0) << frame;
  }
}

/// A free cube of 4³ cells whose upper half is a million times denser.
Scene top_heavy_cube() {
  Scene scene = cube_at_rest(4);
  auto& body = std::get<DeformableBody>(scene.bodies[0].kind);
  AxisBox top;
  top.min.y() = 0.0;
  body.density = 1.0;
  body.densities.push_back({top, 1e6});
  return scene;
}

TEST(Extremes, AMillionfoldMassRatioKeepsTheVolume) {
  Progress quiet;
  Scene scene = top_heavy_cube();
  scene.bodies[0].angular_velocity = Vec3(1.0, 0.0, 0.0);
  const auto simulation = compile(scene, quiet);
  for (int i = 0; i < 20; ++i) {
    const Snapshot frame = simulation->step(quiet);
    ASSERT_TRUE(all_finite(frame)) << i;
    EXPECT_LE(frame.metrics.max_cell_volume_error, 1e-6) << i;
  }
}

/// A top a million times heavier than what it falls on: tets invert and are cured, and no energy comes of it.
TEST(Extremes, RecoveryAddsNoEnergy) {
  Progress quiet;
  Scene scene = top_heavy_cube();
  auto& body = std::get<DeformableBody>(scene.bodies[0].kind);
  body.edge_stiffness = body.diagonal_stiffness = 0.0;
  scene.gravity = Vec3(0.0, -9.81, 0.0);
  scene.bodies[0].position = Vec3(0.0, 0.6, 0.0);
  add_fixed(scene, "ground", PlaneShape{}, Vec3::Zero());
  const auto simulation = compile(scene, quiet);
  const Metrics start = simulation->snapshot().metrics;
  const double energy = start.kinetic_energy + start.potential_energy;
  int recoveries = 0;
  for (int i = 0; i < 60; ++i) {
    const Metrics m = simulation->step(quiet).metrics;
    recoveries += m.recoveries;
    EXPECT_LE(m.kinetic_energy + m.potential_energy, 1.01 * energy) << i;
  }
  EXPECT_GT(recoveries, 10);
}

/// A cube that falls fast on a plate of two centimetres, at four tilts: it crumples, but nothing goes
/// through, and no energy comes of it.
class ThinPlate : public ::testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(ThinPlate, HoldsWhatFallsOnItAndAddsNoEnergy) {
  const auto [speed, tilt] = GetParam();
  Progress quiet;
  for (int cells : {3, 4}) {
    Scene scene = cube_at_rest(cells);
    auto& body = std::get<DeformableBody>(scene.bodies[0].kind);
    body.edge_stiffness = 1e4, body.diagonal_stiffness = 1e3;
    scene.gravity = Vec3(0.0, -9.81, 0.0);
    scene.bodies[0].position = Vec3(0.0, 2.0, 0.0);
    scene.bodies[0].velocity = speed * Vec3(0.1, -1.0, 0.0);
    scene.bodies[0].orientation = Eigen::AngleAxisd(tilt, Vec3::UnitZ());
    add_fixed(scene, "plate", BoxShape{Vec3(50.0, 0.01, 50.0)}, Vec3::Zero());
    const auto simulation = compile(scene, quiet);
    const Metrics start = simulation->snapshot().metrics;
    const double energy = start.kinetic_energy + start.potential_energy;
    for (int i = 0; i < 15; ++i) {
      const Snapshot frame = simulation->step(quiet);
      const Metrics& m = frame.metrics;
      EXPECT_LE(m.kinetic_energy + m.potential_energy, 1.02 * energy) << i;
      EXPECT_LE(m.max_cell_volume_error, 1e-6) << i;
      EXPECT_EQ(m.inverted, 0) << i;
      for (const Vec3& p : frame.bodies[0].positions)
        ASSERT_GT(p.y(), 0.0) << i << " cells " << cells << " at " << p.transpose();
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Speeds, ThinPlate,
                         ::testing::Combine(::testing::Values(20.0, 50.0, 100.0),
                                            ::testing::Values(0.0, 0.17, 0.52, 0.79)));

struct Impact {
  const char* name;
  double ratio;      ///< mass of the rigid body over the cube's
  double stiffness;  ///< N/m, of edges
  double speed;      ///< m/s
};
void PrintTo(const Impact& impact, std::ostream* out) {
  *out << impact.name;
}

/// A cube of 1000 kg and a rigid body that meet: momentum is kept, and in the frame of their common centre
/// the pair never has more energy than it met with. Returns what it has lost of that.
double lost_by_impact(const Scene& scene) {
  Progress quiet;
  const auto simulation = compile(scene, quiet);
  const double mass = 1000.0 + *std::get<RigidBody>(scene.bodies[1].kind).mass;
  const auto energy = [&](const Metrics& m) {
    return m.kinetic_energy + m.potential_energy - 0.5 * m.linear_momentum.squaredNorm() / mass;
  };
  const Metrics start = simulation->snapshot().metrics;
  double lost = 0.0;
  for (int i = 0; i < 15; ++i) {
    const Snapshot frame = simulation->step(quiet);
    EXPECT_TRUE(all_finite(frame)) << i;
    EXPECT_LE(energy(frame.metrics), 1.03 * energy(start)) << i;
    EXPECT_LE((frame.metrics.linear_momentum - start.linear_momentum).norm(),
              1e-10 * start.linear_momentum.norm())
        << i;
    EXPECT_EQ(frame.metrics.inverted, 0) << i;
    lost = energy(start) - energy(frame.metrics);
  }
  return lost;
}

class ImpactOnMassive : public ::testing::TestWithParam<Impact> {};

/// A tilted cube that hits a capsule.
TEST_P(ImpactOnMassive, KeepsMomentumAndAddsNoEnergy) {
  const Impact& impact = GetParam();
  Scene scene = cube_at_rest(3);
  auto& body = std::get<DeformableBody>(scene.bodies[0].kind);
  body.edge_stiffness = impact.stiffness, body.diagonal_stiffness = 0.0;
  scene.bodies[0].position = Vec3(0.1, 1.6, -0.2);
  scene.bodies[0].velocity = Vec3(0.0, -impact.speed, 0.0);
  scene.bodies[0].orientation = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, 3.0).normalized());
  add_fixed(scene, "capsule", CapsuleShape{0.25, 0.5}, Vec3::Zero());
  auto& rigid = std::get<RigidBody>(scene.bodies[1].kind);
  rigid.is_static = false;
  rigid.mass = 1000.0 * impact.ratio;
  scene.bodies[1].orientation = Eigen::AngleAxisd(1.2, Vec3::UnitX());
  EXPECT_GT(lost_by_impact(scene), 0.0);
}
INSTANTIATE_TEST_SUITE_P(Extremes, ImpactOnMassive,
                         ::testing::Values(Impact{"light", 0.01, 1e4, 100.0}, Impact{"equal", 1.0, 1e3, 50.0},
                                           Impact{"heavy", 1e6, 1e4, 50.0}, Impact{"stiff", 1.0, 1e7, 20.0}),
                         [](const auto& test) { return test.param.name; });

/// What is light is thrown out of the way by forces that cancel but for round-off, or by more than was there.
TEST(Extremes, LightBodiesThatAreHitGainNothing) {
  struct Hit {
    int cells;
    double speed, stiffness, friction;
    Vec3 position;
    Eigen::Quaterniond orientation;
    Vec3 spin;
    RigidShape shape;
    double mass;
    Eigen::Quaterniond rigid_orientation;
    Vec3 rigid_spin;
  };
  const Hit hits[] = {{2,
                       20.0,
                       1e4,
                       1.0,
                       {-0.23, 1.9, 0.18},
                       {-0.32, -0.48, 0.45, -0.68},
                       {-2.17, 0.38, -0.56},
                       SphereShape{0.5},
                       10.0,
                       {-0.64, 0.75, 0.16, 0.06},
                       {-2.08, 2.62, -0.07}},
                      {3,
                       50.0,
                       1e5,
                       0.0,
                       {-0.06, 1.9, -0.28},
                       {0.61, -0.7, 0.3, -0.2},
                       {2.66, -0.77, -1.43},
                       CapsuleShape{0.1, 0.5},
                       1.0,
                       {-0.48, -0.36, 0.78, -0.18},
                       {2.7, 1.16, 2.47}},
                      {4,
                       100.0,
                       1e4,
                       1.0,
                       {-0.26, 1.9, -0.06},
                       {0.78, -0.04, 0.51, 0.36},
                       {-2.43, 0.59, -1.04},
                       SphereShape{0.2},
                       1.0,
                       {-0.27, -0.02, 0.75, -0.61},
                       {-1.62, -0.97, -0.45}}};
  for (const Hit& hit : hits) {
    SCOPED_TRACE(hit.cells);
    Scene scene = cube_at_rest(hit.cells);
    SceneBody& cube = scene.bodies[0];
    auto& body = std::get<DeformableBody>(cube.kind);
    body.edge_stiffness = hit.stiffness, body.diagonal_stiffness = 1e3;
    cube.position = hit.position;
    cube.velocity = Vec3(0.0, -hit.speed, 0.0);
    cube.orientation = hit.orientation.normalized();
    cube.angular_velocity = hit.spin;
    add_fixed(scene, "light", hit.shape, Vec3::Zero());
    SceneBody& light = scene.bodies[1];
    auto& rigid = std::get<RigidBody>(light.kind);
    rigid.is_static = false;
    rigid.mass = hit.mass;
    light.orientation = hit.rigid_orientation.normalized();
    light.angular_velocity = hit.rigid_spin;
    cube.friction = light.friction = hit.friction;
    EXPECT_GT(lost_by_impact(scene), 0.0);
  }
}

/// A plate that flies into a cube at rest: in the frame of the plate there is never more energy than before,
/// and nothing goes through.
TEST(Extremes, AFlyingPlateAddsItsWorkAndNoMore) {
  Progress quiet;
  Scene scene = cube_at_rest(4);
  auto& body = std::get<DeformableBody>(scene.bodies[0].kind);
  body.edge_stiffness = 1e3, body.diagonal_stiffness = 0.0;
  scene.bodies[0].orientation = Eigen::AngleAxisd(0.6, Vec3(1.0, 0.0, 1.0).normalized());
  add_fixed(scene, "plate", BoxShape{Vec3(5.0, 0.01, 5.0)}, Vec3(0.0, -1.2, 0.0));
  auto& plate = std::get<RigidBody>(scene.bodies[1].kind);
  const Vec3 v(10.0, 50.0, 0.0);
  plate.is_static = false;
  plate.motion = Motion{v, Vec3::Zero(), 10.0, {}};
  const auto simulation = compile(scene, quiet);
  for (int i = 1; i <= 12; ++i) {
    const Snapshot frame = simulation->step(quiet);
    const Metrics& m = frame.metrics;
    const double before = 0.5 * 1000.0 * v.squaredNorm();
    EXPECT_LE(m.kinetic_energy + m.potential_energy - m.linear_momentum.dot(v) + before, 1.03 * before) << i;
    for (const Vec3& p : frame.bodies[0].positions) ASSERT_GT(p.y(), -1.2 + v.y() * i / 60.0) << i;
  }
}

/// All particles pinned away from rest: nothing can be done, which it says, with the cell.
TEST(Extremes, AnInfeasibleBodyIsNamed) {
  Progress quiet;
  Scene scene = stretched_cube(2, 1e4, 1.0 / 60.0, SpringIntegrator::automatic);
  std::get<DeformableBody>(scene.bodies[0].kind).start.affine = Vec3(0.9, 1.0, 1.0).asDiagonal();
  scene.pins.push_back({"cube", AxisBox{}, std::nullopt});
  const auto simulation = compile(scene, quiet);
  const Snapshot frame = simulation->step(quiet);
  EXPECT_TRUE(all_finite(frame));
  EXPECT_FALSE(frame.metrics.feasible);
  EXPECT_GE(frame.metrics.worst_cell, 0);
  EXPECT_NEAR(frame.metrics.max_cell_volume_error, 0.1, 1e-9);
}

/// A plate comes down on a cube between four walls and a floor until there is less room than its volume: it
/// says so, and stays about where it is.
/// Sunk into what it stands on by up to a metre, as bodies are placed by hand: it comes out at 6 cells a
/// second, with no more motion than it then falls with, and stays out.
class Sunk : public ::testing::TestWithParam<std::pair<RigidShape, double>> {};

TEST_P(Sunk, BodiesComeOut) {
  const auto& [shape, height] = GetParam();
  for (const SpringIntegrator springs : {SpringIntegrator::symplectic, SpringIntegrator::implicit}) {
    Progress quiet;
    Scene scene = cube_at_rest(4);
    scene.solver.springs = springs;
    scene.bodies[0].position = Vec3(0.0, height, 0.0);
    add_fixed(scene, "obstacle", shape, Vec3::Zero());
    const auto simulation = compile(scene, quiet);
    const Metrics start = simulation->snapshot().metrics;
    const double depth = start.max_penetration, cell = 0.25;
    ASSERT_GT(depth, 0.05);
    double fastest = 0.0;
    for (int i = 1; i <= 60; ++i) {
      const Metrics m = simulation->step(quiet).metrics;
      EXPECT_LE(m.max_penetration, std::max(depth - 6.0 * cell * i / 60.0, 0.0) + 1e-3 * cell) << i;
      EXPECT_EQ(m.inverted, 0) << i;
      EXPECT_EQ(m.feasible, m.max_penetration <= 1e-3 * cell) << i;
      EXPECT_LE(m.max_cell_volume_error, 1e-6) << i;
      fastest = std::max(fastest, m.kinetic_energy);
    }
    // At twice that speed; put right at once, depth over h, it were 72 kJ and more.
    EXPECT_LT(fastest, 0.5 * 1000.0 * std::pow(2.0 * 6.0 * cell, 2));
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Sunk,
                         ::testing::Values(std::pair(RigidShape(PlaneShape{}), 0.4),
                                           std::pair(RigidShape(PlaneShape{}), -0.3),
                                           std::pair(RigidShape(SphereShape{0.5}), 0.9),
                                           std::pair(RigidShape(BoxShape{Vec3(0.6, 0.3, 0.6)}), 0.7)));

/// Volumes that the start has not are not kept by leaving the body where it stands, and the frame says so.
TEST(Extremes, FeasibleIsWhatEndsWithItsVolumes) {
  Progress quiet;
  Scene scene = cube_at_rest(3);
  std::get<DeformableBody>(scene.bodies[0].kind).start.invert = true;
  scene.pins.push_back({"cube", AxisBox{Vec3(-1.0, -1.0, -1.0), Vec3(1.0, -0.45, 1.0)}, {}});
  const auto simulation = compile(scene, quiet);
  for (int i = 0; i < 4; ++i) {
    const Metrics m = simulation->step(quiet).metrics;
    EXPECT_EQ(m.feasible, m.max_cell_volume_error <= 1.0001 * scene.solver.tolerance) << i;
  }
}

/// The first substep of an impact that tets take more than their lifts for is taken again in halves, and so
/// the next one begins: what failed once is not tried anew.
TEST(Extremes, ASubstepBeginsWithTheHalvingsThatTheLastOneNeeded) {
  constexpr int substeps = 8;
  Progress quiet;
  Scene scene = cube_at_rest(4);
  auto& body = std::get<DeformableBody>(scene.bodies[0].kind);
  body.edge_stiffness = body.diagonal_stiffness = 3e4;
  scene.solver.substeps = substeps;
  scene.bodies[0].position = Vec3(0.1, 1.1, 0.05);
  scene.bodies[0].velocity = Vec3(0.0, -60.0, 0.0);
  add_fixed(scene, "ball", SphereShape{0.5}, Vec3::Zero());
  const auto simulation = compile(scene, quiet);
  int most = 0;
  for (int i = 0; i < 2; ++i) most = std::max(most, simulation->step(quiet).metrics.substeps);
  EXPECT_GE(most, substeps + 2);  // one more for that which failed, and one for the next
}

/// Flattened by its own weight so that all corners of a tet come to lie on the ground, from where no
/// displacement along the ground leads: contacts have to let one go, or the cube stands still for ever.
TEST(Extremes, ATetPressedFlatOnTheGroundIsLifted) {
  Progress quiet;
  Scene scene = cube_at_rest(3);
  scene.gravity = Vec3(0.0, -9.81, 0.0);
  auto& body = std::get<DeformableBody>(scene.bodies[0].kind);
  body.edge_stiffness = 150.0, body.diagonal_stiffness = 75.0;
  scene.bodies[0].position = Vec3(0.0, 0.5, 0.0);
  add_fixed(scene, "floor", PlaneShape{}, Vec3::Zero());
  const auto simulation = compile(scene, quiet);
  for (int i = 0; i < 60; ++i) {
    const Metrics m = simulation->step(quiet).metrics;
    EXPECT_GT(m.kinetic_energy, 1.0) << i;
    EXPECT_LE(m.max_cell_volume_error, 1e-6);
    EXPECT_EQ(m.inverted, 0);
  }
}

/// The force that lets it go grows until it does, within the substep: none is taken again in halves.
TEST(Extremes, ATetHeldFlatIsLetGoWithoutHalving) {
  Progress quiet;
  for (const double stiffness : {50.0, 150.0}) {
    Scene scene = cube_at_rest(3);
    scene.gravity = Vec3(0.0, -9.81, 0.0);
    scene.solver.substeps = 4;
    auto& body = std::get<DeformableBody>(scene.bodies[0].kind);
    body.edge_stiffness = stiffness, body.diagonal_stiffness = 0.5 * stiffness;
    scene.bodies[0].position = Vec3(0.0, 0.5, 0.0);
    add_fixed(scene, "floor", PlaneShape{}, Vec3::Zero());
    const auto simulation = compile(scene, quiet);
    for (int i = 0; i < 60; ++i) {
      const Metrics m = simulation->step(quiet).metrics;
      EXPECT_EQ(m.substeps, 4) << stiffness << " N/m, frame " << i;
      EXPECT_EQ(m.inverted, 0);
    }
  }
}

TEST(Extremes, ABodyWithoutRoomIsNotThrownAway) {
  struct Squeeze {
    int cells;
    double stiffness, speed, wall, gravity, farthest;
  };
  // The last is thrown when the plate has stopped, unless what does not move counts as well.
  for (const auto& [cells, stiffness, speed, wall, gravity, farthest] : {Squeeze{4, 1e4, 3.0, 0.56, 0.0, 3.0},
                                                                         {2, 1e3, 3.0, 0.53, 0.0, 3.0},
                                                                         {2, 1e4, 3.0, 0.56, 9.81, 5.0}}) {
    SCOPED_TRACE(cells);
    Progress quiet;
    Scene scene = cube_at_rest(cells);
    scene.gravity = Vec3(0.0, -gravity, 0.0);
    auto& body = std::get<DeformableBody>(scene.bodies[0].kind);
    body.edge_stiffness = body.diagonal_stiffness = stiffness;
    scene.bodies[0].position = Vec3(0.0, 0.5, 0.0);
    for (const Vec3& normal :
         {Vec3(Vec3::UnitX()), Vec3(-Vec3::UnitX()), Vec3(Vec3::UnitZ()), Vec3(-Vec3::UnitZ())})
      add_fixed(scene, "wall", PlaneShape{normal, -wall}, Vec3::Zero());
    add_fixed(scene, "floor", PlaneShape{}, Vec3::Zero());
    add_fixed(scene, "plate", BoxShape{Vec3(1.0, 0.05, 1.0)}, Vec3(0.0, 1.06, 0.0));
    auto& plate = std::get<RigidBody>(scene.bodies.back().kind);
    plate.is_static = false;
    plate.motion = Motion{Vec3(0.0, -speed, 0.0), Vec3::Zero(), 0.48 / speed, {}};
    const auto simulation = compile(scene, quiet);
    bool feasible = true;
    for (int i = 0; i < 16; ++i) {
      const Snapshot frame = simulation->step(quiet);
      feasible &= frame.metrics.feasible;
      for (const Vec3& p : frame.bodies[0].positions) ASSERT_LT(p.norm(), farthest) << i;
    }
    EXPECT_FALSE(feasible);
  }
}

/// Pressed between walls on all sides: no sweep can meet every cell, and the
/// bodies stay finite all the same.
TEST(Extremes, SweepsOfAnInfeasibleBodyStayFinite) {
  for (const VolumeSolver solver : {VolumeSolver::gradient, VolumeSolver::scaling}) {
    Progress quiet;
    Scene scene = stretched_cube(3, 1e4, 1.0 / 60.0, SpringIntegrator::automatic);
    scene.solver.volume = solver;
    std::get<DeformableBody>(scene.bodies[0].kind).start = StartState{};
    const auto add_wall = [&](const Vec3& normal, double offset, double speed) {
      RigidBody wall;
      wall.shape = PlaneShape{normal, offset};
      if (speed > 0.0)
        wall.motion = Motion{speed * normal, Vec3::Zero(), 0.2, {}};
      else
        wall.is_static = true;
      scene.bodies.emplace_back();
      scene.bodies.back().name = "wall" + std::to_string(scene.bodies.size());
      scene.bodies.back().kind = wall;
    };
    for (const Vec3& axis : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitZ()), Vec3(Vec3::UnitY())}) {
      add_wall(axis, -0.5, 0.0);
      add_wall(-axis, -0.5, axis.y() > 0.0 ? 1.0 : 0.0);
    }
    const auto simulation = compile(scene, quiet);
    bool feasible = true;
    for (int frame = 0; frame < 4; ++frame) {
      const Snapshot snapshot = simulation->step(quiet);
      ASSERT_TRUE(all_finite(snapshot)) << frame;
      feasible &= snapshot.metrics.feasible;
    }
    EXPECT_FALSE(feasible);
  }
}

/// Ten seconds of flight with strong internal motion.
TEST(Momentum, IsKeptToRoundOffBySymplecticSprings) {
  Progress quiet;
  Scene scene = stretched_cube(3, 1e4, 1.0 / 60.0, SpringIntegrator::symplectic);
  scene.bodies[0].velocity = Vec3(0.3, 0.2, 0.1);
  scene.bodies[0].angular_velocity = Vec3(1.0, 2.0, 3.0);
  const auto simulation = compile(scene, quiet);
  const Metrics start = simulation->snapshot().metrics;
  Metrics m;
  int left = 0;
  for (int i = 0; i < 600; ++i) {
    simulation->advance(quiet);
    m = simulation->snapshot().metrics;
    left += m.recoveries + m.fallbacks;
  }
  ASSERT_EQ(left, 0);
  EXPECT_LT((m.linear_momentum - start.linear_momentum).norm(), 1e-10 * start.linear_momentum.norm());
  EXPECT_LT((m.angular_momentum - start.angular_momentum).norm(), 1e-10 * start.angular_momentum.norm());
}

/// Sixteen cells an edge, so that every stage has work for more threads than one.
TEST(Determinism, TheSameBitsForAnyNumberOfThreads) {
  Progress quiet;
  for (const SpringIntegrator springs :
       {SpringIntegrator::symplectic, SpringIntegrator::implicit, SpringIntegrator::energy_momentum}) {
    std::vector<Vec3> first;
    for (const int threads : {1, 2, 3, 1}) {
      set_thread_count(threads);
      Scene scene = stretched_cube(16, 1e4, 1.0 / 60.0, springs);
      scene.gravity = Vec3(0.0, -9.81, 0.0);
      scene.bodies[0].position = Vec3(0.0, 0.52, 0.0);
      add_fixed(scene, "ground", PlaneShape{}, Vec3::Zero());
      const auto simulation = compile(scene, quiet);
      Snapshot frame;
      for (int i = 0; i < 4; ++i) frame = simulation->step(quiet);
      if (first.empty()) first = frame.bodies[0].positions;
      EXPECT_EQ(frame.bodies[0].positions, first) << threads;
    }
  }
  set_thread_count(0);
}

}  // namespace
}  // namespace isochor

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/parallel/parallel.h"
#include "core/scene/read_scene.h"
#include "core/scene/simulation.h"

namespace isochor {
namespace {

std::unique_ptr<Simulation> compile_text(const std::string& json) {
  Progress quiet;
  return compile(read_scene(json, "."), quiet);
}

Snapshot run_to_end(Simulation& simulation) {
  Progress quiet;
  Snapshot frame = simulation.snapshot();
  while (!simulation.finished()) frame = simulation.step(quiet);
  return frame;
}

const char* const floor_plane =
    R"({"name":"floor","type":"rigid","shape":{"plane":{}},"static":true,"friction":0.25})";

/// s = v²/(2μg) until it stops; both surfaces have μ.
TEST(RigidScene, ABlockSlidesAsFarAsFrictionLetsIt) {
  const auto simulation = compile_text(R"({"duration":2,"bodies":[)" + std::string(floor_plane) + R"(,
    {"name":"block","type":"rigid","shape":{"box":{"half_extents":[0.2,0.1,0.2]}},"mass":3,
     "position":[0,0.1,0],"velocity":[2,0,0],"friction":0.25}]})");
  const Snapshot end = run_to_end(*simulation);
  const double distance = 4.0 / (2.0 * 0.25 * 9.81);
  EXPECT_NEAR(end.bodies[1].position.x(), distance, 0.01 * distance);
  EXPECT_NEAR(end.bodies[1].position.y(), 0.1, 1e-6);
  EXPECT_LT(end.metrics.kinetic_energy, 1e-12);
  EXPECT_LT(end.metrics.max_penetration, 1e-6);
}

/// The speed after each bounce is e times that before.
TEST(RigidScene, ABallBouncesByItsRestitution) {
  const auto simulation =
      compile_text(R"({"duration":0.6,"frame_rate":100,"bodies":[)" + std::string(floor_plane) + R"(,
    {"name":"ball","type":"rigid","shape":{"sphere":{"radius":0.1}},"mass":1,"position":[0,1.1,0],
     "restitution":0.8}]})");
  const Snapshot end = run_to_end(*simulation);
  const double fall = std::sqrt(2.0 / 9.81), up = 0.8 * 9.81 * fall, t = 0.6 - fall;
  EXPECT_NEAR(end.bodies[1].position.y(), 0.1 + up * t - 0.5 * 9.81 * t * t, 1e-6);
}

/// A ball that hits an equal one at rest at an angle: they part at right angles.
TEST(RigidScene, BilliardBallsPartAtRightAngles) {
  const auto simulation = compile_text(R"({"duration":1,"gravity":[0,0,0],"bodies":[
    {"name":"cue","type":"rigid","shape":{"sphere":{"radius":0.1}},"mass":2,"position":[-1,0.1,0],
     "velocity":[2,0,0],"friction":0,"restitution":1},
    {"name":"ball","type":"rigid","shape":{"sphere":{"radius":0.1}},"mass":2,"friction":0,
     "restitution":1}]})");
  Progress quiet;
  run_to_end(*simulation);
  const Snapshot a = simulation->snapshot(), b = simulation->step(quiet);
  const Vec3 cue = 60.0 * (b.bodies[0].position - a.bodies[0].position);
  const Vec3 ball = 60.0 * (b.bodies[1].position - a.bodies[1].position);
  // The line of centres at the impact: sin 30° = 0.1 / 0.2.
  const Vec3 line(std::sqrt(0.75), -0.5, 0.0);
  EXPECT_LT((ball - 2.0 * line.x() * line).norm(), 1e-9);
  EXPECT_LT((cue + ball - Vec3(2.0, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_NEAR(cue.dot(ball), 0.0, 1e-9);
}

TEST(RigidScene, AStackComesToRest) {
  std::string bodies(floor_plane);
  for (int i = 0; i < 5; ++i)
    bodies += R"(,{"type":"rigid","shape":{"box":{"half_extents":[0.1,0.1,0.1]}},"mass":1,"position":[)" +
              std::to_string(0.01 * i) + "," + std::to_string(0.1 + 0.201 * i) + ",0]}";
  const auto simulation = compile_text(R"({"duration":2,"bodies":[)" + bodies + "]}");
  const Snapshot end = run_to_end(*simulation);
  EXPECT_LT(end.metrics.kinetic_energy, 1e-9);
  EXPECT_NEAR(end.bodies[5].position.y(), 0.9, 1e-4);
  EXPECT_LT(end.metrics.max_penetration, 1e-5);
}

std::string rod(int i, const Vec3& at) {
  return R"({"name":"rod)" + std::to_string(i) +
         R"(","type":"rigid","shape":{"box":{"half_extents":[0.2,0.02,0.02]}},"mass":1,"friction":0,"position":[)" +
         std::to_string(at.x()) + "," + std::to_string(at.y()) + "," + std::to_string(at.z()) + "]}";
}

/// T = 2π√(I/(m·g·d)) of a compound pendulum at small angles: a rod hung at its end by a hinge.
TEST(RigidScene, AHingedRodSwingsAsAPendulum) {
  const double inertia = (0.4 * 0.4 + 0.04 * 0.04) / 12.0 + 0.2 * 0.2;
  const double period = 2.0 * std::numbers::pi * std::sqrt(inertia / (9.81 * 0.2));
  const auto simulation = compile_text(R"({"duration":)" + std::to_string(period) + R"(,"frame_rate":)" +
                                       std::to_string(400.0 / period) +
                                       R"(,"bodies":[
    {"name":"rod","type":"rigid","shape":{"box":{"half_extents":[0.02,0.2,0.02]}},"mass":1,"position":[0,-0.2,0],
     "angular_velocity":[0,0,0.05],"velocity":[0.01,0,0]},
    {"name":"hook","type":"rigid","shape":{"sphere":{"radius":0.01}},"static":true}],
    "joints":[{"type":"hinge","a":"rod","b":"hook","anchor":[0,0,0],"axis":[0,0,1]}]})");
  const Snapshot end = run_to_end(*simulation);
  EXPECT_LT(std::abs(end.bodies[0].position.x()), 2e-5);
  EXPECT_NEAR(end.bodies[0].position.norm(), 0.2, 1e-9);
}

/// Four rods in a ring, hung at a corner: the ring stays closed, and falls with the energy that gravity gives
/// it.
TEST(RigidScene, AClosedChainHolds) {
  std::string bodies = R"({"name":"hook","type":"rigid","shape":{"sphere":{"radius":0.01}},"static":true,
                            "position":[0,5,0]})";
  bodies += "," + rod(0, {0.0, 0.0, 0.2}) + "," + rod(1, {0.0, 0.0, -0.2});
  for (const double x : {-0.2, 0.2})
    bodies +=
        R"(,{"name":"side)" + std::string(x < 0.0 ? "0" : "1") +
        R"(","type":"rigid","shape":{"box":{"half_extents":[0.02,0.02,0.2]}},"mass":1,"friction":0,"position":[)" +
        std::to_string(x) + ",0,0]}";
  const auto joint = [](const char* a, const char* b, double x, double z) {
    return std::string(R"({"type":"ball","a":")") + a + R"(","b":")" + b + R"(","anchor":[)" +
           std::to_string(x) + ",0," + std::to_string(z) + "]}";
  };
  const auto simulation = compile_text(
      R"({"duration":1,"bodies":[)" + bodies + R"(],"joints":[)" + joint("rod0", "side1", 0.2, 0.2) + "," +
      joint("side1", "rod1", 0.2, -0.2) + "," + joint("rod1", "side0", -0.2, -0.2) + "," +
      joint("side0", "rod0", -0.2, 0.2) + "," + joint("rod0", "hook", -0.2, 0.2) + "]}");
  Progress quiet;
  Snapshot falling;
  for (int i = 0; i < 15; ++i) falling = simulation->step(quiet);
  EXPECT_GT(falling.metrics.kinetic_energy, 0.1);  // rods meet later, without bouncing
  EXPECT_NEAR(falling.metrics.kinetic_energy, -falling.metrics.potential_energy,
              0.01 * falling.metrics.kinetic_energy);
  const Snapshot end = run_to_end(*simulation);
  const auto corner = [&](int body, const Vec3& local) -> Vec3 {
    return end.bodies[body].position + end.bodies[body].orientation * local;
  };
  EXPECT_LT((corner(1, {0.2, 0, 0}) - corner(4, {0, 0, 0.2})).norm(), 1e-8);
  EXPECT_LT((corner(4, {0, 0, -0.2}) - corner(2, {0.2, 0, 0})).norm(), 1e-8);
  EXPECT_LT((corner(2, {-0.2, 0, 0}) - corner(3, {0, 0, -0.2})).norm(), 1e-8);
  EXPECT_LT((corner(3, {0, 0, 0.2}) - corner(1, {-0.2, 0, 0})).norm(), 1e-8);
}

/// A bar between two balls: the particles at its ends stay where they are held, and all momenta are kept.
TEST(RigidScene, AttachedParticlesStayOnABodyThatFeelsThem) {
  const auto simulation = compile_text(R"({"duration":0.5,"gravity":[0,0,0],"solver":{"springs":"symplectic"},
    "bodies":[
    {"name":"bar","type":"deformable","lattice":{"cells":[6,2,2],"cell_size":0.1,"origin":[-0.3,-0.1,-0.1]},
     "density":1000,"edge_stiffness":1e4,"diagonal_stiffness":1e4},
    {"name":"left","type":"rigid","shape":{"sphere":{"radius":0.2}},"mass":3,"position":[-0.4,0,0],
     "velocity":[0,0,1],"angular_velocity":[2,0,0]},
    {"name":"right","type":"rigid","shape":{"box":{"half_extents":[0.1,0.15,0.15]}},"mass":40,"position":[0.4,0,0],
     "velocity":[0,-1,0]}],
    "pins":[{"body":"bar","inside":{"min":[-1,-1,-1],"max":[-0.29,1,1]},"to":"left"},
            {"body":"bar","inside":{"min":[0.29,-1,-1],"max":[1,1,1]},"to":"right"}]})");
  Progress quiet;
  Snapshot frame = simulation->snapshot();
  const Vec3 linear = frame.metrics.linear_momentum, angular = frame.metrics.angular_momentum;
  const auto held = [&](int body, bool left) {
    std::vector<Vec3> local;
    const BodySnapshot& rigid = frame.bodies[body];
    const auto rest = simulation->topology()[0].rest_positions;
    for (std::size_t i = 0; i < rest.size(); ++i)
      if (left ? rest[i].x() < -0.29 : rest[i].x() > 0.29)
        local.push_back(rigid.orientation.conjugate() * (frame.bodies[0].positions[i] - rigid.position));
    return local;
  };
  const auto on_left = held(1, true), on_right = held(2, false);
  ASSERT_EQ(on_left.size(), 9U);
  double farthest = 0.0;
  while (!simulation->finished()) {
    frame = simulation->step(quiet);
    const auto now_left = held(1, true), now_right = held(2, false);
    for (std::size_t i = 0; i < 9; ++i)
      farthest = std::max({farthest, (now_left[i] - on_left[i]).norm(), (now_right[i] - on_right[i]).norm()});
    EXPECT_LE(frame.metrics.max_cell_volume_error, 1e-6);
    EXPECT_LT((frame.metrics.linear_momentum - linear).norm(), 1e-9);
    if (frame.metrics.fallbacks == 0 && frame.metrics.recoveries == 0) {
      EXPECT_LT((frame.metrics.angular_momentum - angular).norm(), 1e-9) << frame.t;
    }
  }
  EXPECT_LT(farthest, 1e-6);
  EXPECT_GT(frame.bodies[1].position.z(), 0.05);
}

/// An arm of 1.5 kg on a hinge, level at first, with a soft cube of 27 kg held by its upper face. Returns the
/// angle of the arm from the vertical after a quarter of the period that it has when the cube is stiff:
/// T/4 = π/2 / agm(1, cos(φ/2)) · √(I/mgd), with φ the angle of the common centre of mass at the start; and
/// the angle that it has then.
std::array<double, 2> quarter_of_a_swing(int substeps) {
  const auto scene = [&](double duration) {
    const auto number = [](double value) { return std::to_string(value); };
    return R"({"duration":)" + number(duration) + R"(,"frame_rate":)" + number(30.0 / duration) +
           R"(,"solver":{"springs":"symplectic","substeps":)" + std::to_string(substeps) + R"(},"bodies":[
      {"name":"post","type":"rigid","shape":{"sphere":{"radius":0.05}},"static":true,"position":[-0.2,0,0]},
      {"name":"arm","type":"rigid","shape":{"box":{"half_extents":[0.3,0.03,0.03]}},"mass":1.5,
       "position":[0.3,0,0]},
      {"name":"weight","type":"deformable","density":1000,"edge_stiffness":2e4,"diagonal_stiffness":2e4,
       "lattice":{"cells":[3,3,3],"cell_size":0.1,"origin":[0.55,-0.4,-0.15]}}],
      "joints":[{"type":"hinge","a":"post","b":"arm","anchor":[0,0,0],"axis":[0,0,1]}],
      "pins":[{"body":"weight","inside":{"min":[0,-0.11,-1],"max":[1,0,1]},"to":"arm"}]})";
  };
  double inertia = 1.5 * (0.3 * 0.3 + (0.3 * 0.3 + 0.03 * 0.03) / 3.0);
  Vec3 moment(1.5 * 0.3, 0.0, 0.0);
  const auto weight = compile_text(scene(1.0))->topology()[2];
  for (std::size_t i = 0; i < weight.rest_positions.size(); ++i) {
    const Vec3& x = weight.rest_positions[i];
    inertia += weight.masses[i] * (x.x() * x.x() + x.y() * x.y());
    moment += weight.masses[i] * x;
  }
  const double start = std::atan2(moment.x(), -moment.y());
  double mean = 1.0, other = std::cos(0.5 * start);
  for (int i = 0; i < 8; ++i) {
    const double product = mean * other;
    mean = 0.5 * (mean + other);
    other = std::sqrt(product);
  }
  const double quarter = 0.5 * std::numbers::pi / mean * std::sqrt(inertia / (9.81 * moment.norm()));
  const Vec3 arm = run_to_end(*compile_text(scene(quarter))).bodies[1].position;
  return {std::atan2(arm.x(), -arm.y()), 0.5 * std::numbers::pi - start};
}

TEST(RigidScene, AHeavyLoadSwingsItsHingedArmAlikeAtAnySubstep) {
  const auto [coarse, expected] = quarter_of_a_swing(6);
  const double fine = quarter_of_a_swing(96)[0];
  EXPECT_NEAR(coarse, expected, 0.01);  // the cube gives way a little
  EXPECT_NEAR(fine, coarse, 1e-3);
}

/// A ball given as a mesh falls on a floor and rests there at its radius, and on a mesh that stands still.
TEST(RigidScene, AMeshIsABodyOfItsOwn) {
  const std::string folder = ISOCHOR_SAMPLES;
  const auto simulation = compile_text(R"({"duration":1.5,"bodies":[)" + std::string(floor_plane) +
                                       R"(,
    {"name":"ball","type":"rigid","shape":{"mesh":{"file":")" +
                                       folder +
                                       R"(/meshes/sphere.obj","meshing":{"voxels":48}}},"mass":2,
     "position":[0,0.7,0]},
    {"name":"torus","type":"rigid","shape":{"mesh":{"file":")" +
                                       folder +
                                       R"(/meshes/torus.obj","meshing":{"voxels":48}}},"static":true,
     "position":[3,0.5,0]},
    {"name":"cube","type":"deformable","lattice":{"cells":[4,4,4],"cell_size":0.2,"origin":[2.6,0.9,-0.4]},
     "damping":0.02}]})");
  const Snapshot end = run_to_end(*simulation);
  EXPECT_NEAR(end.bodies[1].position.y(), 0.5, 0.01);
  EXPECT_GT(end.metrics.contacts, 4);
  EXPECT_LE(end.metrics.max_penetration, 1e-3 * 0.2);
  EXPECT_LE(end.metrics.max_cell_volume_error, 1e-6);
  const auto plan = simulation->plan();
  const auto bodies = std::ranges::find(plan, "rigid_bodies", &PlannedPhase::name);
  ASSERT_NE(bodies, plan.end());
  EXPECT_GT(bodies->bytes, 2 * 4 * 32 * 32 * 32);  // two distance fields
}

/// Their contacts oppose each other, and no impulses part them: they may not make energy of that, and what is
/// elsewhere must not notice.
TEST(RigidScene, MeshesPlacedInEachOtherDoNotBurst) {
  const std::string folder = ISOCHOR_SAMPLES;
  const auto body = [&](const char* name, const char* mesh, const char* pose) {
    return fmt::format(
        R"({{"name":"{}","type":"rigid","mass":1,{},"shape":{{"mesh":{{"file":"{}/meshes/{}",
            "meshing":{{"voxels":48,"cells":12}}}}}}}})",
        name, pose, folder, mesh);
  };
  const auto simulation = compile_text(fmt::format(
      R"({{"name":"tangle","duration":0.3,"frame_rate":60,"bodies":[{},
          {{"name":"box","type":"rigid","mass":1,"shape":{{"box":{{"half_extents":[0.5,0.5,0.5]}}}},
            "position":[9,0.5,0]}},
          {{"name":"hook","type":"rigid","static":true,"shape":{{"sphere":{{"radius":0.05}}}},
            "position":[-9,3,0]}},
          {{"name":"bob","type":"rigid","mass":1,"shape":{{"sphere":{{"radius":0.05}}}},
            "position":[-9,2,0]}},{},{}],
          "joints":[{{"type":"ball","a":"hook","b":"bob","anchor":[-9,3,0]}}]}})",
      floor_plane, body("table", "table.obj", R"("position":[0,20,0])"),
      body("tree", "tree.obj", R"("position":[0.05,20.3,0.2],"orientation":[0.6123724,0.6123724,0,0.5])")));
  Progress quiet;
  const auto energy = [](const Snapshot& frame) {
    return frame.metrics.kinetic_energy + frame.metrics.potential_energy;
  };
  const double start = energy(simulation->snapshot());
  while (!simulation->finished()) {
    const Snapshot frame = simulation->step(quiet);
    EXPECT_LT(energy(frame), start + 5.0);
    EXPECT_NEAR(frame.bodies[1].position.y(), 0.5, 1e-6);
    EXPECT_NEAR(frame.bodies[3].position.y(), 2.0, 1e-6);
  }
}

/// A cube of half a ton between a light crate on the floor and a heavy one: every contact holds at once, and
/// any number of threads gives the same bits.
TEST(RigidScene, AMixedStackHoldsUnderExtremeMasses) {
  const std::string text = R"({"duration":1,"bodies":[)" + std::string(floor_plane) + R"(,
    {"name":"crate","type":"rigid","shape":{"box":{"half_extents":[0.4,0.1,0.4]}},"mass":10,"position":[0,0.1,0]},
    {"name":"cube","type":"deformable","lattice":{"cells":[4,4,4],"cell_size":0.2,"origin":[-0.4,0.3,-0.4]}},
    {"name":"top","type":"rigid","shape":{"box":{"half_extents":[0.3,0.1,0.3]}},"mass":200,
     "position":[0,1.3,0]}]})";
  Progress quiet;
  std::array<Snapshot, 2> end;
  for (int threads = 1; threads <= 2; ++threads) {
    set_thread_count(threads);
    const auto simulation = compile_text(text);
    while (!simulation->finished()) {
      const Snapshot frame = end[threads - 1] = simulation->step(quiet);
      EXPECT_TRUE(frame.metrics.feasible) << frame.t;
      EXPECT_LE(frame.metrics.max_cell_volume_error, 1e-6) << frame.t;
      EXPECT_LE(frame.metrics.max_penetration, 1e-3 * 0.2) << frame.t;
    }
  }
  set_thread_count(0);
  EXPECT_NEAR(end[0].bodies[1].position.y(), 0.1, 2e-4);
  EXPECT_GT(end[0].bodies[3].position.y(), 1.0);
  EXPECT_EQ(end[0].bodies[2].positions, end[1].bodies[2].positions);
  EXPECT_EQ(end[0].bodies[3].position, end[1].bodies[3].position);
}

/// A box of less than a 2,000th of the cube's mass is pushed off its way, and the cube is not run over by the
/// sphere behind it.
struct LightBox {
  double place, mass, speed;
};
void PrintTo(const LightBox& box, std::ostream* out) {
  *out << box.mass << " kg at " << box.place << " m, " << box.speed << " m/s";
}

class WhatIsPushedOntoALightBox : public testing::TestWithParam<LightBox> {};

TEST_P(WhatIsPushedOntoALightBox, IsNotRunOver) {
  const LightBox& p = GetParam();
  const auto simulation = compile_text(fmt::format(
      R"({{"duration":0.4,"solver":{{"tolerance":1e-8}},"bodies":[
    {{"name":"floor","type":"rigid","shape":{{"plane":{{}}}},"static":true}},
    {{"name":"cube","type":"deformable","lattice":{{"cells":[5,3,5],"cell_size":0.12,"origin":[-0.3,0.01,-0.3]}},
     "edge_stiffness":95642.6862635664,"diagonal_stiffness":478.36190809761473}},
    {{"name":"pusher","type":"rigid","shape":{{"sphere":{{"radius":0.2}}}},"position":[-1.3,0.3,0],
     "motion":{{"velocity":[{},0,0],"until":0.4}}}},
    {{"name":"box","type":"rigid","mass":{},"position":[{},0.25,0],
     "shape":{{"box":{{"half_extents":[0.09144137322864379,0.18137325013252428,0.19195456554835716]}}}}}}]}})",
      p.speed, p.mass, p.place));
  Progress quiet;
  while (!simulation->finished()) {
    const Snapshot frame = simulation->step(quiet);
    EXPECT_LE(frame.metrics.max_penetration, 1e-3 * 0.12) << frame.t;
    EXPECT_TRUE(frame.metrics.feasible) << frame.t;
  }
}

INSTANTIATE_TEST_SUITE_P(RigidScene, WhatIsPushedOntoALightBox,
                         testing::Values(LightBox{0.8, 0.05645957859585672, 5.0},
                                         LightBox{0.8 + 1e-12, 0.05645957859585672, 5.0},
                                         LightBox{0.8 + 1e-10, 0.05645957859585672, 5.0},
                                         LightBox{0.8, 0.02, 4.0}, LightBox{0.8, 0.005, 5.0}));

/// One particle on its way out of the box is no reason for the cubes to gain a twelfth of their energy in a
/// frame.
TEST(RigidScene, ALightBoxBetweenCubesGivesThemNoEnergy) {
  const auto cube = [](const char* name, const char* origin) {
    return fmt::format(
        R"({{"name":"{}","type":"deformable","lattice":{{"cells":[4,4,4],"cell_size":0.1,"origin":{}}},
    "edge_stiffness":1e4,"diagonal_stiffness":1e4,"damping":0.002}})",
        name, origin);
  };
  const auto simulation =
      compile_text(R"({"duration":0.6,"bodies":[
    {"name":"floor","type":"rigid","shape":{"plane":{}},"static":true},)" +
                   cube("below", "[-0.2,0,-0.2]") + R"(,
    {"name":"box","type":"rigid","mass":0.056,"position":[0.01,0.44,0.005],
     "shape":{"box":{"half_extents":[0.08,0.03,0.08]}}},)" +
                   cube("above", "[-0.19666666666666668,0.48000000000000004,-0.2]") + "]}");
  Progress quiet;
  Snapshot frame = simulation->snapshot();
  const double energy = frame.metrics.kinetic_energy + frame.metrics.potential_energy;
  while (!simulation->finished()) {
    frame = simulation->step(quiet);
    EXPECT_LE(frame.metrics.kinetic_energy + frame.metrics.potential_energy, energy) << frame.t;
  }
}

struct TwoWay {
  double mass, friction, restitution;
};
void PrintTo(const TwoWay& law, std::ostream* out) {
  *out << law.mass << " kg, friction " << law.friction << ", restitution " << law.restitution;
}

/// A ball with a mass flies into a free cube, off its centre: together they keep their momentum.
class Collision : public testing::TestWithParam<TwoWay> {};

TEST_P(Collision, KeepsTheMomentumOfBallAndCube) {
  const TwoWay& p = GetParam();
  const std::string law =
      R"(,"friction":)" + std::to_string(p.friction) + R"(,"restitution":)" + std::to_string(p.restitution);
  const auto simulation = compile_text(
      R"({"duration":0.5,"gravity":[0,0,0],"solver":{"springs":"symplectic"},"bodies":[
    {"name":"cube","type":"deformable","lattice":{"cells":[4,4,4],"cell_size":0.25,"origin":[-0.5,-0.5,-0.5]},
     "density":1000,"edge_stiffness":1e5,"diagonal_stiffness":1e5)" +
      law + R"(},
    {"name":"ball","type":"rigid","shape":{"sphere":{"radius":0.3}},"mass":)" +
      std::to_string(p.mass) + R"(,"position":[-1,0.2,0.1],"velocity":[5,0,0],"angular_velocity":[0,3,1])" +
      law + "}]}");
  Progress quiet;
  Snapshot frame = simulation->snapshot();
  const Vec3 linear = frame.metrics.linear_momentum, angular = frame.metrics.angular_momentum;
  const double energy = frame.metrics.kinetic_energy + frame.metrics.potential_energy;
  double penetration = 0.0, hardest = 0.0;
  std::int64_t contacts = 0;
  while (!simulation->finished()) {
    frame = simulation->step(quiet);
    contacts = std::max(contacts, frame.metrics.contacts);
    penetration = std::max(penetration, frame.metrics.max_penetration);
    hardest = std::max(hardest, frame.metrics.kinetic_energy + frame.metrics.potential_energy);
    EXPECT_TRUE(frame.metrics.feasible);
    EXPECT_LE(frame.metrics.max_cell_volume_error, 1e-6);
    EXPECT_LT((frame.metrics.linear_momentum - linear).norm(), 1e-10 * linear.norm()) << frame.t;
    if (frame.metrics.fallbacks == 0 && frame.metrics.recoveries == 0) {
      EXPECT_LT((frame.metrics.angular_momentum - angular).norm(), 1e-10 * linear.norm()) << frame.t;
    }
  }
  EXPECT_GT(contacts, 0);
  EXPECT_LE(penetration, 1e-3 * 0.25);
  EXPECT_LE(hardest, 1.05 * energy);
}

INSTANTIATE_TEST_SUITE_P(Laws, Collision,
                         testing::Values(TwoWay{200.0, 0.0, 0.0}, TwoWay{200.0, 0.3, 0.0},
                                         TwoWay{200.0, 0.3, 0.5}, TwoWay{1.0, 0.3, 0.0},
                                         TwoWay{2000.0, 0.3, 0.0}));

/// A plate between two soft blocks, heavy or light: what stands on it is not felt through it as late as in
/// the next substep.
class Sandwich : public testing::TestWithParam<double> {};
TEST_P(Sandwich, StaysAsItIsAndComesToRest) {
  const std::string mass = std::to_string(GetParam());
  const auto block = [](const std::string& name, const std::string& bottom) {
    return R"({"name":")" + name +
           R"(","type":"deformable","lattice":{"cells":[3,2,3],"cell_size":0.15,"origin":[-0.225,)" + bottom +
           R"(,-0.225]},"edge_stiffness":1e5,"diagonal_stiffness":1e4,"damping":0.02})";
  };
  const auto simulation = compile_text(
      R"({"duration":1.5,"solver":{"springs":"implicit"},"bodies":[)" + std::string(floor_plane) + "," +
      block("below", "0.001") + "," +
      R"({"name":"plate","type":"rigid","shape":{"box":{"half_extents":[0.25,0.1,0.25]}},"mass":)" + mass +
      R"(,"position":[-0.03,0.402,0]},)" + block("above", "0.503") + "]}");
  Progress quiet;
  double height = 0.402, moved = 0.0;
  while (!simulation->finished()) {
    const Snapshot frame = simulation->step(quiet);
    ASSERT_TRUE(frame.metrics.feasible) << frame.t;
    ASSERT_LE(frame.metrics.max_penetration, 1e-3 * 0.15) << frame.t;
    moved = std::abs(frame.bodies[2].position.y() - std::exchange(height, frame.bodies[2].position.y()));
  }
  EXPECT_LE(moved, 0.01 / 60.0);
  EXPECT_NEAR(height, 0.4, 0.02);
}
INSTANTIATE_TEST_SUITE_P(Masses, Sandwich, testing::Values(1.0, 10.0, 100.0, 1000.0));

}  // namespace
}  // namespace isochor

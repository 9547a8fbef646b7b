#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/parallel/parallel.h"
#include "core/scene/read_scene.h"
#include "core/scene/simulation.h"

namespace isochor {
namespace {

std::unique_ptr<Simulation> compile_text(const std::string& json) {
  Progress quiet;
  return compile(read_scene(json, "."), quiet);
}

std::string text(const Vec3& v) {
  return "[" + std::to_string(v.x()) + "," + std::to_string(v.y()) + "," + std::to_string(v.z()) + "]";
}

/// A box of cells of 0.25 m, centred there.
std::string box(const std::string& name, const Vec3i& cells, const Vec3& center, const Vec3& velocity,
                const std::string& more) {
  return R"({"name":")" + name + R"(","type":"deformable","lattice":{"cells":[)" + std::to_string(cells.x()) +
         "," + std::to_string(cells.y()) + "," + std::to_string(cells.z()) +
         R"(],"cell_size":0.25,"origin":)" + text(-0.125 * cells.cast<double>()) + R"(},"position":)" +
         text(center) + R"(,"velocity":)" + text(velocity) + "," + more + "}";
}

constexpr double cell = 0.25;
const char* const lively = R"("edge_stiffness":1e5,"diagonal_stiffness":1e5)";
const char* const dull = R"("edge_stiffness":3e4,"diagonal_stiffness":3e4,"damping":0.02)";
const std::string ground = R"({"name":"ground","type":"rigid","shape":{"plane":{}},"static":true})";

Vec3 center_of(const Snapshot& frame, int body) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : frame.bodies[body].positions) sum += p;
  return sum / static_cast<double>(frame.bodies[body].positions.size());
}

void expect_held(const Snapshot& frame) {
  EXPECT_TRUE(frame.metrics.feasible) << frame.t;
  EXPECT_LE(frame.metrics.max_cell_volume_error, 1e-6) << frame.t;
  EXPECT_LE(frame.metrics.max_penetration, 1e-3 * cell) << frame.t;
}

struct Impact {
  const char* name;
  double density;  ///< of the second, kg/m³; the first has 1000
  Vec3 offset;     ///< of the second across the way of the first, m
  double speed;    ///< m/s
  double friction, restitution;
};
void PrintTo(const Impact& impact, std::ostream* out) {
  *out << impact.name;
}
class SoftImpact : public testing::TestWithParam<Impact> {};

/// Two free cubes: all momenta are kept, the energy does not grow, nothing passes through.
TEST_P(SoftImpact, KeepsMomentumAndVolume) {
  const Impact& p = GetParam();
  const std::string law = std::string(lively) + R"(,"restitution":)" + std::to_string(p.restitution) +
                          R"(,"friction":)" + std::to_string(p.friction);
  const auto simulation =
      compile_text(R"({"duration":0.4,"gravity":[0,0,0],"solver":{"springs":"symplectic"},"bodies":[)" +
                   box("left", Vec3i::Constant(3), Vec3(-0.45, 0, 0), Vec3(0.5 * p.speed, 0, 0), law) + "," +
                   box("right", Vec3i::Constant(3), Vec3(0.45, 0, 0) + p.offset, Vec3(-0.5 * p.speed, 0, 0),
                       law + R"(,"density":)" + std::to_string(p.density)) +
                   "]}");
  Progress quiet;
  Snapshot frame = simulation->snapshot();
  const Vec3 linear = frame.metrics.linear_momentum, angular = frame.metrics.angular_momentum;
  const double energy = frame.metrics.kinetic_energy + frame.metrics.potential_energy;
  const double scale = 0.5 * p.speed * (1000.0 + p.density) * std::pow(3 * cell, 3);
  std::int64_t contacts = 0;
  while (!simulation->finished()) {
    frame = simulation->step(quiet);
    EXPECT_LE(frame.metrics.max_cell_volume_error, 1e-6) << frame.t;
    if (p.speed < 50.0) expect_held(frame);
    contacts = std::max(contacts, frame.metrics.contacts);
    EXPECT_LT((frame.metrics.linear_momentum - linear).norm(), 1e-10 * scale) << frame.t;
    EXPECT_LE(frame.metrics.kinetic_energy + frame.metrics.potential_energy, 1.01 * energy) << frame.t;
    if (p.friction == 0.0 && frame.metrics.fallbacks == 0 && frame.metrics.recoveries == 0) {
      EXPECT_LT((frame.metrics.angular_momentum - angular).norm(), 1e-10 * scale) << frame.t;
    }
  }
  EXPECT_GE(contacts, 9);
  EXPECT_GT(center_of(frame, 1).x() - center_of(frame, 0).x(), 3 * cell - 0.1);
}

INSTANTIATE_TEST_SUITE_P(Cubes, SoftImpact,
                         testing::Values(Impact{"head_on", 1000, Vec3::Zero(), 5, 0, 0},
                                         Impact{"bouncing", 1000, Vec3::Zero(), 5, 0.3, 1},
                                         Impact{"heavy", 1e5, Vec3::Zero(), 5, 0.3, 0},
                                         Impact{"off_centre", 1000, Vec3(0, 0.3, 0.2), 5, 0, 0},
                                         Impact{"fast", 1000, Vec3::Zero(), 100, 0.3, 0}),
                         [](const auto& test) { return std::string(test.param.name); });

/// Blocks thrown at one another askew, so that corners meet rims, sides and what gives way beside them.
struct Throw {
  const char* name;
  Vec3i left, right;  ///< cells
  const char *left_orientation, *right_orientation;
  Vec3 right_at;
  double speed;  ///< of either, m/s
  const char *left_is, *right_is;
};
void PrintTo(const Throw& thrown, std::ostream* out) {
  *out << thrown.name;
}
class SoftThrow : public testing::TestWithParam<Throw> {};
TEST_P(SoftThrow, LeavesNothingInAnother) {
  const Throw& p = GetParam();
  const auto turned = [](const char* orientation, const char* is) {
    return std::string(R"("orientation":)") + orientation + "," + is;
  };
  const auto simulation = compile_text(
      R"({"duration":0.5,"gravity":[0,0,0],"bodies":[)" +
      box("left", p.left, Vec3(-0.8, 0, 0), Vec3(p.speed, 0, 0), turned(p.left_orientation, p.left_is)) +
      "," + box("right", p.right, p.right_at, Vec3(-p.speed, 0, 0), turned(p.right_orientation, p.right_is)) +
      "]}");
  Progress quiet;
  Snapshot frame = simulation->snapshot();
  const double energy = frame.metrics.kinetic_energy + frame.metrics.potential_energy;
  while (!simulation->finished()) {
    frame = simulation->step(quiet);
    expect_held(frame);
    EXPECT_LE(frame.metrics.kinetic_energy + frame.metrics.potential_energy, 1.05 * energy) << frame.t;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Blocks, SoftThrow,
    testing::Values(Throw{"corner_under_a_rim", Vec3i(4, 3, 4), Vec3i(1, 4, 1), "[-0.95,0.17,-0.11,-0.24]",
                          "[0.24,0.36,-0.54,-0.73]", Vec3(0.8, 0.23, -0.26), 2.5,
                          R"("edge_stiffness":1e4,"diagonal_stiffness":1e3)",
                          R"("edge_stiffness":1e4,"diagonal_stiffness":1e3,"density":3000)"},
                    Throw{"beam_on_a_plate", Vec3i(4, 1, 1), Vec3i(2, 1, 3), "[0.71,-0.69,-0.07,-0.14]",
                          "[0.06,-0.08,-1.0,0.0]", Vec3(0.8, 0.25, -0.28), 10,
                          R"("edge_stiffness":1e4,"diagonal_stiffness":1e4)",
                          R"("edge_stiffness":1e5,"diagonal_stiffness":1e4)"},
                    Throw{"along_a_valley", Vec3i(4, 3, 2), Vec3i(1, 2, 1), "[0.39,-0.16,0.19,0.89]",
                          "[-0.67,-0.14,-0.18,-0.71]", Vec3(0.8, -0.17, 0.18), 2.5,
                          R"("edge_stiffness":1e3,"diagonal_stiffness":1e5)",
                          R"("edge_stiffness":1e5,"diagonal_stiffness":1e3,"density":3000)"},
                    Throw{"soft_beam", Vec3i(1, 3, 1), Vec3i(3, 1, 2), "[0.71,0.38,-0.06,-0.59]",
                          "[-0.08,0.64,-0.76,0.0]", Vec3(0.8, 0.19, 0.01), 10,
                          R"("edge_stiffness":1e3,"diagonal_stiffness":1e3)",
                          R"("edge_stiffness":1e3,"diagonal_stiffness":1e3,"density":300)"}),
    [](const auto& test) { return std::string(test.param.name); });

class SoftStack : public testing::TestWithParam<int> {};

/// Root mean square over all vertices, m/s.
double speed_between(const Snapshot& before, const Snapshot& after) {
  double sum = 0.0, count = 0.0;
  for (std::size_t b = 0; b < after.bodies.size(); ++b)
    for (std::size_t i = 0; i < after.bodies[b].positions.size(); ++i, count += 1.0)
      sum += (after.bodies[b].positions[i] - before.bodies[b].positions[i]).squaredNorm();
  return std::sqrt(sum / count) / (after.t - before.t);
}

/// Cubes dropped on each other come to rest, one above the other.
TEST_P(SoftStack, ComesToRest) {
  const int count = GetParam();
  const char* const dead = R"("edge_stiffness":6e4,"diagonal_stiffness":6e4,"damping":0.02)";
  std::string bodies = ground;
  for (int i = 0; i < count; ++i)
    bodies += "," + box("cube" + std::to_string(i), Vec3i::Constant(2),
                        Vec3(0.02 * (i % 2), 0.25 + 0.52 * i, 0.02 * i), Vec3::Zero(), dead);
  const auto simulation =
      compile_text(R"({"duration":1.5,"solver":{"springs":"symplectic"},"bodies":[)" + bodies + "]}");
  Progress quiet;
  Snapshot before, frame = simulation->snapshot();
  while (!simulation->finished()) {
    before = frame;
    frame = simulation->step(quiet);
    expect_held(frame);
  }
  EXPECT_LT(speed_between(before, frame), 0.01);
  for (int i = 0; i < count; ++i) EXPECT_NEAR(center_of(frame, i + 1).y(), 0.25 + 0.5 * i, 0.03) << i;
}

INSTANTIATE_TEST_SUITE_P(Of, SoftStack, testing::Values(2, 3));

/// Corners swing sideways into what gives way below them, though no triangle there faces their normals.
TEST(SoftDrop, KeepsTheCornersOfAStiffBlockOutOfASoftOne) {
  const char* const soft = R"("edge_stiffness":2000,"diagonal_stiffness":800)";
  const char* const stiff = R"("edge_stiffness":12000,"diagonal_stiffness":45000)";
  for (const double offset : {0.0, cell}) {
    const auto simulation =
        compile_text(R"({"duration":0.8,"bodies":[)" + ground + "," +
                     box("soft", Vec3i(3, 2, 5), Vec3(0, 0.3, 0), Vec3::Zero(), soft) + "," +
                     box("stiff", Vec3i(2, 3, 4), Vec3(offset, 1.2, 0), Vec3::Zero(), stiff) + "]}");
    Progress quiet;
    while (!simulation->finished()) expect_held(simulation->step(quiet));
  }
}

/// What begins within another comes out over some frames, and none of these is called feasible.
TEST(SoftDrop, CallsNoFrameFeasibleThatLeavesBlocksInEachOther) {
  const auto simulation =
      compile_text(R"({"duration":0.1,"gravity":[0,0,0],"bodies":[)" +
                   box("lower", Vec3i(3, 2, 3), Vec3::Zero(), Vec3::Zero(), lively) + "," +
                   box("upper", Vec3i(2, 2, 2), Vec3(0.05, 0.45, 0.03), Vec3::Zero(), lively) + "]}");
  Progress quiet;
  int deep = 0;
  while (!simulation->finished()) {
    const Snapshot frame = simulation->step(quiet);
    if (frame.metrics.max_penetration <= 1e-3 * cell) continue;
    ++deep;
    EXPECT_FALSE(frame.metrics.feasible) << frame.t;
  }
  EXPECT_GT(deep, 0);
}

/// Blocks whose damping asks for 354 substeps a frame, with plates below, between or on them.
class MixedStack : public testing::TestWithParam<const char*> {};
TEST_P(MixedStack, GainsNoEnergyAndStaysApart) {
  const std::string layers = GetParam();
  std::string bodies = ground;
  double top = 0.001;
  for (const char layer : layers) {
    const std::string name = layer + std::to_string(top);
    if (layer == 's')
      bodies += R"(,{"name":")" + name +
                R"(","type":"deformable","lattice":{"cells":[3,2,3],"cell_size":0.15,"origin":)" +
                text(Vec3(-0.225, top, -0.225)) +
                R"(},"edge_stiffness":1e5,"diagonal_stiffness":1e4,"damping":0.02})";
    else
      bodies += R"(,{"name":")" + name +
                R"(","type":"rigid","shape":{"box":{"half_extents":[0.25,0.1,0.25]}},"mass":)" +
                (layer == 'r' ? "3" : "100") + R"(,"position":)" + text(Vec3(0.03, top + 0.1, 0)) + "}";
    top += layer == 's' ? 0.301 : 0.201;
  }
  const auto simulation =
      compile_text(R"({"duration":0.15,"solver":{"tolerance":1e-3},"bodies":[)" + bodies + "]}");
  Progress quiet;
  Snapshot frame = simulation->snapshot();
  const double energy = frame.metrics.kinetic_energy + frame.metrics.potential_energy;
  while (!simulation->finished()) {
    frame = simulation->step(quiet);
    EXPECT_TRUE(frame.metrics.feasible) << frame.t;
    EXPECT_LE(frame.metrics.max_penetration, 1e-3 * 0.15) << frame.t;
    EXPECT_LE(frame.metrics.kinetic_energy + frame.metrics.potential_energy, energy) << frame.t;
    EXPECT_LE(10 * frame.metrics.recoveries, frame.metrics.substeps) << frame.t;
  }
}
INSTANTIATE_TEST_SUITE_P(Of, MixedStack, testing::Values("sss", "srss", "srrs"));

/// s = v²/(2μg) on a slab that is held; both surfaces have μ.
TEST(SoftFriction, ABlockSlidesOnASlabAsFarAsFrictionLetsIt) {
  const double friction = 0.3, speed = 2.0;
  const std::string law = R"(,"friction":)" + std::to_string(friction);
  const auto simulation =
      compile_text(R"({"duration":1.2,"solver":{"springs":"symplectic"},"bodies":[)" +
                   box("slab", Vec3i(10, 1, 4), Vec3(0.75, -0.125, 0), Vec3::Zero(), lively + law) + "," +
                   box("block", Vec3i(2, 1, 2), Vec3(0, 0.125, 0), Vec3(speed, 0, 0), dull + law) +
                   R"(],"pins":[{"body":"slab","inside":{}}]})");
  Progress quiet;
  const double start = center_of(simulation->snapshot(), 1).x();
  Snapshot frame;
  while (!simulation->finished()) {
    frame = simulation->step(quiet);
    expect_held(frame);
  }
  const double distance = speed * speed / (2.0 * friction * 9.81);
  EXPECT_NEAR(center_of(frame, 1).x() - start, distance, 0.05 * distance);
  EXPECT_LT(frame.metrics.kinetic_energy, 1e-2);
}

/// A bar that is held in its middle: its halves swing down and meet below it.
std::string folding_bar(bool self_contact) {
  return R"({"duration":1.5,"bodies":[)" +
         box("bar", Vec3i(12, 1, 2), Vec3::Zero(), Vec3::Zero(),
             std::string(R"("edge_stiffness":1e3,"diagonal_stiffness":1e3,"damping":0.05,"self_contact":)") +
                 (self_contact ? "true" : "false")) +
         R"(],"pins":[{"body":"bar","inside":{"min":[-0.1,-1,-1],"max":[0.1,1,1]}}]})";
}

/// How far one end goes past the other.
double passage(Simulation& simulation, bool held) {
  Progress quiet;
  const std::vector<Vec3> rest = simulation.topology()[0].rest_positions;
  double farthest = -1.0;
  while (!simulation.finished()) {
    const Snapshot frame = simulation.step(quiet);
    if (held) expect_held(frame);
    double left = -10.0, right = 10.0;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      if (rest[i].x() < -1.49) left = std::max(left, frame.bodies[0].positions[i].x());
      if (rest[i].x() > 1.49) right = std::min(right, frame.bodies[0].positions[i].x());
    }
    farthest = std::max(farthest, left - right);
  }
  return farthest;
}

TEST(SelfContact, AFoldingBarDoesNotPassThroughItself) {
  EXPECT_GT(passage(*compile_text(folding_bar(false)), false), 0.1);
  EXPECT_LT(passage(*compile_text(folding_bar(true)), true), 0.02);
}

TEST(SurfaceCollision, IsPlannedOnlyWhereItCanHappen) {
  const auto planned = [](const std::string& json) {
    for (const PlannedPhase& phase : compile_text(json)->plan())
      if (phase.name == "surface_contacts") return phase;
    return PlannedPhase{};
  };
  const std::string one = box("a", Vec3i::Constant(1), Vec3::Zero(), Vec3::Zero(), lively);
  const PlannedPhase alone = planned(R"({"bodies":[)" + one + "]}");
  EXPECT_FALSE(alone.included);
  EXPECT_EQ(alone.bytes, 0);
  EXPECT_NE(alone.reason.find("no hash"), std::string::npos);
  const std::string folding = box("b", Vec3i::Constant(1), Vec3(1, 0, 0), Vec3::Zero(),
                                  std::string(lively) + R"(,"self_contact":true)");
  EXPECT_TRUE(planned(R"({"bodies":[)" + folding + "]}").included);
  const std::string large = box("c", Vec3i::Constant(20), Vec3::Zero(), Vec3::Zero(),
                                std::string(lively) + R"(,"self_contact":true)");
  const std::int64_t boxes = 5 * 20 * 20 * 20 * sizeof(Box);  // of the tets, in the hash and before it
  EXPECT_GT(planned(R"({"bodies":[)" + large + "]}").bytes, 2 * boxes);
  EXPECT_TRUE(planned(R"({"bodies":[)" + one + "," + folding + "]}").included);
}

TEST(SurfaceCollision, GivesTheSameBitsForAnyNumberOfThreads) {
  const std::string scene = R"({"duration":null,"bodies":[)" + ground + "," +
                            box("lower", Vec3i::Constant(3), Vec3(0, 0.375, 0), Vec3::Zero(), dull) + "," +
                            box("upper", Vec3i::Constant(3), Vec3(0.05, 1.13, 0), Vec3::Zero(), dull) + "]}";
  Progress quiet;
  std::array<Snapshot, 2> end;
  for (int threads = 1; threads <= 2; ++threads) {
    set_thread_count(threads);
    const auto simulation = compile_text(scene);
    for (int i = 0; i < 30; ++i) simulation->advance(quiet);
    end[threads - 1] = simulation->snapshot();
  }
  set_thread_count(0);
  EXPECT_GE(end[0].metrics.contacts, 32);
  EXPECT_EQ(end[0].bodies[1].positions, end[1].bodies[1].positions);
  EXPECT_EQ(end[0].bodies[2].positions, end[1].bodies[2].positions);
}

}  // namespace
}  // namespace isochor

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/scene/simulation.h"
#include "tests/scene/scenes.h"

namespace isochor {
namespace {

using isochor::testing::stretched_cube;

double energy(const Metrics& m) {
  return m.kinetic_energy + m.potential_energy;
}

struct Landing {
  const char* name;
  double turned;  ///< radians about (1, 0, 1)
  bool on_sphere;
};
void PrintTo(const Landing& landing, std::ostream* out) {
  *out << landing.name;
}

class ImplicitLanding : public ::testing::TestWithParam<std::tuple<Landing, double>> {};

/// A cube of 4³ cells falls 0.2 m on a plane or on a unit sphere's half: it never has more energy than it
/// fell with, whatever its stiffness, keeps its volume and stays outside.
TEST_P(ImplicitLanding, GainsNoEnergy) {
  const auto& [landing, stiffness] = GetParam();
  Progress quiet;
  Scene scene = stretched_cube(4, stiffness, 1.0 / 60.0, SpringIntegrator::implicit);
  scene.gravity = Vec3(0.0, -9.81, 0.0);
  std::get<DeformableBody>(scene.bodies[0].kind).start = StartState{};
  scene.bodies[0].position = Vec3(landing.on_sphere ? 0.2 : 0.0, landing.turned > 0.0 ? 1.1 : 0.7, 0.0);
  scene.bodies[0].orientation =
      Eigen::Quaterniond(Eigen::AngleAxisd(landing.turned, Vec3(1.0, 0.0, 1.0).normalized()));
  RigidBody ground;
  ground.is_static = true;
  if (landing.on_sphere)
    ground.shape = SphereShape{0.5};
  else
    ground.shape = PlaneShape{};
  scene.bodies.resize(2);
  scene.bodies[1].name = "ground";
  scene.bodies[1].kind = ground;
  scene.bodies[1].position = Vec3(0.0, landing.on_sphere ? -0.5 : 0.0, 0.0);
  const auto simulation = compile(scene, quiet);
  const double start = energy(simulation->snapshot().metrics);
  constexpr double fall = 1000.0 * 9.81 * 0.2;
  bool touched = false;
  for (int frame = 0; frame < 40; ++frame) {
    const Metrics m = simulation->step(quiet).metrics;
    touched |= m.contacts > 0;
    ASSERT_LE(energy(m) - start, 0.05 * fall) << "frame " << frame;
    EXPECT_LE(m.max_cell_volume_error, 1e-6) << "frame " << frame;
    EXPECT_LE(m.max_penetration, 1e-3 * 0.25) << "frame " << frame;
    EXPECT_EQ(m.inverted, 0) << "frame " << frame;
  }
  EXPECT_TRUE(touched);
}
INSTANTIATE_TEST_SUITE_P(Stiffness, ImplicitLanding,
                         ::testing::Combine(::testing::Values(Landing{"Flat", 0.0, false},
                                                              Landing{"OnAnEdge", 0.5, false},
                                                              Landing{"OnASphere", 0.0, true}),
                                            ::testing::Values(1e4, 1e6, 1e8, 1e10, 1e12)),
                         [](const auto& param) {
                           return std::string(std::get<0>(param.param).name) + "At1e" +
                                  std::to_string(
                                      static_cast<int>(std::lround(std::log10(std::get<1>(param.param)))));
                         });

/// On the ground or from a ceiling, hanging or lying still, it has no speed: no kick is left over at the end
/// of a substep, g·h/2 = 0.08 m/s.
TEST(Implicit, ABodyThatIsHeldIsAtRest) {
  for (const bool pinned : {false, true}) {
    Progress quiet;
    Scene scene = stretched_cube(3, 1e6, 1.0 / 60.0, SpringIntegrator::implicit);
    scene.gravity = Vec3(0.0, -9.81, 0.0);
    std::get<DeformableBody>(scene.bodies[0].kind).start = StartState{};
    scene.bodies[0].position = Vec3(0.0, 0.5, 0.0);
    if (pinned) {
      Pin pin;
      pin.body = "cube";
      pin.inside.min.y() = 0.9;
      scene.pins.push_back(pin);
    } else {
      scene.bodies.resize(2);
      scene.bodies[1].name = "ground";
      RigidBody ground;
      ground.is_static = true;
      ground.shape = PlaneShape{};
      scene.bodies[1].kind = ground;
    }
    const auto simulation = compile(scene, quiet);
    Metrics m;
    for (int frame = 0; frame < 90; ++frame) m = simulation->step(quiet).metrics;
    EXPECT_LT(m.kinetic_energy, 1e-6 * 1000.0 * 9.81) << (pinned ? "pinned" : "on the ground");
  }
}

/// Stiff bodies and rigid ones that have a mass, from a tenth of its own to a hundred times as heavy, and
/// neither gains energy: on a ball that lies on the ground, under a box that falls, hit in space by a ball of
/// 10 m/s, when the momentum of both stays to round-off as well.
struct Meeting {
  const char* name;
  RigidShape shape;
  Vec3 cube, rigid, velocity;
};
void PrintTo(const Meeting& meeting, std::ostream* out) {
  *out << meeting.name;
}

class ImplicitOnMassive : public ::testing::TestWithParam<std::tuple<Meeting, double, double>> {};

TEST_P(ImplicitOnMassive, GainsNoEnergyAndKeepsMomentum) {
  const auto& [meeting, mass, stiffness] = GetParam();
  Progress quiet;
  Scene scene = stretched_cube(4, stiffness, 1.0 / 60.0, SpringIntegrator::implicit);
  std::get<DeformableBody>(scene.bodies[0].kind).start = StartState{};
  scene.bodies[0].position = meeting.cube;
  const bool in_space = !meeting.velocity.isZero();
  if (!in_space) scene.gravity = Vec3(0.0, -9.81, 0.0);
  scene.bodies.resize(in_space ? 2 : 3);
  RigidBody massive;
  massive.shape = meeting.shape;
  massive.mass = mass;
  scene.bodies[1].name = "massive";
  scene.bodies[1].kind = massive;
  scene.bodies[1].position = meeting.rigid;
  scene.bodies[1].velocity = meeting.velocity;
  if (!in_space) {
    RigidBody ground;
    ground.is_static = true;
    ground.shape = PlaneShape{};
    scene.bodies[2].name = "ground";
    scene.bodies[2].kind = ground;
  }
  const auto simulation = compile(scene, quiet);
  const Metrics start = simulation->snapshot().metrics;
  // What the lighter of the two falls or comes with, and half a kick of gravity that the cube shows.
  const double brought = in_space ? start.kinetic_energy : std::min(mass, 1000.0) * 9.81 * 0.2;
  const double kick = 0.5 * 1000.0 * std::pow(0.5 * scene.gravity.norm() / 60.0, 2);
  bool touched = false, recovered = false;
  for (int frame = 0; frame < 40; ++frame) {
    const Metrics m = simulation->step(quiet).metrics;
    recovered |= m.recoveries > 0;
    touched |= recovered || m.contacts > 0;
    ASSERT_LE(energy(m) - energy(start), 0.05 * brought + kick) << "frame " << frame;
    EXPECT_LE(m.max_cell_volume_error, 1e-6) << "frame " << frame;
    EXPECT_LE(m.max_penetration, 1e-3 * 0.25) << "frame " << frame;
    if (in_space && !recovered) {
      EXPECT_LE((m.linear_momentum - start.linear_momentum).norm(), 1e-11 * start.linear_momentum.norm());
    }
  }
  EXPECT_TRUE(touched);
}
INSTANTIATE_TEST_SUITE_P(
    Stiffness, ImplicitOnMassive,
    ::testing::Combine(
        ::testing::Values(
            Meeting{"OnABall", SphereShape{0.4}, {0.0, 1.5, 0.0}, {0.1, 0.4, 0.0}, {0.0, 0.0, 0.0}},
            Meeting{
                "UnderABox", BoxShape{{0.3, 0.2, 0.3}}, {0.0, 0.5, 0.0}, {0.1, 1.4, 0.0}, {0.0, 0.0, 0.0}},
            Meeting{"HitInSpace", SphereShape{0.3}, {0.0, 0.0, 0.0}, {-1.5, 0.1, 0.0}, {10.0, 0.0, 0.0}}),
        ::testing::Values(100.0, 1e3, 1e5), ::testing::Values(1e6, 1e10)),
    [](const auto& param) {
      const auto power = [](double value) {
        return "1e" + std::to_string(static_cast<int>(std::lround(std::log10(value))));
      };
      return std::string(std::get<0>(param.param).name) + "Mass" + power(std::get<1>(param.param)) + "At" +
             power(std::get<2>(param.param));
    });

class ImplicitStiffness : public ::testing::TestWithParam<double> {};

/// Released stretched at constant volume: finite, the volume kept, energy never above the start's.
TEST_P(ImplicitStiffness, NeverGainsEnergy) {
  for (const double h : {1e-5, 1e-3, 1.0 / 60.0, 0.1}) {
    Progress quiet;
    const auto simulation = compile(stretched_cube(3, GetParam(), h, SpringIntegrator::implicit), quiet);
    const double start = energy(simulation->snapshot().metrics);
    for (int frame = 0; frame < 20; ++frame) {
      const Metrics m = simulation->step(quiet).metrics;
      ASSERT_TRUE(std::isfinite(energy(m))) << "h = " << h;
      EXPECT_LE(energy(m), 1.05 * start + 1e-12) << "h = " << h << ", frame " << frame;
      EXPECT_LE(m.max_cell_volume_error, 1e-6) << "h = " << h;
      EXPECT_EQ(m.inverted, 0) << "h = " << h;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Stiffness, ImplicitStiffness, ::testing::Values(0.0, 1e3, 1e6, 1e9, 1e12));

TEST(Implicit, KeepsMomentumInFreeFlight) {
  Progress quiet;
  Scene scene = stretched_cube(4, 1e6, 1.0 / 60.0, SpringIntegrator::implicit);
  scene.bodies[0].velocity = Vec3(0.3, 0.2, 0.1);
  scene.bodies[0].angular_velocity = Vec3(1.0, 5.0, 3.0);
  const auto simulation = compile(scene, quiet);
  const Metrics start = simulation->snapshot().metrics;
  Metrics m;
  for (int frame = 0; frame < 60; ++frame) m = simulation->step(quiet).metrics;
  EXPECT_LT((m.linear_momentum - start.linear_momentum).norm(), 1e-10 * start.linear_momentum.norm());
  EXPECT_LT((m.angular_momentum - start.angular_momentum).norm(), 1e-10 * start.angular_momentum.norm());
}

/// A stiff body that spins keeps its shape and its spin: k = 1e10, ten radians a second.
TEST(Implicit, DoesNotGrowWithSpin) {
  Progress quiet;
  Scene scene = stretched_cube(3, 1e10, 1.0 / 60.0, SpringIntegrator::implicit);
  std::get<DeformableBody>(scene.bodies[0].kind).start = StartState{};
  scene.bodies[0].angular_velocity = Vec3(0.0, 0.0, 10.0);
  const auto simulation = compile(scene, quiet);
  const double start = energy(simulation->snapshot().metrics);
  Metrics m;
  for (int frame = 0; frame < 120; ++frame) m = simulation->step(quiet).metrics;
  EXPECT_NEAR(energy(m), start, 0.02 * start);
}

/// Symplectic steps in fewer substeps than they need blow up, to an energy of 1e267 J and beyond.
TEST(Implicit, StandsInForMoreSymplecticSubstepsThanAFrameMayHave) {
  Progress quiet;
  const auto simulation = compile(stretched_cube(2, 1e12, 0.1, SpringIntegrator::symplectic), quiet);
  const std::vector<PlannedPhase> plan = simulation->plan();
  const auto implicit = std::ranges::find(plan, "implicit_euler", &PlannedPhase::name);
  ASSERT_NE(implicit, plan.end());
  EXPECT_TRUE(implicit->included);
  EXPECT_NE(implicit->reason.find("more than 20000"), std::string::npos) << implicit->reason;
  const double start = energy(simulation->snapshot().metrics);
  for (int frame = 0; frame < 3; ++frame) EXPECT_LE(energy(simulation->step(quiet).metrics), 1.05 * start);
}

TEST(Implicit, AutoChoosesItWhereSymplecticStepsAreManyAndSaysWhy) {
  Progress quiet;
  for (const auto& [stiffness, implicit] : {std::pair{1e2, false}, {1e7, true}}) {
    const auto simulation =
        compile(stretched_cube(4, stiffness, 1.0 / 60.0, SpringIntegrator::automatic), quiet);
    for (const PlannedPhase& phase : simulation->plan()) {
      if (phase.name == "implicit_euler") {
        EXPECT_EQ(phase.included, implicit) << stiffness;
        EXPECT_EQ(phase.reason.find("Gershgorin") != std::string::npos, implicit) << phase.reason;
        EXPECT_EQ(phase.bytes > 0, implicit);
      }
      if (phase.name == "symplectic_euler") {
        EXPECT_EQ(phase.included, !implicit) << stiffness;
      }
    }
    EXPECT_EQ(simulation->step(quiet).metrics.substeps == 1, implicit || stiffness == 1e2);
  }
}

/// Σ m (r − R)·DR / Σ m |DR|², D = diag(1, −½, −½): how far the cube is stretched along x.
double stretch(const BodyTopology& body, const Snapshot& frame) {
  const Vec3 weights(1.0, -0.5, -0.5);
  double sum = 0.0, norm = 0.0;
  for (std::size_t i = 0; i < body.masses.size(); ++i) {
    const Vec3 mode = weights.cwiseProduct(body.rest_positions[i]);
    sum += body.masses[i] * (frame.bodies[0].positions[i] - body.rest_positions[i]).dot(mode);
    norm += body.masses[i] * mode.squaredNorm();
  }
  return sum / norm;
}

/// How the stretch goes on over 1.25 s, 1 at the start.
std::vector<double> swing(double h, SpringIntegrator springs, double* largest_energy) {
  Progress quiet;
  const auto simulation = compile(stretched_cube(4, 1e6, h, springs), quiet);
  const BodyTopology body = simulation->topology()[0];
  Snapshot frame = simulation->snapshot();
  const double start = energy(frame.metrics), released = stretch(body, frame);
  std::vector<double> swing{1.0};
  *largest_energy = 0.0;
  while (frame.t < 1.25) {
    frame = simulation->step(quiet);
    *largest_energy = std::max(*largest_energy, energy(frame.metrics) / start);
    swing.push_back(stretch(body, frame) / released);
  }
  return swing;
}

/// Radians a second, by the zeros of the swing.
double frequency(const std::vector<double>& q, double h) {
  double first = 0.0, last = 0.0;
  int swings = -1;
  for (std::size_t i = 0; i + 1 < q.size(); ++i) {
    if (q[i] >= 0.0 || q[i + 1] < 0.0) continue;
    last = h * (static_cast<double>(i) + q[i] / (q[i] - q[i + 1]));
    if (++swings == 0) first = last;
  }
  return 2.0 * std::numbers::pi * swings / (last - first);
}

/// Root mean square of √(q² + (q̇/ω)²) from 0.75 to 1.25 s, with mean and slope of neighbouring samples and
/// what the trapezoidal rule makes of them, √(1 + (ωh/2)²), taken out: the amplitude whatever the phase, also
/// where few samples fall into a swing.
double amplitude(const std::vector<double>& q, double h, double omega) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i + 1 < q.size(); ++i) {
    const double t = h * (static_cast<double>(i) + 0.5);
    if (t < 0.75 || t > 1.25) continue;
    const double mean = 0.5 * (q[i] + q[i + 1]), slope = (q[i + 1] - q[i]) / (h * omega);
    sum += (mean * mean + slope * slope) * (1.0 + 0.25 * h * h * omega * omega);
    ++count;
  }
  return std::sqrt(sum / count);
}

/// After a second a stiff cube (ωh is 6) swings as fine symplectic steps have it; implicit Euler has stopped
/// it.
TEST(EnergyMomentum, SwingsAsFineSymplecticStepsDo) {
  const double h = 1.0 / 60.0, fine = h / 32.0;
  double gained = 0.0;
  const std::vector<double> reference = swing(fine, SpringIntegrator::symplectic, &gained);
  const double omega = frequency(reference, fine), wanted = amplitude(reference, fine, omega);
  EXPECT_GT(omega * h, 4.0);
  const double ratio = amplitude(swing(h, SpringIntegrator::energy_momentum, &gained), h, omega) / wanted;
  EXPECT_GT(ratio, 0.9);
  EXPECT_LT(ratio, 1.1);
  EXPECT_LE(gained, 1.01);
  EXPECT_LT(amplitude(swing(h, SpringIntegrator::implicit, &gained), h, omega), 0.01 * wanted);
}

/// At any stiffness, from a feasible start, at most the start's energy and one per cent.
TEST(EnergyMomentum, KeepsItsLedger) {
  Progress quiet;
  for (const double stiffness : {1e4, 1e8, 1e12}) {
    const auto simulation =
        compile(stretched_cube(3, stiffness, 1.0 / 60.0, SpringIntegrator::energy_momentum), quiet);
    const double start = energy(simulation->snapshot().metrics);
    for (int i = 0; i < 30; ++i) {
      const Metrics m = simulation->step(quiet).metrics;
      EXPECT_LE(energy(m), 1.01 * start) << stiffness << ", frame " << i;
      EXPECT_LE(m.max_cell_volume_error, 1e-6) << stiffness;
    }
  }
}

}  // namespace
}  // namespace isochor

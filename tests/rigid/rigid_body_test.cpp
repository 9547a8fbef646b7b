#include "core/rigid/rigid_body.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace isochor {
namespace {

RigidBodyState make_body(const Vec3& moments, const Vec3& angular_velocity) {
  RigidBodyState body;
  body.inverse_mass = 0.5;
  body.inertia = moments.asDiagonal();
  body.inverse_inertia = moments.cwiseInverse().asDiagonal();
  body.pose.orientation = rotation_exp({0.3, -0.2, 0.5});
  body.angular_momentum = body.pose.orientation * (moments.asDiagonal() * angular_velocity);
  return body;
}

TEST(RigidBody, FreeTopKeepsEnergyAndMomentumForTenSeconds) {
  // About the middle axis: the unstable one, which tumbles over (Dzhanibekov).
  const Vec3 moments(1.0, 2.0, 3.0);
  for (const double speed : {3.0, 50.0, 1000.0}) {
    RigidBodyState body = make_body(moments, speed * Vec3(0.01, 1.0, 0.02));
    const Vec3 momentum = body.angular_momentum;
    const double energy = kinetic_energy(body);
    double least_alignment = 1.0;
    const Vec3 axis = body.pose.orientation * Vec3::UnitY();
    for (int step = 0; step < 600; ++step) {
      body.pose = drift(body, 1.0 / 60.0);
      least_alignment = std::min(least_alignment, axis.dot(body.pose.orientation * Vec3::UnitY()));
      ASSERT_EQ(body.angular_momentum, momentum);
      ASSERT_NEAR(kinetic_energy(body) / energy, 1.0, 1e-12);
      ASSERT_NEAR(body.pose.orientation.norm(), 1.0, 1e-15);
    }
    EXPECT_LT(least_alignment, -0.9);  // it did tumble
  }
}

TEST(RigidBody, SymmetricTopPrecessesAtTheClosedFormulasRate) {
  // In body axes ω turns about the symmetry axis at (I₃ − I₁)/I₁·ω₃.
  const Vec3 moments(2.0, 2.0, 3.0), start(0.4, 0.0, 5.0);
  RigidBodyState body = make_body(moments, start);
  const double rate = (3.0 - 2.0) / 2.0 * 5.0, h = 1e-3;
  for (int step = 0; step < 1000; ++step) body.pose = drift(body, h);
  const Vec3 omega = body.pose.orientation.conjugate() * body.angular_velocity();
  EXPECT_NEAR(omega.x(), 0.4 * std::cos(rate), 2e-6);
  EXPECT_NEAR(omega.y(), 0.4 * std::sin(rate), 2e-6);
  EXPECT_NEAR(omega.z(), 5.0, 1e-12);
}

TEST(RigidBody, ThinRodStaysFiniteAndKeepsItsEnergy) {
  RigidBodyState body = make_body({1e-6, 1.0, 1.0}, {1e3, 30.0, -20.0});
  const double energy = kinetic_energy(body);
  for (int step = 0; step < 600; ++step) body.pose = drift(body, 1.0 / 60.0);
  EXPECT_NEAR(kinetic_energy(body) / energy, 1.0, 1e-9);
}

TEST(RigidBody, RunsBackToWhereItStarted) {
  const RigidBodyState start = make_body({1.0, 2.0, 3.0}, {1.0, 2.0, 0.5});
  RigidBodyState body = start;
  body.pose = drift(body, 0.05);
  body.pose = drift(body, -0.05);
  EXPECT_LT(body.pose.orientation.angularDistance(start.pose.orientation), 1e-13);
}

TEST(RigidBody, ImpulseAtAPointGivesItTheVelocityOfTheInverseMass) {
  RigidBodyState body = make_body({1.0, 2.0, 3.0}, Vec3::Zero());
  body.pose.position = {1.0, 2.0, 3.0};
  const Vec3 point(1.5, 1.7, 3.4), impulse(0.3, -0.7, 0.2);
  apply_impulse(body, point, impulse);
  const Vec3 gained = body.velocity + body.angular_velocity().cross(point - body.pose.position);
  EXPECT_LT((gained - inverse_mass_at(body, point) * impulse).norm(), 1e-15);
  EXPECT_NEAR(kinetic_energy(body), 0.5 * impulse.dot(gained), 1e-15);
}

TEST(Rotation, LogarithmInvertsTheExponential) {
  for (const double angle : {0.0, 1e-12, 1e-8, 1e-3, 1.0, 3.0, std::numbers::pi - 1e-9}) {
    const Vec3 rotation = angle * Vec3(0.6, -0.64, 0.48);
    EXPECT_LT((rotation_log(rotation_exp(rotation)) - rotation).norm(), 1e-14 + 1e-15 * angle);
  }
}

}  // namespace
}  // namespace isochor

#include "core/collision/contact_response.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isochor {
namespace {

const Eigen::Matrix3d unit_mass = Eigen::Matrix3d::Identity();

TEST(ContactResponse, PartingBodiesGetNoImpulse) {
  EXPECT_EQ(impact_impulse({1.0, 0.5, 0.0}, Vec3::UnitY(), unit_mass, 0.5, 1.0), Vec3::Zero());
}

TEST(ContactResponse, NormalVelocityIsReversedByTheRestitution) {
  for (const double e : {0.0, 0.3, 1.0}) {
    const Vec3 v(0.0, -2.0, 0.0);
    EXPECT_NEAR((v + impact_impulse(v, Vec3::UnitY(), unit_mass, 0.0, e)).y(), 2.0 * e, 1e-15);
  }
}

TEST(ContactResponse, SlidingLosesFrictionTimesTheNormalImpulse) {
  // A point mass: Δv_t = μ(1+e)v_n while it slides.
  const Vec3 v(5.0, -2.0, 0.0);
  const Vec3 after = v + impact_impulse(v, Vec3::UnitY(), unit_mass, 0.4, 0.5);
  EXPECT_NEAR(after.x(), 5.0 - 0.4 * 1.5 * 2.0, 1e-14);
  EXPECT_NEAR(after.y(), 1.0, 1e-14);
}

TEST(ContactResponse, StickingStopsTheSliding) {
  const Vec3 v(0.5, -2.0, 0.3);
  const Vec3 after = v + impact_impulse(v, Vec3::UnitY(), unit_mass, 0.9, 0.0);
  EXPECT_LT(after.norm(), 1e-15);
}

TEST(ContactResponse, ImpactNeverGainsEnergyWhateverTheMassMatrix) {
  for (int i = 0; i < 200; ++i) {
    const Vec3 r(std::sin(i), std::cos(2.0 * i), std::sin(3.0 * i)), n = Vec3::UnitY();
    Eigen::Matrix3d k = 0.3 * unit_mass + 2.0 * (r.squaredNorm() * unit_mass - r * r.transpose());
    const Vec3 v(std::sin(5.0 * i), -std::abs(std::cos(7.0 * i)), std::cos(11.0 * i));
    const Vec3 p = impact_impulse(v, n, k, 0.1, 1.0);
    EXPECT_GE(n.dot(v + k * p), -1e-13);
    // Work of the impulse: ½p·(v + v').
    EXPECT_LE(0.5 * p.dot(v + v + k * p), 1e-13);
    EXPECT_EQ(clamp_to_cone(p - n.dot(p) * n, 0.1 * (1.0 + 1e-12), n.dot(p)), p - n.dot(p) * n);
  }
}

TEST(ContactResponse, ConeClampKeepsTheDirection) {
  EXPECT_EQ(clamp_to_cone({3.0, 0.0, 4.0}, 0.5, 10.0), Vec3(3.0, 0.0, 4.0));
  EXPECT_LT((clamp_to_cone({3.0, 0.0, 4.0}, 0.5, 2.0) - Vec3(0.6, 0.0, 0.8)).norm(), 1e-15);
  EXPECT_EQ(clamp_to_cone({3.0, 0.0, 4.0}, 0.5, -1.0), Vec3::Zero());
}

TEST(ContactResponse, CombinedCoefficients) {
  EXPECT_DOUBLE_EQ(combined_friction(0.3, 0.3), 0.3);
  EXPECT_EQ(combined_friction(0.0, 0.9), 0.0);
  EXPECT_EQ(combined_restitution(0.8, 0.0), 0.8);
}

}  // namespace
}  // namespace isochor

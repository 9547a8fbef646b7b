#include "core/scene/start_state.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

namespace isochor {
namespace {

Vec3 center_of_mass(const SoftBody& body, const Coordinates& x) {
  Vec3 sum = Vec3::Zero();
  double mass = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += body.masses[i] * x.at(i), mass += body.masses[i];
  return sum / mass;
}

/// About the vertical through the centre: the lower end by −½, the upper by +½ of the angle.
void twist(Coordinates& x, const Vec3& center, double degrees) {
  double low = 1e300, high = -1e300;
  for (const double y : x.y) low = std::min(low, y), high = std::max(high, y);
  if (!(high > low)) return;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double angle = degrees * std::numbers::pi / 180.0 * ((x.y[i] - low) / (high - low) - 0.5);
    x.set(i, center + Eigen::AngleAxisd(angle, Vec3::UnitY()) * (x.at(i) - center));
  }
}

void flatten(Coordinates& x, const Vec3& center, StartState::Flatten to) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (to != StartState::Flatten::none) x.y[i] = center.y();
    if (to == StartState::Flatten::line || to == StartState::Flatten::point) x.z[i] = center.z();
    if (to == StartState::Flatten::point) x.x[i] = center.x();
  }
}

/// Uniform in [−1, 1), the same on every platform.
double uniform(std::mt19937_64& random) {
  return 2.0 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1.0;
}

void randomize(Coordinates& x, double amount, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double dx = uniform(random), dy = uniform(random), dz = uniform(random);
    x.add(i, amount * Vec3(dx, dy, dz));
  }
}

}  // namespace

Coordinates start_positions(const SoftBody& body, const StartState& start) {
  Coordinates x(body.rest_positions);
  const Vec3 center = center_of_mass(body, x);
  Eigen::Matrix3d map = start.affine;
  if (start.invert) map = Eigen::Matrix3d(Vec3(-1.0, 1.0, 1.0).asDiagonal()) * map;
  if (!map.isIdentity(0.0))
    for (std::size_t i = 0; i < x.size(); ++i) x.set(i, center + map * (x.at(i) - center));
  if (start.twist_deg != 0.0) twist(x, center, start.twist_deg);
  flatten(x, center, start.flatten);
  if (start.randomize > 0.0) randomize(x, start.randomize * body.cell_size, start.seed);
  return x;
}

Coordinates start_velocities(const SoftBody& body, const Vec3& velocity, const Vec3& angular_velocity) {
  const Vec3 center = center_of_mass(body, body.positions);
  Coordinates v(body.size());
  for (std::size_t i = 0; i < body.size(); ++i)
    v.set(i, velocity + angular_velocity.cross(body.positions.at(i) - center));
  return v;
}

}  // namespace isochor

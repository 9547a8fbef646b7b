#include "core/dynamics/spring_tangent.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/newton/body.h"

namespace isochor {
namespace {

using namespace testing;

Coordinates product(const SpringStencil& springs, const SpringTangent& tangent, const Coordinates& p) {
  Coordinates result(p.size());
  tangent.add_product(springs, p, result);
  return result;
}

/// −(f(x + εp) − f(x − εp))/2ε against K·p, all springs in tension so that K is whole.
TEST(SpringTangent, IsTheDerivativeOfTheForces) {
  const Body body = make_box({4, 3, 3});
  const SpringMaterial material{700.0, 300.0, 0.0};
  const SpringStencil springs = make_spring_stencil(body.mesh, body.mesh.positions, material);
  Coordinates x(body.mesh.positions), p(x.size());
  std::mt19937 random(7);
  std::uniform_real_distribution<double> noise(-1.0, 1.0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    x.set(i, 1.3 * x.at(i) + 0.01 * Vec3(noise(random), noise(random), noise(random)));
    p.set(i, {noise(random), noise(random), noise(random)});
  }
  SpringTangent tangent(springs);
  const double h = 0.5, step = 1e-6;
  tangent.linearize(springs, material, x, h * h, h);
  const Coordinates kp = product(springs, tangent, p);
  Coordinates plus = x, minus = x, none(x.size()), f_plus(x.size()), f_minus(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) plus.add(i, step * p.at(i)), minus.add(i, -step * p.at(i));
  add_spring_forces(springs, material, plus, none, f_plus);
  add_spring_forces(springs, material, minus, none, f_minus);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 difference = (f_minus.at(i) - f_plus.at(i)) / (2.0 * step);
    EXPECT_LT((kp.at(i) / (h * h) - difference).norm(), 1e-6 * 700.0) << i;
  }
}

/// Compressed springs would make K indefinite: what is used of it never is.
TEST(SpringTangent, StaysPositiveUnderCompression) {
  const Body body = make_box({3, 3, 3});
  const SpringMaterial material{700.0, 300.0, 0.01};
  const SpringStencil springs = make_spring_stencil(body.mesh, body.mesh.positions, material);
  Coordinates x(body.mesh.positions), p(x.size());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-1.0, 1.0);
  for (std::size_t i = 0; i < x.size(); ++i) x.set(i, 0.5 * x.at(i));
  SpringTangent tangent(springs);
  tangent.linearize(springs, material, x, 0.01, 0.1);
  for (int trial = 0; trial < 20; ++trial) {
    for (std::size_t i = 0; i < x.size(); ++i) p.set(i, {noise(random), noise(random), noise(random)});
    const Coordinates kp = product(springs, tangent, p);
    double work = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) work += p.at(i).dot(kp.at(i));
    EXPECT_GT(work, 0.0);
  }
}

}  // namespace
}  // namespace isochor

#include "core/dynamics/implicit_solver.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/common/wide.h"

namespace isochor {
namespace {

constexpr int lanes = 8;

ISOCHOR_MULTIVERSION double dot_axis(const double* a, const double* b, std::size_t size) {
  double sums[lanes] = {};
  std::size_t i = 0;
  for (; i + lanes <= size; i += lanes)
    for (int lane = 0; lane < lanes; ++lane) sums[lane] += a[i + lane] * b[i + lane];
  double sum = 0.0;
  for (const double s : sums) sum += s;
  for (; i < size; ++i) sum += a[i] * b[i];
  return sum;
}

ISOCHOR_MULTIVERSION void axpy(double factor, const double* a, double* __restrict b, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) b[i] += factor * a[i];
}

ISOCHOR_MULTIVERSION void xpay(const double* a, double factor, double* __restrict b, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) b[i] = a[i] + factor * b[i];
}

void axpy(double factor, const Coordinates& a, Coordinates& b) {
  axpy(factor, a.x.data(), b.x.data(), a.size());
  axpy(factor, a.y.data(), b.y.data(), a.size());
  axpy(factor, a.z.data(), b.z.data(), a.size());
}

void xpay(const Coordinates& a, double factor, Coordinates& b) {
  xpay(a.x.data(), factor, b.x.data(), a.size());
  xpay(a.y.data(), factor, b.y.data(), a.size());
  xpay(a.z.data(), factor, b.z.data(), a.size());
}

void set_zero(Coordinates& v) {
  for (auto* axis : {&v.x, &v.y, &v.z}) std::ranges::fill(*axis, 0.0);
}

double dot(const Coordinates& a, const Coordinates& b) {
  return dot_axis(a.x.data(), b.x.data(), a.size()) + dot_axis(a.y.data(), b.y.data(), a.size()) +
         dot_axis(a.z.data(), b.z.data(), a.size());
}

}  // namespace

ImplicitSolver::ImplicitSolver(const SoftBody& body)
    : tangent_(body.springs),
      arms_(body.size()),
      residual_(body.size()),
      preconditioned_(body.size()),
      direction_(body.size()),
      product_(body.size()) {
  for (auto& entries : inverse_blocks_) entries.resize(body.size());
}

void ImplicitSolver::linearize(const SoftBody& body, double stiffness_weight, double damping_weight) {
  tangent_.linearize(body.springs, body.material, body.positions, stiffness_weight, damping_weight);
  auto& b = inverse_blocks_;
  for (auto& entries : b) std::ranges::fill(entries, 0.0);
  for (int axis = 0; axis < 3; ++axis) b[axis] = body.masses;
  tangent_.add_diagonal(body.springs, b);
  for (std::size_t i = 0; i < body.size(); ++i) {
    Eigen::Matrix3d block;
    block << b[0][i], b[3][i], b[4][i], b[3][i], b[1][i], b[5][i], b[4][i], b[5][i], b[2][i];
    const Eigen::Matrix3d inverse = block.inverse();
    b[0][i] = inverse(0, 0), b[1][i] = inverse(1, 1), b[2][i] = inverse(2, 2);
    b[3][i] = inverse(0, 1), b[4][i] = inverse(0, 2), b[5][i] = inverse(1, 2);
  }
  center_.setZero();
  for (std::size_t i = 0; i < body.size(); ++i) center_ += body.masses[i] * body.positions.at(i);
  center_ /= body.total_mass;
  for (std::size_t i = 0; i < body.size(); ++i) arms_.set(i, body.positions.at(i) - center_);
}

void ImplicitSolver::filter(const SoftBody& body, Coordinates& v) const {
  if (body.has_pins)
    for (std::size_t i = 0; i < body.size(); ++i)
      if (!(body.inverse_masses[i] > 0.0)) v.set(i, Vec3::Zero());
}

void ImplicitSolver::multiply(const SoftBody& body, const Coordinates& p, Coordinates& product) const {
  for (std::size_t i = 0; i < body.size(); ++i) {
    const double m = body.masses[i];
    product.x[i] = m * p.x[i], product.y[i] = m * p.y[i], product.z[i] = m * p.z[i];
  }
  tangent_.add_product(body.springs, p, product);
  filter(body, product);
}

void ImplicitSolver::expand(const SoftBody& body, const Vec6& c, Coordinates& v) const {
  for (std::size_t i = 0; i < v.size(); ++i) v.set(i, c.head<3>() + c.tail<3>().cross(arms_.at(i)));
  filter(body, v);
}

ImplicitSolver::Vec6 ImplicitSolver::restrict_to_rigid(const Coordinates& v) const {
  Vec6 sum = Vec6::Zero();
  for (std::size_t i = 0; i < v.size(); ++i) {
    sum.head<3>() += v.at(i);
    sum.tail<3>() += arms_.at(i).cross(v.at(i));
  }
  return sum;
}

// E = ZᵀAZ with Z the filtered rigid modes; modes that the filter has taken away get no correction.
void ImplicitSolver::build_coarse(const SoftBody& body) {
  Eigen::Matrix<double, 6, 6> coarse;
  for (int mode = 0; mode < 6; ++mode) {
    expand(body, Vec6::Unit(mode), direction_);
    multiply(body, direction_, product_);
    coarse.col(mode) = restrict_to_rigid(product_);
  }
  const Vec6 scale = coarse.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  coarse = (scale.asDiagonal() * (0.5 * (coarse + coarse.transpose())) * scale.asDiagonal()).eval();
  const Eigen::FullPivLU<Eigen::Matrix<double, 6, 6>> lu(coarse);
  if (lu.rcond() > 1e-13)
    coarse_inverse_ = scale.asDiagonal() * lu.inverse() * scale.asDiagonal();
  else
    coarse_inverse_.setZero();
}

void ImplicitSolver::precondition(const SoftBody& body) {
  const auto& b = inverse_blocks_;
  for (std::size_t i = 0; i < body.size(); ++i) {
    const double x = residual_.x[i], y = residual_.y[i], z = residual_.z[i];
    preconditioned_.x[i] = b[0][i] * x + b[3][i] * y + b[4][i] * z;
    preconditioned_.y[i] = b[3][i] * x + b[1][i] * y + b[5][i] * z;
    preconditioned_.z[i] = b[4][i] * x + b[5][i] * y + b[2][i] * z;
  }
  filter(body, preconditioned_);
  expand(body, coarse_inverse_ * restrict_to_rigid(residual_), product_);
  axpy(1.0, product_, preconditioned_);
}

int ImplicitSolver::advance(const SoftBody& body, double weight, const Coordinates& forces,
                            Coordinates& displacement, double tolerance, int max_iterations) {
  build_coarse(body);
  set_zero(product_);
  tangent_.add_product(body.springs, displacement, product_);
  residual_ = forces;
  xpay(product_, -weight, residual_);  // T·displacement − weight·forces
  for (auto* axis : {&residual_.x, &residual_.y, &residual_.z})
    for (double& r : *axis) r = -r;
  filter(body, residual_);
  return solve(body, displacement, tolerance, max_iterations);
}

int ImplicitSolver::solve(const SoftBody& body, Coordinates& displacement, double tolerance,
                          int max_iterations) {
  precondition(body);
  direction_ = preconditioned_;
  double energy = dot(residual_, preconditioned_);
  const double target = tolerance * tolerance * energy;
  int iterations = 0;
  while (iterations < max_iterations && energy > target) {
    ++iterations;
    multiply(body, direction_, product_);
    const double curvature = dot(direction_, product_);
    if (!(curvature > 0.0) || !std::isfinite(curvature)) break;
    const double step = energy / curvature;
    axpy(step, direction_, displacement);
    axpy(-step, product_, residual_);
    precondition(body);
    const double next = dot(residual_, preconditioned_);
    xpay(preconditioned_, next / energy, direction_);
    energy = next;
  }
  return iterations;
}

std::int64_t ImplicitSolver::bytes() const {
  const std::size_t doubles = 5 * 3 * arms_.size() + 6 * inverse_blocks_[0].size();
  return tangent_.bytes() + static_cast<std::int64_t>(doubles * sizeof(double));
}

}  // namespace isochor

#include "core/dynamics/saddle_solver.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/common/wide.h"
#include "core/parallel/cancel_scope.h"
#include "core/parallel/parallel.h"

namespace isochor {
namespace {

constexpr int lanes = 8;

ISOCHOR_MULTIVERSION double weighted_dot(const double* w, const double* a, const double* b,
                                         std::size_t size) {
  double sums[lanes] = {};
  std::size_t i = 0;
  for (; i + lanes <= size; i += lanes)
    for (int lane = 0; lane < lanes; ++lane) sums[lane] += w[i + lane] * a[i + lane] * b[i + lane];
  double sum = 0.0;
  for (const double s : sums) sum += s;
  for (; i < size; ++i) sum += w[i] * a[i] * b[i];
  return sum;
}

constexpr int together = 4;  ///< vectors of a basis, so that the one that they meet is read once for all
using Together = std::array<const double*, together>;

/// Σ w·a·b, one sum a vector b.
ISOCHOR_MULTIVERSION void weighted_dots(const double* w, const double* a, const Together& b, std::size_t size,
                                        double* sums) {
  constexpr std::size_t block = 256;
  double wa[block], parts[together][lanes] = {};
  for (std::size_t begin = 0; begin < size; begin += block) {
    const std::size_t count = std::min(block, size - begin), whole = count / lanes * lanes;
    for (std::size_t i = 0; i < count; ++i) wa[i] = w[begin + i] * a[begin + i];
    for (int k = 0; k < together; ++k) {
      const double* with = b[k] + begin;
      double* part = parts[k];
      for (std::size_t i = 0; i < whole; i += lanes)
        for (int lane = 0; lane < lanes; ++lane) part[lane] += wa[i + lane] * with[i + lane];
      for (std::size_t i = whole; i < count; ++i) part[0] += wa[i] * with[i];
    }
  }
  for (int k = 0; k < together; ++k) {
    sums[k] = 0.0;
    for (const double part : parts[k]) sums[k] += part;
  }
}

/// a += Σ factor·b.
ISOCHOR_MULTIVERSION void add_all(const std::array<double, together>& factors, const Together& b,
                                  double* __restrict a, std::size_t size) {
  const double *b0 = b[0], *b1 = b[1], *b2 = b[2], *b3 = b[3];
  for (std::size_t i = 0; i < size; ++i)
    a[i] += (factors[0] * b0[i] + factors[1] * b1[i]) + (factors[2] * b2[i] + factors[3] * b3[i]);
}

ISOCHOR_MULTIVERSION void axpy(double factor, const double* a, double* __restrict b, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) b[i] += factor * a[i];
}

ISOCHOR_MULTIVERSION void scale(double factor, double* a, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) a[i] *= factor;
}

ISOCHOR_MULTIVERSION void multiply_masses(const double* m, const double* a, double* __restrict b,
                                          std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) b[i] = m[i] * a[i];
}

struct Axes {
  const double *x, *y, *z;
};
Axes axes(const Coordinates& v) {
  return {v.x.data(), v.y.data(), v.z.data()};
}

/// v = t + r × arms.
ISOCHOR_MULTIVERSION void set_rigid(const double* t, const double* r, const Axes& arms, double* __restrict x,
                                    double* __restrict y, double* __restrict z, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    x[i] = t[0] + r[1] * arms.z[i] - r[2] * arms.y[i];
    y[i] = t[1] + r[2] * arms.x[i] - r[0] * arms.z[i];
    z[i] = t[2] + r[0] * arms.y[i] - r[1] * arms.x[i];
  }
}

/// Σ v and Σ arms × v.
ISOCHOR_MULTIVERSION void sum_rigid(const Axes& arms, const Axes& v, std::size_t size, double* sum) {
  double sums[6][lanes] = {};
  std::size_t i = 0;
  for (; i + lanes <= size; i += lanes) {
    for (int t = 0; t < lanes; ++t) {
      const double x = v.x[i + t], y = v.y[i + t], z = v.z[i + t];
      const double a = arms.x[i + t], b = arms.y[i + t], c = arms.z[i + t];
      sums[0][t] += x, sums[1][t] += y, sums[2][t] += z;
      sums[3][t] += b * z - c * y, sums[4][t] += c * x - a * z, sums[5][t] += a * y - b * x;
    }
  }
  for (int k = 0; k < 6; ++k) {
    sum[k] = 0.0;
    for (const double s : sums[k]) sum[k] += s;
  }
  for (; i < size; ++i) {
    const double x = v.x[i], y = v.y[i], z = v.z[i], a = arms.x[i], b = arms.y[i], c = arms.z[i];
    sum[0] += x, sum[1] += y, sum[2] += z;
    sum[3] += b * z - c * y, sum[4] += c * x - a * z, sum[5] += a * y - b * x;
  }
}

struct Symmetric {
  const double *xx, *yy, *zz, *xy, *xz, *yz;
};
ISOCHOR_MULTIVERSION void multiply_blocks(const Symmetric& s, const double* x, const double* y,
                                          const double* z, double* __restrict px, double* __restrict py,
                                          double* __restrict pz, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    px[i] = s.xx[i] * x[i] + s.xy[i] * y[i] + s.xz[i] * z[i];
    py[i] = s.xy[i] * x[i] + s.yy[i] * y[i] + s.yz[i] * z[i];
    pz[i] = s.xz[i] * x[i] + s.yz[i] * y[i] + s.zz[i] * z[i];
  }
}

ISOCHOR_MULTIVERSION void invert_blocks(double* xx, double* yy, double* zz, double* xy, double* xz,
                                        double* yz, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    const double a = xx[i], b = yy[i], c = zz[i], d = xy[i], e = xz[i], f = yz[i];
    const double A = b * c - f * f, D = e * f - d * c, E = d * f - e * b;
    const double inverse = 1.0 / (a * A + d * D + e * E);
    xx[i] = inverse * A, xy[i] = inverse * D, xz[i] = inverse * E;
    yy[i] = inverse * (a * c - e * e);
    yz[i] = inverse * (d * e - a * f);
    zz[i] = inverse * (a * b - d * d);
  }
}

const double* array_of(const SaddleVector& v, int array) {
  return (array == 0 ? v.nodes.x : array == 1 ? v.nodes.y : array == 2 ? v.nodes.z : v.cells).data();
}
double* array_of(SaddleVector& v, int array) {
  return const_cast<double*>(array_of(std::as_const(v), array));
}

void scale(double factor, SaddleVector& a) {
  for (auto* axis : {&a.nodes.x, &a.nodes.y, &a.nodes.z, &a.cells}) scale(factor, axis->data(), axis->size());
}

void set_zero(SaddleVector& a) {
  for (auto* axis : {&a.nodes.x, &a.nodes.y, &a.nodes.z, &a.cells}) std::ranges::fill(*axis, 0.0);
}

}  // namespace

SaddleSolver::SaddleSolver(const SoftBody& body)
    : tangent_(body.springs),
      rows_(*body.mesh),
      box_(BoxPreconditioner::make(*body.mesh)),
      weights_(body.size(), rows_.size()),
      arms_(body.size()),
      residual_(body.size(), rows_.size()),
      rigid_(body.size()),
      divergence_(rows_.size()) {
  for (auto& entries : inverse_blocks_) entries.resize(body.size());
  throw_if_scope_cancelled();
  constexpr std::size_t basis_bytes = std::size_t{256} << 20;
  const std::size_t vector_bytes = sizeof(double) * (3 * body.size() + rows_.size());
  cycle_ = static_cast<int>(std::clamp<std::size_t>(basis_bytes / (2 * vector_bytes), 8, longest_cycle));
  basis_.reserve(cycle_ + 1), preconditioned_.reserve(cycle_);
  for (int i = 0; i <= cycle_; ++i) basis_.emplace_back(body.size(), rows_.size());
  for (int i = 0; i < cycle_; ++i) preconditioned_.emplace_back(body.size(), rows_.size());
  hessenberg_.resize(cycle_ + 1, cycle_);
  constexpr std::size_t slice = 2048;
  for (int array = 0; array < 4; ++array) {
    const std::size_t size = array < 3 ? body.size() : rows_.size();
    for (std::size_t begin = 0; begin < size; begin += slice)
      slices_.push_back({array, begin, std::min(slice, size - begin)});
  }
  sums_.resize(slices_.size());
  for (auto* values : {&projected_, &cosines_, &sines_, &coefficients_}) values->resize(cycle_ + 1);
  // The box's inverses are those of equal cells: uneven masses are judged by trial, like other shapes.
  const auto [least, most] = std::ranges::minmax_element(body.masses);
  constexpr double even = 64.0;  // of a corner's vertex against an inner one: 8, doubled by lumping
  chosen_ = !box_ || (box_->fits() && *most < even * *least);
}

void SaddleSolver::linearize(const SoftBody& body, const Coordinates& positions, double stiffness_weight,
                             double damping_weight, std::span<const BlockedParticle> blocked,
                             const CarrierSpace& carriers) {
  blocked_ = blocked;
  carriers_ = &carriers;
  tangent_.linearize(body.springs, body.material, positions, stiffness_weight, damping_weight);
  rows_.linearize(*body.mesh, positions);
  center_.setZero();
  for (std::size_t i = 0; i < body.size(); ++i) center_ += body.masses[i] * positions.at(i);
  center_ /= body.total_mass;
  throw_if_scope_cancelled();
  for (std::size_t i = 0; i < body.size(); ++i) arms_.set(i, positions.at(i) - center_);
  invert_diagonals(body);
  if (box_) {
    MeanStiffness mean = tangent_.mean(body.springs);
    mean.mass = body.total_mass / (8.0 * static_cast<double>(rows_.size()));
    box_->prepare(mean, body.cell_size * body.cell_size);
  }
  build_rigid(body);
}

void SaddleSolver::invert_diagonals(const SoftBody& body) {
  auto& b = inverse_blocks_;
  for (int entry = 3; entry < 6; ++entry) std::ranges::fill(b[entry], 0.0);
  for (int axis = 0; axis < 3; ++axis) b[axis] = body.masses;
  tangent_.add_diagonal(body.springs, b);
  Coordinates& d = rigid_;
  for (std::size_t i = 0; i < body.size(); ++i) {
    const double free = body.inverse_masses[i] > 0.0 ? 1.0 : 0.0;
    d.set(i, free * Vec3(1.0 / b[0][i], 1.0 / b[1][i], 1.0 / b[2][i]));
    weights_.nodes.x[i] = free * 3.0 / (b[0][i] + b[1][i] + b[2][i]);
  }
  for (const BlockedParticle& held : blocked_) {
    const Vec3 share = held.inverse_mass.diagonal() * body.masses[held.particle];
    d.set(held.particle, share.cwiseProduct(d.at(held.particle)));
  }
  rows_.diagonal(d, weights_.cells);
  for (double& s : weights_.cells) s = s > 0.0 ? 1.0 / s : 0.0;
  invert_blocks(b[0].data(), b[1].data(), b[2].data(), b[3].data(), b[4].data(), b[5].data(), body.size());
}

void SaddleSolver::filter(const SoftBody& body, Coordinates& v) const {
  if (body.has_pins)
    for (std::size_t i = 0; i < body.size(); ++i)
      if (!(body.inverse_masses[i] > 0.0)) v.set(i, Vec3::Zero());
  if (blocked_.empty()) return;
  const Eigen::VectorXd& carried = carriers_->restricted(v);
  for (const BlockedParticle& held : blocked_)
    v.set(held.particle, body.masses[held.particle] * (held.inverse_mass * v.at(held.particle)));
  carriers_->expand(carried, v);
}

void SaddleSolver::multiply(const SoftBody& body, const Coordinates& p, Coordinates& product) const {
  multiply_masses(body.masses.data(), p.x.data(), product.x.data(), body.size());
  multiply_masses(body.masses.data(), p.y.data(), product.y.data(), body.size());
  multiply_masses(body.masses.data(), p.z.data(), product.z.data(), body.size());
  tangent_.add_product(body.springs, p, product);
}

void SaddleSolver::expand(const Vector6& c, Coordinates& v) const {
  set_rigid(c.data(), c.data() + 3, axes(arms_), v.x.data(), v.y.data(), v.z.data(), v.size());
}

SaddleSolver::Vector6 SaddleSolver::restrict_to_rigid(const Coordinates& v) const {
  Vector6 sum;
  sum_rigid(axes(arms_), axes(v), v.size(), sum.data());
  return sum;
}

// E = ZᵀAZ with Z the filtered rigid modes; modes that the filter has taken away get no correction.
void SaddleSolver::build_rigid(const SoftBody& body) {
  Coordinates& image = residual_.nodes;
  Eigen::Matrix<double, 6, 6> stiffness;
  // Nothing resists a free translation but the mass.
  const bool held = body.has_pins || !blocked_.empty();
  stiffness.setZero();
  if (!held) stiffness.diagonal().head<3>().setConstant(body.total_mass);
  for (int mode = held ? 0 : 3; mode < 6; ++mode) {
    expand(Vector6::Unit(mode), rigid_);
    filter(body, rigid_);
    multiply(body, rigid_, image);
    carriers_->add_resistance(rigid_, image);
    filter(body, image);
    stiffness.col(mode) = restrict_to_rigid(image);
  }
  const Vector6 units = stiffness.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  stiffness = (units.asDiagonal() * (0.5 * (stiffness + stiffness.transpose())) * units.asDiagonal()).eval();
  const Eigen::FullPivLU<Eigen::Matrix<double, 6, 6>> lu(stiffness);
  if (lu.rcond() > 1e-13)
    rigid_inverse_ = units.asDiagonal() * lu.inverse() * units.asDiagonal();
  else
    rigid_inverse_.setZero();
}

void SaddleSolver::precondition_nodes(const SoftBody& body, const Coordinates& from, Coordinates& to) {
  const auto& b = inverse_blocks_;
  if (box_)
    box_->nodes(from, to);
  else
    multiply_blocks({b[0].data(), b[1].data(), b[2].data(), b[3].data(), b[4].data(), b[5].data()},
                    from.x.data(), from.y.data(), from.z.data(), to.x.data(), to.y.data(), to.z.data(),
                    from.size());
  expand(rigid_inverse_ * restrict_to_rigid(from), rigid_);
  for (auto [r, t] : {std::pair{&rigid_.x, &to.x}, {&rigid_.y, &to.y}, {&rigid_.z, &to.z}})
    axpy(1.0, r->data(), t->data(), r->size());
  filter(body, to);
}

void SaddleSolver::subtract(const SoftBody& body, const Coordinates& displacement, SaddleVector& right_side) {
  multiply(body, displacement, rigid_);
  rows_.multiply(displacement, divergence_);
  axpy(-1.0, rigid_.x.data(), right_side.nodes.x.data(), body.size());
  axpy(-1.0, rigid_.y.data(), right_side.nodes.y.data(), body.size());
  axpy(-1.0, rigid_.z.data(), right_side.nodes.z.data(), body.size());
  axpy(-1.0, divergence_.data(), right_side.cells.data(), divergence_.size());
}

/// to = P⁻¹·from; divergence_ = J·to.
void SaddleSolver::precondition(const SoftBody& body, const SaddleVector& from, SaddleVector& to) {
  precondition_nodes(body, from.nodes, to.nodes);
  rows_.multiply(to.nodes, divergence_);
  std::vector<double>& rest = to.cells;
  for (std::size_t c = 0; c < rest.size(); ++c) rest[c] = from.cells[c] - divergence_[c];
  if (box_)
    box_->cells(rest, rest);
  else
    multiply_masses(weights_.cells.data(), rest.data(), rest.data(), rest.size());
  for (std::size_t c = 0; c < rest.size(); ++c)
    if (weights_.cells[c] == 0.0) rest[c] = 0.0;
}

/// preconditioned = P⁻¹·from, image = matrix·preconditioned.
void SaddleSolver::apply(const SoftBody& body, const SaddleVector& from, SaddleVector& preconditioned,
                         SaddleVector& image) {
  precondition(body, from, preconditioned);
  multiply(body, preconditioned.nodes, image.nodes);
  carriers_->add_resistance(preconditioned.nodes, image.nodes);
  rows_.add_transposed(preconditioned.cells, -1.0, image.nodes);
  filter(body, image.nodes);
  for (std::size_t c = 0; c < divergence_.size(); ++c)
    image.cells[c] = weights_.cells[c] > 0.0 ? divergence_[c] : 0.0;
}

double SaddleSolver::dot(const SaddleVector& a, const SaddleVector& b) const {
  const double* w = weights_.nodes.x.data();
  const std::size_t size = a.nodes.size();
  return weighted_dot(w, a.nodes.x.data(), b.nodes.x.data(), size) +
         weighted_dot(w, a.nodes.y.data(), b.nodes.y.data(), size) +
         weighted_dot(w, a.nodes.z.data(), b.nodes.z.data(), size) +
         weighted_dot(weights_.cells.data(), a.cells.data(), b.cells.data(), a.cells.size());
}

double SaddleSolver::norm(const SoftBody& body, const SaddleVector& residual) {
  residual_ = residual;
  filter(body, residual_.nodes);
  return std::sqrt(dot(residual_, residual_));
}

/// The sums of a slice apart, added in their order, so that threads do not show.
template <class Body>
void SaddleSolver::for_slices(const Body& body) const {
  parallel_for(std::ssize(slices_), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto s = static_cast<std::size_t>(begin); s < static_cast<std::size_t>(end); ++s)
      body(s, slices_[s]);
  });
}

void SaddleSolver::add_combination(const double* factors, const std::vector<SaddleVector>& vectors, int count,
                                   SaddleVector& to) const {
  for_slices([&](std::size_t, const Slice& slice) {
    for (int first = 0; first < count; first += together) {
      std::array<double, together> used{};
      Together from;
      for (int k = 0; k < together; ++k) {
        const bool is_there = first + k < count;
        if (is_there) used[k] = factors[first + k];
        from[k] = array_of(vectors[is_there ? first + k : first], slice.array) + slice.begin;
      }
      add_all(used, from, array_of(to, slice.array) + slice.begin, slice.size);
    }
  });
}

/// Takes from `next` its parts along the basis, four at a time: modified Gram–Schmidt by blocks.
void SaddleSolver::orthogonalize(int count, SaddleVector& next, double* parts) {
  for (int first = 0; first < count; first += together) {
    std::array<const SaddleVector*, together> with;
    for (int k = 0; k < together; ++k) with[k] = &basis_[first + k < count ? first + k : first];
    for_slices([&](std::size_t s, const Slice& slice) {
      Together b;
      for (int k = 0; k < together; ++k) b[k] = array_of(*with[k], slice.array) + slice.begin;
      const double* w = (slice.array < 3 ? weights_.nodes.x : weights_.cells).data() + slice.begin;
      weighted_dots(w, array_of(next, slice.array) + slice.begin, b, slice.size, sums_[s].data());
    });
    std::array<double, together> taken{};
    for (const auto& sum : sums_)
      for (int k = 0; k < together && first + k < count; ++k) taken[k] -= sum[k];
    for_slices([&](std::size_t, const Slice& slice) {
      Together b;
      for (int k = 0; k < together; ++k) b[k] = array_of(*with[k], slice.array) + slice.begin;
      add_all(taken, b, array_of(next, slice.array) + slice.begin, slice.size);
    });
    for (int k = 0; k < together && first + k < count; ++k) parts[first + k] = -taken[k];
  }
}

void SaddleSolver::choose_preconditioner(const SoftBody& body, const SaddleVector& right_side) {
  chosen_ = true;
  constexpr double tolerance = 1e-3, cost_of_box = 1.5;
  constexpr int most = 300;
  SaddleVector trial(body.size(), rows_.size());
  const int with_box = solve(body, right_side, trial, tolerance, most);
  std::optional<BoxPreconditioner> box = std::move(box_);
  box_.reset();
  const int affordable = static_cast<int>(cost_of_box * with_box);
  if (solve(body, right_side, trial, tolerance, affordable) >= affordable) box_ = std::move(box);
}

int SaddleSolver::solve(const SoftBody& body, const SaddleVector& right_side, SaddleVector& solution,
                        double tolerance, int max_iterations) {
  if (!chosen_) choose_preconditioner(body, right_side);
  set_zero(solution);
  const double goal = std::max(tolerance * norm(body, right_side), round_off(body));
  int iterations = 0;
  while (iterations < max_iterations) {
    const double length = std::sqrt(dot(residual_, residual_));
    if (!(length > goal) || !std::isfinite(length)) break;
    const int taken = run_cycle(body, length, goal, std::min(max_iterations - iterations, cycle_), solution);
    if (taken == 0) break;
    iterations += taken;
  }
  return iterations;
}

/// Arnoldi from the residual, of which the best step takes what it can.
int SaddleSolver::run_cycle(const SoftBody& body, double length, double goal, int most,
                            SaddleVector& solution) {
  auto& basis = basis_;
  basis[0] = residual_;
  scale(1.0 / length, basis[0]);
  Eigen::MatrixXd& h = hessenberg_;
  Eigen::VectorXd &left = projected_, &cosines = cosines_, &sines = sines_;
  left.setZero();
  left[0] = length;
  int j = 0;
  for (; j < most && std::abs(left[j]) > goal; ++j) {
    SaddleVector& next = basis[j + 1];
    apply(body, basis[j], preconditioned_[j], next);
    orthogonalize(j + 1, next, h.col(j).data());
    const double norm_of_next = std::sqrt(dot(next, next));
    if (!std::isfinite(norm_of_next)) break;
    for (int i = 0; i < j; ++i) {
      const double a = h(i, j), b = h(i + 1, j);
      h(i, j) = cosines[i] * a + sines[i] * b;
      h(i + 1, j) = cosines[i] * b - sines[i] * a;
    }
    const double r = std::hypot(h(j, j), norm_of_next);
    if (!(r > 0.0)) break;
    cosines[j] = h(j, j) / r;
    sines[j] = norm_of_next / r;
    h(j, j) = r;
    left[j + 1] = -sines[j] * left[j];
    left[j] *= cosines[j];
    if (norm_of_next > 0.0) scale(1.0 / norm_of_next, next);
  }
  if (j == 0) return 0;
  // y of H y = left, and what the rotations leave of the residual: left_j·Qᵀe_j in the basis.
  Eigen::VectorXd& y = coefficients_;
  y.head(j) = left.head(j);
  h.topLeftCorner(j, j).triangularView<Eigen::Upper>().solveInPlace(y.head(j));
  add_combination(y.data(), preconditioned_, j, solution);
  double factor = left[j];
  set_zero(residual_);
  for (int i = j; i >= 0; --i) {
    y[i] = i == 0 ? factor : factor * cosines[i - 1];
    if (i > 0) factor *= -sines[i - 1];
  }
  add_combination(y.data(), basis, j + 1, residual_);
  return j;
}

/// What a displacement of 1e-13 cells a particle leaves.
double SaddleSolver::round_off(const SoftBody& body) const {
  double sum = 0.0;
  for (const double w : weights_.nodes.x) sum += w > 0.0 ? 3.0 / w : 0.0;
  return 1e-13 * body.cell_size * std::sqrt(sum);
}

std::int64_t SaddleSolver::bytes() const {
  const std::size_t particles = arms_.size(), vectors = basis_.size() + preconditioned_.size() + 2;
  const std::size_t doubles = vectors * (3 * particles + rows_.size()) + 12 * particles + rows_.size();
  return tangent_.bytes() + rows_.bytes() + (box_ ? box_->bytes() : 0) +
         static_cast<std::int64_t>(doubles * sizeof(double));
}

}  // namespace isochor

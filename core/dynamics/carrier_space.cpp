#include "core/dynamics/carrier_space.h"

#include <algorithm>
#include <cmath>

#include "core/dynamics/eigenpairs.h"

namespace isochor {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Map = Eigen::Matrix<double, 3, 6>;

/// Of directions that move the particles, squared, relative to the one that moves them most.
constexpr double least_motion = 1e-9;

/// L with L·Lᵀ = C; what round-off has made negative counts as immovable.
Matrix6 root_of(const Matrix6& compliance) {
  const Eigenpairs pairs = symmetric_eigenpairs(compliance);
  return pairs.vectors * pairs.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

struct Entry {
  std::int32_t particle;
  int body;
  Map map;  ///< of the motions q = L·p
};

std::vector<Entry> entries_of(std::span<const CompliantBody> bodies, std::span<const Matrix6> roots) {
  std::vector<Entry> entries;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    for (const CarriedParticle& p : bodies[b].particles)
      entries.push_back({p.particle, static_cast<int>(b), p.map * roots[b]});
  std::ranges::stable_sort(entries, {}, &Entry::particle);
  return entries;
}

/// Calls visit(first, last) for the entries of each particle.
template <class Visit>
void for_particles(const std::vector<Entry>& entries, const Visit& visit) {
  for (auto first = entries.begin(); first != entries.end();) {
    auto last = first;
    while (last != entries.end() && last->particle == first->particle) ++last;
    visit(first, last);
    first = last;
  }
}

}  // namespace

void CarrierSpace::build(std::span<const CompliantBody> bodies) {
  const auto motions = static_cast<Eigen::Index>(6 * bodies.size());
  std::vector<Matrix6> roots;
  for (const CompliantBody& body : bodies) roots.push_back(root_of(body.compliance));
  const std::vector<Entry> entries = entries_of(bodies, roots);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(motions, motions);
  for_particles(entries, [&](auto first, auto last) {
    for (auto a = first; a != last; ++a)
      for (auto b = first; b != last; ++b)
        gram.block<6, 6>(6 * a->body, 6 * b->body) += a->map.transpose() * b->map;
  });
  particles_.clear();
  columns_.clear();
  rank_ = 0;
  if (entries.empty()) return;
  const auto [vectors, values] = symmetric_eigenpairs(gram);
  const double least = least_motion * values[motions - 1];
  while (rank_ < motions && values[motions - 1 - rank_] > least) ++rank_;
  resistance_ = values.tail(rank_).cwiseInverse();
  const Eigen::MatrixXd basis = vectors.rightCols(rank_) * resistance_.cwiseSqrt().asDiagonal();
  owed_ = Eigen::VectorXd::Zero(rank_);
  for (std::size_t b = 0; b < bodies.size(); ++b)
    owed_ += (roots[b] * basis.middleRows<6>(6 * static_cast<Eigen::Index>(b))).transpose() * bodies[b].owed;
  for_particles(entries, [&](auto first, auto last) {
    particles_.push_back(first->particle);
    for (int column = 0; column < rank_; ++column) {
      Vec3 sum = Vec3::Zero();
      for (auto e = first; e != last; ++e) sum += e->map * basis.block<6, 1>(6 * e->body, column);
      columns_.push_back(sum);
    }
  });
}

const Eigen::VectorXd& CarrierSpace::restricted(const Coordinates& v) const {
  coefficients_ = Eigen::VectorXd::Zero(rank_);
  auto column = columns_.begin();
  for (const std::int32_t i : particles_) {
    const Vec3 at = v.at(i);
    for (int k = 0; k < rank_; ++k) coefficients_[k] += (column++)->dot(at);
  }
  return coefficients_;
}

void CarrierSpace::expand(const Eigen::VectorXd& y, Coordinates& v) const {
  auto column = columns_.begin();
  for (const std::int32_t i : particles_) {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < rank_; ++k) sum += y[k] * *column++;
    v.add(i, sum);
  }
}

void CarrierSpace::add_resistance(const Coordinates& u, Coordinates& v) const {
  if (empty()) return;
  scaled_ = resistance_.cwiseProduct(restricted(u));
  expand(scaled_, v);
}

void CarrierSpace::subtract_imbalance(const Eigen::VectorXd& y, Coordinates& v) const {
  if (empty()) return;
  scaled_ = -resistance_.cwiseProduct(y) - owed_;
  expand(scaled_, v);
}

}  // namespace isochor

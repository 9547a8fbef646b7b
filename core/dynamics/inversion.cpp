#include "core/dynamics/inversion.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "core/parallel/cancel_scope.h"

namespace isochor {
namespace {

constexpr int max_sweeps = 20;
constexpr std::size_t tets_a_check = 1U << 17;  ///< between two looks for a cancellation
constexpr double least_volume = 0.05;           ///< of a tet, relative to rest
constexpr double largest_displacement = 0.3;    ///< cells
constexpr double largest_excess = 20.0;         ///< factor
constexpr double least_alignment = 0.1;         ///< of the start's directions with the present ones
constexpr double held = 1e-9;                   ///< of what its particles could do without contacts
constexpr double flat_gradient = 1e-6;          ///< ‖∇V‖ relative to V0^⅔, about that of rest
constexpr double missing_axis = 1e-6;           ///< singular value relative to that of the rest pose

double current_tet_volume(const Tet& t, const Coordinates& x) {
  return tet_volume(x.at(t[0]), x.at(t[1]), x.at(t[2]), x.at(t[3]));
}

double rest_tet_volume(const SoftBody& body, const Tet& t) {
  const auto& p = body.rest_positions;
  return tet_volume(p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
}

/// The rotation that fits the rest pose best to the cell's present one; with axes missing, any that fits the
/// rest: the singular vectors are completed to right-handed frames.
Eigen::Matrix3d best_rotation(const Eigen::Matrix3d& covariance, double rest_scale) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (svd.singularValues()[0] < missing_axis * rest_scale) return Eigen::Matrix3d::Identity();
  Eigen::Matrix3d u = svd.matrixU(), v = svd.matrixV();
  if (svd.singularValues()[1] < missing_axis * rest_scale) {
    // A line: the smallest turn that leads the rest direction onto it.
    return Eigen::Quaterniond::FromTwoVectors(v.col(0), u.col(0)).toRotationMatrix();
  }
  if (u.determinant() * v.determinant() < 0.0) u.col(2) = -u.col(2);
  return u * v.transpose();
}

struct CellPose {
  Vec3 center = Vec3::Zero(), rest_center = Vec3::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
};

CellPose fit_rest_pose(const SoftBody& body, const Cell& cell, const Coordinates& x) {
  CellPose pose;
  for (const auto i : cell.corners) {
    pose.center += x.at(i) / 8.0;
    pose.rest_center += body.rest_positions[i] / 8.0;
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double scale = 0.0;
  for (const auto i : cell.corners) {
    const Vec3 rest = body.rest_positions[i] - pose.rest_center;
    covariance += (x.at(i) - pose.center) * rest.transpose();
    scale += rest.squaredNorm();
  }
  pose.rotation = best_rotation(covariance, scale);
  return pose;
}

double squared_norm(const VolumeElements::Gradient& gradient) {
  double sum = 0.0;
  for (const Vec3& g : gradient) sum += g.squaredNorm();
  return sum;
}

}  // namespace

std::int64_t count_inverted(const TetMesh& mesh, const Coordinates& positions) {
  return std::ranges::count_if(mesh.tets,
                               [&](const Tet& t) { return !(current_tet_volume(t, positions) > 0.0); });
}

bool any_inverted(const TetMesh& mesh, const Coordinates& positions) {
  throw_if_scope_cancelled();
  return std::ranges::any_of(mesh.tets,
                             [&](const Tet& t) { return !(current_tet_volume(t, positions) > 0.0); });
}

TetInequality::TetInequality(const SoftBody& body)
    : mobility_(body.inverse_masses),
      tets_begin_(body.size() + 1, 0),
      tets_of_(4 * body.mesh->tets.size()),
      pending_((body.mesh->tets.size() + 63) / 64) {
  throw_if_scope_cancelled();
  const std::vector<Tet>& tets = body.mesh->tets;
  least_volumes_.reserve(tets.size());
  for (std::size_t t = 0; t < tets.size(); ++t) {
    if (t % tets_a_check == 0) throw_if_scope_cancelled();
    least_volumes_.push_back(least_volume * rest_tet_volume(body, tets[t]));
    for (const auto i : tets[t]) ++tets_begin_[i + 1];
  }
  throw_if_scope_cancelled();
  std::partial_sum(tets_begin_.begin(), tets_begin_.end(), tets_begin_.begin());
  std::vector<std::int32_t> next(tets_begin_.begin(), tets_begin_.end() - 1);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    if (t % tets_a_check == 0) throw_if_scope_cancelled();
    for (const auto i : tets[t]) tets_of_[next[i]++] = static_cast<std::int32_t>(t);
  }
}

bool TetInequality::lift(const SoftBody& body, const ProjectionRequest& request, int round, bool may_let_go,
                         Coordinates& positions) {
  mobility_.begin(request);
  std::ranges::fill(pending_, 0);
  const std::vector<Tet>& tets = body.mesh->tets;
  double missing = 0.0;
  for (std::size_t t = 0; t < tets.size(); ++t) {
    const double volume = current_tet_volume(tets[t], positions);
    if (!(volume < least_volumes_[t])) continue;
    pending_[t / 64] |= 1ULL << t % 64;
    missing += 1.0 - volume / least_volumes_[t];
  }
  // The projection leaves a part r of what was missing: so 1/(1 − r) times the lift, and in the next substep
  // half of what that needed beyond 1.
  const double left = round > 0 ? missing / missing_ : 0.0;
  if (round == 0)
    excess_ = 0.5 * (1.0 + excess_);
  else
    excess_ = left < 1.0 ? std::min(excess_ / (1.0 - left), largest_excess) : 1.0;
  // What contacts hold in all corners, they did not let go: twice the force.
  letting_go_ = round > 0 && lifts_.empty() && left >= 1.0 ? 2.0 * letting_go_ : 1.0;
  missing_ = missing;
  lifts_.clear();
  bool lifted = true;
  for (int s = 0; s < max_sweeps && lifted; ++s) lifted = sweep(body, request.start, may_let_go, positions);
  if (request.start) exceed(body, *request.start, positions);
  mobility_.end();
  return !lifted;
}

void TetInequality::displace(const Tet& tet, double mu, const VolumeElements::Gradient& along,
                             Coordinates& x) {
  for (int k = 0; k < 4; ++k) {
    x.add(tet[k], mu * mobility_.apply(tet[k], along[k]));
    mobility_.record(tet[k], mu * along[k]);
  }
}

void TetInequality::exceed(const SoftBody& body, const Coordinates& start, Coordinates& x) {
  const VolumeElements tets(*body.mesh, true);
  for (const Lift& lift : lifts_) {
    const Tet& tet = body.mesh->tets[lift.tet];
    const auto along = tets.gradient(lift.tet, start);
    double longest = 0.0;
    for (int k = 0; k < 4; ++k) longest = std::max(longest, mobility_.apply(tet[k], along[k]).norm());
    const double mu =
        std::min((excess_ - 1.0) * lift.multiplier, largest_displacement * body.cell_size / longest);
    displace(tet, mu, along, x);
  }
}

// Gauss–Seidel over all tets, which passes by those whose particles have not moved since.
bool TetInequality::sweep(const SoftBody& body, const Coordinates* start, bool may_let_go, Coordinates& x) {
  bool lifted = false;
  for (std::size_t word = 0; word < pending_.size(); ++word) {
    std::uint64_t ahead = ~0ULL;
    while (const std::uint64_t bits = pending_[word] & ahead) {
      const int bit = std::countr_zero(bits);
      ahead = bit == 63 ? 0 : ~0ULL << (bit + 1);
      pending_[word] &= ~(1ULL << bit);
      lifted |= raise(body, static_cast<std::int64_t>(64 * word) + bit, start, may_let_go, x);
    }
  }
  return lifted;
}

void TetInequality::mark_around(const Tet& tet) {
  for (const auto i : tet)
    for (std::int32_t k = tets_begin_[i]; k < tets_begin_[i + 1]; ++k)
      pending_[tets_of_[k] / 64] |= 1ULL << tets_of_[k] % 64;
}

// μ = −C/(∇V(x)·W·∇V(x_dir)) for C = V − 0.05·V0 < 0. True when the tet was below.
bool TetInequality::raise(const SoftBody& body, std::int64_t t, const Coordinates* start, bool may_let_go,
                          Coordinates& x) {
  const VolumeElements tets(*body.mesh, true);
  const Tet& tet = body.mesh->tets[t];
  const double missing = least_volumes_[t] - current_tet_volume(tet, x);
  if (!(missing > 0.0)) return false;
  const auto now = tets.gradient(t, x), along = start ? tets.gradient(t, *start) : now;
  double denominator = 0.0, own = 0.0, longest = 0.0, unheld = 0.0, unheld_longest = 0.0;
  for (int k = 0; k < 4; ++k) {
    const Vec3 step = mobility_.apply(tet[k], along[k]);
    denominator += now[k].dot(step);
    own += now[k].dot(mobility_.apply(tet[k], now[k]));
    longest = std::max(longest, step.norm());
    const double w = mobility_.inverse_mass(tet[k]);
    unheld += w * now[k].squaredNorm();
    unheld_longest = std::max(unheld_longest, w * along[k].norm());
  }
  const double farthest = largest_displacement * body.cell_size;
  if (may_let_go && own < held * unheld) {
    // All four lie on a surface: the force alone, which lets contacts go.
    const double mu = std::min(letting_go_ * missing / unheld, farthest / unheld_longest);
    for (int k = 0; k < 4; ++k) mobility_.record(tet[k], mu * along[k]);
    return false;
  }
  const double mu = std::min(missing / denominator, farthest / longest);
  if (!(denominator > least_alignment * own) || !std::isfinite(mu)) {
    pending_[t / 64] |= 1ULL << t % 64;
    return true;
  }
  displace(tet, mu, along, x);
  lifts_.push_back({static_cast<std::int32_t>(t), mu});
  mark_around(tet);
  return true;
}

std::int64_t TetInequality::bytes() const {
  return mobility_.bytes() +
         static_cast<std::int64_t>(least_volumes_.capacity() * sizeof(double) +
                                   (tets_begin_.capacity() + tets_of_.capacity()) * sizeof(std::int32_t) +
                                   lifts_.capacity() * sizeof(Lift) +
                                   pending_.capacity() * sizeof(std::uint64_t));
}

std::int64_t pull_flattened_cells(const SoftBody& body, Coordinates& positions) {
  throw_if_scope_cancelled();
  const VolumeElements cells(*body.mesh, false);
  std::vector<Vec3> pull;  // made only where a cell is flat: most bodies never have one
  std::vector<int> pulled;
  std::int64_t flattened = 0;
  for (std::int64_t c = 0; c < cells.count(); ++c) {
    const double limit = flat_gradient * flat_gradient * std::pow(body.rest_volumes[c], 4.0 / 3.0);
    if (squared_norm(cells.gradient(c, positions)) > limit) continue;
    if (++flattened == 1) pull.resize(positions.size(), Vec3::Zero()), pulled.resize(positions.size(), 0);
    const Cell& cell = body.mesh->cells[c];
    const CellPose pose = fit_rest_pose(body, cell, positions);
    for (const auto i : cell.corners) {
      pull[i] += pose.center + pose.rotation * (body.rest_positions[i] - pose.rest_center) - positions.at(i);
      ++pulled[i];
    }
  }
  for (std::size_t i = 0; i < pulled.size(); ++i)
    if (pulled[i] && body.inverse_masses[i] > 0.0) positions.add(i, pull[i] / pulled[i]);
  return flattened;
}

bool turn_right_side_out(const SoftBody& body, Coordinates& positions) {
  const VolumeElements cells(*body.mesh, false);
  std::int64_t inside_out = 0;
  for (std::int64_t c = 0; c < cells.count(); ++c) inside_out += cells.volume(c, positions) < 0.0;
  if (2 * inside_out <= cells.count()) return false;
  Vec3 center = Vec3::Zero(), rest_center = Vec3::Zero();
  for (std::size_t i = 0; i < body.size(); ++i) {
    center += body.masses[i] / body.total_mass * positions.at(i);
    rest_center += body.masses[i] / body.total_mass * body.rest_positions[i];
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double scale = 0.0;
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Vec3 rest = body.rest_positions[i] - rest_center;
    covariance += body.masses[i] * (positions.at(i) - center) * rest.transpose();
    scale += body.masses[i] * rest.squaredNorm();
  }
  const Eigen::Matrix3d rotation = best_rotation(covariance, scale);
  for (std::size_t i = 0; i < body.size(); ++i)
    if (body.inverse_masses[i] > 0.0)
      positions.set(i, center + rotation * (body.rest_positions[i] - rest_center));
  return true;
}

}  // namespace isochor

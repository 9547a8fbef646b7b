#include <algorithm>
#include <tuple>

#include "core/dynamics/newton_lattice_system.h"

namespace isochor::newton {

/// Cells that have lost their row with the particle: all their corners stand still, and of those that are not
/// pinned this is the first.
std::int64_t LatticeSystem::count_rowless(std::int32_t held) const {
  std::int64_t count = 0;
  layout_.visit_cells(held, [&](std::int64_t cell, int corner) {
    bool counts = true;
    for (int b = 0; b < 8; ++b) {
      const std::int64_t s = layout_.corner_slot(cell, b);
      counts &= immovable_[s] != 0 && (b >= corner || inverse_masses_[s] == 0.0);
    }
    count += counts;
  });
  return count;
}

void LatticeSystem::block(std::span<const BlockedParticle> blocked) {
  for (const BlockedParticle& particle : blocked) {
    const std::int32_t s = slot(particle.particle);
    blocked_.push_back({s, particle.inverse_mass, Vec3::Zero()});
    immovable_[s] = particle.inverse_mass.isZero(0.0);
  }
  for (const RigidCarrier& carrier : carriers_)
    for (const CarriedParticle& carried : carrier.particles) immovable_[slot(carried.particle)] = 0;
  rowless_ = rowless_when_free_;
  for (const Blocked& particle : blocked_)
    if (immovable_[particle.slot] && inverse_masses_[particle.slot] > 0.0)
      rowless_ += count_rowless(particle.slot);
}

void LatticeSystem::unblock() {
  for (const Blocked& blocked : blocked_) immovable_[blocked.slot] = inverse_masses_[blocked.slot] == 0.0;
  blocked_.clear();
}

void LatticeSystem::load_carriers(std::span<RigidCarrier> carriers) {
  carriers_ = carriers;
  carrier_steps_.resize(carriers.size());
  auto& rows = solver_.carriers();
  if (rows.size() < carriers.size()) rows.resize(carriers.size()), carried_corners_.resize(carriers.size());
  for (CarrierRows& carrier : rows) carrier.own.clear(), carrier.start.clear();
  for (std::size_t i = 0; i < carriers.size(); ++i) {
    carriers[i].motion.setZero();
    rows[i].inverse_mass = (carriers[i].inverse_mass / mean_inverse_mass_).cast<float>();
    auto& corners = carried_corners_[i];
    corners.clear();
    for (std::size_t k = 0; k < carriers[i].particles.size(); ++k)
      layout_.visit_cells(slot(carriers[i].particles[k].particle), [&](std::int64_t cell, int corner) {
        corners.push_back({static_cast<std::int32_t>(cell), corner, static_cast<std::int32_t>(k)});
      });
    std::sort(corners.begin(), corners.end(), [](const CarriedCorner& a, const CarriedCorner& b) {
      return std::tie(a.cell, a.corner, a.carried) < std::tie(b.cell, b.corner, b.carried);
    });
  }
}

/// One of W Jᵀ, as a vector in place.
LatticeSystem::StridedVector LatticeSystem::weighted_gradient(std::int64_t cell, int corner) {
  if (layout_.irregular(cell)) {
    const std::int64_t i = layout_.irregular_index(cell);
    if (layout_.irregular_cells[i].corners[corner] >= layout_.first_extra)
      return StridedVector(weighted_irregular_[i].col(corner).data(), Eigen::InnerStride<>(1));
  }
  return StridedVector(weighted_.value[3 * corner] + cell, Eigen::InnerStride<>(layout_.slots));
}

void LatticeSystem::weigh_irregular_gradients(const PointArray& points) {
  for (const LatticeLayout::IrregularCell& cell : layout_.irregular_cells) {
    const CellCorners gradient = scaled_gradient(cell.slot, points);
    for (int b = 0; b < 8; ++b)
      weighted_gradient(cell.slot, b) = weights_[cell.corners[b]] * gradient[b].cast<float>();
  }
}

void LatticeSystem::weigh_blocked_gradients() {
  for (const Blocked& blocked : blocked_) {
    const double free = inverse_masses_[blocked.slot];
    if (free == 0.0) continue;
    const Eigen::Matrix3f weight = (blocked.inverse_mass / free).cast<float>();
    layout_.visit_cells(blocked.slot, [&](std::int64_t cell, int corner) {
      auto gradient = weighted_gradient(cell, corner);
      replaced_.push_back({cell, corner, gradient});
      gradient = weight * replaced_.back().value;
    });
  }
  blocked_are_weighed_ = true;
}

void LatticeSystem::restore_blocked_gradients() {
  for (const FreeGradient& free : replaced_) weighted_gradient(free.cell, free.corner) = free.value;
  replaced_.clear();
  blocked_are_weighed_ = false;
}

/// J B of each carrier, at the points.
void LatticeSystem::set_carrier_rows(const PointArray& points, CarrierSide side) {
  for (std::size_t i = 0; i < carriers_.size(); ++i) {
    auto& rows = solver_.carriers()[i].*side;
    rows.clear();
    CellCorners gradient;
    for (const CarriedCorner& corner : carried_corners_[i]) {
      if (rows.empty() || rows.back().slot != corner.cell) {
        gradient = scaled_gradient(corner.cell, points);
        rows.push_back({corner.cell, CarrierRows::Vector::Zero()});
      }
      const auto& map = carriers_[i].particles[corner.carried].map;
      rows.back().pull += (map.transpose() * gradient[corner.corner]).cast<float>();
    }
  }
}

/// Entries of irregular cells' rows, which the kernel leaves zero.
void LatticeSystem::set_irregular_rows(const PointArray& points) {
  for (const LatticeLayout::IrregularCell& cell : layout_.irregular_cells) {
    const CellCorners gradient = scaled_gradient(cell.slot, points);
    for (int b = 0; b < 8; ++b)
      layout_.visit_cells(cell.corners[b], [&](std::int64_t other, int corner) {
        solver_.add(cell.slot, static_cast<std::int32_t>(other),
                    gradient[b].cast<float>().dot(weighted_gradient(other, corner)));
      });
  }
}

void LatticeSystem::add_irregular_forces(const PointArray& points, double factor, const float* multipliers) {
  for (const LatticeLayout::IrregularCell& cell : layout_.irregular_cells) {
    const CellCorners gradient = scaled_gradient(cell.slot, points);
    for (int b = 0; b < 8; ++b)
      forces_.add(cell.corners[b], factor * length_ * length_ * multipliers[cell.slot] * gradient[b]);
  }
}

/// Jᵀμ at blocked particles, and what it gives to rigid bodies: W₆ Bᵀ Jᵀμ.
void LatticeSystem::read_blocked_forces() {
  for (Blocked& blocked : blocked_) blocked.force = forces_.at(blocked.slot);
  for (std::size_t i = 0; i < carriers_.size(); ++i) {
    Eigen::Matrix<double, 6, 1> pull = Eigen::Matrix<double, 6, 1>::Zero();
    for (const CarriedParticle& carried : carriers_[i].particles)
      pull += carried.map.transpose() * forces_.at(slot(carried.particle));
    carrier_steps_[i] = carriers_[i].inverse_mass * pull;
  }
}

void LatticeSystem::move_blocked_particles() {
  for (const Blocked& blocked : blocked_) direction_.set(blocked.slot, blocked.inverse_mass * blocked.force);
  for (std::size_t i = 0; i < carriers_.size(); ++i)
    for (const CarriedParticle& carried : carriers_[i].particles)
      direction_.add(slot(carried.particle), carried.map * carrier_steps_[i]);
  const auto move = [&](std::int32_t s) { trial_.set(s, x_.at(s) + direction_.at(s)); };
  for (const Blocked& blocked : blocked_) move(blocked.slot);
  for (const RigidCarrier& carrier : carriers_)
    for (const CarriedParticle& carried : carrier.particles) move(slot(carried.particle));
}

}  // namespace isochor::newton

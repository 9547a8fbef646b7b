#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/dynamics/newton_lattice_system.h"

namespace isochor::newton {

std::int64_t LatticeSystem::count_rowless() const {
  return std::count_if(model_.mesh->cells.begin(), model_.mesh->cells.end(), [&](const Cell& cell) {
    return std::all_of(cell.corners.begin(), cell.corners.end(),
                       [&](std::int32_t corner) { return immovable_[slot(corner)] != 0; });
  });
}

void LatticeSystem::block(std::span<const BlockedParticle> blocked) {
  bool any_held = false;
  for (const BlockedParticle& particle : blocked) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(particle.inverse_mass / mean_inverse_mass_);
    const Eigen::Matrix3d root = solver.eigenvectors() *
                                 solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
                                 solver.eigenvectors().transpose();
    const std::int32_t s = slot(particle.particle);
    blocked_.push_back({s, particle.particle, particle.inverse_mass, root.cast<float>(), Vec3::Zero()});
    root_weights_[s] = 1.0F;
    immovable_[s] = particle.inverse_mass.isZero(0.0);
    any_held |= immovable_[s] != 0;
  }
  for (const RigidCarrier& carrier : carriers_)
    for (const CarriedParticle& carried : carrier.particles) immovable_[slot(carried.particle)] = 0;
  rowless_ = any_held ? count_rowless() : rowless_when_free_;
}

void LatticeSystem::unblock() {
  for (const Blocked& blocked : blocked_) {
    const double w = model_.inverse_masses[blocked.particle];
    root_weights_[blocked.slot] = static_cast<float>(std::sqrt(w / mean_inverse_mass_));
    immovable_[blocked.slot] = w == 0.0;
  }
  blocked_.clear();
}

void LatticeSystem::load_carriers(std::span<RigidCarrier> carriers) {
  carriers_ = carriers;
  carrier_steps_.resize(carriers.size());
  auto& rows = solver_.carriers();
  if (rows.size() < carriers.size()) rows.resize(carriers.size());
  for (CarrierRows& carrier : rows) carrier.own.clear(), carrier.start.clear();
  for (std::size_t i = 0; i < carriers.size(); ++i) {
    carriers[i].motion.setZero();
    rows[i].inverse_mass = (carriers[i].inverse_mass / mean_inverse_mass_).cast<float>();
  }
}

void LatticeSystem::set_irregular_gradients(const PointArray& points, WeightedGradients& gradients) {
  for (std::size_t i = 0; i < layout_.irregular_cells.size(); ++i) {
    const LatticeLayout::IrregularCell& cell = layout_.irregular_cells[i];
    const CellCorners gradient = cell_volume_gradient(corners(cell, points), cell.parity);
    for (int b = 0; b < 8; ++b) {
      const Eigen::Vector3f weighted =
          root_weights_[cell.corners[b]] * (gradient[b] / (length_ * length_)).cast<float>();
      gradients.irregular[i].col(b) = weighted;
      const bool inside = cell.corners[b] < layout_.first_extra;
      for (int axis = 0; axis < 3; ++axis)
        gradients.view.value[3 * b + axis][cell.slot] = inside ? weighted[axis] : 0.0F;
    }
  }
}

/// Calls visit(slot of the cell, gradient) for all cells at a vertex, and takes the gradient back.
template <class Visit>
void LatticeSystem::visit_gradients(WeightedGradients& gradients, std::int32_t vertex_slot,
                                    const Visit& visit) {
  if (vertex_slot >= layout_.first_extra) {
    for (const auto& [cell, corner] : layout_.extra_vertices[vertex_slot - layout_.first_extra]) {
      Eigen::Vector3f gradient = gradients.irregular[cell].col(corner);
      visit(layout_.irregular_cells[cell].slot, gradient);
      gradients.irregular[cell].col(corner) = gradient;
    }
    return;
  }
  for (int b = 0; b < 8; ++b) {
    const std::int64_t cell = vertex_slot - layout_.corner_offset(b);
    Eigen::Vector3f gradient;
    for (int axis = 0; axis < 3; ++axis) gradient[axis] = gradients.view.value[3 * b + axis][cell];
    visit(static_cast<std::int32_t>(cell), gradient);
    for (int axis = 0; axis < 3; ++axis) gradients.view.value[3 * b + axis][cell] = gradient[axis];
  }
}

void LatticeSystem::set_carrier_rows(WeightedGradients& gradients,
                                     std::vector<CarrierRows::Row> CarrierRows::*member) {
  for (std::size_t i = 0; i < carriers_.size(); ++i) {
    auto& rows = solver_.carriers()[i].*member;
    rows.clear();
    for (const CarriedParticle& carried : carriers_[i].particles)
      visit_gradients(gradients, slot(carried.particle),
                      [&](std::int32_t cell, const Eigen::Vector3f& gradient) {
                        if (!gradient.isZero(0.0F))
                          rows.push_back({cell, carried.map.transpose().cast<float>() * gradient});
                      });
  }
}

void LatticeSystem::weigh_blocked_gradients(WeightedGradients& gradients) {
  for (const Blocked& blocked : blocked_)
    visit_gradients(gradients, blocked.slot, [&](std::int32_t, Eigen::Vector3f& gradient) {
      gradient = (blocked.root * gradient).eval();
    });
}

/// What cells have in common at a vertex behind the lattice.
void LatticeSystem::couple_extra_vertices(const WeightedGradients& own, const WeightedGradients& neighbors) {
  for (const auto& incidences : layout_.extra_vertices)
    for (const auto& [a, corner_a] : incidences)
      for (const auto& [b, corner_b] : incidences)
        solver_.add(layout_.irregular_cells[a].slot, layout_.irregular_cells[b].slot,
                    own.irregular[a].col(corner_a).dot(neighbors.irregular[b].col(corner_b)));
}

void LatticeSystem::add_irregular_forces(const PointArray& points, double factor) {
  for (const LatticeLayout::IrregularCell& cell : layout_.irregular_cells) {
    const CellCorners gradient = cell_volume_gradient(corners(cell, points), cell.parity);
    for (int b = 0; b < 8; ++b)
      lower_.add(cell.corners[b], factor * solver_.solution()[cell.slot] * gradient[b]);
  }
}

/// Jᵀμ at blocked particles, and what it gives to rigid bodies: W₆ Bᵀ Jᵀμ.
void LatticeSystem::read_blocked_forces() {
  for (Blocked& blocked : blocked_) blocked.force = lower_.at(blocked.slot) + upper_.at(blocked.slot);
  for (std::size_t i = 0; i < carriers_.size(); ++i) {
    Eigen::Matrix<double, 6, 1> pull = Eigen::Matrix<double, 6, 1>::Zero();
    for (const CarriedParticle& carried : carriers_[i].particles) {
      const std::int32_t s = slot(carried.particle);
      pull += carried.map.transpose() * (lower_.at(s) + upper_.at(s));
    }
    carrier_steps_[i] = carriers_[i].inverse_mass * pull;
  }
}

void LatticeSystem::move_blocked_particles() {
  for (const Blocked& blocked : blocked_) direction_.set(blocked.slot, blocked.inverse_mass * blocked.force);
  for (std::size_t i = 0; i < carriers_.size(); ++i)
    for (const CarriedParticle& carried : carriers_[i].particles)
      direction_.add(slot(carried.particle), carried.map * carrier_steps_[i]);
}

}  // namespace isochor::newton

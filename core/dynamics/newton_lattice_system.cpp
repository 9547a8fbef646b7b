#include "core/dynamics/newton_lattice_system.h"

#include <algorithm>
#include <cmath>

namespace isochor::newton {

LatticeSystem::LatticeSystem(VolumeModel model, LatticeLayout layout)
    : model_(std::move(model)),
      layout_(std::move(layout)),
      residual_weights_(layout_.slots),
      solver_(layout_, residual_weights_) {
  for (auto* points : {&start_, &x_, &trial_, &direction_, &lower_, &upper_})
    *points = PointArray(layout_.slots);
  for (auto* array : {&inverse_sixfold_, &errors_, &inverse_masses_})
    *array = AlignedArray<double>(layout_.slots);
  for (auto* array : {&sign_, &root_weights_}) *array = AlignedArray<float>(layout_.slots);
  for (auto* gradients : {&start_gradients_, &gradients_}) {
    gradients->values = AlignedArray<float>(24 * layout_.slots);
    for (int k = 0; k < 24; ++k) gradients->view.value[k] = gradients->values.data() + k * layout_.slots;
    gradients->irregular.resize(layout_.irregular_cells.size());
  }
  set_rest_volumes();
  set_masses();
}

void LatticeSystem::set_rest_volumes() {
  for (const double rest : model_.rest_volumes) total_rest_volume_ += rest;
  mean_rest_volume_ = total_rest_volume_ / static_cast<double>(model_.rest_volumes.size());
  length_ = std::cbrt(mean_rest_volume_);
  for (std::size_t c = 0; c < model_.rest_volumes.size(); ++c) {
    const std::int32_t s = layout_.cell_slots[c];
    const double sign = model_.mesh->cells[c].parity() ? -1.0 : 1.0;
    sign_[s] = static_cast<float>(sign / 6.0);
    inverse_sixfold_[s] = sign / (6.0 * model_.rest_volumes[c]);
    residual_weights_[s] = static_cast<float>(mean_rest_volume_ / model_.rest_volumes[c]);
  }
  for (std::size_t i = 0; i < layout_.irregular_cells.size(); ++i) {
    const std::int32_t s = layout_.irregular_cells[i].slot;
    irregular_rest_volumes_.push_back(1.0 / (6.0 * std::abs(inverse_sixfold_[s])));
    sign_[s] = 0.0F;
    inverse_sixfold_[s] = 0.0;
  }
}

void LatticeSystem::set_masses() {
  std::size_t free = 0;
  for (const double w : model_.inverse_masses) {
    mean_inverse_mass_ += w;
    free += w > 0.0;
  }
  pinned_ = model_.inverse_masses.size() - free;
  mean_inverse_mass_ = free > 0 ? mean_inverse_mass_ / static_cast<double>(free) : 1.0;
  immovable_.assign(layout_.slots, 0);
  for (std::size_t i = 0; i < model_.inverse_masses.size(); ++i) {
    const std::int32_t s = layout_.vertex_slots[i];
    inverse_masses_[s] = model_.inverse_masses[i];
    root_weights_[s] = static_cast<float>(std::sqrt(model_.inverse_masses[i] / mean_inverse_mass_));
    immovable_[s] = model_.inverse_masses[i] == 0.0;
  }
  rowless_ = rowless_when_free_ = count_rowless();
}

void LatticeSystem::gather(const Coordinates& from, PointArray& to) const {
  for (const LatticeLayout::VertexRun& run : layout_.vertex_runs) {
    std::copy_n(from.x.data() + run.vertex, run.count, to.axis(0) + run.slot);
    std::copy_n(from.y.data() + run.vertex, run.count, to.axis(1) + run.slot);
    std::copy_n(from.z.data() + run.vertex, run.count, to.axis(2) + run.slot);
  }
}

void LatticeSystem::load(const ProjectionRequest& request, const Coordinates& positions) {
  gather(request.start ? *request.start : positions, start_);
  gather(positions, x_);
  start_gradients_valid_ = false;
  unblock();
  load_carriers(request.carriers);
  block(request.blocked);
  blocked_forces_ = request.blocked_forces;
  std::fill(blocked_forces_.begin(), blocked_forces_.end(), Vec3::Zero());
}

void LatticeSystem::store(Coordinates& positions) const {
  for (const LatticeLayout::VertexRun& run : layout_.vertex_runs) {
    std::copy_n(x_.axis(0) + run.slot, run.count, positions.x.data() + run.vertex);
    std::copy_n(x_.axis(1) + run.slot, run.count, positions.y.data() + run.vertex);
    std::copy_n(x_.axis(2) + run.slot, run.count, positions.z.data() + run.vertex);
  }
}

CellCorners LatticeSystem::corners(const LatticeLayout::IrregularCell& cell, const PointArray& points) const {
  CellCorners result;
  for (int b = 0; b < 8; ++b) result[b] = points.at(cell.corners[b]);
  return result;
}

VolumeErrors LatticeSystem::evaluate(double t) {
  VolumeErrors result;
  double excess = 0.0;
  for (const LatticeLayout::Slab& slab : layout_.slabs)
    kernels_.move(as_runs(slab.nodes), x_.view(), t, direction_.view(), trial_.view());
  for (const LatticeLayout::Slab& slab : layout_.slabs) {
    ErrorSums sums;
    kernels_.errors(as_runs(slab.cells), layout_.strides, trial_.view(), inverse_sixfold_.data(),
                    errors_.data(), &sums);
    result.sum_of_squares += sums.squares;
    result.max = std::max(result.max, sums.largest);
    excess += sums.excess;
  }
  for (std::size_t i = 0; i < layout_.irregular_cells.size(); ++i) {
    const LatticeLayout::IrregularCell& cell = layout_.irregular_cells[i];
    const double rest = irregular_rest_volumes_[i];
    const double difference = cell_volume(corners(cell, trial_), cell.parity) - rest;
    errors_[cell.slot] = difference / rest;
    result.sum_of_squares += errors_[cell.slot] * errors_[cell.slot];
    result.max = std::max(result.max, std::abs(errors_[cell.slot]));
    excess += difference;
  }
  result.total = excess / total_rest_volume_;
  return result;
}

void LatticeSystem::accept(double t) {
  std::swap(x_, trial_);
  for (std::size_t i = 0; i < blocked_forces_.size(); ++i) blocked_forces_[i] += t * blocked_[i].force;
  for (std::size_t i = 0; i < carriers_.size(); ++i) carriers_[i].motion += t * carrier_steps_[i];
}

void LatticeSystem::set_gradients(const PointArray& points, WeightedGradients& gradients,
                                  std::vector<CarrierRows::Row> CarrierRows::*carrier_rows) {
  for (const LatticeLayout::Slab& slab : layout_.slabs)
    kernels_.gradients(as_runs(slab.cells), layout_.strides, points.view(), sign_.data(),
                       root_weights_.data(), 1.0 / length_, gradients.view);
  set_irregular_gradients(points, gradients);
  set_carrier_rows(gradients, carrier_rows);
  weigh_blocked_gradients(gradients);
}

void LatticeSystem::linearize(Directions directions) {
  if (directions == Directions::start && !start_gradients_valid_) {
    set_gradients(start_, start_gradients_, &CarrierRows::start);
    start_gradients_valid_ = true;
  }
  set_gradients(x_, gradients_, &CarrierRows::own);
  if (directions == Directions::current)
    for (CarrierRows& carrier : solver_.carriers()) carrier.start = carrier.own;
  const WeightedGradients& neighbors = directions == Directions::start ? start_gradients_ : gradients_;
  for (const LatticeLayout::Slab& slab : layout_.slabs)
    stencil_kernels().assemble(as_runs(slab.cells), layout_.strides, gradients_.view, neighbors.view,
                               solver_.stencil());
  couple_extra_vertices(gradients_, neighbors);
  solver_.prepare(face_areas(x_));
}

/// Squared face areas of the mean cell, of some cells spread over the body.
std::array<double, 3> LatticeSystem::face_areas(const PointArray& points) const {
  const auto& cells = model_.mesh->cells;
  Eigen::Matrix3d edges = Eigen::Matrix3d::Zero();
  const std::size_t step = std::max<std::size_t>(1, cells.size() / 64);
  for (std::size_t c = 0; c < cells.size(); c += step)
    for (int b = 0; b < 8; ++b)
      for (int axis = 0; axis < 3; ++axis)
        edges.col(axis) += (b >> axis & 1 ? 1.0 : -1.0) * points.at(slot(cells[c].corners[b]));
  std::array<double, 3> areas;
  double largest = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    areas[axis] = edges.col((axis + 1) % 3).cross(edges.col((axis + 2) % 3)).squaredNorm();
    largest = std::max(largest, areas[axis]);
  }
  constexpr double flattest = 1e-3;
  for (double& area : areas)
    area = largest > 0.0 && std::isfinite(largest) ? std::max(area / largest, flattest) : 1.0;
  return areas;
}

int LatticeSystem::solve(double tolerance) {
  float* right_side = solver_.right_side();
  for (const LatticeLayout::Slab& slab : layout_.slabs)
    for (const Run& run : slab.cells)
      for (std::int32_t s = run.begin; s < run.end; ++s)
        right_side[s] =
            residual_weights_[s] > 0.0F ? static_cast<float>(-errors_[s] / residual_weights_[s]) : 0.0F;
  return solver_.solve(tolerance);
}

void LatticeSystem::set_step(Directions directions) {
  const PointArray& points = directions == Directions::start ? start_ : x_;
  const double factor = 1.0 / (mean_inverse_mass_ * length_);
  for (const LatticeLayout::Slab& slab : layout_.slabs)
    kernels_.forces(as_runs(slab.cells), layout_.strides, points.view(), sign_.data(), solver_.solution(),
                    factor, lower_.view(), upper_.view());
  add_irregular_forces(points, factor);
  read_blocked_forces();
  for (const LatticeLayout::Slab& slab : layout_.slabs)
    kernels_.accelerate(as_runs(slab.nodes), inverse_masses_.data(), lower_.view(), upper_.view(),
                        direction_.view());
  move_blocked_particles();
}

void LatticeSystem::set_dilation() {
  double mass = 0.0;
  Vec3 center = Vec3::Zero();
  for (std::size_t i = 0; i < model_.inverse_masses.size(); ++i) {
    mass += 1.0 / model_.inverse_masses[i];
    center += start_.at(layout_.vertex_slots[i]) / model_.inverse_masses[i];
  }
  center /= mass;
  for (const std::int32_t s : layout_.vertex_slots) direction_.set(s, start_.at(s) - center);
}

std::int64_t LatticeSystem::worst_cell() const {
  const auto worse = [&](std::int32_t a, std::int32_t b) {
    return std::abs(errors_[a]) < std::abs(errors_[b]);
  };
  return std::max_element(layout_.cell_slots.begin(), layout_.cell_slots.end(), worse) -
         layout_.cell_slots.begin();
}

std::int64_t LatticeSystem::bytes() const {
  return 6 * x_.bytes() + 3 * errors_.bytes() + 3 * sign_.bytes() + 2 * gradients_.values.bytes() +
         static_cast<std::int64_t>(immovable_.size()) + solver_.bytes();
}

std::unique_ptr<NewtonSystem> make_lattice_system(const VolumeModel& model) {
  std::optional<LatticeLayout> layout = make_lattice_layout(*model.mesh);
  if (!layout) return nullptr;
  return std::make_unique<LatticeSystem>(model, *std::move(layout));
}

}  // namespace isochor::newton

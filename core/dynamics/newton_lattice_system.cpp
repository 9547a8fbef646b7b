#include "core/dynamics/newton_lattice_system.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/dynamics/lattice_box.h"
#include "core/parallel/cancel_scope.h"

namespace isochor::newton {

LatticeSystem::LatticeSystem(VolumeModel model, LatticeLayout layout)
    : model_(std::move(model)), layout_(std::move(layout)), solver_(layout_) {
  for (auto* points : {&start_, &x_, &trial_, &direction_, &forces_}) *points = PointArray(layout_.slots);
  for (auto* array : {&inverse_volumes_, &errors_, &inverse_masses_})
    *array = AlignedArray<double>(layout_.slots);
  for (auto* array : {&sign_, &weights_}) *array = AlignedArray<float>(layout_.slots);
  for (auto* array : {&multipliers_, &last_multipliers_}) *array = AlignedArray<float>(layout_.slots);
  weighted_values_ = AlignedArray<float>(24 * layout_.slots);
  for (int k = 0; k < 24; ++k) weighted_.value[k] = weighted_values_.data() + k * layout_.slots;
  weighted_irregular_.resize(layout_.irregular_cells.size());
  irregular_rest_volumes_.resize(layout_.irregular_cells.size());
  slab_sums_.resize(layout_.slabs.size());
  set_rest_volumes();
  throw_if_scope_cancelled();
  set_masses();
  throw_if_scope_cancelled();
  choose_preconditioner();
}

void LatticeSystem::set_rest_volumes() {
  for (const double rest : model_.rest_volumes) total_rest_volume_ += rest;
  mean_rest_volume_ = total_rest_volume_ / static_cast<double>(model_.rest_volumes.size());
  length_ = std::cbrt(mean_rest_volume_);
  for (std::size_t c = 0; c < model_.rest_volumes.size(); ++c) {
    const std::int32_t s = layout_.cell_slots[c];
    const double sixth = (layout_.parity(s) ? -1.0 : 1.0) / (6.0 * model_.rest_volumes[c]);
    if (layout_.irregular(s)) {
      irregular_rest_volumes_[layout_.irregular_index(s)] = model_.rest_volumes[c];
    } else {
      inverse_volumes_[s] = sixth;
      sign_[s] = static_cast<float>(mean_rest_volume_ * sixth);
    }
  }
}

void LatticeSystem::set_masses() {
  std::size_t free = 0;
  for (const double w : model_.inverse_masses) {
    mean_inverse_mass_ += w;
    free += w > 0.0;
    masses_.push_back(w > 0.0 ? 1.0 / w : 0.0);
  }
  pinned_ = model_.inverse_masses.size() - free;
  mean_inverse_mass_ = free > 0 ? mean_inverse_mass_ / static_cast<double>(free) : 1.0;
  immovable_.assign(layout_.slots, 0);
  for (std::size_t i = 0; i < model_.inverse_masses.size(); ++i) {
    const std::int32_t s = layout_.vertex_slots[i];
    inverse_masses_[s] = model_.inverse_masses[i];
    weights_[s] = static_cast<float>(model_.inverse_masses[i] / mean_inverse_mass_);
    immovable_[s] = model_.inverse_masses[i] == 0.0;
  }
  rowless_when_free_ = std::ranges::count_if(model_.mesh->cells, [&](const Cell& cell) {
    return std::ranges::all_of(cell.corners, [&](std::int32_t i) { return model_.inverse_masses[i] == 0.0; });
  });
  rowless_ = rowless_when_free_;
}

/// By trial, on random errors at rest.
void LatticeSystem::choose_preconditioner() {
  if (fills_its_box(*model_.mesh)) return;
  for (std::size_t i = 0; i < layout_.vertex_slots.size(); ++i)
    x_.set(layout_.vertex_slots[i], model_.mesh->positions[i]);
  linearize(Directions::current);
  std::uint32_t random = 1;
  for (const std::int32_t s : layout_.cell_slots) {
    random = random * 1664525U + 1013904223U;
    errors_[s] = random / 2147483648.0 - 1.0;
  }
  solver_.choose_preconditioner(errors_.data());
}

void LatticeSystem::gather(const Coordinates& from, PointArray& to) const {
  for (const LatticeLayout::VertexRun& run : layout_.vertex_runs) {
    std::copy_n(from.x.data() + run.vertex, run.count, to.axis(0) + run.slot);
    std::copy_n(from.y.data() + run.vertex, run.count, to.axis(1) + run.slot);
    std::copy_n(from.z.data() + run.vertex, run.count, to.axis(2) + run.slot);
  }
}

bool LatticeSystem::stands_at(const Coordinates& from, const PointArray& points) const {
  const auto same = [](const double* a, const double* b, std::int32_t count) {
    return std::memcmp(a, b, count * sizeof(double)) == 0;
  };
  return std::ranges::all_of(layout_.vertex_runs, [&](const LatticeLayout::VertexRun& run) {
    return same(from.x.data() + run.vertex, points.axis(0) + run.slot, run.count) &&
           same(from.y.data() + run.vertex, points.axis(1) + run.slot, run.count) &&
           same(from.z.data() + run.vertex, points.axis(2) + run.slot, run.count);
  });
}

void LatticeSystem::load(const ProjectionRequest& request, const Coordinates& positions) {
  const Coordinates& start = request.start ? *request.start : positions;
  // Rounds of contacts begin at the same start: its gradients serve them all.
  weighted_at_start_ = weighted_at_start_ && stands_at(start, start_);
  if (weighted_at_start_)
    restore_blocked_gradients();
  else
    gather(start, start_);
  gather(positions, x_);
  lifting_ = request.lifting;
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

CellCorners LatticeSystem::corners(std::int64_t cell, const PointArray& points) const {
  CellCorners result;
  for (int b = 0; b < 8; ++b) result[b] = points.at(layout_.corner_slot(cell, b));
  return result;
}

CellCorners LatticeSystem::scaled_gradient(std::int64_t cell, const PointArray& points) const {
  CellCorners gradient = cell_volume_gradient(corners(cell, points), layout_.parity(cell));
  const double rest = layout_.irregular(cell) ? irregular_rest_volumes_[layout_.irregular_index(cell)]
                                              : 1.0 / (6.0 * std::abs(inverse_volumes_[cell]));
  const double scale = mean_rest_volume_ / (rest * length_ * length_);
  for (Vec3& corner : gradient) corner *= scale;
  return gradient;
}

VolumeErrors LatticeSystem::evaluate(double t) {
  const bool moved = t != 0.0;
  if (moved && t != trial_t_) {
    layout_.for_slabs([&](std::int64_t, const LatticeLayout::Slab& slab) {
      kernels_.move(as_runs(slab.nodes), x_.view(), t, direction_.view(), trial_.view());
    });
    trial_t_ = t;
  }
  const PointArray& points = moved ? trial_ : x_;
  VolumeErrors result;
  double excess = 0.0;
  smallest_tet_ = 1.0;
  layout_.for_slabs([&](std::int64_t i, const LatticeLayout::Slab& slab) {
    kernels_.errors(as_runs(slab.cells), layout_.strides, points.view(), inverse_volumes_.data(),
                    errors_.data(), &slab_sums_[i]);
  });
  for (const ErrorSums& sums : slab_sums_) {
    result.sum_of_squares += sums.squares;
    result.max = std::max(result.max, sums.largest);
    excess += sums.excess;
    if (!(smallest_tet_ <= sums.smallest_tet)) smallest_tet_ = sums.smallest_tet;
  }
  for (std::size_t i = 0; i < layout_.irregular_cells.size(); ++i) {
    const std::int32_t cell = layout_.irregular_cells[i].slot;
    const double rest = irregular_rest_volumes_[i];
    const CellCorners at = corners(cell, points);
    const double difference = cell_volume(at, layout_.parity(cell)) - rest;
    smallest_tet_ = std::min(smallest_tet_, smallest_tet_volume(at, layout_.parity(cell)) / rest);
    errors_[cell] = difference / rest;
    result.sum_of_squares += errors_[cell] * errors_[cell];
    result.max = std::max(result.max, std::abs(errors_[cell]));
    excess += difference;
  }
  result.total = excess / total_rest_volume_;
  return result;
}

void LatticeSystem::accept(double t) {
  std::swap(x_, trial_);
  trial_t_ = -1.0;
  if (stepping_along_ && !lifting_)
    for (const std::int32_t cell : layout_.cell_slots)
      multipliers_[cell] += static_cast<float>(t) * stepping_along_[cell];
  for (std::size_t i = 0; i < blocked_forces_.size(); ++i) blocked_forces_[i] += t * blocked_[i].force;
  for (std::size_t i = 0; i < carriers_.size(); ++i) carriers_[i].motion += t * carrier_steps_[i];
}

Cells LatticeSystem::cells(const LatticeLayout::Slab& slab, const PointArray& points) const {
  return {as_runs(slab.cells), layout_.strides, points.view(), sign_.data(), 1.0 / length_};
}

/// W Jᵀ at the points.
void LatticeSystem::weigh_gradients(const PointArray& points) {
  layout_.for_slabs([&](std::int64_t, const LatticeLayout::Slab& slab) {
    stencil_kernels().gradients(cells(slab, points), weights_.data(), weighted_);
  });
  weigh_irregular_gradients(points);
  replaced_.clear();
  blocked_are_weighed_ = false;
}

void LatticeSystem::linearize(Directions directions) {
  const bool at_start = directions == Directions::start;
  if (!at_start || !weighted_at_start_) weigh_gradients(at_start ? start_ : x_);
  weighted_at_start_ = at_start;
  if (!blocked_are_weighed_) {
    weigh_blocked_gradients();
    set_carrier_rows(at_start ? start_ : x_, &CarrierRows::start);
  }
  set_carrier_rows(x_, &CarrierRows::own);
  layout_.for_slabs([&](std::int64_t, const LatticeLayout::Slab& slab) {
    stencil_kernels().assemble(cells(slab, x_), weighted_, solver_.stencil());
  });
  set_irregular_rows(x_);
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
  return solver_.solve(errors_.data(), tolerance);
}

void LatticeSystem::set_step(Directions directions) {
  set_step(directions, solver_.solution());
}

/// multipliers_ becomes what this step is likely to need, (h/h')²·(2μ' − μ'') of the two before, and true,
/// where these were alike; else zero.
bool LatticeSystem::carry_on_multipliers(double length) {
  constexpr double alike = 0.5;  // of the squares
  double change = 0.0, size = 0.0;
  for (const std::int32_t cell : layout_.cell_slots) {
    const double last = multipliers_[cell], difference = last - last_multipliers_[cell];
    size += last * last;
    change += difference * difference;
  }
  std::swap(multipliers_, last_multipliers_);
  const bool steady = length > 0.0 && change < alike * size;
  const auto scale = static_cast<float>(length * length);
  for (const std::int32_t cell : layout_.cell_slots)
    multipliers_[cell] = steady ? scale * (2.0F * last_multipliers_[cell] - multipliers_[cell]) : 0.0F;
  return steady;
}

void LatticeSystem::begin_step(const Coordinates& start, double length, Coordinates& positions) {
  if (!carry_on_multipliers(length)) return;
  load({.start = &start}, positions);
  set_step(Directions::start, multipliers_.data());
  std::swap(x_, trial_);
  trial_t_ = -1.0;
  stepping_along_ = nullptr;
  store(positions);
}

void LatticeSystem::set_step(Directions directions, const float* multipliers) {
  stepping_along_ = multipliers;
  const PointArray& points = directions == Directions::start ? start_ : x_;
  const double factor = 1.0 / (mean_inverse_mass_ * length_);
  // Slabs share the nodes between them with the next one only.
  for (const std::int64_t first : {0, 1})
    layout_.for_slabs(
        [&](std::int64_t, const LatticeLayout::Slab& slab) {
          kernels_.forces(as_runs(slab.cells), layout_.strides, points.view(), sign_.data(), multipliers,
                          factor, forces_.view());
        },
        first, 2);
  add_irregular_forces(points, factor, multipliers);
  read_blocked_forces();
  layout_.for_slabs([&](std::int64_t, const LatticeLayout::Slab& slab) {
    kernels_.accelerate(as_runs(slab.nodes), inverse_masses_.data(), forces_.view(), direction_.view(),
                        x_.view(), trial_.view());
  });
  trial_t_ = 1.0;
  move_blocked_particles();
}

void LatticeSystem::set_dilation() {
  double mass = 0.0;
  Vec3 center = Vec3::Zero();
  for (std::size_t i = 0; i < masses_.size(); ++i) {
    mass += masses_[i];
    center += masses_[i] * start_.at(layout_.vertex_slots[i]);
  }
  center /= mass;
  for (const std::int32_t s : layout_.vertex_slots) direction_.set(s, start_.at(s) - center);
  trial_t_ = -1.0;
  stepping_along_ = nullptr;
}

std::int64_t LatticeSystem::worst_cell() const {
  const auto worse = [&](std::int32_t a, std::int32_t b) {
    return std::abs(errors_[a]) < std::abs(errors_[b]);
  };
  return std::max_element(layout_.cell_slots.begin(), layout_.cell_slots.end(), worse) -
         layout_.cell_slots.begin();
}

std::int64_t LatticeSystem::bytes() const {
  return 5 * x_.bytes() + 3 * errors_.bytes() + 4 * sign_.bytes() + weighted_values_.bytes() +
         static_cast<std::int64_t>(immovable_.size() + layout_.kinds.size()) + solver_.bytes();
}

namespace {

/// Some 400 bytes a slot: a few twigs in a large box are better off as lists.
bool is_worth_a_lattice(const TetMesh& mesh) {
  constexpr double always = 4e6, emptiest = 64.0;
  std::array<std::int64_t, 3> low{}, high{};
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t at = mesh.nodes[i][axis];
      low[axis] = i == 0 ? at : std::min(low[axis], at);
      high[axis] = i == 0 ? at : std::max(high[axis], at);
    }
  double slots = 1.0;
  for (int axis = 0; axis < 3; ++axis) slots *= static_cast<double>(high[axis] - low[axis] + 1);
  return slots < always || slots < emptiest * static_cast<double>(mesh.cells.size());
}

}  // namespace

std::unique_ptr<NewtonSystem> make_lattice_system(const VolumeModel& model) {
  if (!is_worth_a_lattice(*model.mesh)) return nullptr;
  std::optional<LatticeLayout> layout = make_lattice_layout(*model.mesh);
  if (!layout) return nullptr;
  return std::make_unique<LatticeSystem>(model, *std::move(layout));
}

}  // namespace isochor::newton

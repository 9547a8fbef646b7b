#include "core/dynamics/volume_rows.h"

#include <algorithm>

#include "core/common/wide.h"
#include "core/dynamics/cell_volume.h"
#include "core/parallel/cancel_scope.h"
#include "core/parallel/parallel.h"

namespace isochor {
namespace {

using CellRun = VolumeRows::CellRun;

struct Entries {
  std::array<const double*, 24> value;
};

constexpr int block = 32;
constexpr std::int64_t cells_a_chunk = 2048, runs_a_chunk = 128;

ISOCHOR_MULTIVERSION void run_products(std::span<const CellRun> runs, const Entries& entries,
                                       const std::array<const double*, 3>& v, double* product) {
  double sum[block];
  for (const CellRun& run : runs) {
    for (std::int32_t begin = 0; begin < run.count; begin += block) {
      const int count = std::min(block, run.count - begin);
      for (int t = 0; t < count; ++t) sum[t] = 0.0;
      for (int b = 0; b < 8; ++b) {
        for (int axis = 0; axis < 3; ++axis) {
          const double *g = entries.value[3 * b + axis] + run.first + begin,
                       *x = v[axis] + run.corners[b] + begin;
          for (int t = 0; t < count; ++t) sum[t] += g[t] * x[t];
        }
      }
      for (int t = 0; t < count; ++t) product[run.first + begin + t] = sum[t];
    }
  }
}

ISOCHOR_MULTIVERSION void run_transposed(std::span<const CellRun> runs, const Entries& entries,
                                         const double* multipliers, double factor,
                                         const std::array<double*, 3>& out) {
  double scaled[block];
  for (const CellRun& run : runs) {
    for (std::int32_t begin = 0; begin < run.count; begin += block) {
      const int count = std::min(block, run.count - begin);
      for (int t = 0; t < count; ++t) scaled[t] = factor * multipliers[run.first + begin + t];
      for (int b = 0; b < 8; ++b) {
        for (int axis = 0; axis < 3; ++axis) {
          const double* g = entries.value[3 * b + axis] + run.first + begin;
          double* __restrict x = out[axis] + run.corners[b] + begin;
          for (int t = 0; t < count; ++t) x[t] += g[t] * scaled[t];
        }
      }
    }
  }
}

CellCorners corners_of(const Cell& cell, const Coordinates& positions) {
  CellCorners corners;
  for (int b = 0; b < 8; ++b) corners[b] = positions.at(cell.corners[b]);
  return corners;
}

bool follows(const Cell& cell, const CellRun& run) {
  for (int b = 0; b < 8; ++b)
    if (cell.corners[b] != run.corners[b] + run.count) return false;
  return true;
}

}  // namespace

VolumeRows::VolumeRows(const TetMesh& mesh) : volumes_(mesh.cells.size()) {
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    if (runs_.empty() || !follows(mesh.cells[c], runs_.back()))
      runs_.push_back({static_cast<std::int32_t>(c), 0, mesh.cells[c].corners});
    ++runs_.back().count;
  }
  for (auto& values : entries_) {
    throw_if_scope_cancelled();
    values.resize(mesh.cells.size());
  }
}

void VolumeRows::linearize(const TetMesh& mesh, const Coordinates& positions) {
  measure(mesh, positions);
  parallel_for(std::ssize(mesh.cells), cells_a_chunk, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = begin; c < end; ++c) {
      const CellCorners gradient =
          cell_volume_gradient(corners_of(mesh.cells[c], positions), mesh.cells[c].parity());
      for (int b = 0; b < 8; ++b)
        for (int axis = 0; axis < 3; ++axis) entries_[3 * b + axis][c] = gradient[b][axis];
    }
  });
}

void VolumeRows::measure(const TetMesh& mesh, const Coordinates& positions) {
  parallel_for(std::ssize(mesh.cells), cells_a_chunk, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = begin; c < end; ++c)
      volumes_[c] = cell_volume(corners_of(mesh.cells[c], positions), mesh.cells[c].parity());
  });
}

void VolumeRows::multiply(const Coordinates& v, std::vector<double>& product) const {
  Entries entries;
  for (int e = 0; e < 24; ++e) entries.value[e] = entries_[e].data();
  parallel_for(std::ssize(runs_), runs_a_chunk, [&](std::int64_t begin, std::int64_t end) {
    run_products(std::span(runs_).subspan(begin, end - begin), entries, {v.x.data(), v.y.data(), v.z.data()},
                 product.data());
  });
}

void VolumeRows::add_transposed(const std::vector<double>& multipliers, double factor,
                                Coordinates& sum) const {
  Entries entries;
  for (int e = 0; e < 24; ++e) entries.value[e] = entries_[e].data();
  run_transposed(runs_, entries, multipliers.data(), factor, {sum.x.data(), sum.y.data(), sum.z.data()});
}

void VolumeRows::diagonal(const Coordinates& d, std::vector<double>& diagonal) const {
  std::ranges::fill(diagonal, 0.0);
  throw_if_scope_cancelled();
  const std::array<const double*, 3> axes{d.x.data(), d.y.data(), d.z.data()};
  for (const CellRun& run : runs_)
    for (int b = 0; b < 8; ++b)
      for (int axis = 0; axis < 3; ++axis)
        for (std::int32_t t = 0; t < run.count; ++t) {
          const double g = entries_[3 * b + axis][run.first + t];
          diagonal[run.first + t] += g * g * axes[axis][run.corners[b] + t];
        }
}

std::int64_t VolumeRows::bytes() const {
  return static_cast<std::int64_t>(25 * volumes_.size() * sizeof(double) + runs_.size() * sizeof(CellRun));
}

}  // namespace isochor

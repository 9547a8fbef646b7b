#include "core/dynamics/spring_stencil.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel/cancel_scope.h"
#include "core/parallel/cancellable_sort.h"

namespace isochor {
namespace {

/// A spring's ends as corner bits; the first one has the lower layer.
using Ends = std::array<int, 2>;
using Direction = std::array<Ends, 4>;
constexpr std::array<Direction, 3> edge_directions{{{{{0, 1}, {2, 3}, {4, 5}, {6, 7}}},
                                                    {{{0, 2}, {1, 3}, {4, 6}, {5, 7}}},
                                                    {{{0, 4}, {1, 5}, {2, 6}, {3, 7}}}}};
constexpr std::array<Ends, 4> diagonal_directions{{{0, 7}, {1, 6}, {2, 5}, {3, 4}}};

/// Particles a chunk: enough work to hand to a thread, few enough to stay in its cache.
constexpr std::int64_t chunk_particles = 1024;

struct Spring {
  std::int32_t a, b;
  auto operator<=>(const Spring&) const = default;
};

int layers_per_chunk(const TetMesh& mesh) {
  const std::int64_t layers = mesh.grid.size.z() + 1;
  const auto particles = static_cast<std::int64_t>(mesh.positions.size());
  return static_cast<int>(
      std::max<std::int64_t>(1, chunk_particles * layers / std::max<std::int64_t>(1, particles)));
}

/// Appends one direction's springs, sorted and merged, as runs of consecutive particles within a chunk.
class FamilyBuilder {
 public:
  FamilyBuilder(const TetMesh& mesh, std::span<const Vec3> rest, int chunks)
      : mesh_(mesh), rest_(rest), layers_(layers_per_chunk(mesh)), runs_(chunks) {}

  void add(std::vector<Spring> springs) {
    throw_if_scope_cancelled();
    cancellable_sort(springs);
    throw_if_scope_cancelled();
    for (std::size_t s = 0; s < springs.size();) {
      std::size_t same = s + 1;
      while (same < springs.size() && springs[same] == springs[s]) ++same;
      append(springs[s], static_cast<double>(same - s));
      s = same;
    }
    extend_ = nullptr;
  }

  SpringFamily finish() {
    for (const auto& chunk : runs_) {
      family_.chunk_begin.push_back(static_cast<std::int32_t>(family_.runs.size()));
      family_.runs.insert(family_.runs.end(), chunk.begin(), chunk.end());
    }
    family_.chunk_begin.push_back(static_cast<std::int32_t>(family_.runs.size()));
    return std::move(family_);
  }

 private:
  void append(const Spring& spring, double cells) {
    const int chunk = mesh_.nodes[spring.a][2] / layers_;
    if (!extend_ || extend_ != &runs_[chunk] || extend_->back().a + extend_->back().count != spring.a ||
        extend_->back().b + extend_->back().count != spring.b) {
      runs_[chunk].push_back({spring.a, spring.b, static_cast<std::int32_t>(family_.rest_lengths.size()), 0});
      extend_ = &runs_[chunk];
    }
    ++extend_->back().count;
    family_.rest_lengths.push_back((rest_[spring.b] - rest_[spring.a]).norm());
    family_.cells.push_back(cells);
  }

  const TetMesh& mesh_;
  std::span<const Vec3> rest_;
  int layers_;
  std::vector<std::vector<SpringRun>> runs_;
  std::vector<SpringRun>* extend_ = nullptr;
  SpringFamily family_;
};

std::vector<Spring> collect(const TetMesh& mesh, std::span<const Ends> ends) {
  std::vector<Spring> springs;
  springs.reserve(mesh.cells.size() * ends.size());
  for (const Cell& cell : mesh.cells) {
    for (const Ends& e : ends) springs.push_back({cell.corners[e[0]], cell.corners[e[1]]});
  }
  return springs;
}

}  // namespace

std::int64_t SpringFamily::bytes() const {
  return static_cast<std::int64_t>(runs.capacity() * sizeof(SpringRun) +
                                   chunk_begin.capacity() * sizeof(std::int32_t) +
                                   (rest_lengths.capacity() + cells.capacity()) * sizeof(double));
}

SpringStencil make_spring_stencil(const TetMesh& mesh, std::span<const Vec3> rest_positions,
                                  const SpringMaterial& material) {
  SpringStencil stencil;
  const int chunks = mesh.grid.size.z() / layers_per_chunk(mesh) + 1;
  if (material.edge > 0.0) {
    FamilyBuilder builder(mesh, rest_positions, chunks);
    for (const Direction& direction : edge_directions) builder.add(collect(mesh, direction));
    stencil.edges = builder.finish();
  }
  if (material.diagonal > 0.0) {
    FamilyBuilder builder(mesh, rest_positions, chunks);
    for (const Ends& ends : diagonal_directions) builder.add(collect(mesh, {&ends, 1}));
    stencil.diagonals = builder.finish();
  }
  return stencil;
}

double gershgorin_bound(const SpringStencil& stencil, const SpringMaterial& material,
                        std::span<const double> inverse_masses) {
  std::vector<double> sums(inverse_masses.size(), 0.0);
  const auto add = [&](const SpringFamily& family, double stiffness) {
    throw_if_scope_cancelled();
    for (const SpringRun& run : family.runs) {
      for (std::int32_t t = 0; t < run.count; ++t) {
        const double wa = inverse_masses[run.a + t], wb = inverse_masses[run.b + t];
        const double k = stiffness * family.cells[run.first + t], mixed = std::sqrt(wa) * std::sqrt(wb);
        sums[run.a + t] += k * (wa + mixed);
        sums[run.b + t] += k * (wb + mixed);
      }
    }
  };
  add(stencil.edges, material.edge);
  add(stencil.diagonals, material.diagonal);
  return sums.empty() ? 0.0 : *std::ranges::max_element(sums);
}

// Symplectic Euler with the damping taken at the old velocity has trace 2 − h²λ − hτλ and determinant
// 1 − hτλ; it is stable while trace ≥ −(1 + determinant).
double stable_substep(double lambda, double damping) {
  if (!(lambda > 0.0)) return std::numeric_limits<double>::infinity();
  const double b = damping * lambda;
  return 4.0 / (b + std::sqrt(b * b + 4.0 * lambda));
}

}  // namespace isochor

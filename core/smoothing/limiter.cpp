#include "core/smoothing/limiter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel/parallel.h"
#include "core/quality/dihedral.h"

namespace isochor {
namespace {

constexpr int max_halvings = 8;
constexpr std::int64_t grain = 4096;

// A hair above the floor, so that the final rescaling's round-off stays above it.
double cosine_of_floor(double degrees) {
  return degrees > 0.0 ? std::cos((degrees + 1e-5) * std::numbers::pi / 180.0) : 1.0;
}

}  // namespace

MoveLimiter::MoveLimiter(const TetMesh& mesh, const BoundaryGraph& graph, double min_dihedral_deg)
    : graph_(graph),
      max_cosine_(cosine_of_floor(min_dihedral_deg)),
      min_volume_(1e-4 * std::pow(mesh.grid.spacing, 3)) {
  std::ranges::copy_if(mesh.tets, std::back_inserter(tets_), [&](const Tet& tet) {
    return std::ranges::any_of(tet, [&](std::int32_t v) { return graph.index[v] >= 0; });
  });
  const std::size_t n = graph.vertices.size();
  share_.resize(n), changed_.resize(n), next_.resize(n), limited_.resize(n, 0);
  bad_.resize(tets_.size());
}

bool MoveLimiter::is_bad(const Tet& t, const std::vector<Vec3>& x) const {
  const double cosine = smallest_dihedral_cosine(x[t[0]], x[t[1]], x[t[2]], x[t[3]], min_volume_);
  return cosine > max_cosine_ || cosine >= 1.0;
}

void MoveLimiter::apply(std::span<const Vec3> moves, std::vector<Vec3>& positions, const Progress& progress) {
  const auto count = static_cast<std::int64_t>(graph_.vertices.size());
  std::vector<Vec3> start(count);
  for (std::int64_t b = 0; b < count; ++b) start[b] = positions[graph_.vertices[b]];
  std::ranges::fill(share_, 1.0);
  std::ranges::fill(changed_, 1);
  for (int round = 0;; ++round) {
    progress.throw_if_cancelled();
    parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
      for (auto b = begin; b < end; ++b)
        if (changed_[b] != 0) positions[graph_.vertices[b]] = start[b] + share_[b] * moves[b];
    });
    if (!shorten(round >= max_halvings, positions)) return;
  }
}

// One round: judge the tets around changed vertices, then shorten the moves of the bad ones' vertices. False
// when there was nothing left to shorten.
bool MoveLimiter::shorten(bool drop, const std::vector<Vec3>& positions) {
  const auto index = [&](std::int32_t v) { return graph_.index[v]; };
  parallel_for(static_cast<std::int64_t>(tets_.size()), grain, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = begin; t < end; ++t) {
      const bool touched = std::ranges::any_of(
          tets_[t], [&](std::int32_t v) { return index(v) >= 0 && changed_[index(v)] != 0; });
      bad_[t] = touched && is_bad(tets_[t], positions);
    }
  });
  std::ranges::fill(next_, 0);
  for (std::size_t t = 0; t < tets_.size(); ++t) {
    if (bad_[t] == 0) continue;
    for (const std::int32_t v : tets_[t])
      if (index(v) >= 0 && share_[index(v)] > 0.0) next_[index(v)] = 1;
  }
  bool any = false;
  for (std::size_t b = 0; b < next_.size(); ++b) {
    if (next_[b] == 0) continue;
    share_[b] = drop ? 0.0 : 0.5 * share_[b];
    limited_[b] = 1;
    any = true;
  }
  changed_.swap(next_);
  return any;
}

std::int64_t MoveLimiter::limited_vertices() const {
  return std::ranges::count(limited_, 1);
}

}  // namespace isochor

#include "core/smoothing/limiter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/common/wide.h"
#include "core/parallel/cancellable_range.h"
#include "core/parallel/parallel.h"
#include "core/quality/dihedral.h"

namespace isochor {
namespace {

constexpr double least_share = 1.0 / 256.0;  ///< of a move; less is none
constexpr double regrowth = 2.0;             ///< of a share from one iteration to the next
constexpr std::int64_t grain = 512;

// A hair above the floor, so that the final rescaling's round-off stays above it.
double cosine_of_floor(double degrees) {
  return degrees > 0.0 ? std::cos((degrees + 1e-5) * std::numbers::pi / 180.0) : 1.0;
}

constexpr double min_volume = 1e-4;  ///< of a tet, in cells

constexpr int lanes = 8;
/// Of eight tets the edges from their first vertices in units of a cell, a coordinate a row.
using TetLanes = double[9][lanes];

void put(const Tet& t, const std::vector<Vec3>& x, double scale, int lane, TetLanes& edges) {
  for (int e = 0; e < 3; ++e)
    for (int axis = 0; axis < 3; ++axis)
      edges[3 * e + axis][lane] = scale * (x[t[e + 1]][axis] - x[t[0]][axis]);
}

ISOCHOR_MULTIVERSION void eight_excesses(const double (*e)[lanes], double squared_cosine, double* out) {
  for (int l = 0; l < lanes; ++l)
    out[l] = excess_over_cosine({e[0][l], e[1][l], e[2][l]}, {e[3][l], e[4][l], e[5][l]},
                                {e[6][l], e[7][l], e[8][l]}, squared_cosine, min_volume);
}

}  // namespace

MoveLimiter::MoveLimiter(const TetMesh& mesh, const BoundaryGraph& graph)
    : graph_(graph), scale_(1.0 / mesh.grid.spacing) {
  for (const Tet& tet : cancellable(mesh.tets))
    if (std::ranges::any_of(tet, [&](std::int32_t v) { return graph.index[v] >= 0; })) tets_.push_back(tet);
  const std::size_t n = graph.vertices.size();
  share_.resize(n, 1.0), limited_.resize(n, 0), chosen_.resize(n, 0), seen_.resize(tets_.size(), 0);
  const auto for_corners = [&](auto&& visit) {
    std::int32_t t = 0;
    for (const Tet& tet : cancellable(tets_)) {
      for (const std::int32_t v : tet)
        if (graph.index[v] >= 0) visit(graph.index[v], t);
      ++t;
    }
  };
  first_.resize(n + 1, 0);
  for_corners([&](std::int32_t b, std::int32_t) { ++first_[b + 1]; });
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  tets_of_.resize(first_.back());
  std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
  for_corners([&](std::int32_t b, std::int32_t t) { tets_of_[next[b]++] = t; });
}

void MoveLimiter::apply(std::span<const Vec3> moves, double min_dihedral_deg, std::vector<Vec3>& positions,
                        const Progress& progress) {
  squared_cosine_ = std::pow(cosine_of_floor(min_dihedral_deg), 2);
  std::vector<Vec3> start(moves.size());
  for (std::size_t b = 0; b < start.size(); ++b) start[b] = positions[graph_.vertices[b]];
  // A vertex at the floor is likely to stay there: from the whole move it would need every halving anew.
  for (double& share : share_) share = std::min(1.0, regrowth * std::max(share, least_share));
  changed_.resize(moves.size()), touched_.resize(tets_.size());
  std::iota(changed_.begin(), changed_.end(), 0);
  std::iota(touched_.begin(), touched_.end(), 0);
  while (true) {
    progress.throw_if_cancelled();
    parallel_for(std::ssize(changed_), grain, [&](std::int64_t begin, std::int64_t end) {
      for (auto n = begin; n < end; ++n) {
        const std::int32_t b = changed_[n];
        positions[graph_.vertices[b]] = start[b] + share_[b] * moves[b];
      }
    });
    bad_.resize(touched_.size());
    parallel_for(std::ssize(touched_), grain,
                 [&](std::int64_t begin, std::int64_t end) { judge(begin, end, positions); });
    if (!shorten()) return;
    touch_changed();
  }
}

// A lane a tet.
void MoveLimiter::judge(std::int64_t begin, std::int64_t end, const std::vector<Vec3>& positions) {
  TetLanes edges{};
  double excesses[lanes];
  for (auto first = begin; first < end; first += lanes) {
    const auto used = static_cast<int>(std::min<std::int64_t>(lanes, end - first));
    for (int l = 0; l < used; ++l) put(tets_[touched_[first + l]], positions, scale_, l, edges);
    eight_excesses(edges, squared_cosine_, excesses);
    for (int l = 0; l < used; ++l) bad_[first + l] = excesses[l] >= 0.0;
  }
}

// The moves of the bad tets' vertices. False when there was nothing left to shorten.
bool MoveLimiter::shorten() {
  changed_.clear();
  for (std::size_t n = 0; n < touched_.size(); ++n) {
    if (bad_[n] == 0) continue;
    for (const std::int32_t v : tets_[touched_[n]]) {
      const std::int32_t b = graph_.index[v];
      if (b >= 0 && share_[b] > 0.0 && chosen_[b] == 0) chosen_[b] = 1, changed_.push_back(b);
    }
  }
  for (const std::int32_t b : changed_) {
    share_[b] = share_[b] > least_share ? 0.5 * share_[b] : 0.0;
    limited_[b] = 1, chosen_[b] = 0;
  }
  return !changed_.empty();
}

void MoveLimiter::touch_changed() {
  touched_.clear();
  for (const std::int32_t b : changed_)
    for (const std::int32_t t : tets_of(b))
      if (seen_[t] == 0) seen_[t] = 1, touched_.push_back(t);
  for (const std::int32_t t : touched_) seen_[t] = 0;
}

std::int64_t MoveLimiter::limited_vertices() const {
  return std::ranges::count(limited_, 1);
}

}  // namespace isochor

#include "core/embedding/tet_locator.h"

#include <algorithm>
#include <cmath>

#include "core/parallel/cancellable_range.h"

namespace isochor {
namespace {

// A point on a face belongs to both tets; round-off must not put it outside of both.
constexpr double inside_tolerance = -1e-9;

/// The tet of each boundary triangle: surface lists them cell by cell, so the search is one pass.
std::vector<std::int32_t> tets_of_surface(const TetMesh& mesh) {
  std::vector<std::int32_t> owners;
  owners.reserve(mesh.surface.size());
  const auto holds = [&](std::size_t tet, const Triangle& triangle) {
    return std::ranges::all_of(triangle,
                               [&](std::int32_t v) { return std::ranges::count(mesh.tets[tet], v) == 1; });
  };
  std::size_t cell = 0;
  for (const Triangle& triangle : cancellable(mesh.surface)) {
    std::int32_t owner = -1;
    for (; owner < 0; cell += owner < 0)
      for (std::size_t tet = 5 * cell; tet < 5 * cell + 5 && owner < 0; ++tet)
        if (holds(tet, triangle)) owner = static_cast<std::int32_t>(tet);
    owners.push_back(owner);
  }
  return owners;
}

}  // namespace

TetLocator::TetLocator(const TetMesh& mesh, const Progress& progress)
    : mesh_(mesh), boundary_(mesh.positions, mesh.surface) {
  progress.throw_if_cancelled();
  tet_of_triangle_ = tets_of_surface(mesh);
  fill_bins(progress);
}

// Bins as wide as cells and half a cell off, so that an unsmoothed cell meets eight of them.
void TetLocator::fill_bins(const Progress& progress) {
  Box box;
  for (const Vec3& x : cancellable(mesh_.positions)) box.extend(x);
  bins_.spacing = mesh_.grid.spacing;
  const Vec3 offset = ((box.min - mesh_.grid.origin) / bins_.spacing).array().floor() - 0.5;
  bins_.origin = mesh_.grid.origin + bins_.spacing * offset;
  bins_.size = ((box.max - bins_.origin) / bins_.spacing).cast<int>() + Vec3i::Ones();
  boxes_.reserve(mesh_.cells.size());
  for (const Cell& cell : cancellable(mesh_.cells)) {
    Box bounds;
    for (const std::int32_t v : cell.corners) bounds.extend(mesh_.positions[v]);
    boxes_.push_back({bounds.min, bounds.max});
  }
  const auto for_bins = [&](std::size_t cell, auto&& visit) {
    if (cell % 4096 == 0) throw_if_scope_cancelled();
    const Vec3i low = ((boxes_[cell][0] - bins_.origin) / bins_.spacing).cast<int>();
    const Vec3i high = ((boxes_[cell][1] - bins_.origin) / bins_.spacing).cast<int>();
    for (int k = low.z(); k <= high.z(); ++k)
      for (int j = low.y(); j <= high.y(); ++j)
        for (int i = low.x(); i <= high.x(); ++i) visit(bins_.index(i, j, k));
  };
  progress.throw_if_cancelled();
  first_.assign(bins_.count() + 1, 0);
  for (std::size_t c = 0; c < boxes_.size(); ++c) for_bins(c, [&](std::int64_t bin) { ++first_[bin + 1]; });
  for (std::int64_t b = 0; b < bins_.count(); ++b) first_[b + 1] += first_[b];
  progress.throw_if_cancelled();
  cells_.resize(first_.back());
  std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t c = 0; c < boxes_.size(); ++c)
    for_bins(c, [&](std::int64_t bin) { cells_[next[bin]++] = static_cast<std::int32_t>(c); });
}

std::array<double, 4> TetLocator::barycentric(std::int32_t tet, const Vec3& p) const {
  const Tet& t = mesh_.tets[tet];
  const Vec3& a = mesh_.positions[t[0]];
  const Vec3 e1 = mesh_.positions[t[1]] - a, e2 = mesh_.positions[t[2]] - a, e3 = mesh_.positions[t[3]] - a;
  const Vec3 r = p - a, n1 = e2.cross(e3);
  const double scale = 1.0 / e1.dot(n1);
  const Vec3 q = r.cross(e1);
  const double w1 = scale * r.dot(n1), w2 = -scale * e3.dot(q), w3 = scale * e2.dot(q);
  return {1.0 - w1 - w2 - w3, w1, w2, w3};
}

/// Takes the tet of a cell that holds p with the largest least weight above `least`; returns that weight.
double TetLocator::find_in_cell(std::int32_t cell, const Vec3& p, double least, Location& found) const {
  const auto weigh = [&](std::int32_t tet) {
    const std::array<double, 4> w = barycentric(tet, p);
    if (const double smallest = std::ranges::min(w); smallest > least)
      least = smallest, found.tet = tet, found.weights = w;
    return w;
  };
  // Beyond the central tet's face opposite its vertex v lies one apex only; odd cells mirror the order.
  static constexpr std::array<std::array<int, 4>, 2> apex{{{1, 2, 3, 4}, {1, 3, 2, 4}}};
  const std::array<double, 4> central = weigh(5 * cell);
  for (int v = 0; v < 4 && least < 0.0; ++v)
    if (central[v] < -inside_tolerance) weigh(5 * cell + apex[mesh_.cells[cell].parity()][v]);
  return least;
}

bool TetLocator::find_inside(const Vec3& p, Hint& hint, Location& found) const {
  const Vec3 at = (p - bins_.origin) / bins_.spacing;
  if (!((at.array() >= 0.0).all() && (at.array() < bins_.size.cast<double>().array()).all())) return false;
  const std::int64_t bin =
      bins_.index(static_cast<int>(at.x()), static_cast<int>(at.y()), static_cast<int>(at.z()));
  const double slack = 1e-9 * bins_.spacing;
  double least = inside_tolerance;
  const auto search = [&](std::int32_t cell) {
    const auto& [min, max] = boxes_[cell];
    if ((p.array() < min.array() - slack).any() || (p.array() > max.array() + slack).any()) return;
    least = find_in_cell(cell, p, least, found);
  };
  const std::int32_t likely = hint.cell;
  if (likely >= 0) search(likely);
  for (std::int32_t n = first_[bin]; n < first_[bin + 1] && least < 0.0; ++n)
    if (cells_[n] != likely) search(cells_[n]);
  if (found.tet >= 0) hint.cell = found.tet / 5;
  return found.tet >= 0;
}

TriangleTree::Nearest TetLocator::nearest_triangle(const Vec3& p, Hint& hint) const {
  const TriangleTree::Nearest nearest = boundary_.nearest(p, hint.triangle);
  hint.triangle = nearest.triangle;
  return nearest;
}

TetLocator::Location TetLocator::locate(const Vec3& p, Hint& hint) const {
  Location found;
  if (find_inside(p, hint, found)) return found;
  const TriangleTree::Nearest nearest = nearest_triangle(p, hint);
  found.triangle = nearest.triangle;
  found.tet = tet_of_triangle_[found.triangle];
  found.weights = barycentric(found.tet, p);
  found.distance = std::sqrt(nearest.squared_distance);
  return found;
}

double TetLocator::distance(const Vec3& p, Hint& hint) const {
  Location found;
  return find_inside(p, hint, found) ? 0.0 : std::sqrt(nearest_triangle(p, hint).squared_distance);
}

}  // namespace isochor

#include "core/dynamics/masses.h"

#include <numeric>

#include "core/dynamics/cell_volume.h"
#include "core/parallel/cancel_scope.h"

namespace isochor {
namespace {

std::vector<double> lumped_masses(const TetMesh& mesh, std::span<const double> cell_masses) {
  std::vector<double> masses(mesh.positions.size(), 0.0);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    const Cell& cell = mesh.cells[c];
    std::array<double, 8> share;
    share.fill(1.0 / 12.0);
    for (const int central : five_tets(cell.parity())[0]) share[central] = 1.0 / 6.0;
    for (int b = 0; b < 8; ++b) masses[cell.corners[b]] += share[b] * cell_masses[c];
  }
  return masses;
}

/// A particle's weight is the mean density of its cells, so that regions keep their density.
std::vector<double> equal_masses(const TetMesh& mesh, std::span<const double> cell_masses,
                                 std::span<const double> densities) {
  std::vector<double> weights(mesh.positions.size(), 0.0), cells(mesh.positions.size(), 0.0);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    for (const auto corner : mesh.cells[c].corners) {
      weights[corner] += densities[c];
      cells[corner] += 1.0;
    }
  }
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] /= cells[i];
  const double total = std::accumulate(cell_masses.begin(), cell_masses.end(), 0.0);
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& weight : weights) weight *= total / sum;
  return weights;
}

}  // namespace

std::vector<double> cell_volumes(const TetMesh& mesh, std::span<const Vec3> positions) {
  std::vector<double> volumes(mesh.cells.size());
  throw_if_scope_cancelled();
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    CellCorners corners;
    for (int b = 0; b < 8; ++b) corners[b] = positions[mesh.cells[c].corners[b]];
    volumes[c] = cell_volume(corners, mesh.cells[c].parity());
  }
  return volumes;
}

std::vector<double> tet_volumes(const TetMesh& mesh, std::span<const Vec3> positions) {
  std::vector<double> volumes(mesh.tets.size());
  for (std::size_t t = 0; t < volumes.size(); ++t) {
    const Tet& v = mesh.tets[t];
    volumes[t] = tet_volume(positions[v[0]], positions[v[1]], positions[v[2]], positions[v[3]]);
  }
  return volumes;
}

std::vector<double> particle_masses(const TetMesh& mesh, std::span<const double> volumes,
                                    std::span<const double> densities, MassLumping lumping) {
  std::vector<double> cell_masses(mesh.cells.size());
  throw_if_scope_cancelled();
  for (std::size_t c = 0; c < cell_masses.size(); ++c) cell_masses[c] = volumes[c] * densities[c];
  return lumping == MassLumping::lumped ? lumped_masses(mesh, cell_masses)
                                        : equal_masses(mesh, cell_masses, densities);
}

}  // namespace isochor

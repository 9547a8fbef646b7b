#pragma once
#include <cmath>
#include <functional>
#include <random>

#include "core/dynamics/volume_projector.h"
#include "core/lattice/lattice.h"

namespace isochor::testing {

/// A body at rest with its masses lumped by the gradient of volume: a sixth of a cell's mass to each vertex
/// of its central tet, a twelfth to each apex.
struct Body {
  TetMesh mesh;
  std::vector<double> masses;

  VolumeModel model(bool per_tet = false) const {
    VolumeModel model;
    model.mesh = &mesh;
    model.per_tet = per_tet;
    std::vector<double> tets;
    for (const Tet& t : mesh.tets)
      tets.push_back(
          tet_volume(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]], mesh.positions[t[3]]));
    if (per_tet) {
      model.rest_volumes = tets;
    } else {
      model.rest_volumes.assign(mesh.cells.size(), 0.0);
      for (std::size_t t = 0; t < tets.size(); ++t) model.rest_volumes[t / 5] += tets[t];
    }
    for (const double mass : masses) model.inverse_masses.push_back(1.0 / mass);
    return model;
  }
};

inline Body make_body(TetMesh mesh) {
  Body body{std::move(mesh), {}};
  body.masses.assign(body.mesh.positions.size(), 0.0);
  for (const Cell& cell : body.mesh.cells) {
    const double mass = 1000.0 * std::pow(body.mesh.grid.spacing, 3);
    for (int b = 0; b < 8; ++b) {
      const bool central = ((b & 1) + (b >> 1 & 1) + (b >> 2 & 1) + cell.parity()) % 2 == 0;
      body.masses[cell.corners[b]] += mass / (central ? 6.0 : 12.0);
    }
  }
  return body;
}

inline Body make_box(const Vec3i& cells, double cell_size = 0.125) {
  return make_body(make_box_lattice(cells, cell_size, Vec3(-0.3, 0.4, 1.1)));
}

/// The cells of an n³ lattice over [−1,1]³ whose centre is inside.
inline Body make_masked(int n, const std::function<bool(const Vec3&)>& inside) {
  Lattice lattice;
  lattice.grid = {Vec3i::Constant(n), 2.0 / n, Vec3::Constant(-1.0)};
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) lattice.kept.push_back(inside(lattice.grid.center(i, j, k)));
  for (const std::uint8_t kept : lattice.kept) lattice.kept_count += kept;
  return make_body(make_tetrahedra(lattice));
}

inline Body make_ball(int n) {
  return make_masked(n, [](const Vec3& p) { return p.norm() < 1.0; });
}
inline Body make_torus(int n) {
  return make_masked(n,
                     [](const Vec3& p) { return std::hypot(std::hypot(p.x(), p.z()) - 0.65, p.y()) < 0.34; });
}
inline Body make_ell(int n) {
  return make_masked(n, [](const Vec3& p) { return p.x() < 0.0 || p.y() < 0.0; });
}

/// Every position moved by up to ±r·spacing an axis.
inline Coordinates randomized(const Body& body, double r, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-r * body.mesh.grid.spacing, r * body.mesh.grid.spacing);
  Coordinates points(body.mesh.positions);
  for (std::size_t i = 0; i < points.size(); ++i)
    points.add(i, Vec3(shift(random), shift(random), shift(random)));
  return points;
}

inline Coordinates transformed(const Body& body, const Eigen::Matrix3d& affine) {
  Coordinates points(body.mesh.positions);
  for (std::size_t i = 0; i < points.size(); ++i) points.set(i, affine * points.at(i));
  return points;
}

}  // namespace isochor::testing

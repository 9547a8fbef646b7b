#pragma once
#include <cmath>

#include "core/scene/scene.h"

namespace isochor::testing {

/// A cube of 1 m, stretched by 5 % at constant volume, in free flight; one stiffness for edges and diagonals.
inline Scene stretched_cube(int cells, double stiffness, double h, SpringIntegrator springs) {
  DeformableBody body;
  body.shape = LatticeShape{Vec3i::Constant(cells), 1.0 / cells, Vec3::Constant(-0.5)};
  body.edge_stiffness = body.diagonal_stiffness = stiffness;
  body.start.affine = Vec3(1.05, 1.0 / std::sqrt(1.05), 1.0 / std::sqrt(1.05)).asDiagonal();
  Scene scene;
  scene.gravity = Vec3::Zero();
  scene.frame_rate = 1.0 / h;
  scene.duration.reset();
  scene.solver.springs = springs;
  scene.bodies.resize(1);
  scene.bodies[0].name = "cube";
  scene.bodies[0].kind = body;
  return scene;
}

}  // namespace isochor::testing

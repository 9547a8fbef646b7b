#pragma once
#include "core/dynamics/coordinates.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// What carries one volume constraint: a cell of eight particles, or a single tet to show that it locks.
class VolumeElements {
 public:
  static constexpr int max_particles = 8;
  using Gradient = std::array<Vec3, max_particles>;

  VolumeElements(const TetMesh& mesh, bool per_tet) : mesh_(&mesh), per_tet_(per_tet) {}

  std::int64_t count() const {
    return static_cast<std::int64_t>(per_tet_ ? mesh_->tets.size() : mesh_->cells.size());
  }
  int particles_each() const { return per_tet_ ? 4 : 8; }
  std::int32_t particle(std::int64_t element, int k) const {
    return per_tet_ ? mesh_->tets[element][k] : mesh_->cells[element].corners[k];
  }
  std::int64_t cell(std::int64_t element) const { return per_tet_ ? element / 5 : element; }

  double volume(std::int64_t element, const Coordinates& x) const;
  Gradient gradient(std::int64_t element, const Coordinates& x) const;

 private:
  const TetMesh* mesh_;
  bool per_tet_;
};

}  // namespace isochor

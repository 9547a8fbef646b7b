#include "core/dynamics/volume_elements.h"

#include "core/dynamics/cell_volume.h"

namespace isochor {
namespace {

CellCorners corners(const Cell& cell, const Coordinates& x) {
  CellCorners p;
  for (int b = 0; b < 8; ++b) p[b] = x.at(cell.corners[b]);
  return p;
}

}  // namespace

double VolumeElements::volume(std::int64_t element, const Coordinates& x) const {
  if (!per_tet_) return cell_volume(corners(mesh_->cells[element], x), mesh_->cells[element].parity());
  const Tet& t = mesh_->tets[element];
  return tet_volume(x.at(t[0]), x.at(t[1]), x.at(t[2]), x.at(t[3]));
}

// Of a tet, 6∂V/∂v is the cross product of two edges of the opposite face.
VolumeElements::Gradient VolumeElements::gradient(std::int64_t element, const Coordinates& x) const {
  Gradient g;
  if (!per_tet_) {
    const CellCorners of_cell =
        cell_volume_gradient(corners(mesh_->cells[element], x), mesh_->cells[element].parity());
    std::copy(of_cell.begin(), of_cell.end(), g.begin());
    return g;
  }
  const Tet& t = mesh_->tets[element];
  const Vec3 a = x.at(t[0]), ab = x.at(t[1]) - a, ac = x.at(t[2]) - a, ad = x.at(t[3]) - a;
  g[1] = ac.cross(ad) / 6.0;
  g[2] = ad.cross(ab) / 6.0;
  g[3] = ab.cross(ac) / 6.0;
  g[0] = -(g[1] + g[2] + g[3]);
  return g;
}

}  // namespace isochor

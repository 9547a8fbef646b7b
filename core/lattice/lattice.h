#pragma once
#include <cstdint>
#include <vector>

#include "core/common/progress.h"
#include "core/pseudo_volume/pseudo_volume.h"

namespace isochor {

/// What to do about cells that touch only along an edge or at a vertex (hinges).
enum class Contacts { keep, fill, separate };

struct LatticeOptions {
  int cells = 24;        ///< along the box's longest edge, 2 to 256, at most voxels/2; odd ones round up
  double density = 0.5;  ///< a cell is kept when m(V)/M(V) exceeds it; 0 to 1
  bool fill_holes = true;
  bool largest_only = false;
  Contacts contacts = Contacts::keep;
  bool fit_volume = true;  ///< scale the lattice so that its tets have the volume of the voxels
  bool operator==(const LatticeOptions&) const = default;
};

/// Cubic cells, an even number on each axis, centred on the soup's box.
struct Lattice {
  Grid grid;                       ///< after fit_volume
  double scale = 1.0;              ///< by which fit_volume scaled it about the centroid of the kept cells
  Vec3 centroid = Vec3::Zero();    ///< that
  Vec3 stretch = Vec3::Ones();     ///< what make_tetrahedra stretches the axes by about it, beside the scale
  std::vector<float> density;      ///< m(V)/M(V) of every cell of the grid
  std::vector<std::uint8_t> kept;  ///< 1 where the cell becomes five tetrahedra
  std::int64_t kept_count = 0;
  std::int64_t filled_count = 0;  ///< of these, added by hole filling (or Contacts::fill)
  int components = 0;             ///< face-connected
  std::int64_t edge_contacts = 0, vertex_contacts = 0;  ///< lattice edges and nodes where only those touch
  Contacts contacts = Contacts::keep;                   ///< separate is carried out by make_tetrahedra
};

/// The lattice alone, covering the box and a margin around it. Reflection maps the parity pattern of the tets
/// onto itself only when every axis has an even number of cells.
Grid lattice_grid(const Box& box, int cells, double margin);

/// box: that of the soup. true_volume: of what the voxels sample, whose flat sides are off by up to half a
/// voxel; 0 where it is not known, and theirs counts. Throws invalid_argument when cells > voxels/2.
Lattice make_lattice(const PseudoVolume& volume, const Box& box, const LatticeOptions& options,
                     Progress& progress, double true_volume = 0.0);

}  // namespace isochor

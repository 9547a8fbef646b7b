#pragma once
#include <array>
#include <vector>

#include "core/common/progress.h"
#include "core/embedding/triangle_tree.h"
#include "core/mesh_input/triangle_soup.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {

/// Finds the tet that holds a point, or else the nearest one. Keeps a reference to the mesh.
class TetLocator {
 public:
  explicit TetLocator(const TetMesh& mesh, const Progress& progress = {});

  struct Location {
    std::int32_t tet = -1;
    std::array<double, 4> weights{};  ///< barycentric, extrapolating outside
    double distance = 0.0;            ///< to the tet; 0 inside
    std::int32_t triangle = -1;       ///< outside: the nearest boundary triangle
  };
  /// Where the last points were found: the next one is likely near.
  struct Hint {
    std::int32_t cell = -1, triangle = -1;
  };
  Location locate(const Vec3& p, Hint& hint) const;

  /// Distance to the model, 0 inside.
  double distance(const Vec3& p, Hint& hint) const;

 private:
  bool find_inside(const Vec3& p, Hint& hint, Location& found) const;
  double find_in_cell(std::int32_t cell, const Vec3& p, double least, Location& found) const;
  TriangleTree::Nearest nearest_triangle(const Vec3& p, Hint& hint) const;
  std::array<double, 4> barycentric(std::int32_t tet, const Vec3& p) const;
  void fill_bins(const Progress& progress);

  const TetMesh& mesh_;
  TriangleTree boundary_;
  std::vector<std::int32_t> tet_of_triangle_;
  Grid bins_;
  std::vector<std::int32_t> first_, cells_;  ///< cells whose boxes meet bin b: cells_[first_[b], first_[b+1])
  std::vector<std::array<Vec3, 2>> boxes_;   ///< a cell
};

}  // namespace isochor

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polyhedral_mesh_domain_3.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>
#include <CGAL/make_mesh_3.h>

#include <array>
#include <map>

#include "tests/bench/other_meshers.h"

namespace isochor {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
using Domain = CGAL::Polyhedral_mesh_domain_3<Surface, Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain, CGAL::Default, CGAL::Sequential_tag>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

Surface wrap(const TriangleSoup& soup, double spacing) {
  std::vector<Kernel::Point_3> points;
  for (const Vec3& p : soup.positions) points.emplace_back(p.x(), p.y(), p.z());
  std::vector<std::array<std::size_t, 3>> faces;
  for (const Triangle& t : soup.triangles)
    faces.push_back(
        {static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]), static_cast<std::size_t>(t[2])});
  Surface surface;
  CGAL::alpha_wrap_3(points, faces, spacing, spacing / 30.0, surface);
  return surface;
}

Tets tets_of(const Complex& complex) {
  Tets result;
  std::map<Triangulation::Vertex_handle, int> index;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
    Tet tet;
    for (int i = 0; i < 4; ++i) {
      const auto vertex = cell->vertex(i);
      const auto [entry, added] = index.try_emplace(vertex, static_cast<int>(index.size()));
      if (added) {
        const auto& p = vertex->point();
        result.positions.emplace_back(p.x(), p.y(), p.z());
      }
      tet[i] = entry->second;
    }
    result.tets.push_back(tet);
  }
  return result;
}

}  // namespace

Tets alpha_wrap_tets(const TriangleSoup& soup, double spacing) {
  namespace params = CGAL::parameters;
  const Surface surface = wrap(soup, spacing);
  const Domain domain(surface);
  // As in the manual's example, with our spacing; perturbing and exuding slivers is the default.
  const Criteria criteria(params::facet_angle = 25, params::facet_size = spacing,
                          params::facet_distance = 0.1 * spacing, params::cell_radius_edge_ratio = 3,
                          params::cell_size = spacing);
  return tets_of(CGAL::make_mesh_3<Complex>(domain, criteria));
}

}  // namespace isochor

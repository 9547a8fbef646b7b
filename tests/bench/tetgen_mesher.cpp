#include <fmt/format.h>
#include <tetgen.h>

#include <algorithm>
#include <stdexcept>

#include "tests/bench/other_meshers.h"

namespace isochor {
namespace {

void set_polygon(tetgenio::facet& facet, const Triangle& triangle) {
  tetgenio::init(&facet);
  facet.numberofpolygons = 1;
  facet.polygonlist = new tetgenio::polygon[1];
  tetgenio::init(&facet.polygonlist[0]);
  facet.polygonlist[0].numberofvertices = 3;
  facet.polygonlist[0].vertexlist = new int[3];
  std::ranges::copy(triangle, facet.polygonlist[0].vertexlist);
}

std::string reason(int code) {
  switch (code) {
    case 3:
      return "TetGen: the input intersects itself";
    case 4:
      return "TetGen: a feature is too small";
    case 5:
      return "TetGen: two facets are too close";
    default:
      return fmt::format("TetGen: error {}", code);
  }
}

}  // namespace

Tets tetgen_tets(const TriangleSoup& soup, double spacing) {
  tetgenio in, out;
  in.numberofpoints = static_cast<int>(soup.positions.size());
  in.pointlist = new REAL[3 * soup.positions.size()];
  for (std::size_t i = 0; i < soup.positions.size(); ++i)
    std::copy_n(soup.positions[i].data(), 3, in.pointlist + 3 * i);
  in.numberoffacets = static_cast<int>(soup.triangles.size());
  in.facetlist = new tetgenio::facet[soup.triangles.size()];
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) set_polygon(in.facetlist[i], soup.triangles[i]);
  // The volume of a regular tet of this edge length; radius-edge ratio as TetGen's manual proposes.
  std::string switches = fmt::format("pq1.414a{}Q", spacing * spacing * spacing / 8.49);
  try {
    tetrahedralize(switches.data(), &in, &out);
  } catch (int code) {
    throw std::runtime_error(reason(code));
  }
  Tets result;
  for (int i = 0; i < out.numberofpoints; ++i)
    result.positions.emplace_back(out.pointlist[3 * i], out.pointlist[3 * i + 1], out.pointlist[3 * i + 2]);
  for (int i = 0; i < out.numberoftetrahedra; ++i) {
    const int* t = out.tetrahedronlist + static_cast<std::ptrdiff_t>(i) * out.numberofcorners;
    result.tets.push_back({t[0], t[1], t[2], t[3]});
  }
  return result;
}

}  // namespace isochor

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/export/writers.h"

namespace isochor {
namespace {

// flexcomp accepts one node block and one element block of entity dimension 3, tags 1..N in order.
void mesh_file(Text& text, const ExportModel& model) {
  const TetMesh& mesh = model.mesh;
  const std::size_t nodes = mesh.positions.size(), tets = mesh.tets.size();
  text << "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n";
  text << "1 " << nodes << " 1 " << nodes << "\n3 1 0 " << nodes << '\n';
  for (std::size_t i = 1; i <= nodes; ++i) text << i << '\n';
  for (const Vec3& position : mesh.positions) text << position << '\n';
  text << "$EndNodes\n$Elements\n1 " << tets << " 1 " << tets << "\n3 1 4 " << tets << '\n';
  for (std::size_t t = 0; t < tets; ++t) (text << t + 1 << ' ').list(mesh.tets[t], ' ', 1) << '\n';
  text << "$EndElements\n$Comments\n" << model.comment << "\n$EndComments\n";
}

/// XML comments must not hold two hyphens in a row.
std::string comment_text(std::string text) {
  for (std::size_t i = 1; i < text.size(); ++i)
    if (text[i] == '-' && text[i - 1] == '-') text[i] = ' ';
  return text;
}

std::string attribute_text(std::string_view text) {
  std::string escaped;
  for (const char c : text) switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  return escaped;
}

/// Shortest height of a tet over one of its sides, 3V/A.
double shortest_height(const TetMesh& mesh) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const auto& [a, b, c, d] : mesh.tets) {
    const Vec3 &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c], &s = mesh.positions[d];
    const double area =
        0.5 * std::sqrt(std::max({(q - p).cross(r - p).squaredNorm(), (q - p).cross(s - p).squaredNorm(),
                                  (r - p).cross(s - p).squaredNorm(), (r - q).cross(s - q).squaredNorm()}));
    shortest = std::min(shortest, 3.0 * tet_volume(p, q, r, s) / area);
  }
  return shortest;
}

// Mass and stiffness are a start to edit: water's density, and a soft rubber.
constexpr double density = 1000.0, young = 1e5, poisson = 0.45;

/// Seconds: a flex steps explicitly, so no pressure wave may cross a tet in one step; half of that, and no
/// more than MuJoCo's own.
double timestep(const TetMesh& mesh) {
  const double wave =
      std::sqrt(young * (1.0 - poisson) / (density * (1.0 + poisson) * (1.0 - 2.0 * poisson)));
  return std::min(0.002, 0.5 * shortest_height(mesh) / wave);
}

std::string snippet(const ExportModel& model) {
  const std::string name = attribute_text(model.stem);
  const double step = timestep(model.mesh), damping = 0.1 * step;  // more would not be stable either
  return fmt::format(
      "<!-- {} -->\n"
      "<mujoco model=\"{}\">\n"
      "  <option timestep=\"{:.2g}\" solver=\"CG\" tolerance=\"1e-6\"/>\n"
      "  <worldbody>\n"
      "    <flexcomp name=\"{}\" type=\"gmsh\" dim=\"3\" file=\"{}.msh\" radius=\"{}\" mass=\"{}\">\n"
      "      <elasticity young=\"{}\" poisson=\"{}\" damping=\"{:.2g}\"/>\n"
      "      <contact selfcollide=\"none\" internal=\"false\"/>\n"
      "    </flexcomp>\n"
      "  </worldbody>\n"
      "</mujoco>\n",
      comment_text(model.comment), name, step, name, name, 0.02 * model.mesh.grid.spacing,
      density * total_volume(model.mesh), young, poisson, damping);
}

}  // namespace

void write_msh4(const ExportModel& model, ExportTexts& files) {
  mesh_file(files.begin(".msh"), model);
  files.begin(".xml") << snippet(model);
}

}  // namespace isochor

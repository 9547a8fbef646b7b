#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "core/common/error.h"
#include "core/export/writers.h"

namespace isochor {
namespace {

struct Row {
  ExportFormat format;
  ExportWriter write;
};

// The first format with an extension is the one that the extension alone asks for.
constexpr std::array rows{
    Row{{"msh2", ".msh", "application/vnd.gmsh", "Gmsh, SOFA, DART",
         "Gmsh 2.2 ASCII; indices from 1, tetrahedra only, positive winding, model units."},
        write_msh2},
    Row{{"msh4", ".msh", "application/vnd.gmsh", "MuJoCo flexcomp",
         "Gmsh 4.1 ASCII with one node block and one element block, tags 1..N in order; with a <flexcomp> "
         "snippet as .xml.",
         true},
        write_msh4},
    Row{{"vtu", ".vtu", "application/vnd.vtk.vtu", "ParaView, PyVista, FEM codes",
         "VTK XML unstructured grid, indices from 0; cell data: lattice cell, volume, dihedral angle, scaled "
         "Jacobian."},
        write_vtu},
    Row{{"vtk", ".vtk", "application/vnd.vtk", "older VTK readers, SOFA",
         "Legacy VTK 3.0 ASCII unstructured grid, indices from 0."},
        write_vtk},
    Row{{"tetgen", ".node", "text/x-tetgen", "TetGen, PositionBasedDynamics, Bullet",
         "A set of .node, .ele and .face; indices from 0, faces outward.", true},
        write_tetgen},
    Row{{"medit", ".mesh", "text/x-medit", "fTetWild, libigl, Mmg",
         "MEDIT version 2 (double precision); indices from 1, boundary triangles outward."},
        write_medit},
    Row{{"usda", ".usda", "text/x-usda", "USD: Isaac Sim, Newton, Houdini",
         "A TetMesh with its surface faces and a companion Mesh; y up, right-handed, one metre a unit."},
        write_usda},
    Row{{"json", ".json", "application/vnd.isochor.tets+json", "three.js, Ten Minute Physics",
         "verts, tetIds, tetEdgeIds, tetSurfaceTriIds as flat arrays; indices from 0."},
        write_tet_json},
    Row{{"embedding", ".embedding.json", "application/vnd.isochor.embedding+json",
         "engines that skin the input",
         "For each original vertex its tetrahedron, the four vertices and barycentric weights that sum to "
         "1."},
        write_embedding},
    Row{{"obj", ".obj", "model/obj", "any viewer: the boundary as triangles",
         "Boundary surface only; indices from 1, faces outward."},
        write_surface_obj},
    Row{{"ply", ".ply", "model/ply", "MeshLab, Open3D: the boundary as triangles",
         "Boundary surface only, ASCII in double precision; indices from 0, faces outward."},
        write_surface_ply},
    Row{{"stl", ".stl", "model/stl", "printing, CAD: the boundary as triangles",
         "Boundary surface only, binary, single precision as STL has it; faces outward."},
        write_surface_stl},
};

constexpr auto formats = [] {
  std::array<ExportFormat, rows.size()> list{};
  std::ranges::transform(rows, list.begin(), &Row::format);
  return list;
}();

struct Collector final : ExportSink {
  std::vector<ExportFile> files;
  void begin(std::string_view name_suffix) override { files.push_back({std::string(name_suffix), {}}); }
  void write(std::string_view bytes) override { files.back().content += bytes; }
};

std::string lower(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(), [](unsigned char c) { return std::tolower(c); });
  return result;
}

}  // namespace

std::span<const ExportFormat> export_formats() {
  return formats;
}

const ExportFormat& export_format(std::string_view name_or_extension) {
  const std::string wanted = lower(name_or_extension);
  for (const ExportFormat& format : formats)
    if (format.name == wanted || format.extension == wanted) return format;
  // Any file of the set stands for it.
  if (wanted == ".ele" || wanted == ".face") return export_format("tetgen");
  std::string names;
  for (const ExportFormat& format : formats)
    names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", format.name, format.extension);
  throw Error(ErrorCode::unsupported_format, fmt::format("no export format \"{}\"", name_or_extension),
              "choose one of " + names);
}

const ExportFormat& export_format_of(const std::filesystem::path& file) {
  const std::string name = lower(file.filename().string());
  std::string extension = file.extension().string();
  for (const ExportFormat& format : formats)
    if (name.ends_with(format.extension) && format.extension.size() > extension.size())
      extension = format.extension;
  return export_format(extension);
}

void export_model(const ExportModel& model, const ExportFormat& format, ExportSink& sink) {
  const auto row = std::ranges::find(rows, format.name, [](const Row& r) { return r.format.name; });
  if (row == rows.end())
    throw Error(ErrorCode::unsupported_format, fmt::format("no export format \"{}\"", format.name));
  ExportTexts files(sink);
  row->write(model, files);
  files.finish();
}

std::vector<ExportFile> export_model(const ExportModel& model, const ExportFormat& format) {
  Collector collector;
  export_model(model, format, collector);
  return std::move(collector.files);
}

std::vector<std::filesystem::path> export_paths(const std::filesystem::path& target,
                                                std::span<const ExportFile> files) {
  if (files.size() == 1) return {target};
  std::filesystem::path stem = target;
  for (const ExportFile& file : files)
    if (lower(target.extension().string()) == file.name_suffix) stem.replace_extension();
  std::vector<std::filesystem::path> paths;
  for (const ExportFile& file : files) paths.emplace_back(stem.string() + file.name_suffix);
  return paths;
}

}  // namespace isochor

#pragma once
#include <vector>

#include "core/export/export.h"

namespace isochor {

/// One function a format; formats.cpp holds the table that names them.
using ExportWriter = std::vector<ExportFile> (*)(const ExportModel&);

std::vector<ExportFile> write_msh2(const ExportModel& model);
std::vector<ExportFile> write_msh4(const ExportModel& model);
std::vector<ExportFile> write_vtu(const ExportModel& model);
std::vector<ExportFile> write_vtk(const ExportModel& model);
std::vector<ExportFile> write_tetgen(const ExportModel& model);
std::vector<ExportFile> write_medit(const ExportModel& model);
std::vector<ExportFile> write_usda(const ExportModel& model);
std::vector<ExportFile> write_tet_json(const ExportModel& model);
std::vector<ExportFile> write_embedding(const ExportModel& model);
std::vector<ExportFile> write_surface_obj(const ExportModel& model);
std::vector<ExportFile> write_surface_ply(const ExportModel& model);
std::vector<ExportFile> write_surface_stl(const ExportModel& model);

/// The boundary with its own dense vertices: `vertex[i]` is the model's vertex behind the i-th.
struct BoundarySurface {
  std::vector<std::int32_t> vertex;
  std::vector<Triangle> triangles;
};
BoundarySurface boundary_surface(const TetMesh& mesh);

}  // namespace isochor

#pragma once
#include <vector>

#include "core/export/export.h"
#include "core/export/text.h"

namespace isochor {

/// The files of a set, written one after another.
class ExportTexts {
 public:
  explicit ExportTexts(ExportSink& sink)
      : sink_(sink), text_([this](std::string_view piece) { sink_.write(piece); }) {}
  ExportTexts(const ExportTexts&) = delete;
  ExportTexts& operator=(const ExportTexts&) = delete;

  /// The next file, to which all goes until there is another.
  Text& begin(std::string_view name_suffix) {
    text_.pass_on();
    sink_.begin(name_suffix);
    return text_;
  }
  void finish() { text_.pass_on(); }

 private:
  ExportSink& sink_;
  Text text_;
};

/// One function a format; formats.cpp holds the table that names them.
using ExportWriter = void (*)(const ExportModel&, ExportTexts&);

void write_msh2(const ExportModel& model, ExportTexts& files);
void write_msh4(const ExportModel& model, ExportTexts& files);
void write_vtu(const ExportModel& model, ExportTexts& files);
void write_vtk(const ExportModel& model, ExportTexts& files);
void write_tetgen(const ExportModel& model, ExportTexts& files);
void write_medit(const ExportModel& model, ExportTexts& files);
void write_usda(const ExportModel& model, ExportTexts& files);
void write_tet_json(const ExportModel& model, ExportTexts& files);
void write_embedding(const ExportModel& model, ExportTexts& files);
void write_surface_obj(const ExportModel& model, ExportTexts& files);
void write_surface_ply(const ExportModel& model, ExportTexts& files);
void write_surface_stl(const ExportModel& model, ExportTexts& files);

/// The boundary with its own dense vertices: `vertex[i]` is the model's vertex behind the i-th.
struct BoundarySurface {
  std::vector<std::int32_t> vertex;
  std::vector<Triangle> triangles;
};
BoundarySurface boundary_surface(const TetMesh& mesh);

}  // namespace isochor

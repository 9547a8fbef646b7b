#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "core/report/meshing_report.h"
#include "core/report/scene_report.h"
#include "core/report/stability.h"

namespace isochor {

/// Error against run time of a scene: given, or a sample's name.
struct SceneReportRequest {
  std::variant<Scene, std::string> scene;
  SceneReportOptions options;
};
/// The same of meshing a mesh.
struct MeshReportRequest {
  std::string mesh_id;
  MeshingReportOptions options;
};
struct StabilityRequest {
  StabilityExtent extent = StabilityExtent::full;
};

struct ReportRequest {
  std::variant<SceneReportRequest, MeshReportRequest, StabilityRequest> subject;
  std::optional<double> budget_ms;
  std::optional<std::string> supersedes;
};

/// Throws SyntaxError, and invalid_argument that lists every faulty field, over_budget when the grid has too
/// many points.
ReportRequest read_report_request(std::string_view text);

}  // namespace isochor

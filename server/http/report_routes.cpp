#include <algorithm>

#include "server/http/api.h"
#include "server/http/query.h"
#include "server/http/service.h"
#include "server/messages/report_messages.h"
#include "server/messages/report_request.h"

namespace isochor {
namespace {

/// Of the memory, what the recorded points of one report may take.
constexpr std::int64_t report_share = 16;

/// {"report": …}
std::string result_of(const std::string& report) {
  return "{\"report\":" + report + "}";
}

/// A finished model has its cells: another resolution needs the mesh.
void check_resolutions(Api& api, const Scene& scene, std::optional<std::vector<double>>& resolutions) {
  if (resolutions && std::ranges::all_of(*resolutions, [](double factor) { return factor == 1.0; })) return;
  for (const SceneBody& body : scene.bodies) {
    const auto* deformable = std::get_if<DeformableBody>(&body.kind);
    const auto* mesh = deformable ? std::get_if<MeshShape>(&deformable->shape) : nullptr;
    if (!mesh || !api.catalog.find_model(mesh->file.generic_string())) continue;
    if (resolutions)
      throw Error(ErrorCode::invalid_argument,
                  "body '" + body.name + "' is a finished model: its cells do not follow the resolution",
                  "name the mesh that it was made of, and its meshing",
                  {{"/axes/resolutions", "does not go with a finished model", {}, {}}});
    resolutions.emplace();  // its own
  }
}

JobQueue::Work scene_work(Api& api, const SceneReportRequest& request, std::optional<double> budget_ms) {
  const auto* sample = std::get_if<std::string>(&request.scene);
  const Scene scene = sample ? sample_scene(api, *sample) : std::get<Scene>(request.scene);
  SceneReportOptions options = request.options;
  check_scene_report(scene, options, api.memory_limit / report_share);
  check_resolutions(api, scene, options.axes.resolutions);
  return [&api, scene, options, budget_ms](JobProgress& progress) mutable {
    options.build = [&api](const Scene& part, Progress& inner) {
      return build_simulation(api, "", part, inner);
    };
    options.on_point = [&](SceneReport part) {
      part.complete = false;
      progress.publish(result_of(encode_scene_report(part, budget_ms)));
    };
    return result_of(encode_scene_report(report_scene(scene, options, progress), budget_ms));
  };
}

JobQueue::Work mesh_work(Api& api, const MeshReportRequest& request, std::optional<double> budget_ms) {
  const auto mesh = api.catalog.mesh(request.mesh_id);
  for (const MeshingOptions& options : meshing_grid(request.options))
    check_budget(mesh->known.size, options, api.memory_limit);
  return [mesh, options = request.options, budget_ms](JobProgress& progress) mutable {
    options.on_point = [&](MeshingReport part) {
      part.complete = false;
      progress.publish(result_of(encode_meshing_report(part, mesh->name, budget_ms)));
    };
    const MeshingReport report = report_meshing(mesh->soup, options, progress);
    return result_of(encode_meshing_report(report, mesh->name, budget_ms));
  };
}

JobQueue::Work stability_work(const StabilityRequest& request) {
  return [extent = request.extent](JobProgress& progress) {
    StabilityReport part;
    part.complete = false;
    const auto publish = [&](const StabilityResult& result) {
      part.results.push_back(result);
      progress.publish(result_of(encode_stability(part)));
    };
    return result_of(encode_stability(run_stability(extent, progress, publish)));
  };
}

Response post_report(Api& api, const Request& request) {
  const ReportRequest wanted = read_report_request(request.body);
  const std::int64_t wait_ms = query_integer(request, "wait_ms", 0, 0, 10000);
  JobQueue::Work work;
  if (const auto* scene = std::get_if<SceneReportRequest>(&wanted.subject))
    work = scene_work(api, *scene, wanted.budget_ms);
  else if (const auto* mesh = std::get_if<MeshReportRequest>(&wanted.subject))
    work = mesh_work(api, *mesh, wanted.budget_ms);
  else
    work = stability_work(std::get<StabilityRequest>(wanted.subject));
  if (wanted.supersedes) api.jobs.cancel(*wanted.supersedes);
  return job_response(api, api.jobs.submit("report", std::move(work), Line::measurements).id, wait_ms, 202);
}

}  // namespace

std::vector<Route> report_routes(Api& api) {
  return {
      {.method = "POST",
       .pattern = "/api/v1/reports",
       .operation = "createReport",
       .summary = "Measure error against run time, or stability: a job whose result is a report",
       .handler = [&](const Request& request) { return post_report(api, request); },
       .answers = {{202, "Job"}, {200, "Job"}},
       .body = BodyKind::json,
       .body_schema = "ReportRequest",
       .query = {{"wait_ms", R"({"type":"integer","minimum":0,"maximum":10000})",
                  "Answer once the job has ended, or after this time"}}},
  };
}

}  // namespace isochor

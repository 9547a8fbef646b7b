#include "server/messages/api_messages.h"

#include "server/messages/frame_codec.h"
#include "server/messages/model_messages.h"
#include "server/messages/problem_messages.h"

namespace isochor {
namespace {

Json embedded_or_null(const std::string& text) {
  return text.empty() ? Json() : Json::parse(text);
}

std::string_view volume_name(VolumeSolver solver) {
  return solver == VolumeSolver::newton ? "newton" : solver == VolumeSolver::scaling ? "scaling" : "gradient";
}

std::string_view integrator_name(SpringIntegrator springs) {
  switch (springs) {
    case SpringIntegrator::automatic:
      return "auto";
    case SpringIntegrator::symplectic:
      return "symplectic";
    case SpringIntegrator::implicit:
      return "implicit";
    case SpringIntegrator::energy_momentum:
      break;
  }
  return "energy_momentum";
}

Json solver_json(const SolverOptions& solver) {
  return {{"volume", volume_name(solver.volume)},
          {"constraint", solver.constraint == ConstraintScope::per_cell ? "per_cell" : "per_tet"},
          {"tolerance", solver.tolerance},
          {"springs", integrator_name(solver.springs)},
          {"substeps", solver.substeps > 0 ? Json(solver.substeps) : Json("auto")},
          {"max_iterations", solver.max_iterations}};
}

}  // namespace

Json grid_json(const Grid& grid) {
  return {{"size", {grid.size.x(), grid.size.y(), grid.size.z()}},
          {"spacing", grid.spacing},
          {"origin", vec3_json(grid.origin)}};
}

Json mesh_json(const StoredMesh& mesh) {
  return {{"id", mesh.id},
          {"name", mesh.name},
          {"format", mesh.format},
          {"bytes", mesh.file_bytes},
          {"report", mesh_report_json(*mesh.known.report)}};
}

Json stored_model_json(const StoredModel& stored) {
  Json json{{"id", stored.id}, {"mesh_id", stored.mesh_id}};
  json.update(model_json(*stored.model));
  return json;
}

Json job_json(const JobView& job) {
  return {{"id", job.id},
          {"kind", job.kind},
          {"status", status_name(job.status)},
          {"phase", job.phase},
          {"fraction", job.fraction},
          {"eta_s", job.eta_s ? Json(*job.eta_s) : Json()},
          {"result", embedded_or_null(job.result)},
          {"problem", embedded_or_null(job.problem)}};
}

Json simulation_json(const SimulationRunner& runner) {
  const RunView view = runner.view();
  const FrameFeed::Status status = runner.feed()->status();
  const auto latest = runner.feed()->latest();
  const std::string url = simulation_url(view.id);
  const bool prepared = !view.plan.empty();
  return {{"id", view.id},
          {"name", view.name},
          {"state", state_name(view.state)},
          {"pace", view.fast ? "fast" : "realtime"},
          {"speed", view.speed},
          {"seq", status.last},
          {"t", status.t},
          {"frame_rate", view.frame_rate},
          {"duration", view.duration ? Json(*view.duration) : Json()},
          {"gravity", vec3_json(view.gravity)},
          {"solver", solver_json(view.solver)},
          {"buffered", latest ? Json{{"first", status.first}, {"last", status.last}} : Json()},
          {"viewers", runner.feed()->viewers()},
          {"encoded_frames", runner.feed()->encodes()},
          {"metrics", latest ? Json::parse(encode_metrics(latest->metrics)) : Json()},
          {"plan", prepared ? Json::parse(encode_plan(view.plan)) : Json()},
          {"problem", view.failure ? Json::parse(encode_problem(*view.failure)) : Json()},
          {"topology", url + "/topology"},
          {"frames", url + "/frames"}};
}

}  // namespace isochor

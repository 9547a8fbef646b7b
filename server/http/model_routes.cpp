#include <fmt/format.h>
#include <algorithm>

#include "core/export/export.h"
#include "core/parameters/parameters.h"
#include "core/report/meshing_report.h"
#include "server/http/api.h"
#include "server/http/query.h"
#include "server/http/service.h"
#include "server/http/tar.h"
#include "server/messages/api_messages.h"
#include "server/messages/model_messages.h"
#include "server/messages/request_messages.h"

namespace isochor {
namespace {

std::string model_result(const StoredModel& model) {
  return to_text({{"model_id", model.id}, {"model", stored_model_json(model)}});
}

Response post_model(Api& api, const Request& request) {
  const ModelRequest wanted = read_model_request(request.body);
  const std::int64_t wait_ms = query_integer(request, "wait_ms", 0, 0, 10000);
  const Precision precision = query_precision(request);
  const auto mesh = api.catalog.mesh(wanted.mesh_id);
  if (wanted.dry_run)
    return Response::json(to_text({{"estimate", estimate_json(estimate(mesh->known.size, wanted.options))}}));
  check_budget(mesh->known.size, wanted.options, api.memory_limit);
  if (wanted.supersedes) api.jobs.cancel(*wanted.supersedes);
  const auto drawing = wanted.drawing ? std::make_shared<std::string>() : nullptr;
  const JobView job = api.jobs.submit(
      "model", [&api, mesh, drawing, precision, options = wanted.options, preview = wanted.preview_cells,
                budget = wanted.budget_tets](Progress& progress) mutable {
        if (budget)
          options = mesh->full.with([&](AuthoringPipeline& pipeline) {
            return fit_tet_budget(pipeline, options, *budget, progress);
          });
        const auto model = make_model(api, mesh, options, preview, progress);
        if (drawing) *drawing = encode_drawing(*model, precision);
        return model_result(*model);
      });
  return job_response(api, job.id, wait_ms, 202, drawing);
}

Response get_model(Api& api, const Request& request) {
  const auto model = api.catalog.model(request.segment("id"));
  Response response = Response::json(to_text(stored_model_json(*model)));
  response.headers.emplace_back("ETag", '"' + model->id + '"');
  return response;
}

/// A large answer of a model, shared by those who read it at the same time.
Response bulk(Api& api, const Request& request, const std::string& what,
              const std::function<void(const StoredModel&, const TextSink&)>& encode) {
  const auto model = api.catalog.model(request.segment("id"));
  return shared_answer(api, model->id + what, model->id, [&](const TextSink& sink) { encode(*model, sink); });
}

void need_embedding(const StoredModel& model) {
  if (!model.model->embedding) refuse(409, "wrong_state", "a preview has no embedding", whole_model);
}

Response get_embedding(Api& api, const Request& request) {
  need_embedding(*api.catalog.model(request.segment("id")));
  return bulk(api, request, "/embedding", encode_embedding);
}

Response get_ray(Api& api, const Request& request) {
  const auto model = api.catalog.model(request.segment("id"));
  const Vec3 direction = query_vector(request, "direction");
  const bool lattice =
      (direction.array() == direction.array().round()).all() && direction.cwiseAbs().maxCoeff() <= 1.0;
  const Vec3i steps = lattice ? Vec3i(direction.cast<int>()) : Vec3i::Zero();
  return Response::json(encode_ray(*model, query_vector(request, "point"), steps));
}

/// Takes one file of a set by its suffix.
class FileOfSet final : public ExportSink {
 public:
  FileOfSet(std::string_view suffix, LargeAnswer& out) : suffix_(suffix), out_(out) {}
  void begin(std::string_view name_suffix) override {
    wanted_ = name_suffix == suffix_;
    found = found || wanted_;
  }
  void write(std::string_view bytes) override {
    if (wanted_) out_.append(bytes);
  }
  bool found = false;

 private:
  std::string_view suffix_;
  LargeAnswer& out_;
  bool wanted_ = false;
};

DownloadFile one_file(const ExportModel& model, const ExportFormat& format, std::string_view suffix,
                      Disposal& disposal) {
  DownloadFile made{model.stem + std::string(suffix), std::string(format.media_type), LargeAnswer(disposal)};
  FileOfSet file(suffix, made.content);
  export_model(model, format, file);
  if (!file.found) refuse(404, "not_found", "the set has no file with this suffix", "");
  return made;
}

DownloadFile archive(const ExportModel& model, const ExportFormat& format, Disposal& disposal) {
  DownloadFile made{fmt::format("{}-{}.tar", model.stem, format.name), "application/x-tar",
                    LargeAnswer(disposal)};
  TarWriter tar(model.stem, made.content);
  export_model(model, format, tar);
  tar.finish();
  return made;
}

/// File name characters that every system takes.
std::string stem_of(const std::string& name) {
  std::string stem = name.substr(0, name.rfind('.'));
  stem = stem.substr(stem.find_last_of("/\\") + 1);
  std::replace_if(
      stem.begin(), stem.end(), [](unsigned char c) { return !std::isalnum(c) && c != '-' && c != '_'; },
      '_');
  return stem.empty() ? "model" : stem.substr(0, 64);
}

Response get_export(Api& api, const Request& request) {
  const auto stored = api.catalog.model(request.segment("id"));
  const ExportFormat& format = export_format(request.segment("format"));
  if (format.name == "embedding") need_embedding(*stored);
  const std::string name =
      api.catalog.has_mesh(stored->mesh_id) ? api.catalog.mesh(stored->mesh_id)->name : "";
  const std::string* suffix = request.parameter("file");
  const auto download = api.downloads.get(
      fmt::format("{}/{}/{}/{}", stored->id, name, format.name, suffix ? *suffix : ""), [&] {
        const Model& model = *stored->model;
        const ExportModel exported{.mesh = model.mesh(),
                                   .embedding = model.embedding.get(),
                                   .comment = describe(model.options),
                                   .stem = stem_of(name)};
        return suffix || !format.is_set
                   ? one_file(exported, format, suffix ? *suffix : format.extension, api.disposal)
                   : archive(exported, format, api.disposal);
      });
  Response response = download->content.respond(download);
  response.content_type = download->content_type;
  response.headers.emplace_back("Content-Disposition",
                                fmt::format("attachment; filename=\"{}\"", download->name));
  return response;
}

Response list_models(const Api& api) {
  Json models = Json::array();
  for (const auto& model : api.catalog.models())
    models.push_back(
        {{"id", model->id}, {"mesh_id", model->mesh_id}, {"tets", model->model->mesh().tets.size()}});
  return Response::json(to_text({{"models", models}}));
}

Response delete_model(Api& api, const Request& request) {
  api.catalog.remove_model(request.segment("id"));
  return Response::empty();
}

}  // namespace

std::vector<Route> model_routes(Api& api) {
  const auto to = [&](auto handler) { return [&api, handler](const Request& r) { return handler(api, r); }; };
  return {
      {.method = "GET",
       .pattern = "/api/v1/models",
       .operation = "listModels",
       .summary = "All models",
       .handler = [&](const Request&) { return list_models(api); },
       .answers = {{200, "ModelList"}}},
      {.method = "POST",
       .pattern = "/api/v1/models",
       .operation = "createModel",
       .summary = "Mesh a mesh: a job whose result is a model",
       .handler = to(post_model),
       .answers = {{202, "Job"}, {200, "JobOrEstimate"}},
       .body = BodyKind::json,
       .body_schema = "ModelRequest",
       .query = {{"wait_ms", R"({"type":"integer","minimum":0,"maximum":10000})",
                  "Answer once the job has ended, or after this time"},
                 precision_spec()}},
      {.method = "GET",
       .pattern = "/api/v1/models/{id}",
       .operation = "getModel",
       .summary = "A model: counts, quality, parameters, stages",
       .handler = to(get_model),
       .answers = {{200, "Model"}}},
      {.method = "GET",
       .pattern = "/api/v1/models/{id}/tets",
       .operation = "getModelTets",
       .summary = "Positions, tets, surface and cells",
       .handler =
           [&](const Request& r) {
             const bool smoothed = query_boolean(r, "smoothed", true);
             const Precision precision = query_precision(r);
             return bulk(api, r, fmt::format("/tets/{}/{}", smoothed, precision == Precision::f64),
                         [&](const StoredModel& model, const TextSink& sink) {
                           encode_tets(model, smoothed, precision, sink);
                         });
           },
       .answers = {{200, "Tets"}},
       .query = {{"smoothed", R"({"type":"boolean","default":true})", "false: as cut from the lattice"},
                 precision_spec()}},
      {.method = "GET",
       .pattern = "/api/v1/models/{id}/quality",
       .operation = "getModelQuality",
       .summary = "Smallest dihedral angle and scaled Jacobian of each tet",
       .handler = [&](const Request& r) { return bulk(api, r, "/quality", encode_quality); },
       .answers = {{200, "Quality"}}},
      {.method = "GET",
       .pattern = "/api/v1/models/{id}/voxels",
       .operation = "getModelVoxels",
       .summary = "The pseudo volume's voxels, and the lattice's densities",
       .handler =
           [&](const Request& r) {
             const bool shell = query_boolean(r, "shell", true);
             return bulk(
                 api, r, shell ? "/shell" : "/voxels",
                 [&](const StoredModel& model, const TextSink& sink) { encode_voxels(model, shell, sink); });
           },
       .answers = {{200, "Voxels"}},
       .query = {{"shell", R"({"type":"boolean","default":true})", "false: also those within"}}},
      {.method = "GET",
       .pattern = "/api/v1/models/{id}/embedding",
       .operation = "getModelEmbedding",
       .summary = "Original vertices bound to tets",
       .handler = to(get_embedding),
       .answers = {{200, "Embedding"}}},
      {.method = "GET",
       .pattern = "/api/v1/models/{id}/ray",
       .operation = "getModelRay",
       .summary = "P along a ray of the lattice",
       .handler = to(get_ray),
       .answers = {{200, "Ray"}},
       .query = {{"point", R"({"type":"string"})", "x,y,z"},
                 {"direction", R"({"type":"string"})", "i,j,k of -1, 0 and 1"}}},
      {.method = "GET",
       .pattern = "/api/v1/models/{id}/exports/{format}",
       .operation = "exportModel",
       .summary = "The model as a file",
       .handler = to(get_export),
       .answers = {{200, "", "*/*"}},
       .query = {{"file", R"({"type":"string"})", "Suffix of one file of a set, e.g. .node"}}},
      {.method = "DELETE",
       .pattern = "/api/v1/models/{id}",
       .operation = "deleteModel",
       .summary = "Forget a model",
       .handler = to(delete_model),
       .answers = {{204, ""}}},
  };
}

}  // namespace isochor

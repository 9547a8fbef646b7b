#include <fmt/format.h>

#include "server/http/api.h"
#include "server/http/query.h"
#include "server/http/service.h"
#include "server/messages/api_messages.h"
#include "server/messages/model_messages.h"

namespace isochor {
namespace {

Json sample_json(const Samples::Sample& sample, std::string_view collection) {
  const std::string file = sample.file.substr(sample.file.rfind('/') + 1);
  return {{"name", sample.name},
          {"title", sample.title},
          {"file", sample.file},
          {"preset", sample.preset.empty() ? Json() : Json(sample.preset)},
          {"meaning", sample.meaning},
          {"bytes", sample.text.size()},
          {"url", std::string(api_base) + "/samples/" + std::string(collection) + "/" + file}};
}

Response list_samples(const Api& api) {
  Json meshes = Json::array(), scenes = Json::array();
  for (const auto& sample : api.samples.meshes()) meshes.push_back(sample_json(sample, "meshes"));
  for (const auto& sample : api.samples.scenes()) scenes.push_back(sample_json(sample, "scenes"));
  return Response::json(to_text({{"meshes", meshes}, {"scenes", scenes}}));
}

Response sample_file(const Samples::Sample* sample, const std::string& content_type) {
  if (!sample) refuse(404, "not_found", "no such sample", "GET /api/v1/samples lists them");
  Response response = Response::json(sample->text);
  response.content_type = content_type;
  return response;
}

Response mesh_response(const StoredMesh& mesh, bool added) {
  Response response = Response::json(to_text(mesh_json(mesh)), added ? 201 : 200);
  response.headers.emplace_back("Location", std::string(api_base) + "/meshes/" + mesh.id);
  return response;
}

/// As long as file systems let names be.
constexpr std::size_t max_name_bytes = 255;

Response post_mesh(Api& api, const Request& request, const std::string& name) {
  if (name.size() > max_name_bytes)
    throw Error(ErrorCode::invalid_argument, fmt::format("the mesh's name is {} bytes long", name.size()),
                fmt::format("give a name of at most {} bytes", max_name_bytes));
  bool added = false;
  Progress progress({}, request.abandoned.get());
  if (const std::string* wanted = request.parameter("sample")) {
    const Samples::Sample* sample = api.samples.mesh(*wanted);
    if (!sample) refuse(404, "not_found", "no such sample", "GET /api/v1/samples lists them");
    const auto mesh = store_mesh(api, {sample->file, {}, sample->text}, added, progress);
    return mesh_response(*mesh, added);
  }
  const std::string* format = request.parameter("format");
  if (name.empty() && !format)
    throw Error(ErrorCode::unsupported_format, "the format is not known",
                "give ?name=bunny.obj or ?format=obj");
  const auto mesh = store_mesh(api, {name, format ? *format : "", request.body}, added, progress);
  return mesh_response(*mesh, added);
}

Response list_meshes(const Api& api) {
  Json meshes = Json::array();
  for (const auto& mesh : api.catalog.meshes())
    meshes.push_back({{"id", mesh->id}, {"name", mesh->name}, {"triangles", mesh->known.report->triangles}});
  return Response::json(to_text({{"meshes", meshes}}));
}

Response geometry(Api& api, const Request& request) {
  const auto mesh = api.catalog.mesh(request.segment("id"));
  const Precision precision = query_precision(request);
  return shared_answer(api, mesh->id + (precision == Precision::f64 ? "/geometry64" : "/geometry"), mesh->id,
                       [&](const TextSink& sink) { encode_geometry(*mesh, precision, sink); });
}

const std::vector<QuerySpec> upload_query{
    {"name", R"({"type":"string","maxLength":255})", "File name; its extension names the format"},
    {"format", R"({"enum":["obj","stl","ply","off","glb"]})", "Instead of the extension"}};

}  // namespace

std::vector<Route> sample_routes(Api& api) {
  return {
      {.method = "GET",
       .pattern = "/api/v1/samples",
       .operation = "listSamples",
       .summary = "The meshes and scenes that ship",
       .handler = [&](const Request&) { return list_samples(api); },
       .answers = {{200, "Samples"}}},
      {.method = "GET",
       .pattern = "/api/v1/samples/meshes/{file}",
       .operation = "getSampleMesh",
       .summary = "A sample mesh, the file itself",
       .handler =
           [&](const Request& r) { return sample_file(api.samples.mesh(r.segment("file")), "model/obj"); },
       .answers = {{200, "", "model/obj"}}},
      {.method = "GET",
       .pattern = "/api/v1/samples/scenes/{file}",
       .operation = "getSampleScene",
       .summary = "A sample scene, the file itself",
       .handler =
           [&](const Request& r) {
             return sample_file(api.samples.scene(r.segment("file")), "application/json");
           },
       .answers = {{200, "Scene"}}},
  };
}

std::vector<Route> mesh_routes(Api& api) {
  std::vector<QuerySpec> post_query = upload_query;
  post_query.push_back({"sample", R"({"type":"string"})", "Name of a sample, instead of a body"});
  return {
      {.method = "GET",
       .pattern = "/api/v1/meshes",
       .operation = "listMeshes",
       .summary = "All meshes",
       .handler = [&](const Request&) { return list_meshes(api); },
       .answers = {{200, "MeshList"}}},
      {.method = "POST",
       .pattern = "/api/v1/meshes",
       .operation = "createMesh",
       .summary = "Send a mesh file; the same content has the same id",
       .handler =
           [&](const Request& r) {
             return post_mesh(api, r, r.parameter("name") ? *r.parameter("name") : "");
           },
       .answers = {{201, "Mesh"}, {200, "Mesh"}},
       .body = BodyKind::file,
       .query = post_query,
       .body_optional = true},
      {.method = "PUT",
       .pattern = "/api/v1/meshes/{name}",
       .operation = "putMesh",
       .summary = "Send a mesh file under its name",
       .handler = [&](const Request& r) { return post_mesh(api, r, r.segment("name")); },
       .answers = {{201, "Mesh"}, {200, "Mesh"}},
       .body = BodyKind::file,
       .query = {upload_query[1]}},
      {.method = "GET",
       .pattern = "/api/v1/meshes/{id}",
       .operation = "getMesh",
       .summary = "A mesh and its report",
       .handler =
           [&](const Request& r) {
             return Response::json(to_text(mesh_json(*api.catalog.mesh(r.segment("id")))));
           },
       .answers = {{200, "Mesh"}}},
      {.method = "GET",
       .pattern = "/api/v1/meshes/{id}/report",
       .operation = "getMeshReport",
       .summary = "What was found in the file: counts and defects",
       .handler =
           [&](const Request& r) {
             return Response::json(
                 to_text(mesh_report_json(*api.catalog.mesh(r.segment("id"))->known.report)));
           },
       .answers = {{200, "MeshReport"}}},
      {.method = "GET",
       .pattern = "/api/v1/meshes/{id}/geometry",
       .operation = "getMeshGeometry",
       .summary = "Positions and triangles",
       .handler = [&](const Request& r) { return geometry(api, r); },
       .answers = {{200, "Geometry"}},
       .query = {precision_spec()}},
      {.method = "DELETE",
       .pattern = "/api/v1/meshes/{id}",
       .operation = "deleteMesh",
       .summary = "Forget a mesh",
       .handler =
           [&](const Request& r) {
             api.catalog.remove_mesh(r.segment("id"));
             return Response::empty();
           },
       .answers = {{204, ""}}},
  };
}

}  // namespace isochor

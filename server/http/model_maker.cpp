#include <algorithm>
#include <array>

#include "core/parallel/cancel_scope.h"
#include "core/parameters/parameters.h"
#include "core/scene/memory_estimate.h"
#include "core/scene/read_scene.h"
#include "server/http/api.h"
#include "server/http/service.h"
#include "server/store/content_id.h"

namespace isochor {
namespace {

using namespace std::string_view_literals;

/// Share of a full run's time that has passed when a stage begins, for the fraction of the whole.
constexpr std::array stage_starts{std::pair{"distance_field"sv, 0.0}, std::pair{"pseudo_volume"sv, 0.55},
                                  std::pair{"lattice"sv, 0.70},       std::pair{"tetrahedra"sv, 0.72},
                                  std::pair{"smoothing"sv, 0.75},     std::pair{"embedding"sv, 0.85},
                                  std::pair{"quality"sv, 0.90},       std::pair{""sv, 1.0}};

constexpr std::array format_names{"obj", "stl", "ply", "off", "glb"};  // in the order of MeshFormat

double overall(std::string_view phase, double fraction) {
  for (std::size_t i = 0; i + 1 < stage_starts.size(); ++i)
    if (stage_starts[i].first == phase)
      return stage_starts[i].second + fraction * (stage_starts[i + 1].second - stage_starts[i].second);
  return 0.0;
}

/// Halved, so that every step of a slider shows.
MeshingOptions with_preview_cells(MeshingOptions options, int most) {
  while (options.lattice.cells > most) options.lattice.cells = (options.lattice.cells + 1) / 2;
  return options;
}

/// Whether the input has few openings: its rays agree on the inside, whatever P_in is.
bool all_but_closed(const MeshReport& input) {
  const auto open = std::ranges::find(input.defects, "open_edges"sv, &Defect::name);
  return open == input.defects.end() || 100 * open->count < input.triangles;
}

/// The last full model, where its distance field is that of these options; null where it is not.
std::shared_ptr<const Model> full_model_of_field(StoredMesh& mesh, const MeshingOptions& options) {
  return mesh.remembered.with([&](const auto& models) {
    const auto& full = models.front();
    return full && full->options.voxels == options.voxels ? full : nullptr;
  });
}

}  // namespace

std::shared_ptr<StoredMesh> store_mesh(Api& api, const MeshFile& file, bool& added, Progress& progress) {
  const auto& [name, format, bytes] = file;
  const MeshFormat kind = mesh_format(format.empty() ? name : "mesh." + format);
  const CancelScope scope(progress);
  const std::string id = content_id("m", bytes);
  if (api.catalog.has_mesh(id)) {
    added = false;
    return api.catalog.mesh(id);
  }
  auto soup =
      std::make_shared<const TriangleSoup>(read_mesh(std::span(bytes.data(), bytes.size()), kind, progress));
  auto mesh = std::make_shared<StoredMesh>(id, soup);
  mesh->name = name.empty() ? "mesh." + format : name;
  mesh->format = format_names[static_cast<std::size_t>(kind)];
  mesh->file_bytes = static_cast<std::int64_t>(bytes.size());
  api.catalog.evict(api.simulations.bytes());
  return api.catalog.add(std::move(mesh), added);
}

std::shared_ptr<const StoredModel> make_model(Api& api, const std::shared_ptr<StoredMesh>& mesh,
                                              const MeshingOptions& asked, std::optional<int> preview_cells,
                                              Progress& progress) {
  const bool preview = preview_cells.has_value();
  const int most = preview_cells.value_or(0);
  // Coarse only where a full run would not be quick. With the distance field at hand it is, but for many
  // cells and for the rays, which then sweep a part of its voxels.
  const MeshingOptions wanted = preview ? with_preview_cells(asked, most) : asked;
  const auto full = preview ? full_model_of_field(*mesh, wanted) : nullptr;
  const bool same_rays = full && full->options.pseudo_volume == wanted.pseudo_volume;
  const bool encloses = full && all_but_closed(*full->input);
  const int stride = full && !same_rays ? preview_stride(wanted, most, encloses) : 1;
  const bool coarse = preview && (!full || stride > 1);
  const MeshingOptions options = !coarse ? wanted
                                 : full  ? thinned(wanted, stride)
                                         : preview_options(wanted, most);
  const std::string content =
      mesh->id + " " + describe(options) + (stride > 1 ? " thinned by " + std::to_string(stride) : "");
  if (auto known = api.catalog.find_model(content_id("d", content))) return known;
  const std::string id = content_id("d", preview ? content + " shape" : content);
  if (auto known = preview ? api.catalog.find_model(id) : nullptr) return known;
  check_budget(mesh->known.size, options, api.memory_limit);
  Progress whole = progress.with_sink(
      [&](std::string_view phase, double fraction) { progress.report(phase, overall(phase, fraction)); });
  auto& pipeline = coarse ? mesh->preview : mesh->full;
  auto model = pipeline.with([&](AuthoringPipeline& stages) {
    const Extent extent = preview ? Extent::shape : Extent::whole;
    return stride > 1 ? stages.run_thinned(options, full->field, stride, whole, extent)
                      : stages.run(options, whole, extent);
  });
  mesh->remembered.with([&](auto& models) { models[coarse ? 1 : 0] = model; });
  api.catalog.evict(api.simulations.bytes());
  return api.catalog.add({id, mesh->id, std::move(model)});
}

void resolve_meshes(Api& api, Scene& scene, Progress& progress) {
  const auto resolve = [&](auto& shape) {
    const auto* named = std::get_if<MeshShape>(&shape);
    if (!named) return;
    const std::string name = named->file.lexically_normal().generic_string();
    if (name.starts_with('d')) {
      if (const auto known = api.catalog.find_model(name)) {
        if (!known->model->embedding)
          throw Error(ErrorCode::invalid_argument, "the model '" + name + "' is a preview", whole_model);
        shape = ModelShape{known->model};
        return;
      }
    }
    std::shared_ptr<StoredMesh> mesh;
    bool added = false;
    if (const Samples::Sample* sample = api.samples.mesh(name))
      mesh = store_mesh(api, {sample->file, {}, sample->text}, added, progress);
    else if (api.catalog.has_mesh(name))
      mesh = api.catalog.mesh(name);
    else
      throw Error(ErrorCode::invalid_argument, "no mesh '" + name + "'",
                  "name a sample's file, the id of a mesh or the id of a model");
    shape = ModelShape{make_model(api, mesh, named->meshing, std::nullopt, progress)->model};
  };
  for (SceneBody& body : scene.bodies) std::visit([&](auto& kind) { resolve(kind.shape); }, body.kind);
}

std::unique_ptr<Simulation> build_simulation(Api& api, const std::string& id, Scene scene,
                                             Progress& progress) {
  resolve_meshes(api, scene, progress);
  api.simulations.make_room(id, estimated_bytes(scene), progress);
  api.catalog.evict(api.simulations.bytes());
  return compile(scene, progress);
}

Scene sample_scene(const Api& api, const std::string& name) {
  if (const Samples::Sample* sample = api.samples.scene(name))
    return read_scene(sample->text, std::filesystem::path(sample->file).parent_path());
  refuse(404, "not_found", "no such sample", "GET /api/v1/samples lists them");
}

}  // namespace isochor

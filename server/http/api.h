#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/common/text_sink.h"
#include "server/http/large_answer.h"
#include "server/http/router.h"
#include "server/http/samples.h"
#include "server/job_queue/job_queue.h"
#include "server/job_queue/shared.h"
#include "server/store/catalog.h"
#include "server/store/simulations.h"

namespace isochor {

struct DownloadFile {
  std::string name, content_type;
  LargeAnswer content;
};

struct TaggedAnswer {
  std::string etag;
  LargeAnswer content;
};

/// What the handlers share.
struct Api {
  Api(Samples samples_, std::shared_ptr<Waker> waker_, std::int64_t memory_limit_);

  Samples samples;
  std::shared_ptr<Waker> waker;
  std::int64_t memory_limit;
  Catalog catalog;
  Disposal disposal;
  Shared<TaggedAnswer> texts;  ///< large answers under way
  Shared<DownloadFile> downloads;
  Simulations simulations;
  JobQueue jobs;
};

// The table of routes, by resource.
std::vector<Route> meta_routes(Api& api);
std::vector<Route> sample_routes(Api& api);
std::vector<Route> mesh_routes(Api& api);
std::vector<Route> model_routes(Api& api);
std::vector<Route> job_routes(Api& api);
std::vector<Route> simulation_routes(Api& api);
std::vector<Route> frame_routes(Api& api);
std::vector<Route> report_routes(Api& api);
/// All of them, and /openapi.json and /docs made from them.
std::vector<Route> api_routes(Api& api);

inline constexpr std::string_view api_base = "/api/v1";

/// A mesh file as it was sent, or as it ships.
struct MeshFile {
  std::string name, format;  ///< without a format, the name's extension tells
  std::string_view bytes;
};
/// Reads a mesh and puts it into the catalog; `added` tells whether it was new. Throws cannot_read,
/// unsupported_format, empty_result, cancelled.
std::shared_ptr<StoredMesh> store_mesh(Api& api, const MeshFile& file, bool& added, Progress& progress);
/// The model of a mesh with these options: the stored one, or a new one; with preview_cells a coarse one, of
/// so many along its longest edge at most. Throws what the stages throw.
std::shared_ptr<const StoredModel> make_model(Api& api, const std::shared_ptr<StoredMesh>& mesh,
                                              const MeshingOptions& options, std::optional<int> preview_cells,
                                              Progress& progress);
/// What to do where a preview will not do.
inline constexpr const char* whole_model = "ask for the model with quality full";
/// Mesh shapes named by a sample, a mesh id or a model id become models; a name from outside is never a path.
void resolve_meshes(Api& api, Scene& scene, Progress& progress);
/// The simulation of a scene whose meshes are so named. Others give way to the one with this id; a report's
/// has none.
std::unique_ptr<Simulation> build_simulation(Api& api, const std::string& id, Scene scene,
                                             Progress& progress);
/// Its mesh files are those of the samples. Throws a refusal, 404.
Scene sample_scene(const Api& api, const std::string& name);

/// The simulation that the path names; throws Missing.
std::shared_ptr<SimulationRunner> find_runner(Api& api, const Request& request);
/// What is known of it once it is prepared; a refusal, 409, before.
std::shared_ptr<const HelloFacts> prepared(const SimulationRunner& runner);

/// A large answer, made once for those who read it at the same time. Without an etag that of its content is
/// taken.
Response shared_answer(Api& api, const std::string& key, const std::string& etag,
                       const std::function<void(const TextSink&)>& encode);

/// Answers once the job has ended, or after the wait, then with unfinished_status. What the job's work has
/// written to `beside`, a JSON text, comes with the answer of one that is done, as its drawing.
Response job_response(Api& api, const std::string& id, std::int64_t wait_ms, int unfinished_status,
                      const std::shared_ptr<const std::string>& beside = nullptr);

}  // namespace isochor

#include <fmt/format.h>
#include <charconv>

#include "core/scene/read_scene.h"
#include "server/http/api.h"
#include "server/http/query.h"
#include "server/http/service.h"
#include "server/messages/api_messages.h"
#include "server/messages/request_messages.h"
#include "server/stream/viewer.h"

namespace isochor {
namespace {

constexpr int max_viewers = 256;

/// Answers with the simulation as soon as `ready` says so, or after the wait; a scene that does not compile
/// is the request's failure.
template <class Ready>
Response when(const std::shared_ptr<SimulationRunner>& runner, int status, std::int64_t wait_ms,
              Ready ready) {
  const auto poll = [runner, status, ready](bool deadline_passed) -> std::optional<Response> {
    const RunView view = runner->view();
    if (!ready(view) && view.state != RunState::failed && !deadline_passed) return std::nullopt;
    if (view.failure && status == 201) throw *view.failure;
    Response response = Response::json(to_text(simulation_json(*runner)), status);
    if (status == 201) response.headers.emplace_back("Location", simulation_url(view.id));
    return response;
  };
  Response response;
  response.pending = std::make_shared<PendingAnswer>(
      PendingAnswer{poll, std::chrono::steady_clock::now() + std::chrono::milliseconds(wait_ms)});
  return response;
}

std::string scene_text(const Api& api, const std::string& body) {
  const auto wanted = read_simulation_request(body);
  return wanted.sample ? sample_scene(api, *wanted.sample) : body;
}

Response post_simulation(Api& api, const Request& request) {
  // An empty base keeps the names of meshes as they were given: they are looked up, never opened.
  const Scene scene = read_scene(scene_text(api, request.body), "");
  RunOptions options;
  options.fast = query_choice(request, "pace", {"realtime", "fast"}, 0) == 1;
  options.playing = query_choice(request, "state", {"paused", "playing"}, 0) == 1;
  const std::int64_t wait_ms = query_integer(request, "wait_ms", 2000, 0, 10000);
  const auto build = [&api, scene](Progress& progress) { return build_simulation(api, scene, progress); };
  const auto runner = api.simulations.create(build, options);
  return when(runner, 201, wait_ms, [](const RunView& view) { return view.state != RunState::preparing; });
}

std::shared_ptr<SimulationRunner> find_runner(Api& api, const Request& request) {
  return api.simulations.find(request.segment("id"));
}

Response get_simulation(Api& api, const Request& request) {
  return Response::json(to_text(simulation_json(*find_runner(api, request))));
}

Response list_simulations(const Api& api) {
  Json simulations = Json::array();
  for (const auto& runner : api.simulations.all()) simulations.push_back(simulation_json(*runner));
  return Response::json(to_text({{"simulations", simulations}}));
}

const BodyTopology& find_body(const HelloFacts& facts, int id) {
  for (const BodyTopology& body : facts.bodies)
    if (body.id == id) return body;
  throw Error(ErrorCode::invalid_argument, fmt::format("the simulation has no body {}", id),
              "GET its topology for the bodies", {{"/body", "is no body's id", {}, {}}});
}

std::shared_ptr<const HelloFacts> prepared(const SimulationRunner& runner) {
  auto facts = runner.facts();
  if (!facts)
    refuse(409, "wrong_state", "the simulation is still being prepared", "wait until its state is paused");
  return facts;
}

void apply_materials(SimulationRunner& runner, const std::vector<MaterialChange>& materials) {
  for (const MaterialChange& m : materials) {
    if (!find_body(*prepared(runner), m.body).deformable)
      throw Error(ErrorCode::invalid_argument, fmt::format("body {} is rigid", m.body),
                  "change a deformable one");
    runner.change(
        fmt::format("material {}", m.body),
        [m](Simulation& simulation) {
          simulation.set_material(m.body, m.edge_stiffness, m.diagonal_stiffness, m.damping);
        },
        true);
  }
}

Response patch_simulation(Api& api, const Request& request) {
  const auto runner = find_runner(api, request);
  const RunView view = runner->view();
  const SimulationChange change = read_simulation_change(request.body, view.solver);
  if (view.state == RunState::failed)
    refuse(409, "wrong_state", "the simulation has failed", "create another one");
  if (change.play.value_or(false) && view.state == RunState::finished && !change.restart)
    refuse(409, "wrong_state", "the simulation has finished", "restart it");
  apply_materials(*runner, change.materials);
  if (change.gravity)
    runner->change(
        "gravity", [g = *change.gravity](Simulation& simulation) { simulation.set_gravity(g); }, true);
  if (change.solver)
    runner->change(
        "solver", [s = *change.solver](Simulation& simulation) { simulation.set_solver(s); }, true);
  if (change.speed) runner->set_speed(*change.speed);
  if (change.fast) runner->set_pace(*change.fast);
  if (change.restart) runner->restart();
  if (change.play) *change.play ? runner->play() : runner->pause();
  // The thread takes the change before its next step.
  constexpr std::int64_t patience_ms = 1000;
  return when(runner, 200, patience_ms,
              [runner, want = runner->requests()](const RunView& now) { return now.taken >= want; });
}

Response post_steps(Api& api, const Request& request) {
  const auto runner = find_runner(api, request);
  const std::int64_t count = read_step_count(request.body);
  const RunState state = runner->view().state;
  if (state == RunState::playing || state == RunState::failed || state == RunState::finished)
    refuse(409, "wrong_state", fmt::format("the simulation is {}", state_name(state)),
           "pause it, or restart it");
  runner->step(count);
  return when(runner, 200, query_integer(request, "wait_ms", 10000, 0, 60000), [](const RunView& view) {
    return view.state != RunState::preparing && view.pending_steps == 0;
  });
}

Response put_grab(Api& api, const Request& request) {
  const auto runner = find_runner(api, request);
  const Grab grab = read_grab(request.body);
  const BodyTopology& body = find_body(*prepared(*runner), grab.body);
  const auto vertices = static_cast<double>(body.rest_positions.size());
  if (!body.deformable || grab.vertex >= vertices)
    throw Error(ErrorCode::invalid_argument, "the body has no such vertex",
                "grab a vertex of a deformable body", {{"/vertex", "is out of range", 0.0, vertices - 1.0}});
  runner->change(
      "grab", [grab](Simulation& simulation) { simulation.grab(grab); }, false);
  return Response::empty();
}

Response delete_grab(Api& api, const Request& request) {
  find_runner(api, request)
      ->change(
          "grab", [](Simulation& simulation) { simulation.grab(std::nullopt); }, false);
  return Response::empty();
}

Response put_collider(Api& api, const Request& request) {
  const auto runner = find_runner(api, request);
  const Pose pose = read_pose(request.body);
  int id = -1;
  const std::string& text = request.segment("body");
  std::from_chars(text.data(), text.data() + text.size(), id);
  if (find_body(*prepared(*runner), id).deformable)
    throw Error(ErrorCode::invalid_argument, fmt::format("body {} is deformable", id),
                "move a rigid one, or grab it");
  runner->change(
      fmt::format("collider {}", id),
      [id, pose](Simulation& simulation) { simulation.move_body(id, pose.position, pose.orientation); },
      false);
  return Response::empty();
}

Response get_topology(Api& api, const Request& request) {
  const auto runner = find_runner(api, request);
  const auto facts = prepared(*runner);
  const std::string& id = request.segment("id");
  Response response;
  response.body = api.texts.get(id + "/topology", [&] { return encode_topology(id, facts->bodies); });
  response.headers.emplace_back("ETag", '"' + id + '"');
  return response;
}

Encoding encoding_of(const Request& request) {
  constexpr std::array encodings{Encoding::f32, Encoding::f64, Encoding::array};
  return encodings[query_choice(request, "encoding", {"f32", "f64", "array"}, 0)];
}

Response get_frames(Api& api, const Request& request) {
  const auto runner = find_runner(api, request);
  constexpr std::int64_t far = std::int64_t{1} << 53;
  ViewerOptions options;
  options.encoding = encoding_of(request);
  options.after_seq = query_integer(request, "after_seq", -1, -1, far);
  options.stride = query_integer(request, "stride", 1, 1, 1000000);
  options.every = query_choice(request, "pace", {"latest", "every"}, 0) == 1;
  options.inline_topology = query_choice(request, "topology", {"url", "inline"}, 0) == 1;
  const std::string* accept = request.header("accept");
  options.server_sent_events = accept && accept->find("text/event-stream") != std::string::npos;
  // A reader that comes back says where it was.
  if (const std::string* last = request.header("last-event-id"); last && !request.parameter("after_seq"))
    std::from_chars(last->data(), last->data() + last->size(), options.after_seq);
  if (api.simulations.viewers() >= max_viewers)
    refuse(429, "too_many_streams", fmt::format("{} streams are open", max_viewers), "close some");
  Response response;
  response.content_type = options.server_sent_events ? "text/event-stream" : "application/x-ndjson";
  response.stream = std::make_shared<Viewer>(runner->feed(), options);
  return response;
}

Response get_frame(Api& api, const Request& request) {
  const auto runner = find_runner(api, request);
  const std::string& text = request.segment("seq");
  std::int64_t seq = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seq);
  if (error != std::errc() || end != text.data() + text.size() || seq < 0)
    refuse(404, "not_found", "a frame is named by its seq", "");
  const FrameFeed::Status status = runner->feed()->status();
  const auto frame = runner->feed()->find(seq);
  if (!frame && seq <= status.last)
    refuse(410, "evicted", fmt::format("frame {} has been evicted", seq),
           fmt::format("frames {} to {} are buffered", status.first, status.last));
  if (!frame) refuse(404, "not_found", fmt::format("frame {} has not been made yet", seq), "");
  return Response::json(encode_frame(*frame, encoding_of(request)));
}

Response delete_simulation(Api& api, const Request& request) {
  api.simulations.remove(request.segment("id"));
  return Response::empty();
}

constexpr std::string_view encoding_schema = R"({"enum":["f32","f64","array"],"default":"f32"})";

std::vector<Route> frame_routes(Api& api) {
  const auto to = [&](auto handler) { return [&api, handler](const Request& r) { return handler(api, r); }; };
  return {
      {.method = "GET",
       .pattern = "/api/v1/simulations/{id}/frames",
       .operation = "streamFrames",
       .summary = "The live stream: JSON lines, or server-sent events",
       .handler = to(get_frames),
       .answers = {{200, "StreamLine", "application/x-ndjson"}, {200, "", "text/event-stream"}},
       .query = {{"after_seq", R"({"type":"integer","minimum":-1})", "Frames after this one"},
                 {"stride", R"({"type":"integer","minimum":1})", "Only multiples of it"},
                 {"encoding", encoding_schema, "How positions are written"},
                 {"pace", R"({"enum":["latest","every"]})",
                  "Skip what is too late, or send every buffered frame"},
                 {"topology", R"({"enum":["url","inline"]})", "inline: the stream is a recording"}}},
      {.method = "GET",
       .pattern = "/api/v1/simulations/{id}/frames/{seq}",
       .operation = "getFrame",
       .summary = "One buffered frame",
       .handler = to(get_frame),
       .answers = {{200, "StreamLine"}},
       .query = {{"encoding", encoding_schema, "How positions are written"}}},
      {.method = "GET",
       .pattern = "/api/v1/simulations/{id}/topology",
       .operation = "getTopology",
       .summary = "The bodies: tets, cells, rest positions, masses, surface, embedding",
       .handler = to(get_topology),
       .answers = {{200, "Topology"}}},
  };
}

std::vector<Route> control_routes(Api& api) {
  const auto to = [&](auto handler) { return [&api, handler](const Request& r) { return handler(api, r); }; };
  return {
      {.method = "POST",
       .pattern = "/api/v1/simulations/{id}/steps",
       .operation = "stepSimulation",
       .summary = "Advance by frames while paused",
       .handler = to(post_steps),
       .answers = {{200, "Simulation"}},
       .body = BodyKind::json,
       .body_schema = "Steps",
       .query = {{"wait_ms", R"({"type":"integer","minimum":0,"maximum":60000})",
                  "Answer after this time at the latest"}},
       .body_optional = true},
      {.method = "PUT",
       .pattern = "/api/v1/simulations/{id}/grabs/{grab}",
       .operation = "putGrab",
       .summary = "Pull a vertex towards a point; the latest wins",
       .handler = to(put_grab),
       .answers = {{204, ""}},
       .body = BodyKind::json,
       .body_schema = "Grab"},
      {.method = "DELETE",
       .pattern = "/api/v1/simulations/{id}/grabs/{grab}",
       .operation = "deleteGrab",
       .summary = "Let go",
       .handler = to(delete_grab),
       .answers = {{204, ""}}},
      {.method = "PUT",
       .pattern = "/api/v1/simulations/{id}/colliders/{body}",
       .operation = "putCollider",
       .summary = "Move a kinematic body",
       .handler = to(put_collider),
       .answers = {{204, ""}},
       .body = BodyKind::json,
       .body_schema = "Pose"},
  };
}

}  // namespace

std::vector<Route> simulation_routes(Api& api) {
  const auto to = [&](auto handler) { return [&api, handler](const Request& r) { return handler(api, r); }; };
  std::vector<Route> routes{
      {.method = "GET",
       .pattern = "/api/v1/simulations",
       .operation = "listSimulations",
       .summary = "All simulations",
       .handler = [&](const Request&) { return list_simulations(api); },
       .answers = {{200, "SimulationList"}}},
      {.method = "POST",
       .pattern = "/api/v1/simulations",
       .operation = "createSimulation",
       .summary = "Compile a scene; it starts paused",
       .handler = to(post_simulation),
       .answers = {{201, "Simulation"}},
       .body = BodyKind::json,
       .body_schema = "SceneRequest",
       .query = {{"wait_ms", R"({"type":"integer","minimum":0,"maximum":10000})",
                  "Answer after this time at the latest"},
                 {"pace", R"({"enum":["realtime","fast"]})", "Real time, or as fast as it goes"},
                 {"state", R"({"enum":["paused","playing"]})", "playing: start at once"}}},
      {.method = "GET",
       .pattern = "/api/v1/simulations/{id}",
       .operation = "getSimulation",
       .summary = "State, time, metrics and plan",
       .handler = to(get_simulation),
       .answers = {{200, "Simulation"}}},
      {.method = "PATCH",
       .pattern = "/api/v1/simulations/{id}",
       .operation = "changeSimulation",
       .summary = "Play, pause, restart, speed, gravity, solver, materials",
       .handler = to(patch_simulation),
       .answers = {{200, "Simulation"}},
       .body = BodyKind::json,
       .body_schema = "SimulationChange"},
      {.method = "DELETE",
       .pattern = "/api/v1/simulations/{id}",
       .operation = "deleteSimulation",
       .summary = "End a simulation and its streams",
       .handler = to(delete_simulation),
       .answers = {{204, ""}}},
  };
  for (auto& more : {frame_routes(api), control_routes(api)})
    routes.insert(routes.end(), more.begin(), more.end());
  return routes;
}

}  // namespace isochor

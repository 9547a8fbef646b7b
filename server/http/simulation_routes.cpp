#include <fmt/format.h>
#include <charconv>

#include "core/scene/read_scene.h"
#include "server/http/api.h"
#include "server/http/query.h"
#include "server/http/service.h"
#include "server/messages/api_messages.h"
#include "server/messages/request_messages.h"

namespace isochor {
namespace {

/// Answers with the simulation as soon as `ready` says so, or after the wait, then with `late`; a scene that
/// does not compile is the request's failure.
template <class Ready>
Response when(const std::shared_ptr<SimulationRunner>& runner, int status, int late, std::int64_t wait_ms,
              Ready ready) {
  const auto poll = [runner, status, late, ready](bool deadline_passed) -> std::optional<Response> {
    const RunView view = runner->view();
    const bool decided = ready(view) || view.state == RunState::failed;
    if (!decided && !deadline_passed) return std::nullopt;
    if (view.failure && status == 201) throw *view.failure;
    Response response = Response::json(to_text(simulation_json(*runner)), decided ? status : late);
    if (status == 201) response.headers.emplace_back("Location", simulation_url(view.id));
    return response;
  };
  Response response;
  response.pending = std::make_shared<PendingAnswer>(
      PendingAnswer{poll, std::chrono::steady_clock::now() + std::chrono::milliseconds(wait_ms)});
  return response;
}

Scene wanted_scene(const Api& api, std::string_view body) {
  const auto wanted = read_simulation_request(body);
  // An empty base keeps the names of meshes as they were given: they are looked up, never opened.
  return wanted.sample ? sample_scene(api, *wanted.sample) : read_scene(body, "");
}

/// The first build goes on from where `before` stands; a restart begins as the scene says.
Simulations::Build build_of(Api& api, const Scene& scene, std::shared_ptr<SimulationRunner> before) {
  return [&api, scene, before](const std::string& id, Progress& progress) mutable {
    auto simulation = build_simulation(api, id, scene, progress);
    if (before) before->look([&](const Simulation& run) { simulation->continue_from(run); }, progress);
    before.reset();
    return simulation;
  };
}

Response post_simulation(Api& api, const Request& request) {
  const Scene scene = wanted_scene(api, request.body);
  RunOptions options;
  options.fast = query_choice(request, "pace", {"realtime", "fast"}, 0) == 1;
  options.playing = query_choice(request, "state", {"paused", "playing"}, 0) == 1;
  const std::int64_t wait_ms = query_integer(request, "wait_ms", 2000, 0, 10000);
  const std::string* before = request.parameter("continues");
  const auto runner =
      api.simulations.create(build_of(api, scene, before ? api.simulations.find(*before) : nullptr), options);
  return when(runner, 201, 201, wait_ms,
              [](const RunView& view) { return view.state != RunState::preparing; });
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

void apply_materials(SimulationRunner& runner, const std::vector<MaterialChange>& materials) {
  for (const MaterialChange& m : materials) {
    if (!find_body(*prepared(runner), m.body).deformable)
      throw Error(ErrorCode::invalid_argument, fmt::format("body {} is rigid", m.body),
                  "change a deformable one");
    runner.change(
        fmt::format("material {}", m.body),
        [m](Simulation& simulation) { simulation.set_material(m.body, m.springs); }, true);
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
  // The thread takes the change before its next step, which may be long in coming.
  return when(runner, 200, 202, query_integer(request, "wait_ms", 10000, 0, 60000),
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
  return when(runner, 200, 202, query_integer(request, "wait_ms", 10000, 0, 60000), [](const RunView& view) {
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

Response delete_simulation(Api& api, const Request& request) {
  api.simulations.remove(request.segment("id"));
  return Response::empty();
}

std::vector<Route> control_routes(Api& api) {
  const auto to = [&](auto handler) { return [&api, handler](const Request& r) { return handler(api, r); }; };
  return {
      {.method = "POST",
       .pattern = "/api/v1/simulations/{id}/steps",
       .operation = "stepSimulation",
       .summary = "Advance by frames while paused",
       .handler = to(post_steps),
       .answers = {{200, "Simulation"}, {202, "Simulation"}},
       .body = BodyKind::json,
       .body_schema = "Steps",
       .query = {{"wait_ms", R"({"type":"integer","minimum":0,"maximum":60000})",
                  "Answer after this time at the latest, 202 where they are not all made"}},
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

std::shared_ptr<SimulationRunner> find_runner(Api& api, const Request& request) {
  return api.simulations.find(request.segment("id"));
}

std::shared_ptr<const HelloFacts> prepared(const SimulationRunner& runner) {
  auto facts = runner.facts();
  if (!facts)
    refuse(409, "wrong_state", "the simulation is still being prepared", "wait until its state is paused");
  return facts;
}

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
                 {"continues", R"({"type":"string"})",
                  "A simulation to go on from: time and the motion of the bodies of the same names are its"},
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
       .answers = {{200, "Simulation"}, {202, "Simulation"}},
       .body = BodyKind::json,
       .body_schema = "SimulationChange",
       .query = {{"wait_ms", R"({"type":"integer","minimum":0,"maximum":60000})",
                  "Answer after this time at the latest, 202 where the step under way has not ended"}}},
      {.method = "DELETE",
       .pattern = "/api/v1/simulations/{id}",
       .operation = "deleteSimulation",
       .summary = "End a simulation and its streams",
       .handler = to(delete_simulation),
       .answers = {{204, ""}}},
  };
  const auto more = control_routes(api);
  routes.insert(routes.end(), more.begin(), more.end());
  return routes;
}

}  // namespace isochor

#include "server/messages/request_messages.h"

#include <fmt/format.h>

#include <array>
#include <cctype>

#include "core/parameters/parameters.h"
#include "server/messages/object_reader.h"

namespace isochor {
namespace {

constexpr std::size_t max_depth = 64;
constexpr std::size_t max_values = 50000, max_members = 1000, max_word = 400;
constexpr double large = 1e9;

/// What an honest document never is: nlohmann's trees are written and freed by recursion, take some 80 bytes
/// a value, look through all members of an object for each one more, and copy a long number several times.
void check_bounds(std::string_view text) {
  std::size_t depth = 0, values = 0, word = 0;
  std::array<std::size_t, max_depth + 1> members{};  // of the object at each depth
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
      continue;
    }
    word = std::isalnum(static_cast<unsigned char>(c)) || c == '.' ? word + 1 : 0;
    if (word > max_word)
      throw SyntaxError(fmt::format("the JSON has a number of more than {} digits", max_word));
    if (c == '"') in_string = true;
    if (c == ']' || c == '}') depth -= depth > 0;
    const bool opens = c == '[' || c == '{';
    if ((opens || c == ',' || c == ':') && ++values > max_values)
      throw SyntaxError(fmt::format("the JSON has more than {} values and names of members", max_values));
    if (opens && ++depth > max_depth)
      throw SyntaxError(fmt::format("the JSON is nested deeper than {} levels", max_depth));
    if (opens) members[depth] = 0;
    if (c == ':' && ++members[depth] > max_members)
      throw SyntaxError(fmt::format("the JSON has an object of more than {} members", max_members));
  }
}

std::optional<ParameterValue> parameter_value(const Json& json) {
  if (json.is_boolean()) return json.get<bool>();
  if (json.is_number_unsigned() && json.get<std::uint64_t>() > std::uint64_t{1} << 62)
    return json.get<double>();
  if (json.is_number_integer()) return json.get<std::int64_t>();
  if (json.is_number()) return json.get<double>();
  if (json.is_string()) return json.get<std::string>();
  return std::nullopt;
}

/// Into options; what is wrong goes to the reader with pointers below /params.
void read_params(ObjectReader& reader, const Json& params, Cells cells, MeshingOptions& options) {
  std::vector<NamedValue> values;
  if (!params.is_object()) return reader.fault("params", "is not an object");
  for (const auto& [name, json] : params.items()) {
    if (json.is_null()) continue;
    if (const auto value = parameter_value(json))
      values.emplace_back(name, *value);
    else
      reader.fault("params/" + name, "is not a number, a string, true or false");
  }
  try {
    set_parameters(options, values, cells);
  } catch (const Error& error) {
    std::vector<ErrorDetail> faults = error.details();
    for (ErrorDetail& detail : faults) detail.pointer = "/params" + detail.pointer;
    if (faults.empty()) faults.push_back({"/params", error.what(), {}, {}});
    reader.take_faults(std::move(faults));
  }
}

SolverOptions read_solver(ObjectReader& parent, const Json& json, const SolverOptions& present) {
  SolverOptions solver = present;
  ObjectReader reader(json, parent.pointer() + "/solver");
  if (const auto volume = reader.choice("volume", {"newton", "scaling", "gradient"}))
    solver.volume = static_cast<VolumeSolver>(*volume);
  if (const auto scope = reader.choice("constraint", {"per_cell", "per_tet"}))
    solver.constraint = static_cast<ConstraintScope>(*scope);
  if (const auto springs = reader.choice("springs", {"auto", "symplectic", "implicit", "energy_momentum"}))
    solver.springs = static_cast<SpringIntegrator>(*springs);
  solver.tolerance = reader.number("tolerance", 1e-12, 1e-1).value_or(solver.tolerance);
  const Json* substeps = reader.member("substeps");
  if (substeps && *substeps == "auto")
    solver.substeps = 0;
  else
    solver.substeps = static_cast<int>(reader.integer("substeps", 0, 1000).value_or(solver.substeps));
  solver.max_iterations =
      static_cast<int>(reader.integer("max_iterations", 1, 10000).value_or(solver.max_iterations));
  reader.finish("solver");
  return solver;
}

MaterialChange read_material(const Json& json, const std::string& pointer) {
  ObjectReader reader(json, pointer);
  MaterialChange change;
  change.body = static_cast<int>(reader.required("body", reader.integer("body", 0, 1000000)));
  SpringSettings& springs = change.springs;
  springs.edge_modulus = reader.number("edge_modulus", 0.0, 1e12);
  springs.diagonal_modulus = reader.number("diagonal_modulus", 0.0, 1e12);
  const auto stiffness = [&](const std::string& name, bool has_modulus) {
    const auto given = reader.number(name, 0.0, 1e12);
    return has_modulus ? given.value_or(0.0) : reader.required(name, given);
  };
  springs.edge_stiffness = stiffness("edge_stiffness", springs.edge_modulus.has_value());
  springs.diagonal_stiffness = stiffness("diagonal_stiffness", springs.diagonal_modulus.has_value());
  springs.damping = reader.number("damping", 0.0, 1e3).value_or(0.0);
  reader.finish("material");
  return change;
}

}  // namespace

Json parse_json(std::string_view text) {
  check_bounds(text);
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    throw SyntaxError(fmt::format("the JSON is malformed at byte {}", error.byte));
  } catch (const Json::out_of_range&) {
    throw SyntaxError("the JSON has a number that is too large");
  }
}

ModelRequest read_model_request(std::string_view text) {
  const Json json = parse_json(text);
  ObjectReader reader(json);
  ModelRequest request;
  request.mesh_id = reader.required("mesh_id", reader.text("mesh_id"));
  if (const auto preset = reader.text("preset")) request.options = preset_options(*preset);
  request.budget_tets = reader.integer("budget_tets", 1, 1000000000);
  if (const Json* params = reader.member("params"))
    read_params(reader, *params, request.budget_tets ? Cells::sought : Cells::given, request.options);
  request.supersedes = reader.text("supersedes");
  const bool preview = reader.choice("quality", {"full", "preview"}).value_or(0) == 1;
  const auto preview_cells = reader.integer("preview_cells", least_preview_cells, most_preview_cells);
  if (preview) request.preview_cells = static_cast<int>(preview_cells.value_or(most_preview_cells));
  request.drawing = reader.boolean("drawing").value_or(false);
  request.dry_run = reader.boolean("dry_run").value_or(false);
  if (preview_cells && !preview)
    reader.fault("preview_cells", "is of previews only: ask for the quality preview, or leave it out");
  if (request.drawing && !preview)
    reader.fault("drawing", "is of previews only: ask for it with the quality preview, or leave it out");
  if (request.drawing && request.dry_run)
    reader.fault("drawing", "stands beside dry_run, which makes no model: leave out one of them");
  reader.finish("model");
  return request;
}

SimulationRequest read_simulation_request(std::string_view text) {
  const Json json = parse_json(text);
  if (!json.is_object() || !json.contains("sample")) return {};
  ObjectReader reader(json);
  SimulationRequest request{reader.text("sample")};
  reader.finish("simulation");
  return request;
}

SimulationChange read_simulation_change(std::string_view text, const SolverOptions& present) {
  const Json json = parse_json(text);
  ObjectReader reader(json);
  SimulationChange change;
  if (const auto state = reader.choice("state", {"paused", "playing"})) change.play = *state == 1;
  change.restart = reader.boolean("restart").value_or(false);
  change.speed = reader.number("speed", 0.01, 100.0);
  if (const auto pace = reader.choice("pace", {"realtime", "fast"})) change.fast = *pace == 1;
  change.gravity = reader.vector("gravity");
  if (const Json* solver = reader.member("solver")) change.solver = read_solver(reader, *solver, present);
  if (const Json* materials = reader.member("materials")) {
    if (!materials->is_array()) reader.fault("materials", "is not a list");
    for (std::size_t i = 0; materials->is_array() && i < materials->size(); ++i)
      change.materials.push_back(read_material((*materials)[i], fmt::format("/materials/{}", i)));
  }
  reader.finish("simulation");
  return change;
}

std::int64_t read_step_count(std::string_view text) {
  if (text.empty()) return 1;
  const Json json = parse_json(text);
  ObjectReader reader(json);
  const std::int64_t count = reader.integer("count", 1, 100000).value_or(1);
  reader.finish("steps");
  return count;
}

Grab read_grab(std::string_view text) {
  const Json json = parse_json(text);
  ObjectReader reader(json);
  Grab grab;
  grab.body = static_cast<int>(reader.integer("body", 0, 1000000).value_or(0));
  grab.vertex = static_cast<std::int32_t>(reader.required("vertex", reader.integer("vertex", 0, INT32_MAX)));
  grab.target = reader.required<Vec3>("target", reader.vector("target"), Vec3::Zero());
  reader.finish("grab");
  return grab;
}

Pose read_pose(std::string_view text) {
  const Json json = parse_json(text);
  ObjectReader reader(json);
  Pose pose;
  pose.position = reader.required<Vec3>("position", reader.vector("position"), Vec3::Zero());
  if (const auto q = reader.numbers("orientation", 4)) {
    pose.orientation = Eigen::Quaterniond((*q)[3], (*q)[0], (*q)[1], (*q)[2]);
    if (const double norm = pose.orientation.norm(); norm > 1e-6 && norm < large)
      pose.orientation.normalize();
    else
      reader.fault("orientation", "is not a rotation");
  }
  if (pose.position.cwiseAbs().maxCoeff() > large) reader.fault("position", "is out of range", -large, large);
  reader.finish("collider");
  return pose;
}

}  // namespace isochor

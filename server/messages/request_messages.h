#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/collision/pose.h"
#include "core/scene/scene.h"
#include "core/scene/simulation.h"
#include "server/messages/json.h"

namespace isochor {

/// JSON bodies become native types at once. All of these throw SyntaxError, and invalid_argument that lists
/// every faulty or unknown field by its pointer.

/// Not JSON at all, where invalid_argument is JSON with faults in it.
class SyntaxError : public Error {
 public:
  explicit SyntaxError(const std::string& what)
      : Error(ErrorCode::cannot_read, what, "send one JSON document") {}
};

/// A document whose depth and number of values are bounded before a tree is built.
Json parse_json(std::string_view text);

struct ModelRequest {
  std::string mesh_id;
  MeshingOptions options;
  std::optional<std::string> supersedes;
  std::optional<std::int64_t> budget_tets;  ///< cells as the lattice that comes closest has them
  std::optional<int> preview_cells;         ///< of a preview: so many along the longest edge at most
  bool drawing = false;                     ///< to come with the answer
  bool dry_run = false;
};
ModelRequest read_model_request(std::string_view text);

/// A scene, or the name of a sample one.
struct SimulationRequest {
  std::optional<std::string> sample;
};
SimulationRequest read_simulation_request(std::string_view text);

struct MaterialChange {
  int body = 0;
  SpringSettings springs;
};
struct SimulationChange {
  std::optional<bool> play;
  bool restart = false;
  std::optional<double> speed;
  std::optional<bool> fast;
  std::optional<Vec3> gravity;
  std::optional<SolverOptions> solver;
  std::vector<MaterialChange> materials;
};
/// Fields of the solver that are absent keep their present values.
SimulationChange read_simulation_change(std::string_view text, const SolverOptions& present);

std::int64_t read_step_count(std::string_view text);
Grab read_grab(std::string_view text);

Pose read_pose(std::string_view text);

}  // namespace isochor

#pragma once
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/common/box.h"
#include "core/common/progress.h"
#include "core/scene/scene.h"
#include "core/scene/snapshot.h"

namespace isochor {

/// One phase of a step: what it is, why it is in or left out, and what it costs.
struct PlannedPhase {
  std::string name;  ///< "contacts", "diagonal_springs", …; the list stands in core/scene/README.md
  bool included = false;
  std::string reason;      ///< one sentence, for both cases
  std::int64_t bytes = 0;  ///< memory held for it; 0 when left out
  double ms = 0.0;         ///< time spent in it so far; 0 when left out
};

/// What viewers need once: the topology of a body.
struct BodyTopology {
  int id = 0;
  std::string name;
  bool deformable = false;
  std::shared_ptr<const TetMesh> mesh;  ///< deformable
  std::vector<Vec3> rest_positions;     ///< in the world at rest, double precision
  std::vector<double> masses;           ///< a particle
  std::shared_ptr<const Model> model;   ///< when made from a mesh: its soup and embedding
  std::optional<RigidShape> shape;      ///< rigid
  std::optional<Box> bounds;            ///< rigid, but for a plane: in its own frame
  double scale = 1.0;
};

struct Grab {
  int body = 0;
  std::int32_t vertex = 0;
  Vec3 target = Vec3::Zero();
};

/// A compiled scene that steps. Owned by one thread.
class Simulation {
 public:
  virtual ~Simulation() = default;

  /// Frame 0: the start as given.
  virtual Snapshot snapshot() const = 0;
  /// Advances by one frame (1/frame_rate) with as many substeps as needed. Never throws for physical reasons:
  /// what could not be met stands in the metrics. Throws cancelled.
  virtual Snapshot step(const Progress& progress) = 0;
  /// The same without the snapshot: once warm, a compiled scene allocates nothing here.
  virtual void advance(const Progress& progress) { step(progress); }
  virtual bool finished() const = 0;
  /// Goes on from where another run stands, of a scene whose bodies may be others: time and frames count on,
  /// and bodies of the same name keep their motion; those without mass stand as this scene has them.
  virtual void continue_from(const Simulation& before) = 0;

  virtual const Scene& scene() const = 0;
  virtual std::vector<PlannedPhase> plan() const = 0;
  virtual std::vector<BodyTopology> topology() const = 0;

  /// Live changes, taken at the next step. A grab pulls a surface vertex towards the target; nullopt
  /// releases.
  virtual void grab(std::optional<Grab> grab) = 0;
  /// Teleports a kinematic body, or gives it a new pose to move to within the next frame.
  virtual void move_body(int body, const Vec3& position, const Eigen::Quaterniond& orientation) = 0;
  virtual void set_gravity(const Vec3& gravity) = 0;
  virtual void set_solver(const SolverOptions& solver) = 0;
  virtual void set_material(int body, const SpringSettings& springs) = 0;
};

/// Builds only the phases that the scene uses. Meshes are read and meshed here; a progress is worth having.
/// Throws invalid_argument, cannot_read, empty_result, over_budget, cancelled.
std::unique_ptr<Simulation> compile(const Scene& scene, Progress& progress);

}  // namespace isochor

#pragma once
#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/dynamics/masses.h"
#include "core/pipeline/pipeline.h"
#include "core/rigid/motion.h"

namespace isochor {

/// A scene as data: what one JSON file says. Metres, kilograms, seconds, N/m. core/scene/read_scene.h reads
/// it, core/scene/compile.h turns it into a Simulation.

enum class VolumeSolver { newton, scaling, gradient };
enum class ConstraintScope { per_cell, per_tet };
enum class SpringIntegrator { automatic, symplectic, implicit, energy_momentum };

struct SolverOptions {
  VolumeSolver volume = VolumeSolver::newton;
  ConstraintScope constraint = ConstraintScope::per_cell;
  double tolerance = 1e-6;  ///< largest relative volume error of a cell, 1e-12 to 1e-1
  SpringIntegrator springs = SpringIntegrator::automatic;
  int substeps = 0;  ///< a frame; 0: as many as stability asks for
  int max_iterations = 40;
};

struct AxisBox {
  Vec3 min = Vec3::Constant(-1e300), max = Vec3::Constant(1e300);
  bool contains(const Vec3& p) const {
    return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
  }
};

/// How a deformable body starts, applied in this order to its rest shape about its centre of mass.
struct StartState {
  Eigen::Matrix3d affine = Eigen::Matrix3d::Identity();
  double twist_deg = 0.0;  ///< about y, over the height
  bool invert = false;     ///< mirrored in x
  enum class Flatten { none, plane, line, point } flatten = Flatten::none;
  double randomize = 0.0;  ///< each particle moved by up to ±r·cell_size an axis
  std::uint64_t seed = 1;
};

struct LatticeShape {
  Vec3i cells = Vec3i::Constant(8);
  double cell_size = 0.125;
  Vec3 origin = Vec3::Zero();  ///< lowest corner
};
struct MeshShape {
  std::filesystem::path file;  ///< absolute, or relative to the scene file's folder
  MeshingOptions meshing;
};
/// A model made before, by the server or a caller; not in files.
struct ModelShape {
  std::shared_ptr<const Model> model;
};

struct DensityRegion {
  AxisBox inside;
  double density = 1000.0;
};

/// Of a body's springs: a stiffness each, or a modulus, which does not change with the resolution.
struct SpringSettings {
  double edge_stiffness = 1e4, diagonal_stiffness = 1e3;  ///< N/m a spring; shared edges add
  std::optional<double> edge_modulus, diagonal_modulus;   ///< Pa; k = E·cell_size, overrides the stiffness
  double damping = 0.0;  ///< seconds: force −damping·k·(rate of length change)
};

struct DeformableBody : SpringSettings {
  std::variant<LatticeShape, MeshShape, ModelShape> shape;
  double density = 1000.0;  ///< kg/m³
  std::vector<DensityRegion> densities;
  MassLumping masses = MassLumping::lumped;
  bool self_contact = false;
  StartState start;
};

struct PlaneShape {
  Vec3 normal = Vec3::UnitY();
  double offset = 0.0;
};
struct SphereShape {
  double radius = 0.5;
};
struct BoxShape {
  Vec3 half_extents = Vec3::Constant(0.5);
};
struct CapsuleShape {
  double radius = 0.25, half_height = 0.5;
};  ///< along y
using RigidShape = std::variant<PlaneShape, SphereShape, BoxShape, CapsuleShape, MeshShape, ModelShape>;

struct RigidBody {
  RigidShape shape;
  bool is_static = false;
  std::optional<double> mass;  ///< absent: static or moved by `motion`
  std::optional<Motion> motion;
};

struct SceneBody {
  std::string name;
  std::variant<DeformableBody, RigidBody> kind;
  Vec3 position = Vec3::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  double scale = 1.0;
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();
  double friction = 0.3, restitution = 0.0;
};

/// Particles inside the box (world coordinates at the start) are held in place, or attached to a rigid body.
struct Pin {
  std::string body;
  AxisBox inside;
  std::optional<std::string> to;
};

enum class JointType { ball, hinge, fixed };
struct Joint {
  JointType type = JointType::ball;
  std::string a, b;
  Vec3 anchor = Vec3::Zero(), axis = Vec3::UnitY();  ///< world coordinates at the start
};

struct Scene {
  std::string name;
  std::optional<double> duration = 2.0;  ///< seconds; nullopt runs until stopped
  double frame_rate = 60.0;
  Vec3 gravity = Vec3(0.0, -9.81, 0.0);
  SolverOptions solver;
  std::vector<SceneBody> bodies;
  std::vector<Pin> pins;
  std::vector<Joint> joints;
};

}  // namespace isochor

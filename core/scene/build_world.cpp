#include "core/scene/build_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "core/collision/mesh_shape.h"
#include "core/mesh_input/read_mesh.h"
#include "core/parallel/cancel_scope.h"
#include "core/scene/memory_estimate.h"
#include "core/scene/start_state.h"
#include "core/scene/surface_collision.h"

namespace isochor {
namespace {

constexpr std::int64_t max_bytes = std::int64_t{8} << 30;

void check_budget(const std::string& name, const LatticeShape& shape) {
  const std::int64_t cells = std::int64_t{shape.cells.x()} * shape.cells.y() * shape.cells.z();
  if (cells <= max_bytes / bytes_a_cell) return;
  throw Error(ErrorCode::over_budget,
              fmt::format("the body {} has {} cells, which take about {} GiB", name, cells,
                          cells * bytes_a_cell >> 30),
              fmt::format("at most {} cells fit into {} GiB", max_bytes / bytes_a_cell, max_bytes >> 30));
}

class SoftBodyBuilder {
 public:
  SoftBodyBuilder(const SceneBody& source, Progress& progress)
      : source_(source), deformable_(std::get<DeformableBody>(source.kind)), progress_(progress) {}

  SceneSoftBody build() {
    std::visit([&](const auto& shape) { take_shape(shape); }, deformable_.shape);
    SoftBody& body = soft_.body;
    throw_if_scope_cancelled();
    place_at_rest();
    body.masses = particle_masses(*body.mesh, body.rest_volumes, densities(), deformable_.masses);
    body.total_mass = std::accumulate(body.masses.begin(), body.masses.end(), 0.0);
    for (const double mass : body.masses) body.inverse_masses.push_back(1.0 / mass);
    body.material = spring_material(deformable_, body.cell_size);
    body.friction = source_.friction;
    body.restitution = source_.restitution;
    throw_if_scope_cancelled();
    find_surface();
    throw_if_scope_cancelled();
    body.positions = start_positions(body, deformable_.start);
    body.velocities = start_velocities(body, source_.velocity, source_.angular_velocity);
    throw_if_scope_cancelled();
    body.start_positions = body.positions;
    body.start_velocities = body.velocities;
    return std::move(soft_);
  }

 private:
  void take_shape(const LatticeShape& shape) {
    check_budget(source_.name, shape);
    soft_.body.mesh = std::make_shared<TetMesh>(make_box_lattice(shape.cells, shape.cell_size, shape.origin));
  }
  void take_shape(const MeshShape& shape) {
    auto soup = std::make_shared<TriangleSoup>(read_mesh(shape.file, progress_));
    take_model(AuthoringPipeline(std::move(soup)).run(shape.meshing, progress_));
  }
  void take_shape(const ModelShape& shape) { take_model(shape.model); }
  void take_model(std::shared_ptr<const Model> model) {
    soft_.body.mesh = std::shared_ptr<const TetMesh>(model, &model->mesh());
    soft_.model = std::move(model);
  }

  void place_at_rest() {
    SoftBody& body = soft_.body;
    body.cell_size = source_.scale * body.mesh->grid.spacing;
    for (const Vec3& p : body.mesh->positions)
      body.rest_positions.push_back(source_.position + source_.orientation * (source_.scale * p));
    body.rest_volumes = cell_volumes(*body.mesh, body.rest_positions);
    body.rest_volume = std::accumulate(body.rest_volumes.begin(), body.rest_volumes.end(), 0.0);
  }

  /// Of each cell: that of the last region which holds its centre.
  std::vector<double> densities() const {
    const SoftBody& body = soft_.body;
    std::vector<double> densities(body.mesh->cells.size(), deformable_.density);
    for (std::size_t c = 0; c < densities.size(); ++c) {
      Vec3 center = Vec3::Zero();
      for (const auto i : body.mesh->cells[c].corners) center += body.rest_positions[i] / 8.0;
      for (const DensityRegion& region : deformable_.densities)
        if (region.inside.contains(center)) densities[c] = region.density;
    }
    return densities;
  }

  void find_surface() {
    SoftBody& body = soft_.body;
    for (const Triangle& t : body.mesh->surface)
      body.surface_particles.insert(body.surface_particles.end(), t.begin(), t.end());
    std::sort(body.surface_particles.begin(), body.surface_particles.end());
    body.surface_particles.erase(std::unique(body.surface_particles.begin(), body.surface_particles.end()),
                                 body.surface_particles.end());
  }

  const SceneBody& source_;
  const DeformableBody& deformable_;
  Progress& progress_;
  SceneSoftBody soft_;
};

/// Shapes of the scene as collisions know them.
struct ShapeMaker {
  double scale;
  bool centered;  ///< meshes, on their centre of mass
  Progress& progress;

  std::unique_ptr<CollisionShape> operator()(const PlaneShape& s) const {
    return make_plane(s.normal, s.offset);
  }
  std::unique_ptr<CollisionShape> operator()(const SphereShape& s) const {
    return make_sphere(scale * s.radius);
  }
  std::unique_ptr<CollisionShape> operator()(const BoxShape& s) const {
    return make_box(scale * s.half_extents);
  }
  std::unique_ptr<CollisionShape> operator()(const CapsuleShape& s) const {
    return make_capsule(scale * s.radius, scale * s.half_height);
  }
  std::unique_ptr<CollisionShape> operator()(const MeshShape& s) const {
    const TriangleSoup soup = read_mesh(s.file, progress);
    const DistanceFieldOptions options{s.meshing.voxels, field_padding};
    const DistanceField field = make_distance_field(soup, options, progress);
    const PseudoVolume pseudo_volume = make_pseudo_volume(field, s.meshing.pseudo_volume, progress);
    return std::make_unique<CollisionMesh>(field, pseudo_volume, scale, centered);
  }
  std::unique_ptr<CollisionShape> operator()(const ModelShape& s) const {
    return std::make_unique<CollisionMesh>(*s.model->field, *s.model->pseudo_volume, scale, centered);
  }
};

void add_rigid(World& world, const SceneBody& source, int id, Progress& progress) {
  const auto& rigid = std::get<RigidBody>(source.kind);
  RigidBodyDesc desc;
  desc.shape = std::visit(ShapeMaker{source.scale, rigid.mass.has_value(), progress}, rigid.shape);
  const auto* mesh = dynamic_cast<const CollisionMesh*>(desc.shape.get());
  const Vec3 center = mesh ? mesh->center() : Vec3(Vec3::Zero());
  desc.pose = {source.position + source.orientation * center, source.orientation};
  desc.mass = rigid.mass;
  desc.motion = rigid.motion;
  desc.velocity = source.velocity;
  desc.angular_velocity = source.angular_velocity;
  desc.friction = source.friction;
  desc.restitution = source.restitution;
  world.rigid.add_body(desc);
  world.rigid_ids.push_back(id);
  world.rigid_centers.push_back(center);
}

int find_body(const Scene& scene, const std::string& name) {
  const auto found = std::ranges::find(scene.bodies, name, &SceneBody::name);
  if (found == scene.bodies.end())
    throw Error(ErrorCode::invalid_argument, fmt::format("no body is named {}", name),
                "name one of the scene's bodies");
  return static_cast<int>(found - scene.bodies.begin());
}

/// A rigid body's number in the RigidWorld.
int find_rigid(const World& world, const std::string& name) {
  const auto found = std::ranges::find(world.rigid_ids, find_body(world.scene, name));
  if (found == world.rigid_ids.end())
    throw Error(ErrorCode::invalid_argument, fmt::format("{} is not a rigid body", name),
                "name one of the scene's rigid bodies");
  return static_cast<int>(found - world.rigid_ids.begin());
}

void add_joint(World& world, const Joint& joint) {
  constexpr std::array kinds{JointKind::ball, JointKind::hinge, JointKind::fixed};
  world.rigid.add_joint({kinds[static_cast<std::size_t>(joint.type)], find_rigid(world, joint.a),
                         find_rigid(world, joint.b), joint.anchor, joint.axis});
}

void add_pins(World& world, const Pin& pin) {
  const int id = find_body(world.scene, pin.body);
  const int rigid = pin.to ? find_rigid(world, *pin.to) : -1;
  const auto soft = std::ranges::find(world.soft, id, &SceneSoftBody::id);
  if (soft == world.soft.end())
    throw Error(ErrorCode::invalid_argument, fmt::format("{} is not a deformable body", pin.body));
  SoftBody& body = soft->body;
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Vec3 p = body.positions.at(i);
    if (!pin.inside.contains(p) || body.inverse_masses[i] == 0.0) continue;
    const bool carried = rigid >= 0 && world.rigid.dynamic(rigid);
    (carried ? soft->attachments : soft->pins)
        .push_back(
            {static_cast<std::int32_t>(i), rigid, rigid < 0 ? p : world.rigid.pose(rigid).to_local(p)});
    if (carried) continue;
    body.inverse_masses[i] = 0.0;
    body.has_pins = true;
    body.velocities.set(i, Vec3::Zero());
  }
}

}  // namespace

SpringMaterial spring_material(const SpringSettings& springs, double cell_size) {
  const auto stiffness = [&](const std::optional<double>& modulus, double given) {
    return modulus ? *modulus * cell_size : given;
  };
  return {stiffness(springs.edge_modulus, springs.edge_stiffness),
          stiffness(springs.diagonal_modulus, springs.diagonal_stiffness), springs.damping};
}

void build_springs(SceneSoftBody& soft) {
  SoftBody& body = soft.body;
  body.springs = make_spring_stencil(*body.mesh, body.rest_positions, body.material);
  const bool springs = !body.springs.edges.empty() || !body.springs.diagonals.empty();
  soft.forces_valid = false;
  soft.implicit.reset();
  body.forces = springs ? Coordinates(body.size()) : Coordinates();
}

void build_projector(SceneSoftBody& soft, const SolverOptions& solver) {
  SoftBody& body = soft.body;
  const bool per_tet = solver.constraint == ConstraintScope::per_tet;
  VolumeModel model{body.mesh.get(),
                    per_tet ? tet_volumes(*body.mesh, body.rest_positions) : body.rest_volumes,
                    body.inverse_masses, per_tet};
  switch (solver.volume) {
    case VolumeSolver::newton:
      body.projector = make_newton_projector(std::move(model));
      break;
    case VolumeSolver::scaling:
      body.projector = make_scaling_projector(std::move(model));
      break;
    case VolumeSolver::gradient:
      body.projector = make_gradient_projector(std::move(model));
      break;
  }
}

World build_world(const Scene& scene, Progress& progress) {
  World world;
  world.scene = scene;
  world.rigid.set_gravity(scene.gravity);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    progress.throw_if_cancelled();
    const int id = static_cast<int>(i);
    if (std::holds_alternative<RigidBody>(scene.bodies[i].kind)) {
      add_rigid(world, scene.bodies[i], id, progress);
    } else {
      world.soft.push_back(SoftBodyBuilder(scene.bodies[i], progress).build());
      world.soft.back().id = id;
    }
  }
  for (const Pin& pin : scene.pins) add_pins(world, pin);
  for (const Joint& joint : scene.joints) add_joint(world, joint);
  for (SceneSoftBody& soft : world.soft) {
    build_springs(soft);
    throw_if_scope_cancelled();
    build_projector(soft, scene.solver);
    throw_if_scope_cancelled();
    soft.tets = std::make_unique<TetInequality>(soft.body);
    if (world.rigid.size() > 0) {
      soft.contacts = std::make_unique<ParticleContacts>(soft.body);
      soft.candidates = std::make_unique<ContactCandidates>(soft.body.size());
    }
  }
  const auto meets_itself = [](const SceneBody& body) {
    const auto* deformable = std::get_if<DeformableBody>(&body.kind);
    return deformable && deformable->self_contact;
  };
  if (world.soft.size() > 1 || std::ranges::any_of(scene.bodies, meets_itself))
    world.surfaces = std::make_unique<SurfaceCollision>(world);
  return world;
}

}  // namespace isochor

// A soft cube dropped on a sphere: Bullet's soft body against ours, from the same lattice, masses and step,
// each on one thread. Compare the times at the cell error that each reaches (counter max_cell_error); the
// ratio is meant, not the seconds.
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <benchmark/benchmark.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <set>

#include "core/dynamics/cell_volume.h"
#include "core/parallel/parallel.h"
#include "core/scene/simulation.h"

namespace isochor {
namespace {

constexpr int frames = 60;
constexpr double density = 1000.0, size = 1.0, height = 0.6, radius = 0.5, h = 1.0 / 60.0;

double largest_cell_error(const TetMesh& mesh, const std::vector<Vec3>& positions) {
  const double rest = std::pow(mesh.grid.spacing, 3);
  double largest = 0.0;
  for (const Cell& cell : mesh.cells) {
    CellCorners corners;
    for (int b = 0; b < 8; ++b) corners[b] = positions[cell.corners[b]];
    largest = std::max(largest, std::abs(cell_volume(corners, cell.parity()) - rest) / rest);
  }
  return largest;
}

TetMesh drop_cube(int n) {
  return make_box_lattice(Vec3i::Constant(n), size / n, Vec3(-0.5 * size, height, -0.5 * size));
}

/// Bullet's world with one soft body of links (merged edges and space diagonals) that keeps its total volume.
struct BulletDrop {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  btSphereShape sphere{static_cast<btScalar>(radius)};
  btRigidBody ball{0.0F, nullptr, &sphere};
  btSoftBody* body = nullptr;

  BulletDrop(const TetMesh& mesh, int iterations) {
    world.setGravity(btVector3(0, static_cast<btScalar>(-9.81), 0));
    world.getWorldInfo().m_gravity = world.getGravity();
    world.addRigidBody(&ball);
    std::vector<btVector3> nodes;
    for (const Vec3& p : mesh.positions)
      nodes.emplace_back(static_cast<btScalar>(p.x()), static_cast<btScalar>(p.y()),
                         static_cast<btScalar>(p.z()));
    body = new btSoftBody(&world.getWorldInfo(), static_cast<int>(nodes.size()), nodes.data(), nullptr);
    btSoftBody::Material* material = body->appendMaterial();
    material->m_kLST = 1;
    std::set<std::pair<int, int>> links;
    for (const Cell& cell : mesh.cells)
      for (int a = 0; a < 8; ++a)
        for (int b = a + 1; b < 8; ++b) {
          const int differ = a ^ b;
          if (differ == 1 || differ == 2 || differ == 4 || differ == 7)
            links.emplace(std::minmax(cell.corners[a], cell.corners[b]));
        }
    for (const auto& [a, b] : links) body->appendLink(a, b, material);
    for (const Triangle& t : mesh.surface) body->appendFace(t[0], t[1], t[2]);
    body->setTotalMass(static_cast<btScalar>(density * size * size * size));
    body->setPose(true, false);
    body->m_cfg.kVC = 20;
    body->m_cfg.piterations = iterations;
    world.addSoftBody(body);
  }
  ~BulletDrop() {
    world.removeSoftBody(body);
    world.removeRigidBody(&ball);
    delete body;
  }
  BulletDrop(const BulletDrop&) = delete;
  BulletDrop& operator=(const BulletDrop&) = delete;
};

void bullet_drop(benchmark::State& state) {
  const TetMesh mesh = drop_cube(static_cast<int>(state.range(0)));
  double largest = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    BulletDrop drop(mesh, static_cast<int>(state.range(1)));
    std::vector<Vec3> positions(mesh.positions.size());
    state.ResumeTiming();
    for (int frame = 0; frame < frames; ++frame) {
      drop.world.stepSimulation(static_cast<btScalar>(h), 0);
      state.PauseTiming();
      for (int i = 0; i < drop.body->m_nodes.size(); ++i) {
        const btVector3& x = drop.body->m_nodes[i].m_x;
        positions[i] = Vec3(x.x(), x.y(), x.z());
      }
      largest = std::max(largest, largest_cell_error(mesh, positions));
      state.ResumeTiming();
    }
  }
  state.counters["max_cell_error"] = largest;
}

void isochor_drop(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  Scene scene;
  scene.duration = frames * h;
  scene.solver.tolerance = std::pow(10.0, -static_cast<double>(state.range(1)));
  SceneBody cube, ball;
  DeformableBody body;
  body.shape = LatticeShape{Vec3i::Constant(n), size / n, Vec3(-0.5 * size, height, -0.5 * size)};
  body.masses = MassLumping::equal;
  body.edge_stiffness = body.diagonal_stiffness = 1e5 * size / n / 4.0;  // four cells share an inner edge
  cube.name = "cube", cube.kind = body;
  RigidBody sphere;
  sphere.shape = SphereShape{radius};
  sphere.is_static = true;
  ball.name = "ball", ball.kind = sphere;
  scene.bodies = {cube, ball};
  double largest = 0.0;
  Progress quiet;
  set_thread_count(1);
  for (auto _ : state) {
    state.PauseTiming();
    const auto simulation = compile(scene, quiet);
    state.ResumeTiming();
    for (int frame = 0; frame < frames; ++frame)
      largest = std::max(largest, simulation->step(quiet).metrics.max_cell_volume_error);
  }
  set_thread_count(0);
  state.counters["max_cell_error"] = largest;
}

BENCHMARK(bullet_drop)
    ->ArgNames({"n", "passes"})
    ->ArgsProduct({{8, 16}, {1, 8, 64}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(isochor_drop)
    ->ArgNames({"n", "digits"})
    ->ArgsProduct({{8, 16}, {2, 3, 6, 9}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace isochor

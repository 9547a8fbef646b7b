#include <gtest/gtest.h>

#include <random>

#include "core/dynamics/masses.h"
#include "core/dynamics/volume_projector.h"

namespace isochor {
namespace {

struct Body {
  explicit Body(const Vec3i& cells = {4, 4, 4}) : mesh(make_box_lattice(cells, 0.25, Vec3(1, 2, 3))) {}

  TetMesh mesh;
  std::vector<double> volumes = cell_volumes(mesh, mesh.positions);
  std::vector<double> masses =
      particle_masses(mesh, volumes, std::vector<double>(volumes.size(), 1000.0), MassLumping::lumped);

  VolumeModel model(bool per_tet = false) const {
    VolumeModel model{&mesh, per_tet ? tet_volumes(mesh, mesh.positions) : volumes, {}, per_tet};
    for (const double mass : masses) model.inverse_masses.push_back(1.0 / mass);
    return model;
  }
  Coordinates shaken(double amount) const {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> noise(-amount, amount);
    Coordinates x(mesh.positions);
    for (std::size_t i = 0; i < x.size(); ++i) x.add(i, {noise(random), noise(random), noise(random)});
    return x;
  }
  Vec3 center(const Coordinates& x) const {
    Vec3 sum = Vec3::Zero();
    double mass = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += masses[i] * x.at(i), mass += masses[i];
    return sum / mass;
  }
};

std::vector<Vec3> points(const Coordinates& x) {
  std::vector<Vec3> list;
  for (std::size_t i = 0; i < x.size(); ++i) list.push_back(x.at(i));
  return list;
}

using Factory = std::unique_ptr<VolumeProjector> (*)(VolumeModel);
struct Case {
  const char* name;
  Factory make;
  bool per_tet;
};
void PrintTo(const Case& solver, std::ostream* out) {
  *out << solver.name;
}
class Sweeps : public testing::TestWithParam<Case> {};

TEST_P(Sweeps, EveryElementGetsItsVolumeAndTheCentreStays) {
  const auto [name, make, per_tet] = GetParam();
  const Body body(per_tet ? Vec3i(1, 1, 1) : Vec3i(4, 4, 4));  // more tets lock
  const auto projector = make(body.model(per_tet));
  const Coordinates start(body.mesh.positions);
  Coordinates x = body.shaken(0.02);
  const Vec3 center = body.center(x);
  ProjectionRequest request{&start};
  request.tolerance = 1e-9;
  request.max_iterations = 200;
  const ProjectionResult result = projector->project(request, x);
  EXPECT_TRUE(result.converged);
  const auto volumes = per_tet ? tet_volumes(body.mesh, points(x)) : cell_volumes(body.mesh, points(x));
  const auto rest = body.model(per_tet).rest_volumes;
  for (std::size_t e = 0; e < rest.size(); ++e) EXPECT_NEAR(volumes[e] / rest[e], 1.0, 1.01e-9);
  EXPECT_LT((body.center(x) - center).norm(), 1e-13);
}

INSTANTIATE_TEST_SUITE_P(Solvers, Sweeps,
                         testing::Values(Case{"gradient, per cell", make_gradient_projector, false},
                                         Case{"scaling, per cell", make_scaling_projector, false},
                                         Case{"gradient, per tet", make_gradient_projector, true},
                                         Case{"scaling, per tet", make_scaling_projector, true}));

Vec3 angular_moment(const Body& body, const Coordinates& start, const Coordinates& from,
                    const Coordinates& to) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < start.size(); ++i)
    sum += body.masses[i] * start.at(i).cross(to.at(i) - from.at(i));
  return sum;
}

TEST(GradientSweeps, DirectionsOfTheStartKeepAngularMomentum) {
  const Body body;
  const auto projector = make_gradient_projector(body.model());
  const Coordinates start(body.mesh.positions), before = body.shaken(0.01);
  Coordinates x = before;
  ProjectionRequest request{&start};
  request.max_iterations = 100;
  const ProjectionResult result = projector->project(request, x);
  EXPECT_TRUE(result.converged);
  EXPECT_TRUE(result.kept_directions);
  EXPECT_LT(angular_moment(body, start, before, x).norm(), 1e-11);
}

TEST(GradientSweeps, ABlockedParticleKeepsItsCoordinateAndTellsTheForceOnIt) {
  const Body body;
  const auto projector = make_gradient_projector(body.model());
  const Coordinates start(body.mesh.positions);
  Coordinates x = body.shaken(0.01);
  std::vector<BlockedParticle> blocked;
  std::vector<double> heights;
  for (std::int32_t i = 0; i < 25; ++i) {
    blocked.push_back({i, Vec3(1.0, 1.0, 0.0).asDiagonal() * Eigen::Matrix3d::Identity() / body.masses[i]});
    heights.push_back(x.z[i]);
  }
  std::vector<Vec3> forces(blocked.size());
  const Vec3 center = body.center(x);
  ProjectionRequest request{&start, blocked, forces};
  request.max_iterations = 200;
  EXPECT_TRUE(projector->project(request, x).converged);
  double pressed = 0.0, mass = 0.0;
  for (std::size_t b = 0; b < blocked.size(); ++b) {
    EXPECT_EQ(x.z[b], heights[b]);
    pressed += forces[b].z();
  }
  for (const double m : body.masses) mass += m;
  // What the volume would have moved the blocked particles by, it has moved the centre of mass by instead.
  EXPECT_NEAR((body.center(x) - center).z() * mass, -pressed, 1e-12 * mass);
  EXPECT_GT(std::abs(pressed), 1e-6);
}

TEST(GradientSweeps, ACarrierMovesSoThatMomentumIsKept) {
  const Body body;
  const auto projector = make_gradient_projector(body.model());
  const Coordinates start(body.mesh.positions);
  Coordinates x = body.shaken(0.01);
  std::vector<BlockedParticle> blocked;
  std::vector<CarriedParticle> carried;
  const double mass = 20.0;
  Eigen::Matrix<double, 6, 6> inertia = Eigen::Matrix<double, 6, 6>::Identity() * mass;
  for (std::int32_t i = 0; i < 25; ++i) {
    blocked.push_back({i, Vec3(1.0, 1.0, 0.0).asDiagonal() * Eigen::Matrix3d::Identity() / body.masses[i]});
    CarriedParticle particle{i, Eigen::Matrix<double, 3, 6>::Zero()};
    const Vec3 r = start.at(i) - Vec3(1.5, 2.5, 2.0);
    particle.map.row(2) << 0.0, 0.0, 1.0, r.y(), -r.x(), 0.0;
    inertia += particle.map.transpose() * body.masses[i] * particle.map;
    carried.push_back(particle);
  }
  std::vector<RigidCarrier> carriers{{carried, inertia.inverse()}};
  const Vec3 center = body.center(x);
  double total = 0.0;
  for (const double m : body.masses) total += m;
  ProjectionRequest request{&start, blocked};
  request.carriers = carriers;
  request.max_iterations = 200;
  EXPECT_TRUE(projector->project(request, x).converged);
  const double rigid = mass * carriers[0].motion[2];
  EXPECT_GT(std::abs(rigid), 1e-6);
  EXPECT_NEAR((body.center(x) - center).z() * total, -rigid, 1e-12 * total);
}

TEST(SweepProjectors, ACellOfPinnedParticlesIsReportedNotMoved) {
  const TetMesh mesh = make_box_lattice({1, 1, 1}, 1.0, Vec3::Zero());
  for (const Factory make : {make_gradient_projector, make_scaling_projector}) {
    const auto projector = make({&mesh, {2.0}, std::vector<double>(8, 0.0), false});
    Coordinates x(mesh.positions);
    const ProjectionResult result = projector->project({}, x);
    EXPECT_FALSE(result.converged);
    EXPECT_EQ(result.rowless_cells, 1);
    EXPECT_EQ(result.worst_cell, 0);
    EXPECT_DOUBLE_EQ(result.max_error, 0.5);
    EXPECT_EQ(points(x), mesh.positions);
  }
}

}  // namespace
}  // namespace isochor

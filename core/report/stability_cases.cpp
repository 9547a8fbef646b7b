#include <cmath>

#include "core/report/stability.h"

namespace isochor {
namespace {

DeformableBody cube(int cells, double size) {
  DeformableBody body;
  body.shape = LatticeShape{Vec3i::Constant(cells), size / cells, Vec3::Constant(-0.5 * size)};
  return body;
}

SceneBody placed(std::string name, std::variant<DeformableBody, RigidBody> kind, const Vec3& position) {
  SceneBody body;
  body.name = std::move(name);
  body.kind = std::move(kind);
  body.position = position;
  return body;
}

RigidBody fixed(RigidShape shape) {
  RigidBody body;
  body.shape = std::move(shape);
  body.is_static = true;
  return body;
}

RigidBody moving(RigidShape shape, const Vec3& velocity, double until) {
  RigidBody body;
  body.shape = std::move(shape);
  body.motion = Motion{velocity, Vec3::Zero(), until, {}};
  return body;
}

Scene free_flight(DeformableBody body, double duration) {
  Scene scene;
  scene.name = "free flight";
  scene.gravity = Vec3::Zero();
  scene.duration = duration;
  scene.bodies.push_back(placed("cube", std::move(body), Vec3::Zero()));
  return scene;
}

Scene on_the_ground(DeformableBody body, double height, double duration) {
  Scene scene;
  scene.name = "on the ground";
  scene.duration = duration;
  scene.bodies.push_back(placed("cube", std::move(body), Vec3(0.0, height, 0.0)));
  scene.bodies.push_back(placed("ground", fixed(PlaneShape{}), Vec3::Zero()));
  return scene;
}

StabilityCase make_case(std::string group, std::string name, Scene scene) {
  StabilityCase test;
  test.group = std::move(group), test.name = std::move(name), test.scene = std::move(scene);
  return test;
}

std::string power(double value) {
  if (value == 0.0) return "0";
  return "1e" + std::to_string(static_cast<int>(std::lround(std::log10(value))));
}

/// Released stretched by 5 % at constant volume, stiffness on the edges, on the diagonals, or on both.
void add_stiffness_map(std::vector<StabilityCase>& cases, StabilityExtent extent) {
  const bool full = extent == StabilityExtent::full;
  const std::vector<double> stiffness =
      full ? std::vector<double>{0, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12}
           : std::vector<double>{0, 1e2, 1e4, 1e6, 1e8, 1e10, 1e12};
  const std::vector<double> steps{1e-5, 1e-4, 1e-3, 1.0 / 60.0, 0.1};
  for (double k : stiffness)
    for (double h : steps)
      for (int which = 0; which < (full ? 3 : 1); ++which) {
        DeformableBody body = cube(full ? 4 : 3, 1.0);
        body.edge_stiffness = which == 1 ? 0.0 : k;
        body.diagonal_stiffness = which == 0 ? 0.0 : k;
        body.start.affine = Vec3(1.05, 1.0 / std::sqrt(1.05), 1.0 / std::sqrt(1.05)).asDiagonal();
        Scene scene = free_flight(std::move(body), 30.0 * h);
        scene.frame_rate = 1.0 / h;
        const char* springs[] = {"edges", "diagonals", "both"};
        StabilityCase test = make_case("stiffness",
                                       std::string(springs[which]) + " k = " + power(k) +
                                           ", h = " + (h == 1.0 / 60.0 ? "1/60" : power(h)),
                                       std::move(scene));
        test.stiffness = k, test.h = h;
        cases.push_back(std::move(test));
      }
}

void add_starts(std::vector<StabilityCase>& cases) {
  const auto add = [&](const char* name, const auto& change) {
    DeformableBody body = cube(4, 1.0);
    change(body.start);
    StabilityCase test = make_case("start", name, free_flight(std::move(body), 1.0));
    test.feasible_start = false;
    cases.push_back(std::move(test));
  };
  add("randomised by a whole cell", [](StartState& s) { s.randomize = 1.0; });
  add("inverted", [](StartState& s) { s.invert = true; });
  add("flattened to a plane", [](StartState& s) { s.flatten = StartState::Flatten::plane; });
  add("flattened to a line", [](StartState& s) { s.flatten = StartState::Flatten::line; });
  add("flattened to a point", [](StartState& s) { s.flatten = StartState::Flatten::point; });
  add("twisted by 360 degrees", [](StartState& s) { s.twist_deg = 360.0; });
  add("squashed to half its height", [](StartState& s) { s.affine(1, 1) = 0.5; });
}

void add_masses(std::vector<StabilityCase>& cases) {
  for (double ratio : {1e3, 1e6}) {
    DeformableBody body = cube(4, 1.0);
    AxisBox top;
    top.min.y() = 0.0;
    body.density = 1000.0 / std::sqrt(ratio);
    body.densities.push_back({top, 1000.0 * std::sqrt(ratio)});
    cases.push_back(make_case("masses", "heavy top, ratio " + power(ratio), on_the_ground(body, 0.6, 1.0)));
  }
  DeformableBody light = cube(4, 1.0);
  light.density = 1.0;
  Scene scene = on_the_ground(light, 0.5, 1.0);
  RigidBody heavy;
  heavy.shape = BoxShape{Vec3(0.6, 0.1, 0.6)};
  heavy.mass = 1e6;
  scene.gravity = Vec3::Zero();
  scene.bodies.push_back(placed("anvil", heavy, Vec3(0.0, 1.2, 0.0)));
  scene.bodies.back().velocity = Vec3(0.0, -0.1, 0.0);
  cases.push_back(make_case("masses", "a body a million times heavier", std::move(scene)));
}

void add_impacts(std::vector<StabilityCase>& cases) {
  const auto add = [&](const char* name, RigidShape shape, double stops_at) {
    Scene scene;
    scene.name = name;
    scene.duration = 0.5;
    scene.bodies.push_back(placed("cube", cube(4, 1.0), Vec3(0.0, 2.0, 0.0)));
    scene.bodies.back().velocity = Vec3(0.0, -100.0, 0.0);
    scene.bodies.push_back(placed("target", fixed(std::move(shape)), Vec3::Zero()));
    StabilityCase test = make_case("impact", name, std::move(scene));
    test.stops_at = stops_at;
    cases.push_back(std::move(test));
  };
  add("100 m/s on a thin plate", BoxShape{Vec3(5.0, 0.01, 5.0)}, 0.0);
  add("100 m/s on the ground", PlaneShape{}, 0.0);
  add("100 m/s on a sphere", SphereShape{0.5}, -1e300);
}

void add_borders(std::vector<StabilityCase>& cases) {
  cases.push_back(make_case("border", "one cell", on_the_ground(cube(1, 0.5), 1.0, 1.0)));

  Scene pinned = free_flight(cube(2, 1.0), 0.5);
  pinned.gravity = Vec3(0.0, -9.81, 0.0);
  pinned.pins.push_back({"cube", AxisBox{}, std::nullopt});
  cases.push_back(make_case("border", "all particles pinned", std::move(pinned)));

  Scene squeezed = on_the_ground(cube(4, 1.0), 0.5, 1.5);
  squeezed.bodies.push_back(
      placed("press", moving(BoxShape{Vec3(2.0, 0.1, 2.0)}, Vec3(0.0, -0.5, 0.0), 1.0), Vec3(0.0, 1.1, 0.0)));
  cases.push_back(make_case("border", "squeezed to half its height", squeezed));

  for (double side : {-1.0, 1.0}) {  // walls that leave no way out
    for (int axis : {0, 2}) {
      Vec3 at = Vec3(0.0, 0.5, 0.0), half = Vec3::Constant(2.0);
      at[axis] = side * 0.6, half[axis] = 0.1;
      squeezed.bodies.push_back(placed("wall", fixed(BoxShape{half}), at));
      squeezed.bodies.back().name += std::to_string(squeezed.bodies.size());
    }
  }
  StabilityCase box = make_case("border", "less room than its volume", std::move(squeezed));
  box.feasible = false;
  cases.push_back(std::move(box));
}

void add_spin(std::vector<StabilityCase>& cases) {
  DeformableBody body = cube(4, 1.0);
  body.start.affine = Vec3(1.1, 1.0, 1.0 / 1.1).asDiagonal();
  StabilityCase test = make_case("spin", "free flight with internal motion", free_flight(body, 2.0));
  test.scene.bodies[0].angular_velocity = Vec3(1.0, 2.0, 3.0);
  test.scene.bodies[0].velocity = Vec3(0.3, 0.2, 0.1);
  test.scene.solver.springs = SpringIntegrator::symplectic;
  test.keeps_momentum = true;
  cases.push_back(std::move(test));
}

}  // namespace

std::vector<StabilityCase> stability_cases(StabilityExtent extent) {
  std::vector<StabilityCase> cases;
  add_stiffness_map(cases, extent);
  add_starts(cases);
  add_masses(cases);
  add_impacts(cases);
  add_borders(cases);
  add_spin(cases);
  if (extent == StabilityExtent::full) {
    DeformableBody body = cube(100, 1.0);
    body.start.affine = Vec3(1.0, 0.9, 1.0).asDiagonal();
    StabilityCase test = make_case("size", "a million cells", free_flight(std::move(body), 2.0 / 60.0));
    test.feasible_start = false;
    cases.push_back(std::move(test));
  }
  return cases;
}

}  // namespace isochor

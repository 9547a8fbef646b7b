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

std::string on_the_map(double k, double h) {
  return "k = " + power(k) + ", h = " + (h == 1.0 / 60.0 ? "1/60" : power(h));
}

std::vector<double> powers_of_ten(int first, int last, int by) {
  std::vector<double> values;
  for (int power = first; power <= last; power += by) values.push_back(std::pow(10.0, power));
  return values;
}

/// Released stretched by 5 % at constant volume, stiffness on the edges, on both, or on the diagonals alone.
void add_stiffness_map(std::vector<StabilityCase>& cases, StabilityExtent extent) {
  const bool full = extent == StabilityExtent::full;
  std::vector<double> stiffness = powers_of_ten(2, 12, full ? 1 : 2);
  stiffness.insert(stiffness.begin(), 0.0);
  for (double k : stiffness)
    for (double h : {1e-5, 1e-4, 1e-3, 1.0 / 60.0, 0.1})
      for (const std::string springs : {"edges", "both", "diagonals"}) {
        if (springs == "diagonals" && !full) continue;
        DeformableBody body = cube(4, 1.0);
        body.edge_stiffness = springs == "diagonals" ? 0.0 : k;
        body.diagonal_stiffness = springs == "edges" ? 0.0 : k;
        body.start.affine = Vec3(1.05, 1.0 / std::sqrt(1.05), 1.0 / std::sqrt(1.05)).asDiagonal();
        Scene scene = free_flight(std::move(body), 30.0 * h);
        scene.frame_rate = 1.0 / h;
        StabilityCase test = make_case("stiffness", springs + " " + on_the_map(k, h), std::move(scene));
        test.stiffness = k, test.h = h;
        cases.push_back(std::move(test));
      }
}

/// A stiff cube dropped from 0.2 m on a plane, and on a ball of its own width.
void add_landings(std::vector<StabilityCase>& cases, StabilityExtent extent) {
  constexpr double half = 0.5, drop = 0.2;
  const bool full = extent == StabilityExtent::full;
  for (double k : powers_of_ten(4, 12, full ? 1 : 2))
    for (double h : {1e-3, 1.0 / 60.0, 0.1})
      for (const auto springs : {SpringIntegrator::automatic, SpringIntegrator::implicit})
        for (const bool on_ball : {false, true}) {
          DeformableBody body = cube(4, 2.0 * half);
          body.edge_stiffness = body.diagonal_stiffness = k;
          Scene scene = on_the_ground(std::move(body), half + drop, std::max(0.5, 10.0 * h));
          if (on_ball) {
            scene.bodies[1] = placed("ball", fixed(SphereShape{half}), Vec3::Zero());
            scene.bodies[0].position.y() += half;
          }
          scene.frame_rate = 1.0 / h;
          scene.solver.springs = springs;
          StabilityCase test = make_case(
              "landing",
              std::string(on_ball ? "ball" : "plane") +
                  (springs == SpringIntegrator::automatic ? " auto " : " implicit ") + on_the_map(k, h),
              std::move(scene));
          test.stiffness = k, test.h = h;
          cases.push_back(std::move(test));
        }
}

void add_starts(std::vector<StabilityCase>& cases) {
  const auto add = [&](const char* name, const auto& change) {
    for (const double k : {0.0, 1e8}) {
      DeformableBody body = cube(4, 1.0);
      if (k > 0.0) body.edge_stiffness = body.diagonal_stiffness = k;
      change(body.start);
      StabilityCase test =
          make_case("start", std::string(k > 0.0 ? "stiff, " : "") + name, free_flight(std::move(body), 1.0));
      test.feasible_start = false;
      cases.push_back(std::move(test));
    }
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
  AxisBox upper_half;
  upper_half.min.y() = 0.0;
  for (double ratio : {1e3, 1e6}) {
    DeformableBody body = cube(4, 1.0);
    body.density = 1000.0 / std::sqrt(ratio);
    body.densities.push_back({upper_half, 1000.0 * std::sqrt(ratio)});
    cases.push_back(make_case("masses", "heavy top, ratio " + power(ratio), on_the_ground(body, 0.6, 1.0)));
  }
  DeformableBody half_heavy = cube(4, 1.0);
  half_heavy.edge_stiffness = half_heavy.diagonal_stiffness = 1e8;
  half_heavy.density = 1.0;
  half_heavy.densities.push_back({upper_half, 1e6});
  half_heavy.start.affine = Vec3(1.05, 1.0, 1.0 / 1.05).asDiagonal();
  cases.push_back(
      make_case("masses", "stiff and adrift, ratio 1e6", free_flight(std::move(half_heavy), 1.0)));

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
  add("100 m/s on the end of a capsule", CapsuleShape{0.25, 0.5}, -1e300);

  RigidBody shot;
  shot.shape = SphereShape{0.2};
  shot.mass = 100.0;
  Scene scene = free_flight(cube(4, 1.0), 0.5);
  scene.bodies.push_back(placed("shot", shot, Vec3(-2.0, 0.1, 0.2)));
  scene.bodies.back().velocity = Vec3(100.0, 0.0, 0.0);
  StabilityCase test = make_case("impact", "hit by a ball of 100 m/s", std::move(scene));
  test.keeps_momentum = true;
  cases.push_back(std::move(test));
}

/// Deformable bodies against each other and against themselves.
void add_collisions(std::vector<StabilityCase>& cases) {
  for (double speed : {5.0, 100.0}) {
    Scene scene = free_flight(cube(3, 1.0), 0.5);
    scene.bodies[0].velocity = Vec3(speed, 0.0, 0.0);
    scene.bodies[0].position = Vec3(0.0, 1.0, 0.0);  // off the origin, so that there is a spin to keep
    scene.bodies.push_back(placed("target", cube(3, 1.0), Vec3(1.2, 1.1, 0.2)));
    scene.solver.springs = SpringIntegrator::symplectic;
    for (SceneBody& body : scene.bodies) body.friction = 0.0;
    StabilityCase test = make_case("collision", "two cubes at " + std::to_string(std::lround(speed)) + " m/s",
                                   std::move(scene));
    test.keeps_momentum = true;
    cases.push_back(std::move(test));
  }
  DeformableBody light = cube(3, 1.0);
  light.edge_stiffness = light.diagonal_stiffness = 1e5;
  DeformableBody heavy = light;
  heavy.density = 1e4;
  Scene stack = on_the_ground(std::move(light), 0.5, 2.0);
  stack.bodies.push_back(placed("heavy", heavy, Vec3(0.1, 1.6, 0.05)));
  StabilityCase test = make_case("collision", "a cube ten times heavier on a cube", std::move(stack));
  test.stops_at = 0.0;
  cases.push_back(std::move(test));

  DeformableBody bar;
  bar.shape = LatticeShape{Vec3i(12, 1, 2), 0.25, Vec3(-1.5, 0.0, 0.0)};
  bar.edge_stiffness = bar.diagonal_stiffness = 1e3;
  bar.self_contact = true;
  Scene fold = free_flight(std::move(bar), 2.0);
  fold.gravity = Vec3(0.0, -9.81, 0.0);
  AxisBox middle;
  middle.min.x() = -0.1, middle.max.x() = 0.1;
  fold.pins.push_back({"cube", middle, std::nullopt});
  cases.push_back(make_case("collision", "a bar that folds onto itself", std::move(fold)));
}

void add_borders(std::vector<StabilityCase>& cases) {
  cases.push_back(make_case("border", "one cell", on_the_ground(cube(1, 0.5), 1.0, 1.0)));

  Scene pinned = free_flight(cube(2, 1.0), 0.5);
  pinned.gravity = Vec3(0.0, -9.81, 0.0);
  pinned.pins.push_back({"cube", AxisBox{}, std::nullopt});
  cases.push_back(make_case("border", "all particles pinned", std::move(pinned)));

  DeformableBody beam;
  beam.shape = LatticeShape{Vec3i(8, 2, 2), 0.125, Vec3(-0.5, -0.125, -0.125)};
  beam.edge_stiffness = beam.diagonal_stiffness = 1e8;
  Scene console = free_flight(std::move(beam), 1.0);
  console.gravity = Vec3(0.0, -9.81, 0.0);
  console.pins.push_back({"cube", AxisBox{Vec3::Constant(-1.0), Vec3(-0.49, 1.0, 1.0)}, std::nullopt});
  cases.push_back(make_case("border", "stiff, pinned at one end", std::move(console)));

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
  const auto add = [&](const char* name, SpringIntegrator springs, double k) {
    DeformableBody body = cube(4, 1.0);
    body.edge_stiffness = k, body.diagonal_stiffness = 0.1 * k;
    body.start.affine = Vec3(1.1, 1.0, 1.0 / 1.1).asDiagonal();
    StabilityCase test = make_case("spin", name, free_flight(std::move(body), 2.0));
    test.scene.bodies[0].angular_velocity = Vec3(1.0, 2.0, 3.0);
    test.scene.bodies[0].velocity = Vec3(0.3, 0.2, 0.1);
    test.scene.solver.springs = springs;
    test.keeps_momentum = true;
    cases.push_back(std::move(test));
  };
  add("stretched, symplectic", SpringIntegrator::symplectic, 1e4);
  add("stretched, implicit", SpringIntegrator::implicit, 1e4);
  add("stretched, energy_momentum", SpringIntegrator::energy_momentum, 1e4);
  add("stretched and stiff", SpringIntegrator::automatic, 1e8);
}

}  // namespace

std::vector<StabilityCase> stability_cases(StabilityExtent extent) {
  std::vector<StabilityCase> cases;
  add_stiffness_map(cases, extent);
  add_landings(cases, extent);
  add_starts(cases);
  add_masses(cases);
  add_impacts(cases);
  add_collisions(cases);
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

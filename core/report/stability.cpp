#include "core/report/stability.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/parallel/cancel_scope.h"
#include "core/scene/simulation.h"

namespace isochor {
namespace {

constexpr double not_judged = std::numeric_limits<double>::quiet_NaN();
constexpr double energy_margin = 0.05, momentum_margin = 1e-10;

struct MassCenter {
  double mass = 0.0;
  Vec3 center = Vec3::Zero();
};

MassCenter mass_center(const std::vector<BodyTopology>& topology, const Snapshot& snapshot) {
  MassCenter result;
  for (const BodyTopology& body : topology) {
    if (!body.deformable) continue;
    const BodySnapshot& state = snapshot.bodies.at(body.id);
    for (std::size_t i = 0; i < body.masses.size(); ++i) {
      result.mass += body.masses[i];
      result.center += body.masses[i] * state.positions[i];
    }
  }
  if (result.mass > 0.0) result.center /= result.mass;
  return result;
}

bool all_finite(const Snapshot& snapshot) {
  const auto finite = [](const Vec3& p) { return p.allFinite(); };
  return std::ranges::all_of(snapshot.bodies, [&](const BodySnapshot& body) {
    return finite(body.position) && std::ranges::all_of(body.positions, finite);
  });
}

std::string decimals(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

/// What the frames of a run add up to.
struct Judge {
  const StabilityCase& test;
  const std::vector<BodyTopology> topology;
  Snapshot first, last;
  MassCenter start;
  double largest_energy = -1e300, fallen = 0.0, linear_drift = 0.0, angular_drift = 0.0;
  bool finite = true;
  std::string infeasible;  ///< the first frame that said so: when, and where
  StabilityResult result;

  Judge(const StabilityCase& stability_case, const Simulation& simulation)
      : test(stability_case),
        topology(simulation.topology()),
        first(simulation.snapshot()),
        last(first),
        start(mass_center(topology, first)) {
    result.group = test.group, result.name = test.name;
    result.stiffness = test.stiffness, result.h = test.h;
    result.tolerance = test.scene.solver.tolerance;
  }

  static double energy(const Metrics& m) { return m.kinetic_energy + m.potential_energy; }

  void frame(Snapshot snapshot) {
    const Metrics& m = snapshot.metrics;
    finite = finite && all_finite(snapshot) && std::isfinite(energy(m));
    if (infeasible.empty() && !m.feasible && m.worst_cell >= 0)
      infeasible = "infeasible at " + decimals(snapshot.t) + " s, cell " + std::to_string(m.worst_cell);
    result.max_cell_volume_error = std::max(result.max_cell_volume_error, m.max_cell_volume_error);
    result.total_volume_error = std::max(result.total_volume_error, m.total_volume_error);
    result.recoveries += m.recoveries, result.fallbacks += m.fallbacks;
    result.inverted = m.inverted;
    largest_energy = std::max(largest_energy, energy(m));
    fallen = std::max(fallen, (mass_center(topology, snapshot).center - start.center).norm());
    linear_drift = std::max(linear_drift, (m.linear_momentum - first.metrics.linear_momentum).norm());
    angular_drift = std::max(angular_drift, (m.angular_momentum - first.metrics.angular_momentum).norm());
    last = std::move(snapshot);
  }

  double energy_ratio() const {
    if (!test.feasible_start || !test.feasible) return not_judged;
    const bool driven = std::ranges::any_of(test.scene.bodies, [&](const SceneBody& body) {
      const auto* rigid = std::get_if<RigidBody>(&body.kind);
      return rigid && (rigid->motion || (rigid->mass && !test.scene.gravity.isZero()));
    });
    if (driven) return not_judged;
    const Vec3& gravity = test.scene.gravity;
    const double springs = first.metrics.potential_energy + start.mass * gravity.dot(start.center);
    const double scale =
        first.metrics.kinetic_energy + std::abs(springs) + start.mass * gravity.norm() * fallen + 1e-12;
    return 1.0 + (largest_energy - energy(first.metrics)) / scale;
  }

  double momentum_drift() const {
    if (!test.keeps_momentum) return not_judged;
    const Metrics& m = first.metrics;
    return std::max(linear_drift / std::max(m.linear_momentum.norm(), 1e-300),
                    angular_drift / std::max(m.angular_momentum.norm(), 1e-300));
  }

  std::string verdict() const {
    if (!finite) return "not finite";
    if (mass_center(topology, last).center.y() < test.stops_at) return "passed through";
    if (test.feasible) {
      if (result.max_cell_volume_error > result.tolerance) return "a cell is off";
      if (result.inverted > 0) return "inverted tets remain";
    } else if (infeasible.empty()) {
      return "infeasible, not named";
    }
    if (result.energy_ratio > 1.0 + energy_margin) return "energy was gained";
    if (result.momentum_drift > momentum_margin && result.recoveries + result.fallbacks == 0)
      return "momentum drifted";
    return {};
  }

  StabilityResult judge() {
    result.energy_ratio = energy_ratio();
    result.momentum_drift = momentum_drift();
    const std::string fault = verdict();
    result.passed = fault.empty();
    if (!result.passed)
      result.outcome = fault + (infeasible.empty() ? "" : "; " + infeasible);
    else if (!test.feasible)
      result.outcome = infeasible;
    else
      result.outcome = result.recoveries > 0 ? "recovered; volume kept" : "volume kept";
    return result;
  }
};

}  // namespace

bool StabilityReport::passed() const {
  return complete && std::ranges::all_of(results, &StabilityResult::passed);
}

StabilityResult run_stability_case(const StabilityCase& test, const Progress& progress) {
  const auto begin = std::chrono::steady_clock::now();
  Progress quiet;
  const auto simulation = compile(test.scene, quiet);
  Judge judge(test, *simulation);
  const CancelScope scope(progress);  // a frame of a million cells takes minutes
  while (!simulation->finished() && judge.finite) judge.frame(simulation->step(progress));
  StabilityResult result = judge.judge();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

StabilityReport run_stability(StabilityExtent extent, Progress& progress,
                              const std::function<void(const StabilityResult&)>& on_result) {
  StabilityReport report;
  const std::vector<StabilityCase> cases = stability_cases(extent);
  try {
    for (std::size_t i = 0; i < cases.size(); ++i) {
      progress.report("stability", static_cast<double>(i) / static_cast<double>(cases.size()));
      progress.throw_if_cancelled();
      report.results.push_back(run_stability_case(cases[i], progress));
      if (on_result) on_result(report.results.back());
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::cancelled) throw;
    report.complete = false;
  }
  return report;
}

}  // namespace isochor

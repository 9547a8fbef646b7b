#include "core/report/scene_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/parallel/deadline.h"
#include "core/report/material_points.h"
#include "core/report/pace.h"
#include "core/scene/simulation.h"

namespace isochor {
namespace {

/// Sizes that make errors relative: of the deformable bodies, or, where there are none, of the rigid ones
/// that have a mass.
struct Scales {
  double length = 1.0, mass = 0.0, duration = 1.0;
};

/// What is kept of a run: a small part of each frame.
struct Run {
  std::vector<std::vector<Vec3>> points;
  std::vector<Metrics> metrics;
  std::vector<double> frame_ms;
  std::int64_t cells = 0;
  Outcome outcome = Outcome::converged;
  std::string reason;
  double share = 1.0;  ///< of the scene's duration: less where it blew up or was stopped

  double seconds() const {
    double sum = 0.0;
    for (double ms : frame_ms) sum += ms / 1000.0;
    return sum;
  }
};

using FrameSink = std::function<void(const Snapshot&)>;

Scales scene_scales(const Simulation& simulation) {
  Scales scales;
  Box box;
  for (const BodyTopology& body : simulation.topology())
    if (body.deformable) {
      for (const Vec3& p : body.rest_positions) box.extend(p);
      for (double m : body.masses) scales.mass += m;
    }
  if (!(scales.mass > 0.0))
    for (const SceneBody& body : simulation.scene().bodies)
      if (const auto* rigid = std::get_if<RigidBody>(&body.kind); rigid && rigid->mass > 0.0) {
        box.extend(body.position);
        scales.mass += *rigid->mass;
      }
  if (box.min.x() <= box.max.x() && box.size().norm() > 0.0) scales.length = box.size().norm();
  scales.duration = simulation.scene().duration.value_or(1.0);
  if (!(scales.duration > 0.0)) scales.duration = 1.0;
  return scales;
}

void judge(const Snapshot& snapshot, const std::vector<Vec3>& points, const Scales& scales, Run& run) {
  const auto wild = [&](const Vec3& p) {
    return !p.allFinite() || p.norm() > 1000.0 * (1.0 + scales.length);
  };
  if (std::ranges::any_of(points, wild)) {
    run.outcome = Outcome::blew_up;
    run.reason = "a point left the scene at t = " + std::to_string(snapshot.t) + " s";
  } else if (!snapshot.metrics.feasible && snapshot.seq > 0 && run.outcome == Outcome::converged) {
    run.outcome = Outcome::infeasible;
    const Metrics& m = snapshot.metrics;
    run.reason =
        fmt::format("infeasible at t = {:.4g} s: cell {} is off by {:.2g}, bodies are in others by {:.2g} m",
                    snapshot.t, m.worst_cell, m.max_cell_volume_error, m.max_penetration);
  }
}

/// nullopt where the time is up before the frame ends: the simulation is of no use then.
std::optional<Snapshot> step_within(Simulation& simulation, const Progress& progress,
                                    const std::optional<Deadline>& deadline) try {
  return simulation.step(deadline ? deadline->progress() : progress);
} catch (const Error& error) {
  if (error.code() != ErrorCode::cancelled || !deadline || !deadline->passed()) throw;
  return std::nullopt;
}

Run run_scene(Simulation& simulation, const MaterialPoints& points, const FrameSink& sink,
              const Progress& progress, double limit, const std::function<void(double)>& fraction) {
  Run run;
  const std::vector<BodyTopology> topology = simulation.topology();
  const PointTracker tracker(points, topology);
  const Scales scales = scene_scales(simulation);
  const double frames = std::max(1.0, scales.duration * simulation.scene().frame_rate);
  for (const BodyTopology& body : topology)
    if (body.deformable) run.cells += static_cast<std::int64_t>(body.mesh->cells.size());

  const auto keep = [&](const Snapshot& snapshot) {
    run.points.push_back(tracker.locate(snapshot));
    run.metrics.push_back(snapshot.metrics);
    if (sink) sink(snapshot);
    judge(snapshot, run.points.back(), scales, run);
  };
  std::optional<Deadline> deadline;
  if (std::isfinite(limit)) deadline.emplace(progress, limit);
  double taken = 0.0, t = 0.0;
  keep(simulation.snapshot());
  while (!simulation.finished() && ended(run.outcome)) {
    progress.throw_if_cancelled();
    const auto snapshot = taken <= limit ? step_within(simulation, progress, deadline) : std::nullopt;
    if (snapshot) {
      run.frame_ms.push_back(snapshot->metrics.step_ms);
      taken += snapshot->metrics.step_ms / 1000.0, t = snapshot->t;
      keep(*snapshot);
      fraction(t / scales.duration);
    } else {
      run.outcome = Outcome::too_slow;
      run.reason += fmt::format("{}stopped after {:g} s, at t = {:.4g} s of {:g} s",
                                run.reason.empty() ? "" : "; ", limit, t, scales.duration);
    }
    if (!ended(run.outcome)) run.share = std::clamp(t / scales.duration, 0.5 / frames, 1.0);
  }
  return run;
}

double total_energy(const Metrics& metrics) {
  return metrics.kinetic_energy + metrics.potential_energy;
}

SceneErrors compare(const Run& run, const Run& reference, const Scales& scales) {
  SceneErrors errors;
  double sum = 0.0, linear_scale = scales.mass * scales.length / scales.duration,
         angular_scale = linear_scale * scales.length, lowest = 1e300, highest = -1e300, kinetic = 0.0;
  for (const Metrics& m : reference.metrics) {
    linear_scale = std::max(linear_scale, m.linear_momentum.norm());
    angular_scale = std::max(angular_scale, m.angular_momentum.norm());
    lowest = std::min(lowest, total_energy(m)), highest = std::max(highest, total_energy(m));
    kinetic = std::max(kinetic, m.kinetic_energy);
  }
  // An undamped scene keeps its energy, so its range is round-off: the motion itself sets the scale.
  const double energy_scale = std::max({highest - lowest, kinetic, 1e-300});

  std::int64_t counted = 0;
  const std::size_t frames = std::min(run.metrics.size(), reference.metrics.size());
  for (std::size_t f = 1; f < frames; ++f) {
    const Metrics &a = run.metrics[f], &b = reference.metrics[f];
    errors.max_cell_volume = std::max(errors.max_cell_volume, a.max_cell_volume_error);
    errors.total_volume = std::max(errors.total_volume, a.total_volume_error);
    errors.max_penetration = std::max(errors.max_penetration, a.max_penetration);
    errors.linear_momentum =
        std::max(errors.linear_momentum, (a.linear_momentum - b.linear_momentum).norm() / linear_scale);
    errors.angular_momentum =
        std::max(errors.angular_momentum, (a.angular_momentum - b.angular_momentum).norm() / angular_scale);
    errors.energy = std::max(errors.energy, std::abs(total_energy(a) - total_energy(b)) / energy_scale);
    for (std::size_t i = 0; i < run.points[f].size(); ++i) {
      const double distance = (run.points[f][i] - reference.points[f][i]).norm();
      errors.trajectory_max = std::max(errors.trajectory_max, distance);
      sum += distance * distance, ++counted;
    }
  }
  errors.trajectory_rms = counted > 0 ? std::sqrt(sum / static_cast<double>(counted)) : 0.0;
  return errors;
}

/// Everything that the points of one report share.
struct Study {
  const Scene& scene;
  const SceneReportOptions& options;
  Progress& progress;
  MaterialPoints points = {};
  Run reference = {};
  Scales scales = {};
  Pace pace = Pace();

  std::unique_ptr<Simulation> build(const SceneSettings& settings) const {
    return build(apply_settings(scene, settings));
  }
  std::unique_ptr<Simulation> build(const Scene& changed) const {
    Progress quiet = progress.with_sink({});
    return options.build ? options.build(changed, quiet) : compile(changed, quiet);
  }
};

/// Which run it is of the same settings.
enum class RunKind { reference, coarser_reference, first, repeated };

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

constexpr double slow_run_seconds = 10.0;
constexpr double wild_energy = 1000.0;  ///< as an error

Run measured_run(Study& study, const SceneSettings& settings, RunKind kind, const std::string& phase) {
  const SceneReportOptions& options = study.options;
  const Clock::time_point start = Clock::now();
  const auto simulation = study.build(settings);
  const double built = seconds_since(start);
  if (study.points.bodies.empty()) {
    study.points = choose_material_points(simulation->topology(), options.material_points);
    study.scales = scene_scales(*simulation);
  }
  const bool recorded = kind == RunKind::reference || kind == RunKind::first;
  if (recorded && options.on_start)
    options.on_start(kind == RunKind::first ? std::optional(settings) : std::nullopt, *simulation);
  const FrameSink sink = recorded ? options.on_frame : nullptr;
  Stalls stalls;
  Clock::time_point frame = Clock::now();
  const bool of_point = kind == RunKind::first || kind == RunKind::repeated;
  const double limit = of_point ? options.point_limit : std::numeric_limits<double>::infinity();
  Run run = run_scene(*simulation, study.points, sink, study.progress, limit, [&](double share) {
    stalls.add(seconds_since(std::exchange(frame, Clock::now())));
    study.progress.report(
        phase, study.pace.fraction(cost_place(settings), share, seconds_since(start), stalls.lost()));
  });
  const double taken = seconds_since(start) - stalls.lost();
  study.pace.end_run(cost_place(settings), taken, built + (taken - built) / run.share);
  study.pace.lose(stalls.lost());
  if (recorded && options.on_end) options.on_end();
  return run;
}

/// Asks the scene at rest and weightless, so that no substep is halved, whatever happens in its first frame.
class Probe {
 public:
  explicit Probe(const Study& study) : study_(study) {}

  SceneSettings as_stepped(SceneSettings settings) {
    Simulation* simulation = built(settings);
    if (!simulation) return settings;
    SolverOptions solver = simulation->scene().solver;
    solver.springs = settings.springs, solver.substeps = settings.substeps;
    simulation->set_solver(solver);
    settings.substeps = simulation->step(study_.progress).metrics.substeps;
    const std::vector<PlannedPhase> plan = simulation->plan();
    if (!includes(plan, "volume")) {  // nor springs
      const SolverOptions& own = study_.scene.solver;
      settings.solver = own.volume, settings.springs = own.springs, settings.tolerance = own.tolerance;
    } else if (settings.springs == SpringIntegrator::automatic) {
      settings.springs = chosen(plan);
    }
    return settings;
  }

 private:
  /// nullptr where the scene cannot be built so: its points will say why.
  Simulation* built(const SceneSettings& settings) {
    const auto [place, is_new] = built_.try_emplace(settings.resolution);
    if (is_new) try {
        Scene scene = apply_settings(study_.scene, settings);
        scene.gravity = Vec3::Zero();
        for (SceneBody& body : scene.bodies) {
          body.velocity = body.angular_velocity = Vec3::Zero();
          if (auto* deformable = std::get_if<DeformableBody>(&body.kind)) deformable->start = {};
          if (auto* rigid = std::get_if<RigidBody>(&body.kind); rigid && rigid->motion)
            rigid->motion.reset(), rigid->is_static = true;
        }
        place->second = study_.build(scene);
      } catch (const Error& error) {
        if (error.code() == ErrorCode::cancelled) throw;
      }
    return place->second.get();
  }

  static bool includes(const std::vector<PlannedPhase>& plan, std::string_view name) {
    return std::ranges::any_of(plan, [&](const PlannedPhase& p) { return p.name == name && p.included; });
  }

  static SpringIntegrator chosen(const std::vector<PlannedPhase>& plan) {
    const bool symplectic = includes(plan, "symplectic_euler"), implicit = includes(plan, "implicit_euler");
    if (symplectic == implicit) return SpringIntegrator::automatic;
    return symplectic ? SpringIntegrator::symplectic : SpringIntegrator::implicit;
  }

  const Study& study_;
  std::map<double, std::unique_ptr<Simulation>> built_;
};

// Symplectic at a far smaller step than any point's. Where that is out of reach, `automatic` steps
// implicitly, at the smaller step all the same.
SceneSettings reference_settings(const SceneReportOptions& options, const std::vector<SceneSettings>& grid,
                                 Probe& probe) {
  constexpr int most_needed = 1000, most_refined = 4000;
  SceneSettings reference = grid.front();
  reference.solver = VolumeSolver::newton;
  reference.tolerance = options.reference_tolerance;
  reference.springs = SpringIntegrator::symplectic;
  reference.substeps = 0;
  int substeps = 1;
  for (const SceneSettings& settings : grid) {
    reference.resolution = std::max(reference.resolution, settings.resolution);
    substeps = std::max(substeps, settings.substeps);
  }
  const int needed = std::max(1, probe.as_stepped(reference).substeps),
            refinement = options.reference_refinement;
  reference.substeps = std::max(refinement * substeps, std::min(refinement * needed, most_refined));
  if (needed > most_needed) reference.springs = SpringIntegrator::automatic;
  return reference;
}

SceneSettings at_half_the_substeps(SceneSettings settings) {
  settings.substeps = std::max(1, settings.substeps / 2);
  return settings;
}

void describe(const Run& run, ScenePoint& point) {
  point.outcome = run.outcome, point.reason = run.reason, point.cells = run.cells;
  for (const Metrics& m : run.metrics) {
    point.substeps = std::max(point.substeps, m.substeps);
    point.recoveries += m.recoveries, point.fallbacks += m.fallbacks;
  }
}

void add_times(const std::vector<std::vector<double>>& frame_ms, ScenePoint& point) {
  std::vector<double> medians, p95, seconds;
  for (const std::vector<double>& frames : frame_ms) {
    medians.push_back(spread_of(frames).median);
    p95.push_back(quantile(frames, 0.95));
    seconds.push_back(std::accumulate(frames.begin(), frames.end(), 0.0) / 1000.0);
  }
  point.runs = static_cast<int>(frame_ms.size());
  point.ms_per_step = spread_of(medians);
  point.ms_p95 = spread_of(p95).max;
  point.seconds = spread_of(seconds).median;
}

/// The reference, and how far it is from itself at half its substeps.
void run_reference(Study& study, ScenePoint& reference) {
  study.reference = measured_run(study, reference.settings, RunKind::reference, "reference");
  describe(study.reference, reference);
  add_times({study.reference.frame_ms}, reference);
  const Run coarser = measured_run(study, at_half_the_substeps(reference.settings),
                                   RunKind::coarser_reference, "reference at twice its step");
  reference.errors = compare(coarser, study.reference, study.scales);
}

void set_no_errors(ScenePoint& point) {
  for (const SceneErrorField& field : scene_error_fields()) point.errors.*field.value = not_measured;
}

ScenePoint run_point(Study& study, const SceneSettings& settings, const std::string& phase) {
  const int repeats = std::max(1, study.options.repeats);
  ScenePoint point;
  point.settings = settings;
  std::vector<std::vector<double>> frame_ms;
  try {
    while (std::ssize(frame_ms) < repeats) {
      const Run run =
          measured_run(study, settings, frame_ms.empty() ? RunKind::first : RunKind::repeated, phase);
      if (run.outcome == Outcome::too_slow && !frame_ms.empty()) break;  // for once: the first stands
      frame_ms.push_back(run.frame_ms);
      if (frame_ms.size() > 1) continue;
      describe(run, point);
      if (point.outcome == Outcome::too_slow) {
        set_no_errors(point);
        break;
      }
      point.errors = compare(run, study.reference, study.scales);
      if (point.outcome != Outcome::blew_up && point.errors.energy > wild_energy) {
        point.outcome = Outcome::blew_up;
        point.reason = "its energy is off by more than a thousand times that of the reference's motion";
      }
      // A slow point is as good as its first run: the noise of a repeat is small beside it.
      if (point.outcome == Outcome::blew_up || run.seconds() > slow_run_seconds) break;
    }
  } catch (const Error& error) {
    // A recording that cannot be written says nothing of the point.
    if (error.code() == ErrorCode::cancelled || error.code() == ErrorCode::cannot_write) throw;
    point.outcome = Outcome::failed;
    point.reason = error.what();
    set_no_errors(point);
  }
  study.pace.leave_out(cost_place(settings));
  add_times(frame_ms, point);
  if (point.outcome == Outcome::too_slow) point.seconds = study.options.point_limit;
  return point;
}

/// What is done of a grid, in its order.
using DonePoints = std::vector<std::optional<ScenePoint>>;

/// What failed costs little to try again; what was stopped is, under a higher limit.
bool settled(const Study& study, const std::optional<ScenePoint>& point) {
  if (!point || point->outcome == Outcome::failed) return false;
  return point->outcome != Outcome::too_slow || study.options.point_limit <= point->seconds;
}

/// The points of an earlier run stay, where the axes do not ask for them, too.
void add_earlier(const SceneReport& earlier, std::vector<SceneSettings>& grid) {
  for (const ScenePoint& point : earlier.points)
    if (std::ranges::find(grid, point.settings) == grid.end()) grid.push_back(point.settings);
}

/// The reference of an earlier run, where it is at least as fine as the wanted one.
const ScenePoint& reference_to_keep(const SceneReport& earlier, const SceneSettings& wanted) {
  const SceneSettings& known = earlier.reference.settings;
  if (known.solver == wanted.solver && known.springs == wanted.springs &&
      known.tolerance <= wanted.tolerance && known.resolution >= wanted.resolution &&
      known.substeps >= wanted.substeps)
    return earlier.reference;
  const auto words = [](const SceneSettings& settings) {
    return fmt::format("{} substeps a frame on ×{:g} the cells", settings.substeps, settings.resolution);
  };
  throw Error(ErrorCode::invalid_argument,
              "the report to resume was measured against a reference of " + words(known) +
                  ", and this one needs one of " + words(wanted),
              "run it afresh, without --resume or into another folder; or ask for no finer steps or lattice");
}

DonePoints done_before(const std::vector<SceneSettings>& grid, const SceneReport& earlier) {
  DonePoints done;
  for (const SceneSettings& settings : grid) {
    const auto known = std::ranges::find(earlier.points, settings, &ScenePoint::settings);
    done.push_back(known != earlier.points.end() ? std::optional(*known) : std::nullopt);
  }
  return done;
}

Pace pace_of(const Study& study, const ScenePoint& reference, const std::vector<CostPlace>& places,
             const DonePoints& done) {
  Pace pace(slow_run_seconds, study.options.point_limit);
  for (std::size_t i = 0; i < places.size(); ++i)
    if (settled(study, done[i]) && ended(done[i]->outcome)) pace.know(places[i], done[i]->seconds);
  pace.expect_reference(cost_place(reference.settings));
  pace.expect_reference(cost_place(at_half_the_substeps(reference.settings)));
  for (std::size_t i = 0; i < places.size(); ++i)
    if (!settled(study, done[i])) pace.expect(places[i], std::max(1, study.options.repeats));
  return pace;
}

void run_grid(Study& study, const std::vector<SceneSettings>& grid, DonePoints& done, SceneReport& report) {
  const auto collect = [&] {
    report.points.clear();
    for (const auto& point : done)
      if (point) report.points.push_back(*point);
  };
  collect();
  const auto is_settled = [&](const auto& point) { return settled(study, point); };
  if (std::ranges::all_of(done, is_settled)) return;
  std::vector<CostPlace> places;
  std::ranges::transform(grid, std::back_inserter(places), cost_place);
  study.pace = pace_of(study, report.reference, places, done);
  ScenePoint reference;
  reference.settings = report.reference.settings;
  run_reference(study, reference);
  report.reference = reference;
  auto number = std::ranges::count_if(done, is_settled);
  for (std::size_t i : revealing_order(places)) {
    if (is_settled(done[i])) continue;
    const std::string phase = "point " + std::to_string(++number) + " of " + std::to_string(grid.size());
    done[i] = run_point(study, grid[i], phase);
    collect();
    if (study.options.on_point) study.options.on_point(report);
  }
}

}  // namespace

void check_scene_report(const Scene& scene, const SceneReportOptions& options, std::int64_t max_bytes) {
  if (!scene.duration)
    throw Error(ErrorCode::invalid_argument, "a report needs a scene that ends", "give it a duration",
                {{"/duration", "is null", 0.0, std::nullopt}});
  const double frames = *scene.duration * scene.frame_rate + 1.0;
  const double frame_bytes =
      sizeof(Metrics) + static_cast<double>(scene.bodies.size()) * options.material_points * sizeof(Vec3);
  if (2.0 * frames * frame_bytes > static_cast<double>(max_bytes))
    throw Error(ErrorCode::over_budget,
                "a report of " + std::to_string(static_cast<std::int64_t>(frames)) + " frames is too long",
                "shorten its duration, or lower its frame_rate",
                {{"/duration", "is too long", 0.0,
                  0.5 * static_cast<double>(max_bytes) / frame_bytes / scene.frame_rate}});
}

SceneReport report_scene(const Scene& scene, const SceneReportOptions& options, Progress& progress) {
  check_scene_report(scene, options, std::numeric_limits<std::int64_t>::max());
  Study study{scene, options, progress};
  SceneReport report;
  report.scene = scene.name;
  try {
    Probe probe(study);
    std::vector<SceneSettings> grid = scene_grid(
        scene, options.axes, [&](const SceneSettings& settings) { return probe.as_stepped(settings); });
    if (!options.axes.resolutions) report.one_lattice = why_one_lattice(scene);
    add_earlier(options.earlier, grid);
    report.reference.settings = reference_settings(options, grid, probe);
    if (!options.earlier.points.empty())
      report.reference = reference_to_keep(options.earlier, report.reference.settings);
    DonePoints done = done_before(grid, options.earlier);
    run_grid(study, grid, done, report);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::cancelled) throw;
    report.complete = false;
  }
  return report;
}

const ScenePoint* fit_budget(const SceneReport& report, double budget_ms) {
  const ScenePoint* best = nullptr;
  const double floor = error_floor(report, scene_error_fields().front());
  const auto key = [&](const ScenePoint& p) {
    return std::tuple(std::max(p.errors.trajectory_rms, floor), p.errors.max_cell_volume,
                      p.ms_per_step.median);
  };
  for (const ScenePoint& point : report.points)
    if (point.outcome == Outcome::converged && point.fits_ms() <= budget_ms &&
        (!best || key(point) < key(*best)))
      best = &point;
  return best;
}

}  // namespace isochor

#include "core/report/scene_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/report/material_points.h"
#include "core/scene/simulation.h"

namespace isochor {
namespace {

template <class T>
std::vector<T> axis(const std::vector<T>& values, T fallback) {
  return values.empty() ? std::vector<T>{fallback} : values;
}

/// Sizes that make errors relative.
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
  if (box.min.x() <= box.max.x()) scales.length = box.size().norm();
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
    run.reason = "the tolerance was not met at t = " + std::to_string(snapshot.t) + " s, worst in cell " +
                 std::to_string(snapshot.metrics.worst_cell);
  }
}

Run run_scene(Simulation& simulation, const MaterialPoints& points, const FrameSink& sink,
              const Progress& progress, const std::function<void(double)>& fraction) {
  Run run;
  const std::vector<BodyTopology> topology = simulation.topology();
  const PointTracker tracker(points, topology);
  const Scales scales = scene_scales(simulation);
  for (const BodyTopology& body : topology)
    if (body.deformable) run.cells += static_cast<std::int64_t>(body.mesh->cells.size());

  const auto keep = [&](const Snapshot& snapshot) {
    run.points.push_back(tracker.locate(snapshot));
    run.metrics.push_back(snapshot.metrics);
    if (sink) sink(snapshot);
    judge(snapshot, run.points.back(), scales, run);
  };
  keep(simulation.snapshot());
  while (!simulation.finished() && run.outcome != Outcome::blew_up) {
    progress.throw_if_cancelled();
    const Snapshot snapshot = simulation.step(progress);
    run.frame_ms.push_back(snapshot.metrics.step_ms);
    keep(snapshot);
    fraction(snapshot.t / scales.duration);
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
  int needed_substeps = 1;             ///< of symplectic Euler, at the finest resolution
  double work_done = 0.0, work = 1.0;  ///< as expected_work counts it

  std::unique_ptr<Simulation> build(const SceneSettings& settings) const {
    Progress quiet = progress.with_sink({});
    const Scene changed = apply_settings(scene, settings);
    return options.build ? options.build(changed, quiet) : compile(changed, quiet);
  }
};

/// Of one run, relative: substeps times cells. An implicit step counts as ten.
double expected_work(const Study& study, const SceneSettings& settings) {
  constexpr int cheap_substeps = 15;
  const bool implicit = settings.springs == SpringIntegrator::automatic
                            ? study.needed_substeps > std::max(cheap_substeps, settings.substeps)
                            : settings.springs != SpringIntegrator::symplectic;
  const int substeps =
      implicit ? 10 * std::max(1, settings.substeps) : std::max(study.needed_substeps, settings.substeps);
  return substeps * std::pow(settings.resolution, 3);
}

constexpr int reference_index = -1;
constexpr double slow_run_seconds = 10.0;

Run measured_run(Study& study, const SceneSettings& settings, int index, bool recorded,
                 const std::string& phase) {
  const SceneReportOptions& options = study.options;
  const auto simulation = study.build(settings);
  if (study.points.bodies.empty()) {
    study.points = choose_material_points(simulation->topology(), options.material_points);
    study.scales = scene_scales(*simulation);
  }
  if (recorded && options.on_start) options.on_start(index, *simulation);
  FrameSink sink;
  if (recorded && options.on_frame)
    sink = [&, index](const Snapshot& frame) { options.on_frame(index, frame); };
  const double work = expected_work(study, settings);
  Run run = run_scene(*simulation, study.points, sink, study.progress, [&](double fraction) {
    study.progress.report(phase, (study.work_done + work * fraction) / study.work);
  });
  study.work_done += work;
  return run;
}

/// Substeps a frame that symplectic Euler asks for by itself, at the finest resolution of the grid.
int needed_substeps(const Study& study, SceneSettings settings) {
  settings.springs = SpringIntegrator::symplectic;
  settings.substeps = 0;
  return std::max(1, study.build(settings)->step(study.progress).metrics.substeps);
}

// Symplectic at a far smaller step than any point's. Where that is out of reach, `automatic` steps
// implicitly, at the smaller step all the same.
SceneSettings reference_settings(Study& study, const std::vector<SceneSettings>& grid) {
  constexpr int most_needed = 1000, most_refined = 4000;
  SceneSettings reference = grid.front();
  reference.solver = VolumeSolver::newton;
  reference.tolerance = study.options.reference_tolerance;
  int substeps = 1;
  for (const SceneSettings& settings : grid) {
    reference.resolution = std::max(reference.resolution, settings.resolution);
    substeps = std::max(substeps, settings.substeps);
  }
  study.needed_substeps = needed_substeps(study, reference);
  const int refinement = study.options.reference_refinement;
  reference.substeps =
      std::max(refinement * substeps, std::min(refinement * study.needed_substeps, most_refined));
  reference.springs =
      study.needed_substeps <= most_needed ? SpringIntegrator::symplectic : SpringIntegrator::automatic;
  return reference;
}

ScenePoint run_point(Study& study, const SceneSettings& settings, int index, const std::string& phase) {
  ScenePoint point;
  point.settings = settings;
  std::vector<double> medians, slow, seconds;
  const double work_after =
      study.work_done + std::max(1, study.options.repeats) * expected_work(study, settings);
  try {
    for (int repeat = 0; repeat < std::max(1, study.options.repeats); ++repeat) {
      const Run run = measured_run(study, settings, index, repeat == 0, phase);
      medians.push_back(spread_of(run.frame_ms).median);
      slow.push_back(quantile(run.frame_ms, 0.95));
      seconds.push_back(run.seconds());
      if (repeat > 0) continue;
      point.outcome = run.outcome, point.reason = run.reason, point.cells = run.cells;
      point.errors = compare(run, study.reference, study.scales);
      for (const Metrics& m : run.metrics) {
        point.substeps = std::max(point.substeps, m.substeps);
        point.recoveries += m.recoveries, point.fallbacks += m.fallbacks;
      }
      // A slow point is as good as its first run: the noise of a repeat is small beside it.
      if (run.outcome == Outcome::blew_up || run.seconds() > slow_run_seconds) break;
    }
  } catch (const Error& error) {
    if (error.code() == ErrorCode::cancelled) throw;
    point.outcome = Outcome::failed;
    point.reason = error.what();
  }
  study.work_done = work_after;  // also where repeats were left out
  point.ms_per_step = spread_of(medians);
  point.ms_p95 = spread_of(slow).median;
  point.seconds = spread_of(seconds).median;
  return point;
}

void refine(SceneBody& body, double resolution) {
  auto* deformable = std::get_if<DeformableBody>(&body.kind);
  if (!deformable || resolution == 1.0) return;
  if (auto* lattice = std::get_if<LatticeShape>(&deformable->shape)) {
    // The scene's own stiffness, read as a modulus at its own cell size, so that the material stays the same.
    if (!deformable->edge_modulus) deformable->edge_modulus = deformable->edge_stiffness / lattice->cell_size;
    if (!deformable->diagonal_modulus)
      deformable->diagonal_modulus = deformable->diagonal_stiffness / lattice->cell_size;
    const Vec3 extent = lattice->cells.cast<double>() * lattice->cell_size;
    const int longest = std::max(1, static_cast<int>(std::lround(lattice->cells.maxCoeff() * resolution)));
    lattice->cell_size = extent.maxCoeff() / longest;
    lattice->cells = (extent / lattice->cell_size).array().round().max(1.0).cast<int>();
    return;
  }
  if (!deformable->edge_modulus || !deformable->diagonal_modulus)
    throw Error(ErrorCode::invalid_argument,
                "body \"" + body.name + "\" gives its springs in N/m, which do not follow the resolution",
                "give edge_modulus and diagonal_modulus in Pa");
  auto* mesh = std::get_if<MeshShape>(&deformable->shape);
  if (!mesh)
    throw Error(ErrorCode::invalid_argument,
                "the model of body \"" + body.name + "\" is finished: its cells do not follow the resolution",
                "name the mesh that it was made of");
  mesh->meshing.lattice.cells =
      std::max(2, static_cast<int>(std::lround(mesh->meshing.lattice.cells * resolution)));
}

}  // namespace

std::vector<SceneSettings> scene_grid(const Scene& scene, const SceneAxes& axes) {
  std::vector<SceneSettings> grid;
  for (VolumeSolver solver : axis(axes.solvers, scene.solver.volume))
    for (SpringIntegrator springs : axis(axes.springs, scene.solver.springs))
      for (double resolution : axis(axes.resolutions, 1.0))
        for (double tolerance : axis(axes.tolerances, scene.solver.tolerance))
          for (int substeps : axis(axes.substeps, scene.solver.substeps))
            grid.push_back({solver, springs, substeps, tolerance, resolution});
  return grid;
}

Scene apply_settings(const Scene& scene, const SceneSettings& settings) {
  Scene changed = scene;
  changed.solver.volume = settings.solver;
  changed.solver.springs = settings.springs;
  changed.solver.substeps = settings.substeps;
  changed.solver.tolerance = settings.tolerance;
  for (SceneBody& body : changed.bodies) refine(body, settings.resolution);
  return changed;
}

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
  const std::vector<SceneSettings> grid = scene_grid(scene, options.axes);
  Study study{scene, options, progress};
  SceneReport report{scene.name, {}, 0.0, {}, true};
  std::vector<ScenePoint> done;
  const auto known = [&](const SceneSettings& settings) {
    return std::ranges::find(done, settings, &ScenePoint::settings);
  };
  try {
    report.reference = reference_settings(study, grid);
    if (options.earlier.reference == report.reference) done = options.earlier.points;
    study.work = expected_work(study, report.reference);
    for (const SceneSettings& settings : grid)
      if (known(settings) == done.end())
        study.work += std::max(1, options.repeats) * expected_work(study, settings);
    study.reference = measured_run(study, report.reference, reference_index, true, "reference");
    report.reference_seconds = study.reference.seconds();
    for (std::size_t i = 0; i < grid.size(); ++i) {
      const auto earlier = known(grid[i]);
      const std::string phase = "point " + std::to_string(i + 1) + " of " + std::to_string(grid.size());
      report.points.push_back(earlier != done.end() ? *earlier
                                                    : run_point(study, grid[i], static_cast<int>(i), phase));
      if (options.on_point) options.on_point(report);
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::cancelled) throw;
    report.complete = false;
  }
  return report;
}

const ScenePoint* fit_budget(const SceneReport& report, double budget_ms) {
  const ScenePoint* best = nullptr;
  const auto key = [](const ScenePoint& p) {
    return std::pair(p.errors.trajectory_rms, p.errors.max_cell_volume);
  };
  for (const ScenePoint& point : report.points)
    if (point.outcome == Outcome::converged && point.ms_p95 <= budget_ms &&
        (!best || key(point) < key(*best)))
      best = &point;
  return best;
}

}  // namespace isochor

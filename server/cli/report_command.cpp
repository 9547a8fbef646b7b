#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

#include "core/export/atomic_file.h"
#include "core/parallel/parallel.h"
#include "core/report/meshing_report.h"
#include "core/report/scene_report.h"
#include "core/scene/read_scene.h"
#include "server/cli/commands.h"
#include "server/cli/data_folder.h"
#include "server/cli/input.h"
#include "server/cli/parameter_options.h"
#include "server/cli/recording.h"
#include "server/messages/report_messages.h"
#include "server/problem.h"
#include "server/report/report_page.h"
#include "server/store/content_id.h"

namespace isochor {
namespace {

namespace fs = std::filesystem;

constexpr const char* scene_group = "Axes, of scenes";
constexpr const char* mesh_group = "Axes, of meshes (all else as below)";

struct ReportCommand {
  std::vector<std::string> inputs;
  std::string output;
  std::vector<std::string> solvers, springs;  ///< an empty axis takes the usual values
  std::vector<int> substeps;
  std::vector<double> tolerances, resolutions;
  MeshingAxes meshing;
  int repeats = 3, refinement = 16;
  std::optional<double> budget_ms, point_limit;
  bool resume = false, recordings = false;
};

/// Without what a program that was killed has left in it.
void make_folder(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure)
    throw Error(ErrorCode::cannot_write,
                fmt::format("cannot make the folder {}: {}", folder.string(), failure.message()),
                "name one where you may write");
  remove_abandoned(folder);
}

/// The three files of a report.
void write_report(const fs::path& folder, const std::string& json, const std::string& csv) {
  write_file(folder / "report.json", json);
  write_file(folder / "report.csv", csv);
  write_file(folder / "report.html", make_report_page(json, data_folder("web")));
}

/// What is done is written while a run goes on, but no more than every two seconds: three files that are safe
/// on the disk take longer than a quick point.
class PartWriter {
 public:
  template <class Write>
  void write(const Write& write_files) {
    if (Clock::now() - last_ < std::chrono::seconds(2)) return;
    write_files();
    last_ = Clock::now();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

/// Recordings of the reference and of each point's first repeat, as `simulate` writes them. A name depends on
/// the point alone, so that those of an earlier run into the folder are never taken for others.
class PointRecorder {
 public:
  explicit PointRecorder(fs::path folder) : folder_(std::move(folder)) { make_folder(folder_); }

  void start(const std::optional<SceneSettings>& point, const Simulation& simulation) {
    const fs::path file = folder_ / ((point ? point_name(*point) : "reference") + ".ndjson");
    recording_ = make_recording(simulation, {file.string(), Encoding::f64, {}});
  }
  void add(const Snapshot& frame) { recording_->add(frame); }
  void end() { recording_->finish(); }

 private:
  fs::path folder_;
  std::unique_ptr<Recording> recording_;
};

void note_interruption(CliContext& context) {
  context.exit_code = exit_interrupted;
  context.note("interrupted; the same command with --resume goes on");
}

/// Of the trajectory, on the finest lattice, over the first axis that has any; all stand in the files.
void print_orders(const CliContext& context, const SceneReport& report) {
  std::string_view axis;
  for (const FittedOrder& order : fitted_orders(report)) {
    if (order.points < 3 || order.error != "trajectory_rms" || (!axis.empty() && order.axis != axis))
      continue;
    axis = order.axis;
    if (axis != "cell_size" && order.series.resolution != report.reference.settings.resolution) continue;
    const double rounded = std::round(100.0 * order.order) / 100.0 + 0.0;  // no −0
    context.print(fmt::format("order {:.2f} of {} in {}: {}, {} points", rounded, order.error, order.axis,
                              series_name(order), order.points));
  }
}

/// A dash where there is none.
std::string figure(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "–";
}

void print_scene_report(const CliContext& context, const SceneReport& report, const fs::path& folder) {
  context.print(fmt::format("{:<12} {:<16} {:>8} {:>9} {:>6} {:>10} {:>12} {:>12}  {}", "solver", "springs",
                            "substeps", "tolerance", "res", "ms a step", "trajectory", "cell volume",
                            "outcome"));
  const double floor = error_floor(report, scene_error_fields().front());
  bool any_below = false;
  for (const ScenePoint& p : report.points) {
    const bool below = p.errors.trajectory_rms <= floor;
    any_below |= below;
    context.print(fmt::format(
        "{:<12} {:<16} {:>8} {:>9.0e} {:>6.2g} {:>10} {:>12} {:>12}  {}{}", solver_name(p.settings.solver),
        springs_name(p.settings.springs), p.settings.substeps, p.settings.tolerance, p.settings.resolution,
        figure(p.ms_per_step.median, "{:.3g}"), figure(p.errors.trajectory_rms, below ? "~{:.2e}" : "{:.2e}"),
        figure(p.errors.max_cell_volume, "{:.2e}"), outcome_name(p.outcome),
        p.reason.empty() ? "" : ": " + p.reason));
  }
  if (!report.one_lattice.empty()) context.note(fmt::format("one resolution only: {}", report.one_lattice));
  if (!report.points.empty())
    context.note(fmt::format("at twice its step the reference is {:.2e} m (rms) from itself{}",
                             report.reference.errors.trajectory_rms,
                             any_below
                                 ? fmt::format("; errors up to {:.2e} m (~) cannot be told from its own, "
                                               "and no order is fitted to them",
                                               floor)
                                 : ""));
  if (report.reference.outcome != Outcome::converged && !report.points.empty())
    context.warning(fmt::format(
        "the reference itself is no solution ({}: {}): errors against it are differences between two runs",
        outcome_name(report.reference.outcome), report.reference.reason));
  print_orders(context, report);
  context.note("wrote " + (folder / "report.html").string());
}

void fit_scene_budget(const CliContext& context, const SceneReport& report, double budget_ms,
                      const fs::path& folder) {
  const ScenePoint* best = fit_budget(report, budget_ms);
  if (!best)
    throw Error(
        ErrorCode::over_budget,
        fmt::format("no settings of the grid simulate 95 % of their steps in four fifths of {:g} ms on "
                    "this machine",
                    budget_ms),
        "lower --resolutions, or allow a larger budget");
  write_file(folder / "budget.json", encode_settings(best->settings));
  const SceneErrorField& trajectory = scene_error_fields().front();
  const bool told = best->errors.trajectory_rms > error_floor(report, trajectory);
  context.note(
      fmt::format("within {:g} ms: {} and {} springs with {} substeps to {:g}: {:.3g} ms a step, {:.3g} ms "
                  "in 95 % of them, "
                  "trajectory error {:.2e} m{}; wrote {}",
                  budget_ms, solver_name(best->settings.solver), springs_name(best->settings.springs),
                  best->settings.substeps, best->settings.tolerance, best->ms_per_step.median, best->ms_p95,
                  best->errors.trajectory_rms,
                  told ? ""
                       : fmt::format(", no more than the reference's own: chosen by the cell error of {:.2e}",
                                     best->errors.max_cell_volume),
                  (folder / "budget.json").string()));
}

/// The file's id, and that of the meshes it names.
std::string source_of(const std::string& input, const Scene& scene) {
  std::string content = read_bytes(input);
  for (const SceneBody& body : scene.bodies)
    std::visit(
        [&](const auto& kind) {
          if (const auto* mesh = std::get_if<MeshShape>(&kind.shape))
            content += read_bytes(mesh->file.string());
        },
        body.kind);
  return content_id("scene-", content);
}

template <class T>
std::optional<std::vector<T>> asked(const std::vector<T>& axis) {
  return axis.empty() ? std::nullopt : std::optional(axis);
}

template <class T>
std::optional<std::vector<T>> named(const std::vector<std::string>& names,
                                    T (*value_of)(const std::string&)) {
  std::vector<T> axis;
  std::ranges::transform(names, std::back_inserter(axis), value_of);
  return asked(axis);
}

SceneAxes scene_axes(const ReportCommand& command) {
  return {named(command.solvers, solver_named), named(command.springs, springs_named),
          asked(command.substeps), asked(command.tolerances), asked(command.resolutions)};
}

/// The encoded report.
std::string run_scene_report(CliContext& context, const ReportCommand& command, const std::string& input,
                             const fs::path& folder) {
  const Scene scene = read_scene_file(input);
  SceneReportOptions options;
  options.axes = scene_axes(command);
  options.repeats = command.repeats;
  options.reference_refinement = command.refinement;
  options.point_limit = command.point_limit.value_or(options.point_limit);
  const std::string source = source_of(input, scene);
  if (command.resume && fs::exists(folder / "report.json"))
    options.earlier = decode_scene_report(read_bytes((folder / "report.json").string()), source);
  PartWriter parts;
  options.on_point = [&](SceneReport part) {
    part.complete = false;
    parts.write([&] {
      write_report(folder, encode_scene_report(part, command.budget_ms, source), encode_scene_csv(part));
    });
  };
  std::unique_ptr<PointRecorder> recorder;
  if (command.recordings) {
    recorder = std::make_unique<PointRecorder>(folder / "recordings");
    options.on_start = [&](const auto& point, const Simulation& simulation) {
      recorder->start(point, simulation);
    };
    options.on_frame = [&](const Snapshot& frame) { recorder->add(frame); };
    options.on_end = [&] { recorder->end(); };
  }
  SceneReport report;
  {
    CommandProgress progress(context);
    report = report_scene(scene, options, progress);
  }
  std::string json = encode_scene_report(report, command.budget_ms, source);
  if (report.points.empty() && !report.complete) {  // an earlier report may stand there
    note_interruption(context);
    return json;
  }
  write_report(folder, json, encode_scene_csv(report));
  print_scene_report(context, report, folder);
  if (!report.complete)
    note_interruption(context);
  else if (command.budget_ms)
    fit_scene_budget(context, report, *command.budget_ms, folder);
  return json;
}

MeshingAxes meshing_axes(const MeshingAxes& asked, const MeshingOptions& base) {
  MeshingAxes axes = usual_meshing_axes(base);
  if (!asked.voxels.empty()) axes.voxels = asked.voxels;
  if (!asked.cells.empty()) axes.cells = asked.cells;
  if (!asked.smoothing_iterations.empty()) axes.smoothing_iterations = asked.smoothing_iterations;
  if (!asked.p_in_voxels.empty()) axes.p_in_voxels = asked.p_in_voxels;
  return axes;
}

void print_meshing_report(const CliContext& context, const MeshingReport& report, const fs::path& folder) {
  context.print(fmt::format("{:>6} {:>5} {:>5} {:>8} {:>8} {:>8} {:>9} {:>10} {:>8}  {}", "voxels", "P_in",
                            "cells", "smoothed", "tets", "ms", "volume", "distance", "dihedral", "outcome"));
  for (const MeshingPoint& p : report.points) {
    const MeshingOptions& o = p.options;
    context.print(fmt::format("{:>6} {:>5.3g} {:>5} {:>8} {:>8} {:>8} {:>9} {:>10} {:>8}  {}", o.voxels,
                              o.pseudo_volume.p_in_voxels, o.lattice.cells, o.smoothing.iterations, p.tets,
                              figure(p.ms.median, "{:.3g}"),
                              p.volume_error      ? fmt::format("{:+.2f} %", 100.0 * *p.volume_error)
                              : p.problem.empty() ? "open"
                                                  : "–",
                              figure(p.distance(), "{:.3g}"), figure(p.quality.min_dihedral_deg, "{:.1f}"),
                              fmt::format("{}{}{}", outcome_name(outcome_of(p)),
                                          p.problem.empty() && p.incomplete.empty() ? "" : ": ",
                                          p.problem.empty() ? p.incomplete : p.problem)));
  }
  context.note("wrote " + (folder / "report.html").string());
}

void fit_meshing_budget(const CliContext& context, const MeshingReport& report, double budget_ms,
                        const fs::path& folder) {
  const MeshingPoint* best = fit_budget(report, budget_ms);
  if (!best)
    throw Error(ErrorCode::over_budget,
                fmt::format("no settings of the grid make a model in four fifths of {:g} ms", budget_ms),
                "lower --grid-voxels, or allow a larger budget");
  write_file(folder / "budget.json", write_meshing_options(best->options));
  context.note(fmt::format("within {:g} ms: {} voxels, {} cells: {:.3g} ms, {:.3g} from the input; wrote {}",
                           budget_ms, best->options.voxels, best->options.lattice.cells, best->ms.median,
                           best->distance(), (folder / "budget.json").string()));
}

std::string run_meshing_report(CliContext& context, const ReportCommand& command, const MeshingOptions& base,
                               const std::string& input, const fs::path& folder) {
  MeshingReportOptions options;
  options.base = base;
  options.axes = meshing_axes(command.meshing, base);
  options.repeats = command.repeats;
  const std::string source = content_id("mesh-", read_bytes(input));
  if (command.resume && fs::exists(folder / "report.json"))
    options.done = decode_meshing_report(read_bytes((folder / "report.json").string()), source).points;
  const std::string name = fs::path(input).filename().string();
  PartWriter parts;
  options.on_point = [&](MeshingReport part) {
    part.complete = false;
    parts.write([&] {
      write_report(folder, encode_meshing_report(part, name, command.budget_ms, source),
                   encode_meshing_csv(part));
    });
  };
  MeshingReport report;
  {
    CommandProgress progress(context);
    const InputMesh mesh = read_input({input, {}}, progress);
    report = report_meshing(mesh.soup, options, progress);
  }
  std::string json = encode_meshing_report(report, name, command.budget_ms, source);
  write_report(folder, json, encode_meshing_csv(report));
  print_meshing_report(context, report, folder);
  if (!report.complete)
    note_interruption(context);
  else if (command.budget_ms)
    fit_meshing_budget(context, report, *command.budget_ms, folder);
  return json;
}

bool is_scene(const std::string& input) {
  return fs::path(input).extension() == ".json";
}

/// Where a report of this input goes.
fs::path folder_of(const ReportCommand& command, const std::string& input) {
  const fs::path output = command.output;
  return command.inputs.size() == 1 ? output : output / fs::path(input).stem();
}

/// What can be refused before the work begins.
void check_command(const CLI::App& app, const ReportCommand& command) {
  std::set<fs::path> folders;
  for (const std::string& input : command.inputs)
    if (!folders.insert(folder_of(command, input)).second)
      throw Error(
          ErrorCode::invalid_argument,
          fmt::format("two inputs are called {}, and would share a folder", fs::path(input).stem().string()),
          "report them one by one, or rename one");
  const auto without = [&](const char* group, bool has_input, const char* what) {
    if (has_input) return;
    for (const CLI::Option* option :
         app.get_options([&](const CLI::Option* o) { return o->get_group() == group; }))
      if (option->count() > 0)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{} is for {}, and none is given", option->get_name(), what),
                    "leave it out; isochor report --help lists what goes with scenes and what with meshes");
  };
  const bool any_scene = std::ranges::any_of(command.inputs, is_scene);
  without(scene_group, any_scene, "scenes");
  for (const char* group : {mesh_group, "Meshing"})
    without(group, !std::ranges::all_of(command.inputs, is_scene), "meshes");
  make_report_page("{}", data_folder("web"));  // says where a part of it is missing
  for (const std::string& input : command.inputs)
    if (is_scene(input))
      check_scene_report(read_scene_file(input), {}, std::numeric_limits<std::int64_t>::max());
    else
      read_bytes(input);
}

void run_report(CliContext& context, const ReportCommand& command, const ParameterOptions& parameters) {
  set_thread_count(context.threads);  // reports name it
  Json documents = Json::array();
  std::optional<Error> unmet;  // a budget of one input does not stop the others
  for (const std::string& input : command.inputs) {
    if (context.exit_code == exit_interrupted) break;
    const fs::path folder = folder_of(command, input);
    make_folder(folder);
    try {
      const std::string json =
          is_scene(input) ? run_scene_report(context, command, input, folder)
                          : run_meshing_report(context, command, parameters.resolve(), input, folder);
      if (context.json) documents.push_back(Json::parse(json));
    } catch (const Error& error) {
      if (error.code() != ErrorCode::over_budget) throw;
      unmet.emplace(error.code(), input + ": " + error.what(), error.hint());
    }
  }
  if (unmet) throw *unmet;
  if (context.json) context.print_json(documents.size() == 1 ? documents.front() : documents);
}

}  // namespace

void add_report_command(CLI::App& app, CliContext& context) {
  CLI::App* command =
      add_command(app, context, "report",
                  "Error against run time of scenes, or of meshing a mesh, over a grid of settings");
  const auto options = std::make_shared<ReportCommand>();
  const auto parameters = std::make_shared<ParameterOptions>();
  command->add_option("INPUT", options->inputs, "Scenes (.json) or meshes")->required();
  command->add_option("-o,--output", options->output, "Folder for report.json, report.csv and report.html")
      ->required();
  const auto list = [&](const char* group, const char* name, auto& values, const char* type,
                        const char* meaning) {
    return command->add_option(name, values, meaning)->delimiter(',')->type_name(type)->group(group);
  };
  const auto range = [](AxisRange r) { return CLI::Range(r.min, r.max); };
  list(scene_group, "--solvers", options->solvers, "NAME,...",
       "Volume solvers: newton, gradient, scaling; all when absent")
      ->check(CLI::IsMember({"newton", "gradient", "scaling"}));
  list(scene_group, "--springs", options->springs, "NAME,...",
       "Integrators of the springs: auto, symplectic, implicit, energy_momentum; the scene's own when absent")
      ->check(CLI::IsMember({"auto", "symplectic", "implicit", "energy_momentum"}));
  list(scene_group, "--substeps", options->substeps, "N,...",
       "Substeps a frame, 0 to 1000; fewer than stability asks for are raised to it, as is 0; when absent "
       "once, "
       "twice, 4 and 8 times what the scene takes, and of symplectic Euler, where that takes more")
      ->check(range(substeps_range));
  list(scene_group, "--tolerances", options->tolerances, "NUMBER,...",
       "Largest relative volume error of a cell, 1e-12 to 0.1; 1e-2, 1e-4 and the scene's own when absent")
      ->check(range(tolerance_range));
  list(scene_group, "--resolutions", options->resolutions, "FACTOR,...",
       "Factors on the cells of each deformable body, 0.125 to 8, that leave whole cells along each axis; "
       "when absent 1 and 0.5, or the closest one below 1 that does")
      ->check(range(resolution_range));
  command
      ->add_option("--refinement", options->refinement,
                   "Substeps of the reference over the largest of the grid")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str()
      ->group(scene_group);
  command
      ->add_option("--point-limit", options->point_limit,
                   "Seconds after which a run of a point is stopped, and the point named too slow; none when "
                   "absent. The reference has no limit")
      ->check(CLI::PositiveNumber)
      ->group(scene_group);
  command
      ->add_flag(
          "--recordings", options->recordings,
          "Keep the frames of the reference and of every point that is run, by its name in report.json")
      ->group(scene_group);
  list(mesh_group, "--grid-voxels", options->meshing.voxels, "N,...",
       "Voxels; half and all of --voxels when absent");
  list(mesh_group, "--grid-cells", options->meshing.cells, "N,...",
       "Cells; half, all and four thirds of --cells when absent");
  list(mesh_group, "--grid-smoothing", options->meshing.smoothing_iterations, "N,...",
       "Smoothing iterations; 0 and --smoothing-iterations when absent");
  list(mesh_group, "--grid-p-in-voxels", options->meshing.p_in_voxels, "NUMBER,...",
       "P_in in voxels; once and twice --p-in-voxels when absent");
  command->add_option("--repeats", options->repeats, "Runs of each point; one of those above 10 s")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command
      ->add_option(
          "--budget-ms", options->budget_ms,
          "Name the settings with the smallest error that fit this time, and write them as budget.json, "
          "for simulate --params or mesh --params: 95 % of the steps of the slowest repeat, or the "
          "slowest meshing, take four fifths of it; the rest is in reserve, since a machine is not "
          "equally fast at all times")
      ->check(CLI::PositiveNumber);
  command->add_flag(
      "--resume", options->resume,
      "Take over all points that an earlier run into this folder has finished, other axes or not");
  parameters->add_to(*command);
  command->callback([&context, command, options, parameters] {
    context.run = [&context, command, options, parameters] {
      check_command(*command, *options);
      run_report(context, *options, *parameters);
    };
  });
}

}  // namespace isochor

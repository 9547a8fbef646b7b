#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "core/export/atomic_file.h"
#include "core/report/meshing_report.h"
#include "core/report/scene_report.h"
#include "core/scene/read_scene.h"
#include "server/cli/commands.h"
#include "server/cli/data_folder.h"
#include "server/cli/input.h"
#include "server/cli/parameter_options.h"
#include "server/messages/frame_codec.h"
#include "server/messages/report_messages.h"
#include "server/problem.h"
#include "server/report/report_page.h"
#include "server/store/content_id.h"

namespace isochor {
namespace {

namespace fs = std::filesystem;

struct ReportCommand {
  std::vector<std::string> inputs;
  std::string output;
  std::vector<std::string> solvers, springs;
  SceneAxes axes = usual_scene_axes;
  MeshingAxes meshing;  ///< an empty one takes the usual values
  int repeats = 3, refinement = 16;
  std::optional<double> budget_ms;
  bool resume = false, recordings = false;
};

/// The three files of a report; a part of a run is written as soon as it is done.
void write_report(const fs::path& folder, const std::string& json, const std::string& csv) {
  write_file(folder / "report.json", json);
  write_file(folder / "report.csv", csv);
  write_file(folder / "report.html", make_report_page(json, data_folder("web")));
}

/// Recordings of the reference and of each point's first repeat, as `simulate` writes them.
class PointRecorder {
 public:
  explicit PointRecorder(fs::path folder) : folder_(std::move(folder)) { fs::create_directories(folder_); }

  void start(int point, const Simulation& simulation) {
    file_.close();
    file_.clear();
    const std::string name = point < 0 ? "reference" : fmt::format("point-{:03}", point);
    file_.open(folder_ / (name + ".ndjson"), std::ios::binary);
    file_ << encode_hello(simulation, Encoding::f64);
  }
  void add(const Snapshot& frame) {
    file_ << encode_frame(frame, Encoding::f64);
    if (!file_)
      throw Error(ErrorCode::cannot_write, "cannot write a recording into " + folder_.string(),
                  "free some space, or leave out --recordings");
  }

 private:
  fs::path folder_;
  std::ofstream file_;
};

void note_interruption(CliContext& context) {
  context.exit_code = exit_interrupted;
  context.note("interrupted; the same command with --resume goes on");
}

void print_scene_report(const CliContext& context, const SceneReport& report, const fs::path& folder) {
  context.print(fmt::format("{:<12} {:<16} {:>8} {:>9} {:>6} {:>10} {:>12} {:>12}  {}", "solver", "springs",
                            "substeps", "tolerance", "res", "ms a step", "trajectory", "cell volume",
                            "outcome"));
  for (const ScenePoint& p : report.points)
    context.print(fmt::format("{:<12} {:<16} {:>8} {:>9.0e} {:>6.2g} {:>10.3g} {:>12.2e} {:>12.2e}  {}{}",
                              solver_name(p.settings.solver), springs_name(p.settings.springs), p.substeps,
                              p.settings.tolerance, p.settings.resolution, p.ms_per_step.median,
                              p.errors.trajectory_rms, p.errors.max_cell_volume, outcome_name(p.outcome),
                              p.reason.empty() ? "" : ": " + p.reason));
  for (const FittedOrder& order : fitted_orders(report))
    if (order.points > 2 && order.error == "trajectory_rms")
      context.print(fmt::format("order {:.2f} of {} in {}: {}, {} points", order.order, order.error,
                                order.axis, series_name(order), order.points));
  context.note("wrote " + (folder / "report.html").string());
}

void fit_scene_budget(const CliContext& context, const SceneReport& report, double budget_ms,
                      const fs::path& folder) {
  const ScenePoint* best = fit_budget(report, budget_ms);
  if (!best)
    throw Error(ErrorCode::over_budget,
                fmt::format("no settings of the grid simulate 95 % of their steps in {:g} ms on this machine",
                            budget_ms),
                "lower --resolutions, or allow a larger budget");
  write_file(folder / "budget.json", encode_settings(best->settings));
  context.note(
      fmt::format("within {:g} ms: {} and {} springs with {} substeps to {:g}: {:.3g} ms a step, {:.3g} ms "
                  "in 95 % of them, "
                  "trajectory error {:.2e} m; wrote {}",
                  budget_ms, solver_name(best->settings.solver), springs_name(best->settings.springs),
                  best->substeps, best->settings.tolerance, best->ms_per_step.median, best->ms_p95,
                  best->errors.trajectory_rms, (folder / "budget.json").string()));
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

/// The encoded report.
std::string run_scene_report(CliContext& context, const ReportCommand& command, const std::string& input,
                             const fs::path& folder) {
  const Scene scene = read_scene_file(input);
  SceneReportOptions options;
  options.axes = command.axes;
  if (!command.solvers.empty()) options.axes.solvers.clear();
  for (const std::string& name : command.solvers) options.axes.solvers.push_back(solver_named(name));
  for (const std::string& name : command.springs) options.axes.springs.push_back(springs_named(name));
  options.repeats = command.repeats;
  options.reference_refinement = command.refinement;
  const std::string source = source_of(input, scene);
  if (command.resume && fs::exists(folder / "report.json"))
    options.earlier = decode_scene_report(read_bytes((folder / "report.json").string()), source);
  options.on_point = [&](const SceneReport& part) {
    SceneReport so_far = part;
    so_far.complete = false;
    write_report(folder, encode_scene_report(so_far, command.budget_ms, source), encode_scene_csv(so_far));
  };
  std::unique_ptr<PointRecorder> recorder;
  if (command.recordings) {
    recorder = std::make_unique<PointRecorder>(folder / "recordings");
    options.on_start = [&](int point, const Simulation& simulation) { recorder->start(point, simulation); };
    options.on_frame = [&](int, const Snapshot& frame) { recorder->add(frame); };
  }
  SceneReport report;
  {
    CommandProgress progress(context);
    report = report_scene(scene, options, progress);
  }
  std::string json = encode_scene_report(report, command.budget_ms, source);
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
    context.print(fmt::format("{:>6} {:>5.3g} {:>5} {:>8} {:>8} {:>8.3g} {:>9} {:>10.3g} {:>8.1f}  {}",
                              o.voxels, o.pseudo_volume.p_in_voxels, o.lattice.cells, o.smoothing.iterations,
                              p.tets, p.ms.median,
                              p.volume_error ? fmt::format("{:+.2f} %", 100.0 * *p.volume_error) : "open",
                              p.quality.boundary_to_input, p.quality.min_dihedral_deg,
                              p.problem.empty() ? "converged" : "failed: " + p.problem));
  }
  context.note("wrote " + (folder / "report.html").string());
}

void fit_meshing_budget(const CliContext& context, const MeshingReport& report, double budget_ms,
                        const fs::path& folder) {
  const MeshingPoint* best = fit_budget(report, budget_ms);
  if (!best)
    throw Error(ErrorCode::over_budget,
                fmt::format("no settings of the grid make a model in {:g} ms", budget_ms),
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
  options.on_point = [&](const MeshingReport& part) {
    MeshingReport so_far = part;
    so_far.complete = false;
    write_report(folder, encode_meshing_report(so_far, name, command.budget_ms, source),
                 encode_meshing_csv(so_far));
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

void run_report(CliContext& context, const ReportCommand& command, const ParameterOptions& parameters) {
  Json documents = Json::array();
  std::optional<Error> unmet;  // a budget of one input does not stop the others
  for (const std::string& input : command.inputs) {
    if (context.exit_code == exit_interrupted) break;
    const fs::path folder = command.inputs.size() == 1 ? fs::path(command.output)
                                                       : fs::path(command.output) / fs::path(input).stem();
    fs::create_directories(folder);
    try {
      const std::string json =
          fs::path(input).extension() == ".json"
              ? run_scene_report(context, command, input, folder)
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
  const auto list = [&](const std::string& name, auto& values, const std::string& meaning) {
    return command->add_option(name, values, meaning)->delimiter(',');
  };
  list("--solvers", options->solvers, "Volume solvers to compare; all when absent")
      ->check(CLI::IsMember({"newton", "gradient", "scaling"}));
  list("--springs", options->springs, "Spring integrators")
      ->check(CLI::IsMember({"auto", "symplectic", "implicit", "energy_momentum"}));
  list("--substeps", options->axes.substeps, "Substeps a frame; 0 is automatic");
  list("--tolerances", options->axes.tolerances, "Largest relative volume error of a cell");
  list("--resolutions", options->axes.resolutions, "Factors on the cells of each deformable body");
  list("--grid-voxels", options->meshing.voxels, "Voxels, for a mesh");
  list("--grid-cells", options->meshing.cells, "Cells, for a mesh");
  list("--grid-smoothing", options->meshing.smoothing_iterations, "Smoothing iterations, for a mesh");
  list("--grid-p-in-voxels", options->meshing.p_in_voxels, "P_in in voxels, for a mesh");
  command->add_option("--repeats", options->repeats, "Runs of each point")->check(CLI::Range(1, 100));
  command
      ->add_option("--refinement", options->refinement,
                   "Substeps of the reference over the largest of the grid")
      ->check(CLI::Range(1, 1024));
  command->add_option("--budget-ms", options->budget_ms,
                      "Name the settings with the smallest error that keep 95 % of the steps (or meshing) "
                      "within this time, and "
                      "write them as budget.json, a params file");
  command->add_flag("--resume", options->resume, "Take over the points that an earlier run has finished");
  command->add_flag("--recordings", options->recordings,
                    "Keep the frames of the reference and of every point");
  parameters->add_to(*command);
  command->callback([&context, options, parameters] {
    context.run = [&context, options, parameters] { run_report(context, *options, *parameters); };
  });
}

}  // namespace isochor

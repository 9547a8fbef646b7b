#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/pipeline/shortfall.h"
#include "core/scene/read_scene.h"
#include "server/cli/commands.h"
#include "server/cli/input.h"
#include "server/cli/recording.h"
#include "server/cli/run_summary.h"
#include "server/messages/report_messages.h"

namespace isochor {
namespace {

struct SimulateCommand {
  std::string scene, params, encoding = "f32";
  RecordingOptions recording;
  double duration = 0.0;  ///< seconds; 0: the scene's own
  bool plan = false;
};

Scene read_input_scene(const SimulateCommand& command) {
  Scene scene = command.scene == "-" ? read_scene(read_bytes("-"), std::filesystem::current_path())
                                     : read_scene_file(command.scene);
  if (command.duration > 0.0) scene.duration = command.duration;
  return command.params.empty() ? scene : apply_params(scene, read_bytes(command.params));
}

void check(const CliContext& context, SimulateCommand& command, const Scene& scene) {
  command.recording.encoding = *parse_encoding(command.encoding);
  const std::string& output = command.recording.output;
  if (output.empty()) {
    if (command.plan) return;
    throw Error(ErrorCode::invalid_argument, "simulate needs a file to write",
                "add -o OUT.ndjson, or --plan");
  }
  check_recording_format(output);
  if (output == "-" && context.json)
    throw Error(ErrorCode::invalid_argument, "stdout can hold one document only",
                "write the recording to a file, or leave out --json");
  if (!scene.duration)
    throw Error(ErrorCode::invalid_argument, fmt::format("the scene \"{}\" runs without an end", scene.name),
                "give --duration in seconds");
}

/// A line a phase; times only after a run.
std::string plan_text(const Simulation& simulation, bool has_run) {
  const auto line = [&](char sign, std::string_view name, const std::string& memory, const std::string& time,
                        std::string_view reason) {
    return fmt::format("{} {:<17} {:>12} ", sign, name, memory) +
           (has_run ? fmt::format("{:>11} ", time) : "") + fmt::format(" {}\n", reason);
  };
  const auto kib = [](std::int64_t bytes) {
    return fmt::format("{:.1f} KiB", static_cast<double>(bytes) / 1024.0);
  };
  std::string text = line(' ', "phase", "memory", "time", "why it is in (+) or left out (-)");
  std::int64_t bytes = 0;
  double ms = 0.0;
  for (const PlannedPhase& phase : simulation.plan()) {
    text += phase.included
                ? line('+', phase.name, kib(phase.bytes), fmt::format("{:.2f} ms", phase.ms), phase.reason)
                : line('-', phase.name, "", "", phase.reason);
    bytes += phase.bytes, ms += phase.ms;
  }
  return text + line(' ', "all phases", kib(bytes), fmt::format("{:.2f} ms", ms), "");
}

/// What is simulated may be a part of the mesh only.
std::vector<std::string> warnings_of(const Simulation& simulation) {
  std::vector<std::string> warnings;
  for (const BodyTopology& body : simulation.topology())
    if (const auto fault = body.model ? shortfall(*body.model) : std::nullopt)
      warnings.push_back(
          fmt::format("the model of {} is incomplete: {}: {}", body.name, fault->what, fault->hint));
  return warnings;
}

RunSummary record(Simulation& simulation, Recording& recording, Progress& progress) {
  const double total = std::max(1.0, *simulation.scene().duration * simulation.scene().frame_rate);
  RunSummary summary;
  Snapshot frame = simulation.snapshot();
  recording.add(frame);
  while (!simulation.finished()) {
    progress.throw_if_cancelled();
    frame = simulation.step(progress);
    recording.add(frame);
    summary.add(frame);
    progress.report("simulate", std::min(1.0, static_cast<double>(frame.seq) / total));
  }
  return summary;
}

void print_result(const CliContext& context, const SimulateCommand& command, const Simulation& simulation,
                  const RunSummary& summary) {
  const Metrics& worst = summary.worst();
  context.note(
      fmt::format("{} frames at {:.3g} ms; largest volume error {:.2g} (cell), {:.2g} (total); "
                  "penetration {:.2g} m; {} recoveries, {} fallbacks",
                  summary.frames(), summary.ms_per_step(), worst.max_cell_volume_error,
                  worst.total_volume_error, worst.max_penetration, worst.recoveries, worst.fallbacks));
  if (!context.json) {
    if (command.plan) std::fputs(plan_text(simulation, true).c_str(), stdout);
    return;
  }
  Json document{{"scene", simulation.scene().name}};
  document.update(summary.json());
  document["plan"] = Json::parse(encode_plan(simulation.plan()));
  document["warnings"] = warnings_of(simulation);
  document["output"] = command.recording.output;
  context.print_json(document);
}

void print_plan(const CliContext& context, const Simulation& simulation) {
  if (context.json)
    context.print_json(
        {{"scene", simulation.scene().name}, {"plan", Json::parse(encode_plan(simulation.plan()))}});
  else
    std::fputs(plan_text(simulation, false).c_str(), stdout);
}

void run_simulate(const CliContext& context, SimulateCommand& command) {
  const Scene scene = read_input_scene(command);
  check(context, command, scene);
  std::unique_ptr<Simulation> simulation;
  RunSummary summary;
  {
    CommandProgress progress(context);
    simulation = compile(scene, progress);
    for (const std::string& warning : warnings_of(*simulation)) context.warning(warning);
    if (command.recording.output.empty()) return print_plan(context, *simulation);
    const auto recording = make_recording(*simulation, command.recording);
    summary = record(*simulation, *recording, progress);
    recording->finish();
  }
  print_result(context, command, *simulation, summary);
}

}  // namespace

void add_simulate_command(CLI::App& app, CliContext& context) {
  CLI::App* command = add_command(app, context, "simulate", "Run a scene and record its frames");
  const auto options = std::make_shared<SimulateCommand>();
  command->add_option("SCENE", options->scene, "Scene as JSON; - reads stdin")->required();
  command->add_option(
      "-o,--output", options->recording.output,
      "Recording to write: .ndjson, or an animation as .mdd, .pc2, .glb or .pvd; - is stdout");
  command->add_option("--encoding", options->encoding, "Positions in an .ndjson: f32, f64 or array")
      ->check(CLI::IsMember({"f32", "f64", "array"}))
      ->capture_default_str();
  command->add_option("--duration", options->duration, "Seconds to simulate instead of the scene's own")
      ->check(CLI::PositiveNumber);
  command->add_option("--params", options->params,
                      "JSON file with solver settings, as the budget.json of a report");
  command->add_option("--body", options->recording.body,
                      "Body of an animation; the first deformable one by default");
  command->add_flag("--plan", options->plan,
                    "Print the phases compiled in and those left out, with reasons; without -o, stop there");
  command->callback(
      [&context, options] { context.run = [&context, options] { run_simulate(context, *options); }; });
}

}  // namespace isochor

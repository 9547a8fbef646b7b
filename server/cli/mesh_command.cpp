#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "core/common/counted.h"
#include "core/export/atomic_file.h"
#include "core/export/export.h"
#include "core/pipeline/shortfall.h"
#include "core/report/meshing_report.h"
#include "server/build_info.h"
#include "server/cli/commands.h"
#include "server/cli/gates.h"
#include "server/cli/input.h"
#include "server/cli/parameter_options.h"
#include "server/messages/model_messages.h"
#include "server/problem.h"

namespace isochor {
namespace {

namespace fs = std::filesystem;

struct MeshCommand {
  InputOptions input;
  ParameterOptions parameters;
  std::vector<std::string> outputs;
  std::string format, require;
  bool dry_run = false;
  double max_memory_gib = 0.0;
  std::int64_t budget_tets = 0;
};

std::int64_t memory_limit(const MeshCommand& command) {
  if (command.max_memory_gib > 0.0) return static_cast<std::int64_t>(command.max_memory_gib * (1 << 30));
  return memory_budget();
}

const ExportFormat& format_of(const MeshCommand& command, const std::string& output) {
  if (!command.format.empty()) return export_format(command.format);
  if (output == "-") return export_format("msh2");
  return export_format_of(output);
}

/// Everything that can be refused before the work begins.
void check_outputs(const CliContext& context, const MeshCommand& command) {
  for (const std::string& output : command.outputs) {
    format_of(command, output);
    if (output == "-" && (context.json || command.outputs.size() > 1))
      throw Error(ErrorCode::invalid_argument, "stdout can hold one document only",
                  "write the model to a file, or leave out --json and the other outputs");
    // Files are replaced in their folder, devices and pipes written to.
    const fs::path target = output, folder = target.parent_path();
    const fs::path& written = fs::exists(target) && !fs::is_regular_file(target) ? target : folder;
    if (output != "-" && ::access(written.empty() ? "." : written.c_str(), W_OK) != 0)
      throw Error(ErrorCode::cannot_write, fmt::format("cannot write {}", output),
                  "check that the folder exists and that you may write there");
  }
}

/// One line, whatever a file is called.
std::string comment_for(const MeshCommand& command, const Model& model) {
  std::string text = fmt::format("isochor {} {} {}", build_info().version,
                                 fs::path(command.input.path).filename().string(), describe(model.options));
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

/// Returns the paths written.
Json write_outputs(const MeshCommand& command, const Model& model) {
  std::vector<std::vector<ExportFile>> sets;
  std::vector<NamedContent> contents;
  Json written = Json::array();
  for (const std::string& output : command.outputs) {
    const ExportFormat& format = format_of(command, output);
    const ExportModel subject{model.mesh(), model.embedding.get(), comment_for(command, model),
                              fs::path(output).stem().string()};
    sets.push_back(export_model(subject, format));
    if (output == "-" && sets.back().size() > 1)
      throw Error(ErrorCode::invalid_argument, fmt::format("{} is a set of several files", format.name),
                  "give a file name instead of -");
    const auto paths = export_paths(output, sets.back());
    for (std::size_t i = 0; i < paths.size(); ++i) {
      contents.push_back({paths[i], sets.back()[i].content});
      written.push_back(paths[i].string());
    }
  }
  write_files(contents);
  return written;
}

void print_summary(const CliContext& context, const Model& model, double read_ms) {
  double total = read_ms;
  context.detail(fmt::format("{:<16} {:9.2f} ms", "read", read_ms));
  for (const StageReport& stage : model.stages) {
    context.detail(fmt::format("{:<16} {:9.2f} ms", stage.name, stage.ms));
    total += stage.ms;
  }
  const QualitySummary& quality = model.quality;
  context.note(fmt::format(
      "{} in {}, {}, {}, {:.0f} ms; smallest dihedral {:.1f} "
      "deg, {} inverted, "
      "volume {:.6g}, coverage {:.1f} %, within {:.2f} cell diagonals of the pseudo volume (mean {:.2f})",
      counted(model.mesh().tets.size(), "tets"), counted(model.mesh().cells.size(), "cells"),
      counted(model.mesh().positions.size(), "vertices"), counted(model.lattice->components, "components"),
      total, quality.min_dihedral_deg, quality.inverted, quality.volume, 100.0 * quality.coverage,
      quality.to_pseudo_volume.max_diagonals, quality.to_pseudo_volume.mean_diagonals));
}

void run_dry(const CliContext& context, const MeshCommand& command, const TriangleSoup& soup,
             const MeshingOptions& options) {
  const SoupSize size = soup_size(soup);
  const Estimate counts = estimate(size, options);
  check_budget(size, options, memory_limit(command));
  if (context.json)
    return context.print_json({{"input", command.input.path},
                               {"params", parameters_json(options)},
                               {"estimate", estimate_json(counts)}});
  std::fputs(
      fmt::format("{} voxels, about {} cells and {} tets (at most {} and {}), {:.1f} MiB, about {:.2g} s\n",
                  counts.voxels, counts.cells, 5 * counts.cells, counts.max_cells, counts.max_tets,
                  static_cast<double>(counts.bytes) / (1 << 20), counts.seconds)
          .c_str(),
      stdout);
}

void print_result(const CliContext& context, const MeshCommand& command, const InputMesh& input,
                  const Model& model, Json written) {
  for (const std::string& warning : model.warnings) context.warning(warning);
  print_summary(context, model, input.read_ms);
  for (const Json& path : written) context.detail("wrote " + path.get<std::string>());
  if (written.empty() && !context.json) context.note("nothing is written: -o names a file for the model");
  if (!context.json) return;
  Json document{{"input", command.input.path}, {"bytes", input.bytes}, {"read_ms", input.read_ms}};
  document.update(model_json(model));
  document["outputs"] = std::move(written);
  document["report"] = mesh_report_json(*model.input);
  context.print_json(document);
}

void tell_budget(const CliContext& context, const Model& model, std::int64_t wanted) {
  const auto tets = static_cast<std::int64_t>(model.mesh().tets.size());
  context.note(
      fmt::format("closest to {}: --cells {}", counted(wanted, "tets"), model.options.lattice.cells));
  if (10 * std::abs(tets - wanted) <= wanted) return;
  const bool most_cells = model.options.lattice.cells + 2 > model.options.voxels / 2;
  context.warning(fmt::format("{} are the closest to {} that a lattice has{}", counted(tets, "tets"), wanted,
                              most_cells && tets < wanted ? ": more voxels allow more cells" : ""));
}

void run_mesh(CliContext& context, const MeshCommand& command) {
  MeshingOptions options = command.parameters.resolve(command.budget_tets > 0 ? Cells::sought : Cells::given);
  const auto gates = parse_gates(command.require);
  check_outputs(context, command);
  std::shared_ptr<const Model> model;
  InputMesh input;
  {
    CommandProgress progress(context);
    input = read_input(command.input, progress);
    if (command.dry_run) return run_dry(context, command, *input.soup, options);
    check_budget(soup_size(*input.soup), options, memory_limit(command));
    AuthoringPipeline pipeline(input.soup);
    if (command.budget_tets > 0) options = fit_tet_budget(pipeline, options, command.budget_tets, progress);
    model = pipeline.run(options, progress);
  }
  check_gates(*model, gates);
  print_result(context, command, input, *model, write_outputs(command, *model));
  if (command.budget_tets > 0) tell_budget(context, *model, command.budget_tets);
  if (const auto fault = shortfall(*model)) {
    std::fputs(fmt::format("error: the model is incomplete: {}\nhint: {}{}\n", fault->what, fault->hint,
                           command.outputs.empty() ? "" : "; what was made is written, to be looked at")
                   .c_str(),
               stderr);
    context.exit_code = exit_empty;
  }
}

}  // namespace

void add_mesh_command(CLI::App& app, CliContext& context) {
  CLI::App* command = add_command(app, context, "mesh", "Make a tetrahedral model from a triangle mesh");
  const auto options = std::make_shared<MeshCommand>();
  add_input_options(*command, options->input);
  command
      ->add_option("-o,--output", options->outputs,
                   "File to write, its format by its extension; may be repeated; - is stdout")
      ->allow_extra_args(false);  // else it would swallow INPUT
  command->add_option("--format", options->format, "Export format by name; see isochor formats");
  command->add_flag("--dry-run", options->dry_run, "Print counts and memory, and stop");
  command
      ->add_option("--require", options->require,
                   "Bounds that the model must keep, else exit 6: " + gate_names())
      ->type_name("NAME=NUMBER,...");
  command
      ->add_option("--budget-tets", options->budget_tets,
                   "Find the number of cells whose tets come closest to this number")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--max-memory", options->max_memory_gib,
                   "Refuse what needs more than this; 0 is three quarters of the machine's")
      ->type_name("GIB")
      ->check(CLI::NonNegativeNumber);
  options->parameters.add_to(*command);
  command->callback(
      [&context, options] { context.run = [&context, options] { run_mesh(context, *options); }; });
}

}  // namespace isochor

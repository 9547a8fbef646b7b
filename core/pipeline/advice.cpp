#include "core/pipeline/advice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/common/counted.h"
#include "core/pipeline/shortfall.h"
#include "core/pipeline/stages.h"

namespace isochor {
namespace {

constexpr double open_pockets = 0.67;  ///< a far_majority above what the votes in a pocket reach

void warn(Model& model, std::string text) {
  model.warnings.push_back(std::move(text));
}
void warn(Model& model, std::string text, std::string parameter, double value) {
  model.fixes.push_back({model.warnings.size(), std::move(parameter), value});
  model.warnings.push_back(std::move(text));
}

/// The p_in_voxels that a sheet needs to stay in one piece, 2·d_in ≥ 3·density·cell, and at least a quarter
/// more than now; rounded up to halves.
std::optional<double> wider_p_in(const Model& model) {
  const double cell = model.lattice->grid.spacing / model.field->grid.spacing;
  const double needed = std::max(1.5 * model.options.lattice.density * cell,
                                 1.25 * model.pseudo_volume->thresholds.p_in_voxels);
  const double p_in = std::ceil(2.0 * needed) / 2.0;
  return p_in <= 16.0 ? std::optional(p_in) : std::nullopt;
}

/// "along 2 edges", "at 1 vertex", or both.
std::string contacts_in_words(const Lattice& lattice) {
  std::vector<std::string> places;
  if (lattice.edge_contacts > 0) places.push_back("along " + counted(lattice.edge_contacts, "edges"));
  if (lattice.vertex_contacts > 0) places.push_back("at " + counted(lattice.vertex_contacts, "vertices"));
  return fmt::format("{}", fmt::join(places, " and "));
}

MeshingOptions with_p_in(const MeshingOptions& options, double p_in_voxels) {
  MeshingOptions changed = options;
  PseudoVolumeOptions& thresholds = changed.pseudo_volume;
  thresholds.p_in.reset(), thresholds.p_subs.reset();
  thresholds.p_in_voxels = p_in_voxels;
  thresholds.p_subs_voxels = std::max(thresholds.p_subs_voxels, p_in_voxels);
  return changed;
}

/// Tries settings on one soup, so that they share what they can.
class Trials {
 public:
  Trials(const Model& model, Progress& progress) : stages_(model.soup), progress_(progress) {}

  bool work(const MeshingOptions& options) {
    const auto model = stages_.run(options, progress_, Extent::whole);
    return model->lattice->kept_count > 0 && !shortfall(*model);
  }

 private:
  PipelineStages stages_;
  Progress& progress_;
};

/// The first of a few larger p_in_voxels that works.
std::optional<double> find_p_in(const Model& model, Trials& trials) {
  for (auto p_in = wider_p_in(model); p_in && *p_in <= 16.0; p_in = std::ceil(3.0 * *p_in) / 2.0)
    if (trials.work(with_p_in(model.options, *p_in))) return p_in;
  return std::nullopt;
}

/// A density that keeps at least the fullest cells; 0 where they are all but empty.
double lower_density(const Model& model) {
  return std::floor(80.0 * *std::ranges::max_element(model.lattice->density)) / 100.0;
}

/// That density, where it works.
std::optional<double> find_density(const Model& model, Trials& trials) {
  MeshingOptions options = model.options;
  options.lattice.density = lower_density(model);
  if (options.lattice.density < model.options.lattice.density && trials.work(options))
    return options.lattice.density;
  return std::nullopt;
}

/// A body all the same, of what is thinner than its cells.
std::string thick_advice(const Model& model) {
  const double density = lower_density(model);
  if (density <= 0.0 || density >= model.options.lattice.density) return "";
  return fmt::format(", or try density {}, which makes it as thick as its cells", density);
}

[[noreturn]] void throw_with_fix(const std::string& what, const std::string& parameter,
                                 std::optional<double> at_least, std::optional<double> at_most) {
  const double value = at_least ? *at_least : *at_most;
  throw Error(ErrorCode::empty_result, what, fmt::format("try {} {}", parameter, value),
              {{"/" + parameter, fmt::format("try {}", value), at_least, at_most}});
}

/// Where no setting that was tried works.
std::string last_advice(const Model& model) {
  if (model.enclosed_volume > 0.0) return wall_advice(model) + thick_advice(model);
  if (const auto fault = input_below_a_cell(model)) return fmt::format("{}: {}", fault->what, fault->hint);
  return "try the preset thin or more cells";
}

}  // namespace

void throw_empty(const Model& model, Progress& progress) {
  const bool no_voxel = model.pseudo_volume->inside_count == 0;
  const std::string what = no_voxel
                               ? "no voxel lies inside"
                               : "no lattice cell is filled enough to be kept, so there is no tetrahedron";
  Trials trials(model, progress);
  if (const auto p_in = find_p_in(model, trials)) throw_with_fix(what, "p_in_voxels", p_in, {});
  if (const auto density = find_density(model, trials)) throw_with_fix(what, "density", {}, density);
  throw Error(ErrorCode::empty_result, what, last_advice(model));
}

void add_warnings(Model& model) {
  const QualitySummary& quality = model.quality;
  const Lattice& lattice = *model.lattice;
  if (quality.coverage < sufficient_coverage) {
    const std::string text =
        fmt::format("the model covers {:.1f} % of the input's area; the rest lies more than a cell away",
                    100.0 * quality.coverage);
    if (const auto cells = finer_cells(model); cells && 2 * *cells <= model.options.voxels)
      warn(model, fmt::format("{}: {}", text, coverage_advice(model)), "cells", *cells);
    else if (const auto p_in = wider_p_in(model); p_in && !cells)
      warn(model, fmt::format("{}: try p_in_voxels {}", text, *p_in), "p_in_voxels", *p_in);
    else
      warn(model, fmt::format("{}: {}", text, coverage_advice(model)));
  }
  if (model.smoothed->largest_shrinkage > 0.05)
    warn(model,
         fmt::format("smoothing shrank a thin part by {:.0f} % before its volume was restored: use fewer "
                     "smoothing iterations",
                     100.0 * model.smoothed->largest_shrinkage),
         "smoothing_iterations", std::max(0, model.options.smoothing.iterations / 2));
  if (model.solid_shells)
    warn(model, fmt::format(
                    "parts that lie inside others and face the same way are taken as solid: turn them inside "
                    "out to make cavities of them, which leaves a volume of {:.4g}",
                    model.size.volume));
  if (lattice.components > 1)
    warn(model,
         fmt::format("the model falls into {} parts: largest_only keeps the largest", lattice.components),
         "largest_only", 1.0);
  if (lattice.edge_contacts + lattice.vertex_contacts > 0 && lattice.contacts != Contacts::separate)
    warn(model,
         fmt::format("cells touch only {} and will swing like hinges: set contacts to fill or separate",
                     contacts_in_words(lattice)));
  if (const double cell = lattice.grid.spacing; quality.boundary_to_input > std::sqrt(3.0) * cell) {
    const std::string text = fmt::format(
        "{:.2g} % of the model's boundary lies more than a cell's diagonal from the input, up to {:.1f} "
        "cells, where the pseudo volume closes an opening or fills a pocket",
        100.0 * quality.boundary_beyond, quality.boundary_to_input / cell);
    const PseudoVolumeOptions& options = model.options.pseudo_volume;
    const bool asked_already = options.enclosed && model.enclosed_volume > 0.0;  // of what is not enclosed
    if (options.far_majority < open_pockets && !asked_already)
      warn(model, fmt::format("{}: far_majority {} leaves pockets open", text, open_pockets), "far_majority",
           open_pockets);
    else
      warn(model, text);
  }
  if (const double most = quality.to_pseudo_volume.max_diagonals; most > 1.0)
    warn(model,
         fmt::format("the model's boundary lies up to {:.1f} cell diagonals from the pseudo volume that it "
                     "is made of: use more cells",
                     most));
  if (model.volume_error() > 0.1)
    warn(model, fmt::format("the volume is {:.4g}, but the closed input encloses {:.4g}: {}", quality.volume,
                            model.enclosed_volume, wall_advice(model)));
  else if (const auto fault = shortfall(model); fault && quality.coverage >= sufficient_coverage)
    warn(model, fmt::format("the model is incomplete: {}: {}", fault->what, fault->hint));
}

}  // namespace isochor

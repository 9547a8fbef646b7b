#include "core/pipeline/advice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/common/counted.h"
#include "core/pipeline/stages.h"

namespace isochor {
namespace {

constexpr double enough_coverage = 0.95;
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

bool covers_input(const std::shared_ptr<const TriangleSoup>& soup, const MeshingOptions& options,
                  Progress& progress) {
  const auto model = PipelineStages(soup).run(options, progress);
  return model->lattice->kept_count > 0 && model->quality.coverage >= enough_coverage;
}

/// The first of a few larger p_in_voxels that was tried and gives a model that covers the input.
std::optional<double> find_p_in(const Model& model, Progress& progress) {
  for (auto p_in = wider_p_in(model); p_in && *p_in <= 16.0; p_in = std::ceil(3.0 * *p_in) / 2.0)
    if (covers_input(model.soup, with_p_in(model.options, *p_in), progress)) return p_in;
  return std::nullopt;
}

}  // namespace

void throw_empty(const Model& model, Progress& progress) {
  const bool no_voxel = model.pseudo_volume->inside_count == 0;
  const std::string what = no_voxel
                               ? "no voxel lies inside"
                               : "no lattice cell is filled enough to be kept, so there is no tetrahedron";
  if (const auto p_in = find_p_in(model, progress))
    throw Error(ErrorCode::empty_result, what, fmt::format("try p_in_voxels {}", *p_in),
                {{"/p_in_voxels", fmt::format("try {}", *p_in), *p_in, std::nullopt}});
  throw Error(ErrorCode::empty_result, what,
              "try the preset thin, more cells, or a density below " +
                  fmt::format("{:.2f}", *std::ranges::max_element(model.lattice->density)));
}

void add_warnings(Model& model) {
  const QualitySummary& quality = model.quality;
  const Lattice& lattice = *model.lattice;
  if (quality.coverage < enough_coverage) {
    const std::string text =
        fmt::format("the model covers {:.1f} % of the input's area; the rest lies more than a cell away",
                    100.0 * quality.coverage);
    if (const auto p_in = wider_p_in(model))
      warn(model, fmt::format("{}: try p_in_voxels {}", text, *p_in), "p_in_voxels", *p_in);
    else
      warn(model, text + ": try the preset thin or more cells");
  }
  if (model.smoothed->largest_shrinkage > 0.05)
    warn(model,
         fmt::format("smoothing shrank a thin part by {:.0f} % before its volume was restored: use fewer "
                     "smoothing iterations",
                     100.0 * model.smoothed->largest_shrinkage),
         "smoothing_iterations", std::max(0, model.options.smoothing.iterations / 2));
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
        "the model's boundary lies up to {:.1f} cells from the input, where it closes a gap or fills a "
        "pocket",
        quality.boundary_to_input / cell);
    if (model.options.pseudo_volume.far_majority < open_pockets)
      warn(model, fmt::format("{}: far_majority {} leaves pockets open", text, open_pockets), "far_majority",
           open_pockets);
    else
      warn(model, text);
  }
  if (model.volume_error() > 0.1)
    warn(model, fmt::format("the volume is {:.4g}, but the closed input encloses {:.4g}: use more cells",
                            quality.volume, model.size.volume));
}

}  // namespace isochor

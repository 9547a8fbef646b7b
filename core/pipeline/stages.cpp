#include "core/pipeline/stages.h"

#include <algorithm>
#include <cmath>

#include "core/pseudo_volume/enclosed.h"
#include "core/tetrahedra/tetrahedra.h"

namespace isochor {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// None: the input has no inside, and leaves of two equal triangles have none either. Where it crosses
/// itself, its orientation tells overlaps from cavities.
std::optional<Enclosing> enclosing_rule(const MeshReport& input) {
  const auto has = [&](std::string_view defect) {
    return std::ranges::any_of(input.defects, [&](const Defect& d) { return d.name.starts_with(defect); });
  };
  if (input.components == 0 || has("open_edges") || has("non_manifold_edges") || has("duplicate_triangles"))
    return std::nullopt;
  if (!has("self_intersections")) return Enclosing::parity;
  return input.closed ? std::optional(Enclosing::winding) : std::nullopt;
}

}  // namespace

PipelineStages::PipelineStages(std::shared_ptr<const TriangleSoup> soup) : soup_(std::move(soup)) {}
PipelineStages::PipelineStages(std::shared_ptr<const TriangleSoup> soup, KnownInput known)
    : soup_(std::move(soup)), size_(known.size), input_(std::move(known.report)) {}

const SoupSize& PipelineStages::size() {
  if (!size_) size_ = soup_size(*soup_);
  return *size_;
}

void PipelineStages::thin(const std::shared_ptr<const DistanceField>& fine, int stride) {
  if (fine_.lock() == fine && stride_ == stride) return;
  fine_ = fine, stride_ = stride;
  field_.result.reset();
}

template <class Noun, class Options, class Make>
std::shared_ptr<const Noun> PipelineStages::update(std::string_view name, std::int64_t source,
                                                   Stage<Noun, Options>& stage, const Options& options,
                                                   Make&& make) {
  const bool reused = stage.result && stage.source == source && stage.options == options;
  if (!reused) {
    stage.result.reset();  // makes room, and after a throw the stage does not look fresh
    const auto begin = Clock::now();
    stage.result = std::make_shared<const Noun>(make());
    stage.options = options;
    stage.source = source;
    stage.serial = ++last_serial_;
    stage.ms = ms_since(begin);
  }
  reports_.push_back({name, stage.ms, reused});
  return stage.result;
}

void PipelineStages::measure(Model& model, Progress& progress) {
  if (quality_source_ != embedding_.serial) {
    const auto begin = Clock::now();
    if (!measured_soup_) measured_soup_.emplace(*soup_);
    progress.throw_if_cancelled();
    quality_ = summarize_quality(model.mesh(), *measured_soup_, *model.embedding, *model.field, progress);
    quality_ms_ = ms_since(begin);
    quality_source_ = embedding_.serial;
  }
  model.quality = quality_;
  model.quality_ms = quality_ms_;
}

std::shared_ptr<Model> PipelineStages::run_to_lattice(const MeshingOptions& options, Progress& progress) {
  auto model = std::make_shared<Model>();
  model->options = options;
  model->soup = soup_;
  model->size = size();
  if (!input_) input_ = std::make_shared<const MeshReport>(inspect(*soup_));
  model->input = input_;
  progress.throw_if_cancelled();
  reports_.clear();
  const DistanceFieldOptions field{options.voxels, field_padding};
  model->field = update("distance_field", 0, field_, field, [&] {
    const auto fine = fine_.lock();
    DistanceField made = fine ? thinned(*fine, stride_) : make_distance_field(*soup_, field, progress);
    const auto rule = enclosing_rule(*input_);
    enclosed_ = rule ? enclosed_voxels(*soup_, made, *rule, progress) : std::nullopt;
    return made;
  });
  model->pseudo_volume = update("pseudo_volume", field_.serial, pseudo_volume_, options.pseudo_volume, [&] {
    return make_pseudo_volume(*field_.result, options.pseudo_volume, progress,
                              enclosed_ ? &*enclosed_ : nullptr);
  });
  model->lattice = update("lattice", pseudo_volume_.serial, lattice_, options.lattice, [&] {
    return make_lattice(*pseudo_volume_.result, size().box, options.lattice, progress);
  });
  model->stages = reports_;
  return model;
}

std::shared_ptr<Model> PipelineStages::run(const MeshingOptions& options, Progress& progress) {
  std::shared_ptr<Model> model = run_to_lattice(options, progress);
  if (model->lattice->kept_count > 0) {
    model->unsmoothed = update("tetrahedra", lattice_.serial, unsmoothed_, Nothing{},
                               [&] { return make_tetrahedra(*lattice_.result, progress); });
    model->smoothed = update("smoothing", unsmoothed_.serial, smoothed_, options.smoothing,
                             [&] { return smooth(*unsmoothed_.result, options.smoothing, progress); });
    model->embedding = update("embedding", smoothed_.serial, embedding_, Nothing{},
                              [&] { return make_embedding(*soup_, model->mesh(), progress); });
    measure(*model, progress);
  }
  model->stages = reports_;
  return model;
}

}  // namespace isochor

#include "core/pipeline/stages.h"

#include <algorithm>
#include <cmath>

#include "core/mesh_input/orientation.h"
#include "core/pseudo_volume/enclosed.h"
#include "core/tetrahedra/tetrahedra.h"

namespace isochor {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// What tells inside from outside.
struct Boundary {
  std::shared_ptr<const TriangleSoup> soup;
  Enclosing rule;
};

/// None: the input has no inside. Parity asks for no orientation, but cannot tell overlaps from cavities.
std::optional<Boundary> boundary_of(const std::shared_ptr<const TriangleSoup>& soup,
                                    const MeshReport& input) {
  const auto outward = [](TriangleSoup any) {
    return Boundary{std::make_shared<const TriangleSoup>(facing_outward(std::move(any))), Enclosing::winding};
  };
  if (input.winds) return input.components > 1 ? outward(*soup) : Boundary{soup, Enclosing::winding};
  if (input.components == 0 || has(input, "open_edges") || has(input, "non_manifold_edges") ||
      has(input, "duplicate_triangles"))
    return std::nullopt;
  if (!has(input, "self_intersections")) return Boundary{soup, Enclosing::parity};
  if (auto alike = facing_alike(*soup)) return outward(*std::move(alike));
  return std::nullopt;
}

/// Sampled volumes are off where a plate lies between the columns; the signed one is exact, but counts
/// overlaps and shells within shells twice. By the same columns, parity leaves out what winding has there.
EnclosedVolume enclosed_volume(const Boundary& boundary, const MeshReport& input, double by_parity) {
  constexpr double same = 0.02;
  if (boundary.rule == Enclosing::parity) {
    const auto alike = facing_alike(*boundary.soup);
    const double exact = alike ? std::abs(signed_volume(*alike)) : by_parity;
    return {std::abs(exact - by_parity) < same * by_parity ? exact : by_parity, false};
  }
  const double by_winding = wound_volume(*boundary.soup), exact = std::abs(signed_volume(*boundary.soup));
  const bool crosses = has(input, "self_intersections") || !input.closed;
  const bool shells = !crosses && by_parity < (1.0 - same) * by_winding;
  const bool once = !crosses && !shells;
  return {once || std::abs(exact - by_winding) < same * by_winding ? exact : by_winding, shells};
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
    quality_.to_pseudo_volume = voxel_distance(model.mesh(), *model.pseudo_volume, progress);
    quality_ms_ = ms_since(begin);
    quality_source_ = embedding_.serial;
  }
  model.quality = quality_;
  model.quality_ms = quality_ms_;
}

/// That of what the input encloses, where the voxels sample little more than that; else 0.
double PipelineStages::true_volume(const PseudoVolume& volume) const {
  constexpr double same = 0.02;
  const auto more = static_cast<double>(std::abs(volume.inside_count - enclosed_count_));
  return more <= same * static_cast<double>(enclosed_count_) ? enclosed_volume_.volume : 0.0;
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
    enclosed_.reset(), enclosed_volume_ = {}, enclosed_count_ = 0;
    if (const auto boundary = boundary_of(soup_, *input_)) {
      progress.throw_if_cancelled();
      enclosed_volume_ = enclosed_volume(*boundary, *input_, size().volume);
      if (enclosed_volume_.volume > 0.0)
        enclosed_ = enclosed_voxels(*boundary->soup, made, boundary->rule, progress);
      if (enclosed_) enclosed_count_ = enclosed_->count();
    }
    return made;
  });
  model->enclosed_volume = enclosed_volume_.volume, model->solid_shells = enclosed_volume_.shells;
  model->pseudo_volume = update("pseudo_volume", field_.serial, pseudo_volume_, options.pseudo_volume, [&] {
    return make_pseudo_volume(*field_.result, options.pseudo_volume, progress,
                              enclosed_ ? &*enclosed_ : nullptr);
  });
  model->lattice = update("lattice", pseudo_volume_.serial, lattice_, options.lattice, [&] {
    const PseudoVolume& volume = *pseudo_volume_.result;
    return make_lattice(volume, size().box, options.lattice, progress, true_volume(volume));
  });
  model->stages = reports_;
  return model;
}

std::shared_ptr<Model> PipelineStages::run(const MeshingOptions& options, Progress& progress, Extent extent) {
  std::shared_ptr<Model> model = run_to_lattice(options, progress);
  if (model->lattice->kept_count > 0) {
    model->unsmoothed = update("tetrahedra", lattice_.serial, unsmoothed_, Nothing{},
                               [&] { return make_tetrahedra(*lattice_.result, progress); });
    model->smoothed = update("smoothing", unsmoothed_.serial, smoothed_, options.smoothing,
                             [&] { return smooth(*unsmoothed_.result, options.smoothing, progress); });
    if (extent == Extent::shape) {
      model->quality = summarize_tets(model->mesh(), progress);
    } else {
      model->embedding = update("embedding", smoothed_.serial, embedding_, Nothing{},
                                [&] { return make_embedding(*soup_, model->mesh(), progress); });
      measure(*model, progress);
    }
  }
  model->stages = reports_;
  return model;
}

}  // namespace isochor

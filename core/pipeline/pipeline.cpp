#include "core/pipeline/pipeline.h"

#include <algorithm>
#include <cmath>

#include "core/parallel/cancel_scope.h"
#include "core/pipeline/advice.h"
#include "core/pipeline/stages.h"

namespace isochor {

struct AuthoringPipeline::Stages : PipelineStages {
  using PipelineStages::PipelineStages;
};

double Model::volume_error() const {
  return enclosed_volume > 0.0 ? std::abs(quality.volume - enclosed_volume) / enclosed_volume : 0.0;
}

AuthoringPipeline::AuthoringPipeline(std::shared_ptr<const TriangleSoup> soup)
    : stages_(std::make_unique<Stages>(std::move(soup))) {}
AuthoringPipeline::AuthoringPipeline(std::shared_ptr<const TriangleSoup> soup, KnownInput known)
    : stages_(std::make_unique<Stages>(std::move(soup), std::move(known))) {}
AuthoringPipeline::~AuthoringPipeline() = default;
AuthoringPipeline::AuthoringPipeline(AuthoringPipeline&&) noexcept = default;
AuthoringPipeline& AuthoringPipeline::operator=(AuthoringPipeline&&) noexcept = default;

std::shared_ptr<const Model> AuthoringPipeline::run(const MeshingOptions& options, Progress& progress,
                                                    Extent extent) {
  stages_->thin({}, 1);
  return run_stages(options, progress, extent);
}

std::shared_ptr<const Model> AuthoringPipeline::run_thinned(const MeshingOptions& options,
                                                            const std::shared_ptr<const DistanceField>& field,
                                                            int stride, Progress& progress, Extent extent) {
  stages_->thin(field, stride);
  return run_stages(options, progress, extent);
}

std::shared_ptr<const Model> AuthoringPipeline::run_stages(const MeshingOptions& options, Progress& progress,
                                                           Extent extent) {
  const CancelScope scope(progress);
  check_budget(stages_->size(), options, memory_budget());
  std::shared_ptr<Model> model = stages_->run(options, progress, extent);
  if (model->lattice->kept_count == 0) throw_empty(*model, progress);
  if (extent == Extent::whole) add_warnings(*model);
  return model;
}

std::int64_t AuthoringPipeline::count_tets(const MeshingOptions& options, Progress& progress) {
  const CancelScope scope(progress);
  stages_->thin({}, 1);
  check_budget(stages_->size(), options, memory_budget());
  return 5 * stages_->run_to_lattice(options, progress)->lattice->kept_count;
}

}  // namespace isochor

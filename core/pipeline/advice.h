#pragma once
#include "core/pipeline/pipeline.h"

namespace isochor {

/// What a person should know of a model before trusting it, into model.warnings and model.fixes. Cheap: it
/// runs whenever a slider moves.
void add_warnings(Model& model);

/// empty_result for a model that ended without a cell; its hint names values that were tried and work.
[[noreturn]] void throw_empty(const Model& model, Progress& progress);

}  // namespace isochor

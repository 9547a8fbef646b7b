#pragma once
#include <optional>
#include <string>

#include "core/pipeline/pipeline.h"

namespace isochor {

/// Below this share of the input's area within one cell, a model is not a success.
inline constexpr double sufficient_coverage = 0.95;

/// Why a model is no success, and what to change.
struct Shortfall {
  std::string what, hint;
};

/// Nothing for a complete model. Short falls one that covers too little of its input, whose volume is more
/// than a quarter off what the input encloses (a tenth where it falls into pieces), or is more than a box
/// around the input could hold, or all of whose input is smaller than a cell's face. Cheap.
std::optional<Shortfall> shortfall(const Model& model);

/// The last of these: triangles that are next to nothing beside their distances.
std::optional<Shortfall> input_below_a_cell(const Model& model);

/// How many cells and voxels resolve the walls of a closed input, or that none do.
std::string wall_advice(const Model& model);

/// Twice the cells, for a closed input of which thin parts are missing: thresholds that keep them thicken the
/// rest. None where the input is open or its cells are the finest.
std::optional<int> finer_cells(const Model& model);

/// What brings back the parts of an input that a model does not cover.
std::string coverage_advice(const Model& model);

}  // namespace isochor

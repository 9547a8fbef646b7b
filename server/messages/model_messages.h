#pragma once
#include <string>

#include "core/parameters/parameters.h"
#include "core/pipeline/pipeline.h"
#include "server/messages/json.h"

namespace isochor {

/// Below this share of the input's area within one cell, a model is not a success.
inline constexpr double sufficient_coverage = 0.95;

/// JSON Schema (2020-12) of the parameter table, in table order. Beside the standard keywords each property
/// has "x-unit", "x-step" and "x-stage" (the first stage it makes stale); "x-presets" lists the presets.
Json parameters_schema();
/// The present values, as /models takes them and a params file holds them.
Json parameters_json(const MeshingOptions& options);

/// {vertices, triangles, components, bounds, area, closed, volume, defects: [{name, count, locations}]}
Json mesh_report_json(const MeshReport& report);
/// Why a model is no success: it covers too little of its input, or its volume is more than a quarter off
/// that of a closed input without self-intersections. Empty when it is complete.
std::string shortfall(const Model& model);

/// {params, cells, tets, vertices, components, volume, coverage, complete, inverted, min_dihedral_deg,
/// min_scaled_jacobian, …, stages: [{name, ms, reused}], warnings,
/// fixes: [{warning, parameter, value}]}: values that cure the warning of that number
Json model_json(const Model& model);
Json estimate_json(const Estimate& estimate);

/// [{name, extension, media_type, consumers, conventions}]
Json export_formats_json();

}  // namespace isochor

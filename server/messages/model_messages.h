#pragma once
#include <string>

#include "core/parameters/parameters.h"
#include "core/pipeline/pipeline.h"
#include "server/messages/json.h"

namespace isochor {

/// JSON Schema (2020-12) of the parameter table, in table order. Beside the standard keywords each property
/// has "x-unit", "x-step" and "x-stage" (the first stage it makes stale); "x-presets" lists the presets.
Json parameters_schema();
/// The present values, as /models takes them and a params file holds them.
Json parameters_json(const MeshingOptions& options);

/// {vertices, triangles, components, bounds, area, closed, volume, defects: [{name, count, locations}]}
Json mesh_report_json(const MeshReport& report);

/// {params, cells, tets, vertices, components, volume, coverage, complete, inverted, min_dihedral_deg,
/// min_scaled_jacobian, …, stages: [{name, ms, reused}], warnings,
/// fixes: [{warning, parameter, value}]}: values that cure the warning of that number
Json model_json(const Model& model);
Json estimate_json(const Estimate& estimate);

/// [{name, extension, media_type, consumers, conventions}]
Json export_formats_json();

}  // namespace isochor

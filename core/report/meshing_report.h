#pragma once
#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/common/progress.h"
#include "core/pipeline/pipeline.h"
#include "core/report/cost_model.h"
#include "core/report/fit.h"

namespace isochor {

/// The grid voxels × cells × smoothing × p_in_voxels; an empty axis takes the value of `base`.
struct MeshingAxes {
  std::vector<int> voxels, cells, smoothing_iterations;
  std::vector<double> p_in_voxels;
};

/// What is compared when nobody says otherwise: half and all of the voxels of `base`, half, all and four
/// thirds of its cells, with and without smoothing, P_in as it is and at twice its distance.
MeshingAxes usual_meshing_axes(const MeshingOptions& base);

struct MeshingPoint {
  MeshingOptions options;
  std::string problem;     ///< why there is no model; empty when there is one
  std::string incomplete;  ///< why the model is no success, as shortfall() says; empty when it is one
  QualitySummary quality;
  std::optional<double> volume_error;  ///< (model − input)/input, for closed input
  std::int64_t tets = 0, cells = 0;
  Spread ms;  ///< from the soup to the tets, over the repeats

  double fits_ms() const { return fitting_budget(ms.max); }
  /// From the boundary to the input or back, whichever is larger: a coarse model that misses a part may have
  /// its boundary close to the rest.
  double distance() const { return std::max(quality.boundary_to_input, quality.input_to_boundary); }
};

struct MeshingReport {
  std::vector<MeshingPoint> points;
  bool complete = true;  ///< false when cancelled
};

struct MeshingReportOptions {
  MeshingOptions base;
  MeshingAxes axes;
  int repeats = 3;
  std::vector<MeshingPoint> done;  ///< by an earlier run: all are taken over
  std::function<void(const MeshingReport&)> on_point;
};

/// The settings of every point. Throws invalid_argument when those of an earlier run differ in more than the
/// axes.
std::vector<MeshingOptions> meshing_grid(const MeshingReportOptions& options);

CostPlace cost_place(const MeshingOptions& options);

MeshingReport report_meshing(const std::shared_ptr<const TriangleSoup>& soup,
                             const MeshingReportOptions& options, Progress& progress);

/// The point whose boundary and input come closest, of the complete ones that fit the budget.
const MeshingPoint* fit_budget(const MeshingReport& report, double budget_ms);

/// The lattice resolution whose number of tets comes closest to the wanted one, all else as in base, found
/// among all that give between half and twice as many. Throws empty_result when no resolution gives a model.
MeshingOptions fit_tet_budget(AuthoringPipeline& pipeline, const MeshingOptions& base, std::int64_t tets,
                              Progress& progress);

}  // namespace isochor

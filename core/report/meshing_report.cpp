#include "core/report/meshing_report.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/pipeline/shortfall.h"
#include "core/report/pace.h"

namespace isochor {
namespace {

template <class T>
std::vector<T> axis(const std::vector<T>& values, T fallback) {
  return values.empty() ? std::vector<T>{fallback} : values;
}

std::vector<int> distinct(std::vector<int> rising) {
  rising.erase(std::unique(rising.begin(), rising.end()), rising.end());
  return rising;
}

constexpr QualitySummary unmeasured{.volume = not_measured,
                                    .min_dihedral_deg = not_measured,
                                    .min_scaled_jacobian = not_measured,
                                    .coverage = not_measured,
                                    .boundary_to_input = not_measured,
                                    .boundary_beyond = not_measured,
                                    .input_to_boundary = not_measured,
                                    .to_pseudo_volume = {not_measured, not_measured}};

/// Everything that the points of one report share.
struct Study {
  const std::shared_ptr<const TriangleSoup>& soup;
  const MeshingReportOptions& options;
  Progress& progress;
  Pace pace = Pace();

  int repeats() const { return std::max(1, options.repeats); }
};

/// What is done of a grid, in its order.
using DonePoints = std::vector<std::optional<MeshingPoint>>;

/// What failed costs little to try again.
bool settled(const std::optional<MeshingPoint>& point) {
  return point && point->problem.empty();
}

DonePoints done_before(const std::vector<MeshingOptions>& grid, const std::vector<MeshingPoint>& earlier) {
  DonePoints done;
  for (const MeshingOptions& settings : grid) {
    const auto known = std::ranges::find(earlier, settings, &MeshingPoint::options);
    done.push_back(known != earlier.end() ? std::optional(*known) : std::nullopt);
  }
  return done;
}

void describe(const Model& model, MeshingPoint& point) {
  point.quality = model.quality;
  if (const auto fault = shortfall(model)) point.incomplete = fault->what;
  point.tets = static_cast<std::int64_t>(model.mesh().tets.size());
  point.cells = static_cast<std::int64_t>(model.mesh().cells.size());
  if (const double enclosed = model.enclosed_volume; enclosed > 0.0)
    point.volume_error = (model.quality.volume - enclosed) / enclosed;
}

MeshingPoint run_point(Study& study, const MeshingOptions& options, const std::string& phase) {
  Progress quiet = study.progress.with_sink({});
  const CostPlace place = cost_place(options);
  MeshingPoint point;
  point.options = options;
  std::vector<double> ms;
  try {
    while (std::ssize(ms) < study.repeats()) {
      study.progress.report(phase, study.pace.fraction(place, 0.0, 0.0));
      AuthoringPipeline pipeline(study.soup);
      const auto begin = std::chrono::steady_clock::now();
      const auto model = pipeline.run(options, quiet);
      ms.push_back(
          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
      study.pace.end_run(place, ms.back() / 1000.0);
      describe(*model, point);
    }
  } catch (const Error& error) {
    if (error.code() == ErrorCode::cancelled) throw;
    point.problem = error.what();
    point.quality = unmeasured;
  }
  study.pace.leave_out(place);
  point.ms = spread_of(ms);
  return point;
}

void run_grid(Study& study, const std::vector<MeshingOptions>& grid, DonePoints& done,
              MeshingReport& report) {
  const auto collect = [&] {
    report.points.clear();
    for (const auto& point : done)
      if (point) report.points.push_back(*point);
  };
  collect();
  std::vector<CostPlace> places;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    places.push_back(cost_place(grid[i]));
    if (settled(done[i])) study.pace.know(places[i], done[i]->ms.median / 1000.0);
  }
  for (std::size_t i = 0; i < grid.size(); ++i)
    if (!settled(done[i])) study.pace.expect(places[i], study.repeats());
  auto number = std::ranges::count_if(done, settled);
  for (std::size_t i : revealing_order(places)) {
    if (settled(done[i])) continue;
    const std::string phase = "point " + std::to_string(++number) + " of " + std::to_string(grid.size());
    done[i] = run_point(study, grid[i], phase);
    collect();
    if (study.options.on_point) study.options.on_point(report);
  }
}

MeshingOptions at_place(const MeshingOptions& base, int voxels, double p_in, int cells, int iterations) {
  const double subs_over_in = base.pseudo_volume.p_subs_voxels / base.pseudo_volume.p_in_voxels;
  MeshingOptions options = base;
  options.voxels = voxels;
  options.pseudo_volume.p_in_voxels = p_in;
  options.pseudo_volume.p_subs_voxels = p_in * subs_over_in;
  options.lattice.cells = cells;
  options.smoothing.iterations = iterations;
  return options;
}

/// The points of an earlier run stay, where the axes do not ask for them, too.
void add_earlier(const MeshingReportOptions& report, std::vector<MeshingOptions>& grid) {
  for (const MeshingPoint& point : report.done) {
    const MeshingOptions& known = point.options;
    if (known != at_place(report.base, known.voxels, known.pseudo_volume.p_in_voxels, known.lattice.cells,
                          known.smoothing.iterations))
      throw Error(ErrorCode::invalid_argument,
                  "the report to resume differs from this one in a parameter that is no axis",
                  "give the same parameters, or run it afresh, without --resume or into another folder");
    if (std::ranges::find(grid, known) == grid.end()) grid.push_back(known);
  }
}

}  // namespace

MeshingAxes usual_meshing_axes(const MeshingOptions& base) {
  const int cells = base.lattice.cells, most_cells = std::min(cells * 4 / 3, base.voxels / 2);
  MeshingAxes axes{distinct({std::max({16, base.voxels / 2, 2 * most_cells}), base.voxels}),
                   distinct({std::max(2, cells / 2), cells, std::max(cells, most_cells)}),
                   distinct({0, base.smoothing.iterations}),
                   {}};
  const double p_in = base.pseudo_volume.p_in_voxels;
  if (!base.pseudo_volume.p_in && !base.pseudo_volume.p_subs)
    axes.p_in_voxels = {p_in, std::min(2.0 * p_in, 16.0)};
  return axes;
}

std::vector<MeshingOptions> meshing_grid(const MeshingReportOptions& report) {
  const MeshingOptions& base = report.base;
  std::vector<MeshingOptions> grid;
  for (int voxels : axis(report.axes.voxels, base.voxels))
    for (double p_in : axis(report.axes.p_in_voxels, base.pseudo_volume.p_in_voxels))
      for (int cells : axis(report.axes.cells, base.lattice.cells))
        for (int iterations : axis(report.axes.smoothing_iterations, base.smoothing.iterations))
          grid.push_back(at_place(base, voxels, p_in, cells, iterations));
  add_earlier(report, grid);
  return grid;
}

CostPlace cost_place(const MeshingOptions& options) {
  const double voxels = std::log(options.voxels), cells = std::log(options.lattice.cells),
               p_in = std::log(options.pseudo_volume.p_in_voxels),
               smoothing = std::log1p(options.smoothing.iterations);
  return {0, 0, {voxels, cells, smoothing, p_in}, 1.5 * voxels + 0.5 * cells};
}

MeshingReport report_meshing(const std::shared_ptr<const TriangleSoup>& soup,
                             const MeshingReportOptions& options, Progress& progress) {
  const std::vector<MeshingOptions> grid = meshing_grid(options);
  DonePoints done = done_before(grid, options.done);
  Study study{soup, options, progress};
  MeshingReport report;
  try {
    run_grid(study, grid, done, report);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::cancelled) throw;
    report.complete = false;
  }
  return report;
}

const MeshingPoint* fit_budget(const MeshingReport& report, double budget_ms) {
  const MeshingPoint* best = nullptr;
  for (const MeshingPoint& point : report.points)
    if (point.problem.empty() && point.incomplete.empty() && point.fits_ms() <= budget_ms &&
        (!best || point.distance() < best->distance()))
      best = &point;
  return best;
}

// The number of tets grows with the resolution but not monotonically (a finer lattice may lose a thin part,
// or fit a flat side by a layer less), so that the first crossing is only where the search begins: it goes on
// both ways until the numbers are out of question. A new resolution costs the lattice and what follows only.
MeshingOptions fit_tet_budget(AuthoringPipeline& pipeline, const MeshingOptions& base, std::int64_t tets,
                              Progress& progress) {
  MeshingOptions options = base, best = base;
  std::int64_t best_distance = -1;
  const int largest = std::min(256, base.voxels / 2);
  const auto count = [&](int cells) -> std::int64_t {
    options.lattice.cells = cells;
    const std::int64_t found = pipeline.count_tets(options, progress);
    if (found == 0) return 0;
    const std::int64_t distance = std::abs(found - tets);
    if (best_distance < 0 || distance < best_distance) best = options, best_distance = distance;
    return found;
  };
  int low = 1, high = largest / 2;  // half the cells: odd numbers of them round up
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (count(2 * middle) < tets ? low : high) = middle;
  }
  for (int half = low; half >= 1 && 2 * count(2 * half) > tets; --half) {
  }
  for (int half = high; 2 * half <= largest && count(2 * half) < 2 * tets; ++half) {
  }
  if (best_distance < 0)
    throw Error(ErrorCode::empty_result, "no lattice resolution gives a model",
                "raise p_in_voxels or lower the density threshold");
  return best;
}

}  // namespace isochor

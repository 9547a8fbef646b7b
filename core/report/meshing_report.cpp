#include "core/report/meshing_report.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "core/pipeline/shortfall.h"

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

MeshingPoint measure(const std::shared_ptr<const TriangleSoup>& soup, const MeshingOptions& options,
                     int repeats, const Progress& progress) {
  Progress quiet = progress.with_sink({});
  MeshingPoint point;
  point.options = options;
  std::vector<double> ms;
  try {
    for (int repeat = 0; repeat < std::max(1, repeats); ++repeat) {
      AuthoringPipeline pipeline(soup);
      const auto begin = std::chrono::steady_clock::now();
      const auto model = pipeline.run(options, quiet);
      ms.push_back(
          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
      point.quality = model->quality;
      if (const auto fault = shortfall(*model)) point.incomplete = fault->what;
      point.tets = static_cast<std::int64_t>(model->mesh().tets.size());
      point.cells = static_cast<std::int64_t>(model->mesh().cells.size());
      if (const double enclosed = model->enclosed_volume(); enclosed > 0.0)
        point.volume_error = (model->quality.volume - enclosed) / enclosed;
    }
  } catch (const Error& error) {
    if (error.code() == ErrorCode::cancelled) throw;
    point.problem = error.what();
  }
  point.ms = spread_of(ms);
  return point;
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
  const double subs_over_in = base.pseudo_volume.p_subs_voxels / base.pseudo_volume.p_in_voxels;
  std::vector<MeshingOptions> grid;
  for (int voxels : axis(report.axes.voxels, base.voxels))
    for (double p_in : axis(report.axes.p_in_voxels, base.pseudo_volume.p_in_voxels))
      for (int cells : axis(report.axes.cells, base.lattice.cells))
        for (int iterations : axis(report.axes.smoothing_iterations, base.smoothing.iterations)) {
          MeshingOptions options = base;
          options.voxels = voxels;
          options.pseudo_volume.p_in_voxels = p_in;
          options.pseudo_volume.p_subs_voxels = p_in * subs_over_in;
          options.lattice.cells = cells;
          options.smoothing.iterations = iterations;
          grid.push_back(options);
        }
  return grid;
}

MeshingReport report_meshing(const std::shared_ptr<const TriangleSoup>& soup,
                             const MeshingReportOptions& options, Progress& progress) {
  const std::vector<MeshingOptions> grid = meshing_grid(options);
  MeshingReport report;
  const auto work = [](double sum, const MeshingOptions& settings) { return sum + settings.voxels; };
  const double whole = std::accumulate(grid.begin(), grid.end(), 0.0, work);
  try {
    for (auto settings_at = grid.begin(); settings_at != grid.end(); ++settings_at) {
      const MeshingOptions& settings = *settings_at;
      const std::string phase =
          "point " + std::to_string(report.points.size() + 1) + " of " + std::to_string(grid.size());
      progress.report(phase, std::accumulate(grid.begin(), settings_at, 0.0, work) / whole);
      const auto known = std::ranges::find(options.done, settings, &MeshingPoint::options);
      report.points.push_back(
          known != options.done.end() ? *known : measure(soup, settings, options.repeats, progress));
      if (options.on_point) options.on_point(report);
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::cancelled) throw;
    report.complete = false;
  }
  return report;
}

const MeshingPoint* fit_budget(const MeshingReport& report, double budget_ms) {
  const MeshingPoint* best = nullptr;
  for (const MeshingPoint& point : report.points)
    if (point.problem.empty() && point.incomplete.empty() && point.ms.median <= budget_ms &&
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

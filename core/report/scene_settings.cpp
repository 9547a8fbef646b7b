#include "core/report/scene_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/common/error.h"

namespace isochor {
namespace {

const std::vector<VolumeSolver> usual_solvers{VolumeSolver::newton, VolumeSolver::gradient,
                                              VolumeSolver::scaling};

template <class T>
std::vector<T> sorted(std::vector<T> values) {
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

template <class T>
std::vector<T> values_of(const std::optional<std::vector<T>>& axis, const std::vector<T>& usual, T own) {
  if (!axis) return usual;
  return axis->empty() ? std::vector<T>{own} : *axis;
}

std::vector<double> usual_tolerances(double own) {
  std::vector<double> tolerances = sorted(std::vector{1e-2, 1e-4, own});
  std::ranges::reverse(tolerances);  // the quick ones first
  return tolerances;
}

std::vector<int> usual_substeps(SceneSettings settings, const AsStepped& as_stepped) {
  constexpr int many = 64, most_needed = 256;
  settings.substeps = 0;
  const int first = as_stepped(settings).substeps;
  std::vector<int> substeps{first, 2 * first, 4 * first};
  if (8 * first <= many) substeps.push_back(8 * first);
  if (settings.springs == SpringIntegrator::automatic) {
    settings.springs = SpringIntegrator::symplectic;
    const int needed = as_stepped(settings).substeps;
    if (needed > first && needed <= most_needed)
      substeps.insert(substeps.end(), {needed, 2 * needed, 4 * needed});
  }
  return sorted(std::move(substeps));
}

/// Cubes that fill the same box, or the body would be another.
Vec3i refined(const Vec3i& cells, double resolution, const std::string& body) {
  constexpr double written_short = 0.01;  // cells: 0.333 is a third
  const Vec3 wanted = cells.cast<double>() * resolution, whole = wanted.array().round();
  if (whole.minCoeff() < 1.0 || (wanted - whole).cwiseAbs().maxCoeff() > written_short)
    throw Error(ErrorCode::invalid_argument,
                fmt::format("{} × {} × {} cells of body \"{}\" times {:g} are no whole cells", cells.x(),
                            cells.y(), cells.z(), body, resolution),
                "choose a factor that leaves whole ones along each axis, as 2 does");
  return whole.cast<int>();
}

void refine(SceneBody& body, double resolution) {
  auto* deformable = std::get_if<DeformableBody>(&body.kind);
  if (!deformable || resolution == 1.0) return;
  if (auto* lattice = std::get_if<LatticeShape>(&deformable->shape)) {
    // The scene's own stiffness, read as a modulus at its own cell size, so that the material stays the same.
    if (!deformable->edge_modulus) deformable->edge_modulus = deformable->edge_stiffness / lattice->cell_size;
    if (!deformable->diagonal_modulus)
      deformable->diagonal_modulus = deformable->diagonal_stiffness / lattice->cell_size;
    const Vec3i own = std::exchange(lattice->cells, refined(lattice->cells, resolution, body.name));
    lattice->cell_size *= static_cast<double>(own.maxCoeff()) / lattice->cells.maxCoeff();
    return;
  }
  if (!deformable->edge_modulus || !deformable->diagonal_modulus)
    throw Error(ErrorCode::invalid_argument,
                "body \"" + body.name + "\" gives its springs in N/m, which do not follow the resolution",
                "give edge_modulus and diagonal_modulus in Pa");
  auto* mesh = std::get_if<MeshShape>(&deformable->shape);
  if (!mesh)
    throw Error(ErrorCode::invalid_argument,
                "the model of body \"" + body.name + "\" is finished: its cells do not follow the resolution",
                "name the mesh that it was made of");
  int& cells = mesh->meshing.lattice.cells;
  const int own = std::exchange(cells, static_cast<int>(std::lround(cells * resolution)));
  if (cells < 2)
    throw Error(ErrorCode::invalid_argument,
                fmt::format("{} cells of body \"{}\" times {:g} are less than 2", own, body.name, resolution),
                "choose a larger factor");
}

bool has_cells(const Scene& scene) {
  return std::ranges::any_of(
      scene.bodies, [](const SceneBody& body) { return std::holds_alternative<DeformableBody>(body.kind); });
}

/// Half the cells of each body, or the closest share that leaves every lattice its shape.
double coarser(const Scene& scene) {
  int divisor = 0;
  for (const SceneBody& body : scene.bodies)
    if (const auto* deformable = std::get_if<DeformableBody>(&body.kind))
      if (const auto* lattice = std::get_if<LatticeShape>(&deformable->shape))
        for (int cells : lattice->cells) divisor = std::gcd(divisor, cells);
  if (divisor == 1)
    throw Error(ErrorCode::invalid_argument, "the numbers of cells along the axes have no common divisor",
                "fewer cells would be other bodies; resolutions of 1 and 2 compare with more");
  return divisor == 0 ? 0.5 : std::round(0.5 * divisor) / divisor;
}

std::vector<double> usual_resolutions(const Scene& scene) {
  if (!has_cells(scene) || !why_one_lattice(scene).empty()) return {1.0};
  return {coarser(scene), 1.0};
}

}  // namespace

std::string why_one_lattice(const Scene& scene) try {
  if (has_cells(scene)) apply_settings(scene, {.resolution = coarser(scene)});
  return "";
} catch (const Error& error) {
  return fmt::format("{}: {}", error.what(), error.hint());
}

std::vector<SceneSettings> scene_grid(const Scene& scene, const SceneAxes& axes,
                                      const AsStepped& as_stepped) {
  const SolverOptions& own = scene.solver;
  std::vector<SceneSettings> grid;
  const auto add = [&](SceneSettings settings, int substeps) {
    settings.substeps = substeps;
    settings = as_stepped(settings);
    if (std::ranges::find(grid, settings) == grid.end()) grid.push_back(settings);
  };
  for (VolumeSolver solver : values_of(axes.solvers, usual_solvers, own.volume))
    for (SpringIntegrator springs : values_of(axes.springs, {own.springs}, own.springs))
      for (double resolution : values_of(axes.resolutions, usual_resolutions(scene), 1.0))
        for (double tolerance : values_of(axes.tolerances, usual_tolerances(own.tolerance), own.tolerance)) {
          const SceneSettings settings{solver, springs, 0, tolerance, resolution};
          for (int substeps : values_of(axes.substeps, usual_substeps(settings, as_stepped), own.substeps))
            add(settings, substeps);
        }
  return grid;
}

CostPlace cost_place(const SceneSettings& settings) {
  const double substeps = std::log(std::max(1, settings.substeps)),
               cells = 3.0 * std::log(settings.resolution),
               decades = std::log(-std::log10(settings.tolerance));
  // Solvers that go cell by cell take more sweeps the more cells there are; an implicit step about five times
  // an explicit one.
  const double sweeps = settings.solver == VolumeSolver::newton ? 0.0 : 0.5 * cells,
               integrator = settings.springs == SpringIntegrator::symplectic ? 0.0 : std::log(5.0);
  return {static_cast<int>(settings.solver),
          static_cast<int>(settings.springs),
          {substeps, cells, decades},
          substeps + cells + decades + sweeps + integrator};
}

std::size_t most_points(const SceneAxes& axes) {
  const auto size = [](const auto& axis, std::size_t usual) {
    return axis ? std::max<std::size_t>(1, axis->size()) : usual;
  };
  return size(axes.solvers, 3) * size(axes.springs, 1) * size(axes.substeps, 7) * size(axes.tolerances, 3) *
         size(axes.resolutions, 2);
}

Scene apply_settings(const Scene& scene, const SceneSettings& settings) {
  Scene changed = scene;
  changed.solver.volume = settings.solver;
  changed.solver.springs = settings.springs;
  changed.solver.substeps = settings.substeps;
  changed.solver.tolerance = settings.tolerance;
  for (SceneBody& body : changed.bodies) refine(body, settings.resolution);
  return changed;
}

}  // namespace isochor

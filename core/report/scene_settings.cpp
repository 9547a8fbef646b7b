#include "core/report/scene_settings.h"

#include <algorithm>
#include <cmath>

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

void refine(SceneBody& body, double resolution) {
  auto* deformable = std::get_if<DeformableBody>(&body.kind);
  if (!deformable || resolution == 1.0) return;
  if (auto* lattice = std::get_if<LatticeShape>(&deformable->shape)) {
    // The scene's own stiffness, read as a modulus at its own cell size, so that the material stays the same.
    if (!deformable->edge_modulus) deformable->edge_modulus = deformable->edge_stiffness / lattice->cell_size;
    if (!deformable->diagonal_modulus)
      deformable->diagonal_modulus = deformable->diagonal_stiffness / lattice->cell_size;
    const Vec3 extent = lattice->cells.cast<double>() * lattice->cell_size;
    const int longest = std::max(1, static_cast<int>(std::lround(lattice->cells.maxCoeff() * resolution)));
    lattice->cell_size = extent.maxCoeff() / longest;
    lattice->cells = (extent / lattice->cell_size).array().round().max(1.0).cast<int>();
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
  mesh->meshing.lattice.cells =
      std::max(2, static_cast<int>(std::lround(mesh->meshing.lattice.cells * resolution)));
}

std::int64_t asked_cells(const Scene& scene) {
  std::int64_t cells = 0;
  for (const SceneBody& body : scene.bodies)
    if (const auto* deformable = std::get_if<DeformableBody>(&body.kind)) {
      if (const auto* lattice = std::get_if<LatticeShape>(&deformable->shape))
        cells += lattice->cells.cast<std::int64_t>().prod();
      if (const auto* mesh = std::get_if<MeshShape>(&deformable->shape)) cells += mesh->meshing.lattice.cells;
    }
  return cells;
}

/// Half the cells as well, where every body follows and one has then fewer.
std::vector<double> usual_resolutions(const Scene& scene) try {
  const Scene half = apply_settings(scene, {.resolution = 0.5});
  return asked_cells(half) < asked_cells(scene) ? std::vector{0.5, 1.0} : std::vector{1.0};
} catch (const Error&) {
  return {1.0};
}

}  // namespace

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

// Every stage of meshing on its own, with the growth over what it works on: triangles, voxels, cells or
// vertices (complexity_n). One thread; CPU time. A torus without symmetry to the grid, so that sizes can be
// chosen freely.
#include <benchmark/benchmark.h>

#include <array>
#include <map>
#include <sstream>

#include "core/embedding/embedding.h"
#include "core/lattice/lattice.h"
#include "core/mesh_input/inspect.h"
#include "core/mesh_input/read_mesh.h"
#include "core/parallel/parallel.h"
#include "core/pipeline/pipeline.h"
#include "core/quality/quality.h"
#include "core/smoothing/smoothing.h"
#include "tests/support/shapes.h"

namespace isochor {
namespace {

constexpr int usual_segments = 264;  // 69,696 triangles, as many as the bunny
constexpr int usual_voxels = 128, usual_cells = 48;

TriangleSoup tilted_torus(int segments) {
  TriangleSoup soup = test::torus(1.0, 0.4, segments);
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(0.5, Vec3::UnitX()) * Eigen::AngleAxisd(0.3, Vec3::UnitY())).toRotationMatrix();
  for (Vec3& p : soup.positions) p = turn * p;
  return soup;
}

/// Everything that the stages take from the one before.
struct Model {
  TriangleSoup soup;
  DistanceField field;
  PseudoVolume volume;
  Lattice lattice;
  TetMesh mesh;
  Smoothed smoothed;
};

/// Made once: Google Benchmark calls a function again for every number of iterations it tries.
const Model& make_model(int segments, int voxels, int cells) {
  static std::map<std::array<int, 3>, Model> made;
  const auto [known, missing] = made.try_emplace({segments, voxels, cells});
  Model& model = known->second;
  if (!missing) return model;
  Progress quiet;
  model.soup = tilted_torus(segments);
  model.field = make_distance_field(model.soup, {.voxels = voxels}, quiet);
  model.volume = make_pseudo_volume(model.field, {}, quiet);
  model.lattice = make_lattice(model.volume, bounding_box(model.soup), {.cells = cells}, quiet);
  model.mesh = make_tetrahedra(model.lattice);
  model.smoothed = smooth(model.mesh, {}, quiet);
  return model;
}

/// Runs one stage on one thread; `size` is what its growth is fitted over.
template <class Stage>
void run(benchmark::State& state, std::size_t size, Stage&& stage) {
  set_thread_count(1);
  for (auto _ : state) {
    auto result = stage();
    benchmark::DoNotOptimize(result);
  }
  set_thread_count(0);
  state.SetComplexityN(static_cast<std::int64_t>(size));
  state.counters["size"] = static_cast<double>(size);
}

std::string obj_text(const TriangleSoup& soup) {
  std::ostringstream text;
  text.precision(9);
  for (const Vec3& p : soup.positions) text << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
  for (const Triangle& t : soup.triangles)
    text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  return text.str();
}

void read_obj(benchmark::State& state) {
  const std::string text = obj_text(tilted_torus(static_cast<int>(state.range(0))));
  Progress quiet;
  run(state, static_cast<std::size_t>(state.range(0) * state.range(0)),
      [&] { return read_mesh(text, MeshFormat::obj, quiet); });
}

void inspection(benchmark::State& state) {
  const TriangleSoup soup = tilted_torus(static_cast<int>(state.range(0)));
  run(state, soup.triangles.size(), [&] { return inspect(soup); });
}

void distance_over_voxels(benchmark::State& state) {
  const TriangleSoup soup = tilted_torus(usual_segments);
  const DistanceFieldOptions options{.voxels = static_cast<int>(state.range(0))};
  Progress quiet;
  run(state, distance_grid(bounding_box(soup), options).count(),
      [&] { return make_distance_field(soup, options, quiet); });
}

void distance_over_triangles(benchmark::State& state) {
  const TriangleSoup soup = tilted_torus(static_cast<int>(state.range(0)));
  Progress quiet;
  run(state, soup.triangles.size(),
      [&] { return make_distance_field(soup, {.voxels = usual_voxels}, quiet); });
}

void pseudo_volume(benchmark::State& state) {
  const Model& model = make_model(usual_segments, static_cast<int>(state.range(0)), usual_cells / 2);
  Progress quiet;
  run(state, model.field.grid.count(), [&] { return make_pseudo_volume(model.field, {}, quiet); });
}

void lattice_over_voxels(benchmark::State& state) {
  const Model& model = make_model(usual_segments, static_cast<int>(state.range(0)), usual_cells / 2);
  const Box box = bounding_box(model.soup);
  Progress quiet;
  run(state, model.field.grid.count(),
      [&] { return make_lattice(model.volume, box, {.cells = usual_cells / 2}, quiet); });
}

void lattice_over_cells(benchmark::State& state) {
  const Model& model = make_model(usual_segments, usual_voxels, static_cast<int>(state.range(0)));
  const Box box = bounding_box(model.soup);
  Progress quiet;
  run(state, static_cast<std::size_t>(model.lattice.kept_count),
      [&] { return make_lattice(model.volume, box, {.cells = static_cast<int>(state.range(0))}, quiet); });
}

void tetrahedra(benchmark::State& state) {
  const Model& model = make_model(usual_segments, usual_voxels, static_cast<int>(state.range(0)));
  run(state, model.mesh.cells.size(), [&] { return make_tetrahedra(model.lattice); });
}

void smoothing(benchmark::State& state) {
  const Model& model = make_model(usual_segments, usual_voxels, static_cast<int>(state.range(0)));
  Progress quiet;
  run(state, model.mesh.cells.size(), [&] { return smooth(model.mesh, {}, quiet); });
}

void embedding_over_vertices(benchmark::State& state) {
  const Model& model = make_model(static_cast<int>(state.range(0)), usual_voxels, usual_cells);
  Progress quiet;
  run(state, model.soup.positions.size(),
      [&] { return make_embedding(model.soup, model.smoothed.mesh, quiet); });
}

void embedding_over_cells(benchmark::State& state) {
  const Model& model = make_model(usual_segments, usual_voxels, static_cast<int>(state.range(0)));
  Progress quiet;
  run(state, model.mesh.cells.size(), [&] { return make_embedding(model.soup, model.smoothed.mesh, quiet); });
}

void quality(benchmark::State& state) {
  const Model& model = make_model(usual_segments, usual_voxels, static_cast<int>(state.range(0)));
  Progress quiet;
  const MeasuredSoup input(model.soup);
  const Embedding embedding = make_embedding(model.soup, model.smoothed.mesh, quiet);
  run(state, model.mesh.cells.size(),
      [&] { return summarize_quality(model.smoothed.mesh, input, embedding, model.field, quiet); });
}

void whole_pipeline(benchmark::State& state) {
  const auto soup = std::make_shared<const TriangleSoup>(tilted_torus(usual_segments));
  MeshingOptions options;
  options.voxels = static_cast<int>(state.range(0));
  options.lattice.cells = options.voxels / 4;
  Progress quiet;
  const std::size_t voxels = distance_grid(bounding_box(*soup), {.voxels = options.voxels}).count();
  run(state, voxels, [&] { return AuthoringPipeline(soup).run(options, quiet); });
}

void over(const char* unit, void (*stage)(benchmark::State&), const char* name,
          std::initializer_list<std::int64_t> sizes) {
  auto* entry = benchmark::RegisterBenchmark(name, stage)
                    ->ArgName(unit)
                    ->Unit(benchmark::kMillisecond)
                    ->MinTime(0.2)
                    ->Complexity();
  for (const std::int64_t size : sizes) entry->Arg(size);
}

const bool registered = [] {
  over("segments", read_obj, "read_obj", {64, 128, 256, 512});
  over("segments", inspection, "inspect", {64, 128, 256, 512});
  over("voxels", distance_over_voxels, "distance_field/over_voxels", {64, 128, 256});
  over("segments", distance_over_triangles, "distance_field/over_triangles", {32, 64, 128, 256, 512});
  over("voxels", pseudo_volume, "pseudo_volume", {64, 128, 256});
  over("voxels", lattice_over_voxels, "lattice/over_voxels", {64, 128, 256});
  over("cells", lattice_over_cells, "lattice/over_cells", {16, 32, 64});
  over("cells", tetrahedra, "tetrahedra", {16, 32, 64});
  over("cells", smoothing, "smoothing", {16, 32, 64});
  over("segments", embedding_over_vertices, "embedding/over_vertices", {64, 128, 256, 512});
  over("cells", embedding_over_cells, "embedding/over_cells", {16, 32, 64});
  over("cells", quality, "quality", {16, 32, 64});
  over("voxels", whole_pipeline, "pipeline", {64, 128, 256});
  return true;
}();

}  // namespace
}  // namespace isochor

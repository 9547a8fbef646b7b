// Moves a fine mesh with its body every frame: 100,000 vertices and more bound to the tets of a lattice, on
// one thread.
#include <benchmark/benchmark.h>

#include <random>

#include "core/embedding/embedding.h"
#include "core/parallel/parallel.h"
#include "core/tetrahedra/tet_mesh.h"

namespace isochor {
namespace {

void BM_ApplyEmbedding(benchmark::State& state) {
  const TetMesh mesh = make_box_lattice({24, 24, 24}, 1.0 / 24.0, Vec3::Zero());
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  TriangleSoup soup;
  for (std::int64_t i = 0; i < state.range(0); ++i)
    soup.positions.emplace_back(unit(random), unit(random), unit(random));
  Progress quiet;
  const Embedding embedding = make_embedding(soup, mesh, quiet);
  std::vector<Vec3> moved(soup.positions.size());
  set_thread_count(1);
  for (auto _ : state) {
    apply_embedding(embedding, mesh, mesh.positions, moved);
    benchmark::DoNotOptimize(moved.data());
  }
  set_thread_count(0);
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_ApplyEmbedding)->Arg(100000)->Arg(1000000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace isochor

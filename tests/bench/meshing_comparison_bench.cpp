// A mesh to tets: ours beside TetGen and CGAL's alpha wrap with Mesh_3, each on one thread (CPU time) and
// aiming at the same edge length. times_isochor is the ratio of the times in this run. What another mesher
// cannot do stands as an error.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "core/mesh_input/read_mesh.h"
#include "core/parallel/parallel.h"
#include "core/parameters/parameters.h"
#include "core/quality/quality.h"
#include "tests/bench/cpu_clock.h"
#include "tests/bench/run_apart.h"

namespace isochor {
namespace {

namespace fs = std::filesystem;

constexpr int seconds_allowed = 120;

/// One input, and what ours took for it in this run.
struct Input {
  std::string name;
  std::shared_ptr<const TriangleSoup> soup;
  MeshingOptions options;
  MeshReport report;
  double seconds = 0.0, spacing = 0.0;
};

void judge(benchmark::State& state, const Input& input, std::span<const Vec3> positions,
           std::span<const Tet> tets, double seconds) {
  const TetQuality quality = tet_quality(positions, tets);
  double volume = 0.0;
  for (const Tet& t : tets)
    volume += tet_volume(positions[t[0]], positions[t[1]], positions[t[2]], positions[t[3]]);
  state.counters["tets"] = static_cast<double>(tets.size());
  state.counters["min_dihedral_deg"] = *std::ranges::min_element(quality.min_dihedral_deg);
  state.counters["volume"] = volume;
  if (input.report.closed) state.counters["volume_error"] = volume / std::abs(input.report.volume) - 1.0;
  state.counters["times_isochor"] = seconds / input.seconds;
}

void isochor_tets(benchmark::State& state, Input& input) {
  set_thread_count(1);
  std::shared_ptr<const Model> model;
  std::vector<double> seconds;
  Progress quiet;
  for (auto _ : state) {
    const double start = cpu_seconds();
    model = AuthoringPipeline(input.soup).run(input.options, quiet);
    seconds.push_back(cpu_seconds() - start);
    state.SetIterationTime(seconds.back());
  }
  set_thread_count(0);
  std::ranges::sort(seconds);
  input.seconds = seconds[seconds.size() / 2];
  judge(state, input, model->mesh().positions, model->mesh().tets, input.seconds);
  state.counters["inverted"] = static_cast<double>(model->quality.inverted);
}

using Mesher = Tets (*)(const TriangleSoup&, double spacing);

void other_tets(benchmark::State& state, const Input& input, Mesher mesher) {
  Apart apart;
  for (auto _ : state) {
    apart = run_apart([&] { return mesher(*input.soup, input.spacing); }, seconds_allowed);
    if (!apart.failure.empty()) {
      state.SkipWithError(apart.failure.c_str());
      return;
    }
    state.SetIterationTime(apart.seconds);
  }
  judge(state, input, apart.mesh.positions, apart.mesh.tets, apart.seconds);
}

void add(const fs::path& file, const char* preset) {
  Progress quiet;
  const auto soup = std::make_shared<const TriangleSoup>(read_mesh(file, quiet));
  static std::vector<std::unique_ptr<Input>> inputs;
  inputs.push_back(
      std::make_unique<Input>(Input{file.stem().string(), soup, preset_options(preset), inspect(*soup)}));
  Input& input = *inputs.back();
  input.spacing = input.report.bounds.size().maxCoeff() / input.options.lattice.cells;
  const auto once = [&](const char* mesher, auto function, int iterations) {
    benchmark::RegisterBenchmark((input.name + "/" + mesher).c_str(), function)
        ->Iterations(iterations)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  };
  once(
      "isochor", [&](benchmark::State& state) { isochor_tets(state, input); }, 5);
  once(
      "tetgen", [&](benchmark::State& state) { other_tets(state, input, tetgen_tets); }, 1);
  once(
      "alpha_wrap_mesh_3", [&](benchmark::State& state) { other_tets(state, input, alpha_wrap_tets); }, 1);
}

const bool registered = [] {
  const fs::path samples = fs::path(ISOCHOR_SAMPLES) / "meshes";
  for (const char* closed : {"sphere.obj", "torus.obj", "table.obj"}) add(samples / closed, "solid");
  add(samples / "tree.obj", "thin");
  const char* folder = std::getenv("ISOCHOR_MESHES");
  for (const char* scan : {"bunny.obj", "armadillo.obj", "featuretype.obj"})
    if (folder != nullptr && fs::exists(fs::path(folder) / scan)) add(fs::path(folder) / scan, "solid");
  return true;
}();

}  // namespace
}  // namespace isochor

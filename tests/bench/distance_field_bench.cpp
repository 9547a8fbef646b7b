// The dense distance field beside CGAL's AABB tree with hints (GPL, here only), on one thread. The counter
// `times_faster` is the ratio of the two in this run: CGAL's time is taken from every 64th voxel row, each
// with the last closest point as the hint, as a loop over the whole grid would.
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <vector>

#include "core/distance_field/distance_field.h"
#include "core/mesh_input/read_mesh.h"
#include "core/parallel/parallel.h"
#include "tests/support/shapes.h"

namespace isochor {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, std::vector<Kernel::Triangle_3>::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

/// The bunny where ISOCHOR_MESHES has it, else a torus with as many triangles.
const TriangleSoup& mesh() {
  static const TriangleSoup soup = [] {
    const char* folder = std::getenv("ISOCHOR_MESHES");
    Progress progress;
    const std::filesystem::path bunny = std::filesystem::path(folder != nullptr ? folder : "") / "bunny.obj";
    return std::filesystem::exists(bunny) ? read_mesh(bunny, progress) : test::torus(1.0, 0.4, 264);
  }();
  return soup;
}

Kernel::Point_3 cgal(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

double seconds_of_cgal(int voxels) {
  const Grid grid = distance_grid(mesh(), {voxels, 4});
  const auto start = std::chrono::steady_clock::now();
  std::vector<Kernel::Triangle_3> triangles;
  for (const Triangle& t : mesh().triangles) {
    const Kernel::Triangle_3 triangle(cgal(mesh().positions[t[0]]), cgal(mesh().positions[t[1]]),
                                      cgal(mesh().positions[t[2]]));
    if (!triangle.is_degenerate()) triangles.push_back(triangle);
  }
  Tree tree(triangles.cbegin(), triangles.cend());
  tree.accelerate_distance_queries();
  tree.squared_distance(cgal(grid.origin));
  const auto built = std::chrono::steady_clock::now();
  constexpr int sampled = 64;
  double sum = 0.0;
  const int rows = grid.size.y() * grid.size.z();
  for (int row = 0; row < rows; row += sampled) {
    auto hint = tree.any_reference_point_and_id();
    for (int i = 0; i < grid.size.x(); ++i) {
      const auto x = cgal(grid.center(i, row % grid.size.y(), row / grid.size.y()));
      hint = tree.closest_point_and_primitive(x, hint);
      sum += CGAL::squared_distance(x, hint.first);
    }
  }
  benchmark::DoNotOptimize(sum);
  const auto end = std::chrono::steady_clock::now();
  return std::chrono::duration<double>(built - start).count() +
         sampled * std::chrono::duration<double>(end - built).count();
}

void distance_field(benchmark::State& state) {
  const int voxels = static_cast<int>(state.range(0)), threads = static_cast<int>(state.range(1));
  static std::map<int, double> reference;
  if (!reference.contains(voxels)) reference[voxels] = seconds_of_cgal(voxels);
  set_thread_count(threads);
  double seconds = 0.0;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    Progress progress;
    benchmark::DoNotOptimize(make_distance_field(mesh(), {voxels, 4}, progress));
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  set_thread_count(0);
  state.counters["cgal_seconds"] = reference[voxels];
  state.counters["times_faster"] = reference[voxels] / (seconds / static_cast<double>(state.iterations()));
}

BENCHMARK(distance_field)
    ->ArgNames({"voxels", "threads"})
    ->ArgsProduct({{64, 128, 256}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace isochor

// The dense distance field beside CGAL's AABB tree (GPL, here only), which gets the last closest point as its
// hint along each row of voxels. The counter `times_faster` is the ratio of the two in this run, CGAL on one
// thread; `difference_voxels` the largest distance between their answers. One thread is measured in CPU time.
// At 128³ and 256³ CGAL's time is taken from every 8th and 64th row.
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <vector>

#include "core/distance_field/distance_field.h"
#include "core/mesh_input/read_mesh.h"
#include "core/parallel/parallel.h"
#include "tests/bench/cpu_clock.h"
#include "tests/support/shapes.h"

namespace isochor {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, std::vector<Kernel::Triangle_3>::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

/// A torus of 69,696 triangles and, where ISOCHOR_MESHES has it, the bunny with as many.
struct Input {
  std::string name;
  TriangleSoup soup;
};
const std::vector<Input>& inputs() {
  static const std::vector<Input> all = [] {
    std::vector<Input> list;
    list.push_back({"torus", test::torus(1.0, 0.4, 264)});
    const char* folder = std::getenv("ISOCHOR_MESHES");
    Progress progress;
    const std::filesystem::path bunny = std::filesystem::path(folder != nullptr ? folder : "") / "bunny.obj";
    if (std::filesystem::exists(bunny)) list.push_back({"bunny", read_mesh(bunny, progress)});
    return list;
  }();
  return all;
}

Kernel::Point_3 cgal(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

struct Reference {
  double seconds = 0.0, difference_voxels = 0.0;
};

Reference measure_cgal(const TriangleSoup& soup, int voxels) {
  Progress quiet;
  const DistanceField field = make_distance_field(soup, {.voxels = voxels}, quiet);
  const Grid& grid = field.grid;
  const double start = cpu_seconds();
  std::vector<Kernel::Triangle_3> triangles;
  for (const Triangle& t : soup.triangles) {
    const Kernel::Triangle_3 triangle(cgal(soup.positions[t[0]]), cgal(soup.positions[t[1]]),
                                      cgal(soup.positions[t[2]]));
    if (!triangle.is_degenerate()) triangles.push_back(triangle);
  }
  Tree tree(triangles.cbegin(), triangles.cend());
  tree.accelerate_distance_queries();
  tree.squared_distance(cgal(grid.origin));
  const double built = cpu_seconds();
  const int every = voxels > 128 ? 64 : voxels > 64 ? 8 : 1;
  Reference reference;
  const int rows = grid.size.y() * grid.size.z();
  for (int row = 0; row < rows; row += every) {
    auto hint = tree.any_reference_point_and_id();
    const int j = row % grid.size.y(), k = row / grid.size.y();
    for (int i = 0; i < grid.size.x(); ++i) {
      const auto x = cgal(grid.center(i, j, k));
      hint = tree.closest_point_and_primitive(x, hint);
      const double distance = std::sqrt(CGAL::squared_distance(x, hint.first));
      reference.difference_voxels =
          std::max(reference.difference_voxels,
                   std::abs(distance - field.distance[grid.index(i, j, k)]) / grid.spacing);
    }
  }
  reference.seconds = (built - start) + every * (cpu_seconds() - built);
  return reference;
}

void distance_field(benchmark::State& state) {
  const Input& input = inputs()[static_cast<std::size_t>(state.range(0))];
  const int voxels = static_cast<int>(state.range(1)), threads = static_cast<int>(state.range(2));
  static std::map<std::pair<std::string, int>, Reference> references;
  const auto [known, missing] = references.try_emplace({input.name, voxels});
  if (missing) known->second = measure_cgal(input.soup, voxels);
  set_thread_count(threads);
  double seconds = 0.0;
  for (auto _ : state) {
    const double start = cpu_seconds();
    Progress progress;
    benchmark::DoNotOptimize(make_distance_field(input.soup, {.voxels = voxels}, progress));
    seconds += cpu_seconds() - start;
  }
  set_thread_count(0);
  state.SetLabel(input.name);
  state.counters["cgal_seconds"] = known->second.seconds;
  state.counters["difference_voxels"] = known->second.difference_voxels;
  state.counters["times_faster"] =
      known->second.seconds / (seconds / static_cast<double>(state.iterations()));
}

void each_input(benchmark::internal::Benchmark* benchmark) {
  for (std::size_t input = 0; input < inputs().size(); ++input)
    for (const int voxels : {64, 128, 256})
      for (const int threads : {1, 2}) benchmark->Args({static_cast<std::int64_t>(input), voxels, threads});
}
BENCHMARK(distance_field)
    ->ArgNames({"mesh", "voxels", "threads"})
    ->Apply(each_input)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace isochor

// CGAL's AABB tree (GPL) as an independent reference.
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <vector>

#include "core/distance_field/distance_field.h"
#include "core/mesh_input/read_mesh.h"
#include "tests/support/shapes.h"

namespace isochor {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, std::vector<Kernel::Triangle_3>::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

void compare(const TriangleSoup& soup, int voxels) {
  Progress progress;
  const DistanceField field = make_distance_field(soup, {voxels, 8}, progress);
  const auto cgal = [](const Vec3& p) { return Kernel::Point_3(p.x(), p.y(), p.z()); };
  std::vector<Kernel::Triangle_3> triangles;
  for (const Triangle& t : soup.triangles) {
    triangles.emplace_back(cgal(soup.positions[t[0]]), cgal(soup.positions[t[1]]),
                           cgal(soup.positions[t[2]]));
    if (triangles.back().is_degenerate()) triangles.pop_back();  // the tree cannot take them
  }
  Tree tree(triangles.cbegin(), triangles.cend());
  tree.accelerate_distance_queries();
  std::mt19937_64 random(11);
  std::uniform_int_distribution<std::int64_t> any(0, field.grid.count() - 1);
  double worst = 0.0;
  for (int sample = 0; sample < 4000; ++sample) {
    const std::int64_t index = any(random);
    const auto i = static_cast<int>(index % field.grid.size.x());
    const auto j = static_cast<int>(index / field.grid.size.x() % field.grid.size.y());
    const auto k = static_cast<int>(index / field.grid.size.x() / field.grid.size.y());
    const double truth = std::sqrt(tree.squared_distance(cgal(field.grid.center(i, j, k))));
    worst = std::max(worst, std::abs(field.distance[index] - truth) / field.grid.spacing);
  }
  EXPECT_LE(worst, 1e-5);
}

TEST(AgreesWithCgal, OnATorus) {
  compare(test::torus(1.0, 0.35, 120), 96);
}

TEST(AgreesWithCgal, OnRealMeshes) {
  const char* folder = std::getenv("ISOCHOR_MESHES");
  if (folder == nullptr) GTEST_SKIP() << "set ISOCHOR_MESHES to a folder of meshes";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".obj") continue;
    SCOPED_TRACE(entry.path().string());
    Progress progress;
    compare(read_mesh(entry.path(), progress), 100);
  }
}

}  // namespace
}  // namespace isochor

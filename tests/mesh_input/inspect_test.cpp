#include "core/mesh_input/inspect.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "core/mesh_input/read_mesh.h"

namespace isochor {
namespace {

std::int64_t count(const MeshReport& report, std::string_view name) {
  for (const Defect& defect : report.defects)
    if (defect.name == name) return defect.count;
  return 0;
}

/// The unit cube, outward, 12 triangles, moved by offset.
TriangleSoup cube(const Vec3& offset = Vec3::Zero()) {
  TriangleSoup soup;
  for (int b = 0; b < 8; ++b) soup.positions.push_back(offset + Vec3(b & 1, b >> 1 & 1, b >> 2 & 1));
  for (const auto& q :
       {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    soup.triangles.push_back({q[0], q[1], q[2]});
    soup.triangles.push_back({q[0], q[2], q[3]});
  }
  return soup;
}

void append(TriangleSoup& soup, const TriangleSoup& other) {
  const auto base = static_cast<std::int32_t>(soup.positions.size());
  soup.positions.insert(soup.positions.end(), other.positions.begin(), other.positions.end());
  for (const Triangle& t : other.triangles) soup.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

TEST(Inspect, AClosedCubeHasNoDefects) {
  const MeshReport report = inspect(cube(Vec3(1e6, 0, 0)));
  EXPECT_TRUE(report.closed);
  EXPECT_EQ(report.components, 1);
  EXPECT_NEAR(report.volume, 1.0, 1e-9);
  EXPECT_NEAR(report.area, 6.0, 1e-9);
  EXPECT_TRUE(report.defects.empty());
  EXPECT_EQ(report.bounds.max, Vec3(1e6 + 1, 1, 1));
}

TEST(Inspect, CountsOpenEdgesAndLocatesThem) {
  TriangleSoup soup = cube();
  soup.triangles.erase(soup.triangles.begin(), soup.triangles.begin() + 2);  // the side z = 0
  const MeshReport report = inspect(soup);
  EXPECT_FALSE(report.closed);
  ASSERT_EQ(count(report, "open_edges"), 4);
  for (const Vec3& location : report.defects.front().locations) EXPECT_EQ(location.z(), 0.0);
}

TEST(Inspect, CountsAFlippedTriangle) {
  TriangleSoup soup = cube();
  std::swap(soup.triangles[5][0], soup.triangles[5][1]);
  const MeshReport report = inspect(soup);
  EXPECT_EQ(count(report, "inconsistent_edges"), 3);
  EXPECT_EQ(count(report, "open_edges"), 0);
  EXPECT_FALSE(report.closed);
}

TEST(Inspect, CountsDuplicatesAndDegenerates) {
  TriangleSoup soup = cube();
  soup.triangles.push_back(soup.triangles[3]);
  soup.triangles.push_back({0, 0, 1});
  soup.triangles.push_back({0, 1, 8});
  soup.positions.emplace_back(0.5, 0.0, 0.0);
  soup.positions.emplace_back(7.0, 7.0, 7.0);
  soup.positions.emplace_back(-0.0, 0.0, 0.0);
  const MeshReport report = inspect(soup);
  EXPECT_EQ(count(report, "duplicate_triangles"), 1);
  EXPECT_EQ(count(report, "degenerate_triangles"), 2);
  EXPECT_EQ(count(report, "unused_vertices"), 2);
  EXPECT_EQ(count(report, "duplicate_vertices"), 1);
  // Three of the duplicate, and the one that the degenerate triangle without area but with three corners
  // uses.
  EXPECT_EQ(count(report, "non_manifold_edges"), 4);
  EXPECT_EQ(report.bounds.max, Vec3(1, 1, 1));
}

TEST(Inspect, MergesVerticesByPositionAndCountsComponents) {
  TriangleSoup soup = cube();
  append(soup, cube(Vec3(3, 0, 0)));
  EXPECT_EQ(inspect(soup).components, 2);
  append(soup, cube(Vec3(1, 1, 1)));  // touches the first in a vertex
  EXPECT_EQ(inspect(soup).components, 2);

  TriangleSoup loose;  // every triangle with vertices of its own
  for (const Triangle& t : cube().triangles) {
    const auto base = static_cast<std::int32_t>(loose.positions.size());
    for (std::int32_t v : t) loose.positions.push_back(cube().positions[v]);
    loose.triangles.push_back({base, base + 1, base + 2});
  }
  const MeshReport report = inspect(loose);
  EXPECT_TRUE(report.closed);
  EXPECT_EQ(report.components, 1);
  EXPECT_EQ(count(report, "duplicate_vertices"), 28);
}

TEST(Inspect, MergesSoFarFromTheOriginThatCubesOfTheToleranceAreBeyondCounting) {
  for (const double far : {1e300, -1e300, 1e20}) {
    const TriangleSoup soup{{{far, 0, 0}, {far, 1, 0}, {far, 0, 1}, {far, 0, 1}}, {{0, 1, 2}, {1, 0, 3}}};
    EXPECT_EQ(count(inspect(soup), "duplicate_vertices"), 1);
  }
}

TEST(Inspect, ASeamThatIsRoundOffWideIsClosed) {
  TriangleSoup soup = cube();
  std::vector<Vec3> corners = soup.positions;
  for (std::size_t t = 0; t < 6; ++t)
    for (std::int32_t& v : soup.triangles[t]) {
      soup.positions.push_back(corners[v] + Vec3(3e-17, -2e-16, 1e-16));
      v = static_cast<std::int32_t>(soup.positions.size()) - 1;
    }
  EXPECT_TRUE(inspect(soup).closed);
  for (Vec3& p : soup.positions) p += Vec3::Constant(1e-6 * (&p - soup.positions.data() < 8));
  EXPECT_FALSE(inspect(soup).closed);
}

TEST(Inspect, AFillerOfATJunctionClosesTheSurface) {
  TriangleSoup soup = cube();
  const Triangle whole = soup.triangles[0];
  const auto middle = static_cast<std::int32_t>(soup.positions.size());
  soup.positions.push_back(0.5 * (soup.positions[whole[0]] + soup.positions[whole[1]]));
  soup.triangles[0] = {whole[0], middle, whole[2]};
  soup.triangles.push_back({middle, whole[1], whole[2]});
  EXPECT_FALSE(inspect(soup).closed);
  soup.triangles.push_back({whole[0], whole[1], middle});
  EXPECT_TRUE(inspect(soup).closed);
  EXPECT_EQ(count(inspect(soup), "degenerate_triangles"), 1);
}

TEST(Inspect, TwoCubesOnOneFaceAreNonManifold) {
  TriangleSoup soup = cube();
  append(soup, cube(Vec3(1, 0, 0)));
  const MeshReport report = inspect(soup);
  EXPECT_EQ(count(report, "non_manifold_edges"), 5);  // the shared side's border and its diagonal
  EXPECT_FALSE(report.closed);
  EXPECT_TRUE(report.winds);
}

TEST(Inspect, LeavesOfTwoEqualTrianglesHaveNoInside) {
  TriangleSoup soup = cube();
  EXPECT_TRUE(inspect(soup).winds);
  append(soup, {{{3, 0, 0}, {4, 0, 0}, {3, 1, 0}, {4, 1, 0}}, {{0, 1, 2}, {1, 3, 2}, {2, 1, 0}, {2, 3, 1}}});
  EXPECT_FALSE(inspect(soup).winds);
  soup.triangles.pop_back();
  EXPECT_FALSE(inspect(soup).winds);
}

TEST(Inspect, AgreesWithTheFactsOfRealMeshes) {
  const char* folder = std::getenv("ISOCHOR_MESHES");
  if (folder == nullptr) GTEST_SKIP() << "set ISOCHOR_MESHES to a folder of meshes";
  Progress progress;
  const MeshReport bunny = inspect(read_mesh(std::filesystem::path(folder) / "bunny.obj", progress));
  EXPECT_EQ(bunny.triangles, 69451);
  EXPECT_EQ(count(bunny, "open_edges"), 223);
  const MeshReport armadillo = inspect(read_mesh(std::filesystem::path(folder) / "armadillo.obj", progress));
  EXPECT_TRUE(armadillo.closed);
  EXPECT_NEAR(armadillo.volume, 0.0686, 1e-4);
}

}  // namespace
}  // namespace isochor

#include "core/mesh_input/self_intersections.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Triangle_3.h>
#include <gtest/gtest.h>

#include <random>

#include "core/mesh_input/topology.h"
#include "tests/support/shapes.h"

namespace isochor {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;

std::int64_t pairs_of_cgal(const TriangleSoup& soup) {
  const auto triangle = [&](const Triangle& t) {
    const auto point = [&](std::int32_t v) {
      return Kernel::Point_3(soup.positions[v].x(), soup.positions[v].y(), soup.positions[v].z());
    };
    return Kernel::Triangle_3(point(t[0]), point(t[1]), point(t[2]));
  };
  std::int64_t pairs = 0;
  for (std::size_t a = 0; a < soup.triangles.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const Triangle &s = soup.triangles[a], &t = soup.triangles[b];
      const bool share = std::ranges::any_of(s, [&](auto v) { return std::ranges::count(t, v) > 0; });
      pairs += !share && CGAL::do_intersect(triangle(s), triangle(t));
    }
  return pairs;
}

TEST(SelfIntersections, AreThePairsThatCgalFinds) {
  for (const double size : {0.02, 0.2, 1.0}) {
    std::mt19937 random(11);
    std::normal_distribution<double> place(0.0, 1.0);
    TriangleSoup soup;
    for (int t = 0; t < 400; ++t) {
      const Vec3 center(place(random), place(random), 0.1 * place(random));
      for (int c = 0; c < 3; ++c)
        soup.positions.push_back(center + size * Vec3(place(random), place(random), place(random)));
      soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    const SelfIntersections found = find_self_intersections(soup.positions, soup.triangles, 64);
    EXPECT_TRUE(found.complete);
    EXPECT_EQ(found.pairs, pairs_of_cgal(soup));
    EXPECT_EQ(found.locations.size(), std::min<std::size_t>(64, found.pairs));
  }
}

/// The sphere's seam and poles repeat vertices.
TriangleSoup merged(TriangleSoup soup) {
  const std::vector<std::int32_t> first = merge_vertices(soup.positions, 1e-9);
  for (Triangle& t : soup.triangles)
    for (std::int32_t& v : t) v = first[v];
  std::erase_if(soup.triangles,
                [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  return soup;
}

TEST(SelfIntersections, CountATouch) {
  const TriangleSoup soup{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, 0}, {0.2, 0.2, 1}, {0.4, 0.2, 1}},
                          {{0, 1, 2}, {3, 4, 5}}};
  EXPECT_EQ(find_self_intersections(soup.positions, soup.triangles, 64).pairs, 1);
}

TEST(SelfIntersections, LieWhereTwoSpheresMeet) {
  TriangleSoup soup = merged(test::sphere(1.0, 1.0, 40)), other = merged(test::sphere(1.0, 1.0, 36));
  EXPECT_EQ(find_self_intersections(soup.positions, soup.triangles, 64).pairs, 0);
  for (Vec3& p : other.positions) p.x() += 1.2;
  test::append(soup, other);
  const SelfIntersections found = find_self_intersections(soup.positions, soup.triangles, 64);
  EXPECT_GT(found.pairs, 20);
  for (const Vec3& at : found.locations) EXPECT_NEAR(at.x(), 0.6, 0.05);
}

TEST(SelfIntersections, OfACrowdAreBounded) {
  std::mt19937 random(3);
  std::normal_distribution<double> place(0.0, 1.0);
  TriangleSoup soup;  // all of them meet at the origin: 50 million pairs
  for (int t = 0; t < 10000; ++t) {
    for (int c = 0; c < 3; ++c) soup.positions.emplace_back(place(random), place(random), place(random));
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  const SelfIntersections found = find_self_intersections(soup.positions, soup.triangles, 64);
  EXPECT_FALSE(found.complete);
  EXPECT_GT(found.pairs, 1000);
}

}  // namespace
}  // namespace isochor

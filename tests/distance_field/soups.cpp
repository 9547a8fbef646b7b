#include "tests/distance_field/soups.h"

#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/shapes.h"

namespace isochor {
namespace {

using test::append;
using test::patch;

TriangleSoup mapped(TriangleSoup soup, double scale, const Vec3& offset) {
  for (Vec3& p : soup.positions) p = scale * p + offset;
  return soup;
}

TriangleSoup one_triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
  return {{a, b, c}, {{0, 1, 2}}};
}

TriangleSoup random_soup(unsigned seed, int triangles, double size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(0.0, 1.0), offset(-size, size);
  TriangleSoup soup;
  for (int i = 0; i < triangles; ++i) {
    const Vec3 center(place(random), place(random), place(random));
    for (int corner = 0; corner < 3; ++corner)
      soup.positions.push_back(center + Vec3(offset(random), offset(random), offset(random)));
    soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return soup;
}

/// Triangles over a few shared points: every edge and vertex is non-manifold, many triangles are duplicates
/// or degenerate.
TriangleSoup tangled_soup(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(0.0, 1.0);
  std::uniform_int_distribution<std::int32_t> vertex(0, 11);
  TriangleSoup soup;
  for (int i = 0; i < 12; ++i) soup.positions.emplace_back(place(random), place(random), place(random));
  for (int i = 0; i < 60; ++i) soup.triangles.push_back({vertex(random), vertex(random), vertex(random)});
  return soup;
}

/// Many slivers that share a corner.
TriangleSoup fan_soup(int slivers) {
  TriangleSoup soup;
  soup.positions.emplace_back(0.01, 0.02, 0.03);
  for (int i = 0; i <= slivers; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / slivers;
    soup.positions.emplace_back(std::cos(angle), std::sin(angle), 0.3 * std::sin(3.0 * angle));
  }
  for (int i = 0; i < slivers; ++i) soup.triangles.push_back({0, i + 1, i + 2});
  return soup;
}

TriangleSoup huge_and_tiny() {
  TriangleSoup soup = mapped(test::sphere(0.02, 1.0, 20), 1.0, Vec3(0.3, 0.31, 0.05));
  append(soup, one_triangle({0, 0, 0}, {1, 0, 0}, {0.2, 1, 0}));
  append(soup, one_triangle({0, 0, 0.6}, {1, 0.1, 0.2}, {0.2, 1, 0.9}));
  return soup;
}

}  // namespace

std::vector<NamedSoup> hard_soups() {
  std::vector<NamedSoup> soups{
      {"triangle", one_triangle({0.1, 0.2, 0.3}, {1.3, 0.4, 0.2}, {0.4, 1.1, 0.9})},
      {"axis_aligned_triangle", one_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0})},
      {"needle", one_triangle({0, 0, 0}, {1, 0.3, 0.2}, {0.5, 0.1500001, 0.1})},
      {"segment", one_triangle({0, 0, 0}, {1, 0.5, 0.25}, {0.5, 0.25, 0.125})},
      {"segment_and_point", {{{0, 0, 0}, {1, 1, 0}, {0.2, 0.9, 0.4}}, {{0, 1, 1}, {2, 2, 2}}}},
      {"flat_sheet", patch(9, 7, [](double u, double v) { return Vec3(u, v, 0.0); })},
      {"tilted_sheet", patch(5, 8, [](double u, double v) { return Vec3(u, v, 0.3 * u + 0.5 * v); })},
      {"wavy_sheet", patch(12, 12, [](double u, double v) { return Vec3(u, v, 0.2 * std::sin(9 * u * v)); })},
      {"box", test::box(Vec3::Zero(), Vec3::Ones())},
      {"sphere", test::sphere(1.0, 1.0, 20)},
      {"torus", test::torus(1.0, 0.3, 20)},
      {"fan", fan_soup(300)},
      {"huge_and_tiny", huge_and_tiny()},
      {"offset_1e6", mapped(test::sphere(1.0, 1.0, 16), 1.0, Vec3(1e6, -1e6, 3e5))},
      {"scale_1e-20", mapped(test::torus(1.0, 0.4, 14), 1e-20, Vec3::Zero())},
      {"scale_1e20", mapped(test::torus(1.0, 0.4, 14), 1e20, Vec3::Zero())}};
  for (unsigned seed = 1; seed <= 4; ++seed) {
    soups.push_back({"tangled_" + std::to_string(seed), tangled_soup(seed)});
    soups.push_back({"loose_small_" + std::to_string(seed), random_soup(seed, 250, 0.04)});
    soups.push_back({"loose_large_" + std::to_string(seed), random_soup(seed, 60, 0.6)});
  }
  return soups;
}

}  // namespace isochor

#include "core/pseudo_volume/enclosed.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "tests/support/shapes.h"

namespace isochor {
namespace {

struct Enclosed {
  DistanceField field;
  BitVolume voxels;

  Enclosed(const TriangleSoup& soup, Enclosing rule, int count = 32) {
    Progress progress;
    field = make_distance_field(soup, {count, 4}, progress);
    voxels = enclosed_voxels(soup, field, rule, progress).value();
  }
  bool has(int i, int j, int k) const { return (voxels.row(j, k)[i / 64] >> i % 64 & 1) != 0; }
  template <class Visit>
  void for_voxels(Visit&& visit) const {
    for (int k = 0; k < field.grid.size.z(); ++k)
      for (int j = 0; j < field.grid.size.y(); ++j)
        for (int i = 0; i < field.grid.size.x(); ++i) visit(i, j, k);
  }
};

/// Windings around p by the solid angles of the triangles [Van Oosterom 1983].
double winding_number(const TriangleSoup& soup, const Vec3& p) {
  double angle = 0.0;
  for (const Triangle& t : soup.triangles) {
    const Vec3 a = soup.positions[t[0]] - p, b = soup.positions[t[1]] - p, c = soup.positions[t[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle +=
        2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4.0 * std::numbers::pi);
}

TriangleSoup turned(TriangleSoup soup) {
  for (Triangle& t : soup.triangles) std::swap(t[0], t[1]);
  return soup;
}

/// Tetrahedra over each other, in both orientations.
TriangleSoup random_tetrahedra(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  TriangleSoup soup;
  for (int n = 0; n < 12; ++n) {
    TriangleSoup tet{{}, {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}};
    for (int v = 0; v < 4; ++v) tet.positions.emplace_back(place(random), place(random), place(random));
    test::append(soup, tet);
  }
  return soup;
}

TEST(EnclosedVoxels, AreThoseWithAWindingNumber) {
  const TriangleSoup soup = random_tetrahedra(3);
  for (const Enclosing rule : {Enclosing::winding, Enclosing::parity}) {
    const Enclosed enclosed(soup, rule);
    enclosed.for_voxels([&](int i, int j, int k) {
      if (enclosed.field.distance[enclosed.field.grid.index(i, j, k)] < 2e-3 * enclosed.field.grid.spacing)
        return;
      const long n = std::lround(winding_number(soup, enclosed.field.grid.center(i, j, k)));
      ASSERT_EQ(enclosed.has(i, j, k), rule == Enclosing::winding ? n != 0 : n % 2 != 0)
          << i << " " << j << " " << k << ": " << n;
    });
  }
}

TEST(EnclosedVoxels, KnowACavityByParityWhateverTheOrientation) {
  TriangleSoup hollow = test::box({-1, -1, -1}, {1, 1, 1});
  test::append(hollow, test::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}));
  const Enclosed by_parity(hollow, Enclosing::parity), by_winding(hollow, Enclosing::winding);
  const int middle = by_parity.field.grid.size.x() / 2;
  EXPECT_FALSE(by_parity.has(middle, middle, middle));
  EXPECT_TRUE(by_winding.has(middle, middle, middle));
  TriangleSoup cavity = test::box({-1, -1, -1}, {1, 1, 1});
  test::append(cavity, turned(test::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5})));
  EXPECT_FALSE(Enclosed(cavity, Enclosing::winding).has(middle, middle, middle));
}

// The faces of this box pass through voxel centres across its longer sides.
TEST(EnclosedVoxels, AreSymmetricWhereTheSurfacePassesThroughCentres) {
  const Enclosed enclosed(test::box({-16, -8.5, -7.5}, {16, 8.5, 7.5}), Enclosing::parity);
  const Vec3i last = enclosed.field.grid.size - Vec3i::Ones();
  enclosed.for_voxels([&](int i, int j, int k) {
    ASSERT_EQ(enclosed.has(i, j, k), enclosed.has(last.x() - i, last.y() - j, last.z() - k));
  });
}

TEST(EnclosedVoxels, AreGivenUpWhereTheCrossingsAreTooMany) {
  TriangleSoup soup;
  for (int n = 0; n < 3000; ++n) test::append(soup, test::box({-1, -1, -1}, {1, 1, 1}));
  Progress progress;
  DistanceField field;
  field.grid = distance_grid(bounding_box(soup), {256, 4});
  EXPECT_FALSE(enclosed_voxels(soup, field, Enclosing::parity, progress));
}

}  // namespace
}  // namespace isochor

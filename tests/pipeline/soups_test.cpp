#include <gtest/gtest.h>

#include <map>
#include <random>

#include "core/pipeline/pipeline.h"
#include "tests/support/shapes.h"

namespace isochor {
namespace {

std::shared_ptr<const TriangleSoup> shared(TriangleSoup soup) {
  return std::make_shared<const TriangleSoup>(std::move(soup));
}

MeshingOptions small() {
  MeshingOptions options;
  options.voxels = 48;
  options.lattice.cells = 12;
  return options;
}

/// Runs; where the error or a warning names a p_in_voxels, follows it. Whatever comes out must be sound.
std::shared_ptr<const Model> run_with_advice(const TriangleSoup& soup, MeshingOptions options) {
  AuthoringPipeline pipeline(shared(soup));
  Progress progress;
  for (int attempt = 0; attempt < 2; ++attempt) {
    try {
      const auto model = pipeline.run(options, progress);
      EXPECT_LT(model->quality.to_pseudo_volume.max_diagonals, 1.0);
      const bool fixable = !model->fixes.empty() && model->fixes[0].parameter == "p_in_voxels";
      if (!fixable || attempt == 1) return model;
      options.pseudo_volume.p_in_voxels = model->fixes[0].value;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::empty_result) << error.what();
      EXPECT_FALSE(error.hint().empty());
      if (error.details().empty()) return nullptr;
      if (error.details()[0].pointer == "/density") {
        options.lattice.density = error.details()[0].max.value();
        continue;
      }
      EXPECT_EQ(error.details()[0].pointer, "/p_in_voxels");
      options.pseudo_volume.p_in_voxels = error.details()[0].min.value();
    }
    options.pseudo_volume.p_subs_voxels =
        std::max(options.pseudo_volume.p_subs_voxels, options.pseudo_volume.p_in_voxels);
  }
  return nullptr;
}

TEST(Soups, AFlatSheetBecomesAModelWithTheAdviceGiven) {
  for (const double degrees : {0.0, 30.0, 45.0}) {
    const auto model = run_with_advice(test::sheet(1.0, degrees), small());
    ASSERT_NE(model, nullptr) << degrees;
    EXPECT_GE(model->quality.coverage, 0.95) << degrees;
    EXPECT_EQ(model->quality.inverted, 0);
  }
}

TEST(Soups, ASingleTriangleBecomesAModelWithTheAdviceGiven) {
  TriangleSoup soup{{{0, 0, 0}, {1, 0, 0.2}, {0.3, 0.9, 0}}, {{0, 1, 2}}};
  const auto model = run_with_advice(soup, small());
  ASSERT_NE(model, nullptr);
  EXPECT_GE(model->quality.coverage, 0.95);
}

TEST(Soups, CollinearAndPointLikeOnesEndInAModelOrASentence) {
  const TriangleSoup line{{{0, 0, 0}, {1, 0, 0}, {0.4, 0, 0}}, {{0, 1, 2}}};
  if (const auto model = run_with_advice(line, small())) {
    EXPECT_GT(model->quality.volume, 0.0);
    EXPECT_GE(model->quality.coverage, 0.95);
  }
  const TriangleSoup point{{{3, 4, 5}}, {{0, 0, 0}}};
  Progress progress;
  try {
    AuthoringPipeline(shared(point)).run(small(), progress);
    FAIL() << "a point has no size";
  } catch (const Error& error) {
    EXPECT_FALSE(std::string(error.what()).empty());
    EXPECT_FALSE(error.hint().empty());
  }
}

TEST(Soups, RandomTrianglesEndInASoundModelOrASentence) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> place(0.0, 1.0);
    TriangleSoup soup;
    const int count = 1 + static_cast<int>(seed * seed * 3);
    for (int t = 0; t < count; ++t) {
      const Vec3 center(place(random), place(random), place(random));
      for (int c = 0; c < 3; ++c)
        soup.positions.push_back(center + 0.5 * Vec3(place(random), place(random), place(random)));
      soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    if (const auto model = run_with_advice(soup, small())) {
      EXPECT_EQ(model->quality.inverted, 0);
      EXPECT_GE(model->quality.min_dihedral_deg, 20.0);
      EXPECT_TRUE(std::isfinite(model->quality.volume) && model->quality.volume > 0.0);
      EXPECT_TRUE(model->quality.coverage >= 0.95 || !model->warnings.empty()) << "seed " << seed;
    }
  }
}

TEST(Soups, ASphereTurnedInsideOutIsTheSameModel) {
  TriangleSoup soup = test::sphere(0.5, 1.0, 32);
  Progress progress;
  const auto outward = AuthoringPipeline(shared(soup)).run(small(), progress);
  for (std::size_t t = 0; t < soup.triangles.size(); t += 2)
    std::swap(soup.triangles[t][0], soup.triangles[t][1]);
  const auto mixed = AuthoringPipeline(shared(soup)).run(small(), progress);
  EXPECT_EQ(mixed->mesh().tets, outward->mesh().tets);
  EXPECT_NEAR(mixed->quality.volume, outward->quality.volume, 1e-12);
}

TriangleSoup turned(TriangleSoup soup) {
  for (Triangle& t : soup.triangles) std::swap(t[0], t[1]);
  return soup;
}

TEST(Soups, AShellWithinAnotherIsACavityWhereItFacesAgainstItAndElseSolidAndSaidToBe) {
  const TriangleSoup outer = test::sphere(0.5, 1.0, 48), inner = test::sphere(0.3, 1.0, 48);
  TriangleSoup solid = outer, hollow = outer;
  test::append(solid, inner), test::append(hollow, turned(inner));
  Progress progress;
  for (const bool inward : {false, true}) {
    const auto filled = AuthoringPipeline(shared(inward ? turned(solid) : solid)).run(small(), progress);
    EXPECT_NEAR(filled->enclosed_volume, 0.521, 0.01);
    EXPECT_LT(filled->volume_error(), 0.05);
    ASSERT_EQ(filled->warnings.size(), 1u);
    EXPECT_TRUE(filled->warnings[0].starts_with("parts that lie inside others and face the same way"));
    const auto shell = AuthoringPipeline(shared(inward ? turned(hollow) : hollow)).run(small(), progress);
    EXPECT_NEAR(shell->enclosed_volume, 0.409, 0.01);
    EXPECT_LT(shell->volume_error(), 0.05);
    EXPECT_TRUE(shell->warnings.empty());
  }
}

TEST(Soups, PartsThatCrossBecomeOneSolidWhicheverWayTheyFace) {
  const TriangleSoup one = test::sphere(0.5, 1.0, 32);
  TriangleSoup other = one;
  for (Vec3& p : other.positions) p.x() += 0.6;
  TriangleSoup alike = one, against = one, mixed = one;
  test::append(alike, other), test::append(against, turned(other)), test::append(mixed, turned(other));
  for (std::size_t t = 0; t < mixed.triangles.size(); t += 5)
    std::swap(mixed.triangles[t][0], mixed.triangles[t][1]);
  Progress progress;
  const auto solid = AuthoringPipeline(shared(alike)).run(small(), progress);
  for (const TriangleSoup& soup : {against, mixed}) {
    const auto model = AuthoringPipeline(shared(soup)).run(small(), progress);
    EXPECT_EQ(model->mesh().tets, solid->mesh().tets);
    EXPECT_NEAR(model->enclosed_volume, solid->enclosed_volume, 1e-12);
  }
}

TEST(Soups, CubesThatShareFacesAreOneSolid) {
  TriangleSoup blocks;
  for (int n = 0; n < 27; ++n) {
    const Vec3 corner(n % 3, n / 3 % 3, n / 9);
    test::append(blocks, test::box(corner, corner + Vec3::Ones()));
  }
  Progress progress;
  const auto model = AuthoringPipeline(shared(blocks)).run(small(), progress);
  EXPECT_EQ(model->lattice->components, 1);
  EXPECT_NEAR(model->enclosed_volume, 27.0, 1e-9);
  EXPECT_LT(model->volume_error(), 0.03);
}

TEST(Soups, LeavesOfTwoEqualTrianglesAreJudgedAsOpen) {
  TriangleSoup leaf = test::sheet(1.0, 30.0);
  test::append(leaf, turned(leaf));
  MeshingOptions options = small();
  options.pseudo_volume.p_in_voxels = options.pseudo_volume.p_subs_voxels = 4.0;
  Progress progress;
  const auto model = AuthoringPipeline(shared(leaf)).run(options, progress);
  EXPECT_EQ(model->enclosed_volume, 0.0);
  EXPECT_EQ(model->volume_error(), 0.0);
  EXPECT_GT(model->quality.coverage, 0.95);
}

TEST(Soups, PartsThatOverlapBecomeOneSolid) {
  TriangleSoup crossed = test::box({-2, -0.5, -0.5}, {2, 0.5, 0.5});
  test::append(crossed, test::box({-0.4, -2, -0.4}, {0.4, 2, 0.4}));
  test::append(crossed, test::box({-0.45, -0.45, -2}, {0.45, 0.45, 2}));
  Progress progress;
  MeshingOptions options = small();
  const auto solid = AuthoringPipeline(shared(crossed)).run(options, progress);
  EXPECT_EQ(solid->lattice->components, 1);
  EXPECT_NEAR(solid->quality.volume, 8.35, 0.05 * 8.35);
  options.pseudo_volume.enclosed = false;
  const auto voted = AuthoringPipeline(shared(crossed)).run(options, progress);
  EXPECT_LT(voted->quality.volume, 0.97 * solid->quality.volume)
      << "the rays alone leave the overlaps hollow";
}

TriangleSoup separate_beads() {
  TriangleSoup beads;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 4; ++k) {
        TriangleSoup bead = test::sphere(0.5, 1.0, 12);
        for (Vec3& p : bead.positions) p += 2.1 * Vec3(i, j, k);
        test::append(beads, bead);
      }
  return beads;
}

TEST(Soups, RaysThatGrazeSmallPartsFillNothing) {
  const TriangleSoup beads = separate_beads();
  Progress progress;
  MeshingOptions options = small();
  const auto model = AuthoringPipeline(shared(beads)).run(options, progress);
  EXPECT_LT(model->quality.boundary_to_input, std::sqrt(3.0) * model->lattice->grid.spacing);
  options.pseudo_volume.enclosed = false;
  const auto voted = AuthoringPipeline(shared(beads)).run(options, progress);
  EXPECT_GT(voted->quality.volume, 1.1 * model->quality.volume) << "the rays alone fill between them";
}

// What a closed input does not enclose needs two thirds of the votes anyhow.
// A Menger sponge: where its tunnels cross, more rays have grazed an edge than have not.
TEST(Soups, RaysFillNothingInMidAir) {
  const auto is_bored = [](const Vec3i& at) { return (at.array() == 1).count() >= 2; };
  TriangleSoup sponge;
  for (int n = 0; n < 729; ++n) {
    const Vec3i at(n % 9, n / 9 % 9, n / 81);
    const Vec3i coarse = at / 3, fine = at - 3 * coarse;
    if (is_bored(coarse) || is_bored(fine)) continue;
    test::append(sponge, test::box(at.cast<double>(), (at + Vec3i::Ones()).cast<double>()));
  }
  ASSERT_EQ(sponge.triangles.size(), 400U * 12U);
  MeshingOptions options;
  options.lattice.cells = 64;
  Progress progress;
  const auto model = AuthoringPipeline(shared(sponge)).run(options, progress);
  EXPECT_LT(model->quality.boundary_to_input, std::sqrt(3.0) * model->mesh().grid.spacing);
  EXPECT_NEAR(model->quality.volume, 400.0, 8.1);
}

TEST(Soups, OnlyWhereVotesDecideMoreOfThemAreAdvised) {
  MeshingOptions options = small();
  options.lattice.cells = 24;
  options.pseudo_volume.p_in_voxels = options.pseudo_volume.p_subs_voxels = 4.0;
  for (const bool enclosed : {false, true}) {
    options.pseudo_volume.enclosed = enclosed;
    Progress progress;
    const auto model = AuthoringPipeline(shared(separate_beads())).run(options, progress);
    ASSERT_GT(model->quality.boundary_to_input, std::sqrt(3.0) * model->lattice->grid.spacing);
    const bool advised =
        std::ranges::any_of(model->fixes, [](const Fix& fix) { return fix.parameter == "far_majority"; });
    EXPECT_EQ(advised, !enclosed);
  }
}

TEST(Soups, AMirroredInputGivesTheMirroredModel) {
  for (const TriangleSoup& soup :
       {test::sphere(0.5, 1.0, 48), test::torus(0.35, 0.15), test::box({-1, -2, 0}, {1, 2, 1})}) {
    TriangleSoup mirrored = soup;
    for (Vec3& p : mirrored.positions) p.x() = -p.x();
    Progress progress;
    const auto a = AuthoringPipeline(shared(soup)).run(small(), progress);
    const auto b = AuthoringPipeline(shared(mirrored)).run(small(), progress);
    ASSERT_EQ(a->mesh().positions.size(), b->mesh().positions.size());
    const int n = a->mesh().grid.size.x();
    std::map<std::array<int, 3>, Vec3> of_node;
    for (std::size_t v = 0; v < b->mesh().nodes.size(); ++v)
      of_node[b->mesh().nodes[v]] = b->mesh().positions[v];
    double error = 0.0;
    for (std::size_t v = 0; v < a->mesh().nodes.size(); ++v) {
      const auto [i, j, k] = a->mesh().nodes[v];
      ASSERT_TRUE(of_node.contains({n - i, j, k}));
      const Vec3 x = of_node.at({n - i, j, k});
      error = std::max(error, (Vec3(-x.x(), x.y(), x.z()) - a->mesh().positions[v]).norm());
    }
    EXPECT_LT(error, 1e-12);
  }
}

}  // namespace
}  // namespace isochor

#include "core/pipeline/pipeline.h"

#include <gtest/gtest.h>

#include <numbers>

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

std::vector<std::string> recomputed(const Model& model) {
  std::vector<std::string> names;
  for (const StageReport& stage : model.stages)
    if (!stage.reused) names.emplace_back(stage.name);
  return names;
}

TEST(Pipeline, MakesAModelOfASphere) {
  AuthoringPipeline pipeline(shared(test::sphere(0.5)));
  MeshingOptions options;
  options.voxels = 128, options.lattice.cells = 48;
  Progress progress;
  const auto model = pipeline.run(options, progress);
  EXPECT_NEAR(model->quality.volume / (std::numbers::pi / 6.0), 1.0, 0.03);
  EXPECT_EQ(model->quality.inverted, 0);
  EXPECT_GE(model->quality.min_dihedral_deg, 29.0);
  EXPECT_GT(model->quality.coverage, 0.9999);
  EXPECT_TRUE(model->warnings.empty()) << model->warnings.front();
  const double diagonal = std::sqrt(3.0) * model->mesh().grid.spacing;
  EXPECT_LT(model->quality.boundary_to_input, diagonal);
  EXPECT_LT(model->quality.input_to_boundary, diagonal);
}

// Whose sides fall between cells, and whose ends lie far from their middle.
TEST(Pipeline, RodsAndPlatesHaveTheirVolumeAndStayWhereTheyAre) {
  for (const Vec3& size :
       {Vec3(24, 2.9, 2.9), Vec3(10, 1, 1), Vec3(24, 24, 2.9), Vec3(20, 5, 3), Vec3(8, 3, 1)})
    for (const int cells : {24, 48}) {
      AuthoringPipeline pipeline(shared(test::box(Vec3::Zero(), size)));
      MeshingOptions options;
      options.lattice.cells = cells;
      Progress progress;
      const auto model = pipeline.run(options, progress);
      EXPECT_NEAR(model->quality.volume / size.prod(), 1.0, 0.025) << size.transpose() << ", " << cells;
      EXPECT_LT(model->quality.boundary_to_input, 0.5 * std::sqrt(3.0) * model->mesh().grid.spacing);
      EXPECT_GE(model->quality.min_dihedral_deg, 40.0);
      EXPECT_TRUE(model->warnings.empty()) << model->warnings.front();
    }
}

TEST(Pipeline, RecomputesFromTheFirstStageThatChanged) {
  AuthoringPipeline pipeline(shared(test::sphere(0.5)));
  MeshingOptions options = small();
  Progress progress;
  using Names = std::vector<std::string>;
  const Names all{"distance_field", "pseudo_volume", "lattice", "tetrahedra", "smoothing", "embedding"};
  EXPECT_EQ(recomputed(*pipeline.run(options, progress)), all);
  EXPECT_EQ(recomputed(*pipeline.run(options, progress)), Names{});
  options.smoothing.iterations = 1;
  EXPECT_EQ(recomputed(*pipeline.run(options, progress)), Names(all.begin() + 4, all.end()));
  options.lattice.density = 0.4;
  EXPECT_EQ(recomputed(*pipeline.run(options, progress)), Names(all.begin() + 2, all.end()));
  options.pseudo_volume.p_in_voxels = 1.2;
  EXPECT_EQ(recomputed(*pipeline.run(options, progress)), Names(all.begin() + 1, all.end()));
  for (const auto& [p_in, p_subs] : {std::pair{1.2, 24.0}, std::pair{16.0, 24.0}, std::pair{0.87, 1.5}}) {
    options.pseudo_volume.p_in_voxels = p_in, options.pseudo_volume.p_subs_voxels = p_subs;
    EXPECT_EQ(recomputed(*pipeline.run(options, progress)), Names(all.begin() + 1, all.end()));
  }
  options.voxels = 40;
  EXPECT_EQ(recomputed(*pipeline.run(options, progress)), all);
}

TEST(Pipeline, APreviewStepsOverVoxelsOfTheFieldAtHand) {
  const auto soup = shared(test::sphere(0.5));
  AuthoringPipeline pipeline(soup), previews(soup);
  MeshingOptions options;
  options.pseudo_volume.p_in_voxels = 2.0, options.pseudo_volume.p_subs_voxels = 3.0;
  Progress progress;
  const auto full = pipeline.run(options, progress);
  EXPECT_EQ(preview_stride(options), 2);
  const MeshingOptions coarse = thinned(options, 2);
  const auto preview = previews.run_thinned(coarse, full->field, 2, progress);
  EXPECT_DOUBLE_EQ(preview->field->grid.spacing, 2.0 * full->field->grid.spacing);
  EXPECT_DOUBLE_EQ(preview->pseudo_volume->thresholds.d_in, full->pseudo_volume->thresholds.d_in);
  EXPECT_NEAR(preview->quality.volume / full->quality.volume, 1.0, 0.02);
  EXPECT_TRUE(previews.run_thinned(coarse, full->field, 2, progress)->stages.front().reused);
  EXPECT_FALSE(previews.run(coarse, progress)->stages.front().reused);
}

TEST(Pipeline, AShapeHasTheTetsAloneAndTheWholeGoesOnFromThere) {
  AuthoringPipeline pipeline(shared(test::sphere(0.5)));
  Progress progress;
  const auto shape = pipeline.run(small(), progress, Extent::shape);
  EXPECT_FALSE(shape->embedding);
  EXPECT_GT(shape->quality.min_dihedral_deg, 0.0);
  const auto whole = pipeline.run(small(), progress);
  EXPECT_EQ(whole->smoothed, shape->smoothed);
  EXPECT_EQ(whole->quality.volume, shape->quality.volume);
  EXPECT_TRUE(whole->embedding);
  EXPECT_GT(whole->quality.coverage, 0.9);
}

TEST(Pipeline, AReusedResultIsThatOfAFreshRun) {
  const auto soup = shared(test::torus(0.35, 0.15));
  AuthoringPipeline pipeline(soup);
  Progress progress;
  MeshingOptions options = small();
  for (const double density : {0.5, 0.3, 0.7})
    for (const double p_in : {1.0, 1.5}) {
      options.lattice.density = density, options.pseudo_volume.p_in_voxels = p_in;
      const auto kept = pipeline.run(options, progress);
      const auto fresh = AuthoringPipeline(soup).run(options, progress);
      EXPECT_EQ(kept->mesh().positions, fresh->mesh().positions);
      EXPECT_EQ(kept->mesh().tets, fresh->mesh().tets);
    }
}

TEST(Pipeline, ACancelledRunKeepsWhatWasFinished) {
  AuthoringPipeline pipeline(shared(test::sphere(0.5)));
  Progress quiet;
  pipeline.run(small(), quiet);
  MeshingOptions options = small();
  options.voxels = 40;
  std::atomic<bool> cancel{false};
  Progress progress([&](std::string_view phase, double) { cancel = phase == "lattice"; }, &cancel);
  EXPECT_THROW(pipeline.run(options, progress), Error);
  const auto model = pipeline.run(options, quiet);
  EXPECT_EQ(recomputed(*model).front(), "lattice");
  EXPECT_EQ(model->mesh().positions,
            AuthoringPipeline(shared(test::sphere(0.5))).run(options, quiet)->mesh().positions);
}

}  // namespace
}  // namespace isochor

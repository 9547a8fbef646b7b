#include <gtest/gtest.h>

#include "core/pipeline/pipeline.h"
#include "tests/support/shapes.h"

namespace isochor {
namespace {

TEST(Budget, TheEstimateBoundsWhatIsMade) {
  const auto soup = std::make_shared<const TriangleSoup>(test::box(Vec3::Zero(), Vec3(1, 2, 3)));
  MeshingOptions options;
  options.voxels = 60, options.lattice.cells = 20;
  Progress progress;
  const auto model = AuthoringPipeline(soup).run(options, progress);
  const Estimate e = estimate(*soup, options);
  EXPECT_EQ(e.voxels, model->field->grid.count());
  EXPECT_GE(e.max_cells, static_cast<std::int64_t>(model->mesh().cells.size()));
  EXPECT_EQ(e.max_tets, 5 * e.max_cells);
  EXPECT_GT(e.seconds, 0.0);
}

TEST(Budget, NamesTheLargestCellsThatFit) {
  const TriangleSoup soup = test::box(Vec3::Zero(), Vec3::Ones());
  MeshingOptions options;
  options.voxels = 256, options.lattice.cells = 128;
  MeshingOptions smaller = options;
  smaller.lattice.cells = 40;
  const std::int64_t limit = estimate(soup, smaller).bytes;
  try {
    check_budget(soup, options, limit);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::over_budget);
    EXPECT_EQ(error.details().at(0).pointer, "/cells");
    EXPECT_EQ(error.details().at(0).max, 40.0);
  }
  EXPECT_NO_THROW(check_budget(soup, smaller, limit));
}

TEST(Budget, NamesTheLargestVoxelsWhenNoNumberOfCellsFits) {
  const TriangleSoup soup = test::box(Vec3::Zero(), Vec3::Ones());
  MeshingOptions options;
  options.voxels = 512;
  MeshingOptions smaller = options;
  smaller.voxels = 100;
  try {
    check_budget(soup, options, estimate(soup, smaller).bytes);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.details().at(0).pointer, "/voxels");
    EXPECT_EQ(error.details().at(0).max, 100.0);
  }
}

TEST(Budget, APreviewKeepsDistancesAtHalfTheVoxels) {
  MeshingOptions options;
  options.pseudo_volume.p_in_voxels = 4.0, options.pseudo_volume.p_subs_voxels = 6.0;
  const MeshingOptions preview = preview_options(options);
  EXPECT_EQ(preview.voxels, 64);
  EXPECT_DOUBLE_EQ(preview.pseudo_volume.p_in_voxels, 2.0);
  EXPECT_DOUBLE_EQ(preview.pseudo_volume.p_subs_voxels, 3.0);
  EXPECT_EQ(preview.lattice.cells, 24);
  options.voxels = 40, options.lattice.cells = 20;
  EXPECT_EQ(preview_options(options).lattice.cells, 10);
}

}  // namespace
}  // namespace isochor

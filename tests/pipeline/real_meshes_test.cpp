#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "core/mesh_input/read_mesh.h"
#include "core/pipeline/pipeline.h"

namespace isochor {
namespace {

/// Meshes that are not part of the project: a folder named by the environment.
class RealMeshes : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("ISOCHOR_MESHES");
    if (folder == nullptr) GTEST_SKIP() << "ISOCHOR_MESHES is not set";
    const auto path = std::filesystem::path(folder) / GetParam();
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
    Progress progress;
    soup_ = std::make_shared<const TriangleSoup>(read_mesh(path, progress));
  }

  std::shared_ptr<const TriangleSoup> soup_;
};

TEST_P(RealMeshes, GiveASoundModelForAnySmoothing) {
  AuthoringPipeline pipeline(soup_);
  Progress progress;
  for (const int cells : {24, 48}) {
    MeshingOptions options;
    options.lattice.cells = cells;
    options.smoothing.iterations = 0;
    const double lattice_volume = pipeline.run(options, progress)->quality.volume;
    for (const int iterations : {0, 1, 2, 5, 20}) {
      options.smoothing.iterations = iterations;
      const auto model = pipeline.run(options, progress);
      EXPECT_EQ(model->quality.inverted, 0);
      EXPECT_GE(model->quality.min_dihedral_deg, iterations <= 2 ? 29.0 : 20.0)
          << iterations << " iterations";
      EXPECT_NEAR(model->quality.volume / lattice_volume, 1.0, 1e-12);
      EXPECT_TRUE(model->quality.coverage >= 0.95 || !model->warnings.empty());
      EXPECT_LT(model->quality.to_pseudo_volume.max_diagonals, 0.6);
    }
  }
}

TEST_P(RealMeshes, HaveTheirVolumeAt48Cells) {
  MeshingOptions options;
  options.lattice.cells = 48;
  Progress progress;
  const auto model = AuthoringPipeline(soup_).run(options, progress);
  EXPECT_EQ(model->quality.inverted, 0);
  EXPECT_GE(model->quality.min_dihedral_deg, 29.0);
  if (!model->input->closed) return;
  const bool self_intersecting =
      std::string_view(GetParam()) == "featuretype.obj";  // it counts overlaps twice
  EXPECT_NEAR(model->quality.volume / std::abs(model->input->volume), 1.0, self_intersecting ? 0.06 : 0.03);
  EXPECT_LT(model->quality.boundary_to_input, std::sqrt(3.0) * model->mesh().grid.spacing);
}

INSTANTIATE_TEST_SUITE_P(Shared, RealMeshes,
                         testing::Values("armadillo.obj", "bunny.obj", "featuretype.obj", "sheet.obj",
                                         "teapot.obj", "treesoup.obj"));

TEST(MillionTets, FromTheArmadillo) {
  const char* folder = std::getenv("ISOCHOR_MESHES");
  if (folder == nullptr) GTEST_SKIP() << "ISOCHOR_MESHES is not set";
  Progress progress;
  const auto soup = std::make_shared<const TriangleSoup>(
      read_mesh(std::filesystem::path(folder) / "armadillo.obj", progress));
  MeshingOptions options;
  options.voxels = 288, options.lattice.cells = 144;
  const auto model = AuthoringPipeline(soup).run(options, progress);
  EXPECT_GT(model->mesh().tets.size(), 1'000'000u);
  EXPECT_EQ(model->quality.inverted, 0);
  EXPECT_GE(model->quality.min_dihedral_deg, 20.0);
  EXPECT_NEAR(model->quality.volume / model->input->volume, 1.0, 0.03);
}

}  // namespace
}  // namespace isochor

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "core/mesh_input/read_mesh.h"
#include "core/parameters/parameters.h"
#include "core/pipeline/pipeline.h"
#include "core/scene/read_scene.h"

namespace isochor {
namespace {

namespace fs = std::filesystem;

std::string read_text(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::shared_ptr<const Model> make_sample(AuthoringPipeline& pipeline, const std::string& params) {
  Progress progress;
  return pipeline.run(read_meshing_options(read_text(fs::path(ISOCHOR_SAMPLES) / "params" / params)),
                      progress);
}

AuthoringPipeline open_sample(const std::string& mesh) {
  Progress progress;
  return AuthoringPipeline(
      std::make_shared<TriangleSoup>(read_mesh(fs::path(ISOCHOR_SAMPLES) / "meshes" / mesh, progress)));
}

/// V − E + F of the boundary: 2 for each piece without holes, 2 less for each handle.
std::int64_t euler_characteristic(const TetMesh& mesh) {
  std::set<std::int32_t> vertices;
  std::set<std::pair<std::int32_t, std::int32_t>> edges;
  for (const Triangle& t : mesh.surface)
    for (int i = 0; i < 3; ++i) {
      vertices.insert(t[i]);
      edges.insert(std::minmax(t[i], t[(i + 1) % 3]));
    }
  return static_cast<std::int64_t>(vertices.size() + mesh.surface.size()) -
         static_cast<std::int64_t>(edges.size());
}

// Diziol 2009, Figure 1.
TEST(Figures, TheThresholdsTakeTheTreeFromThinBranchesToAClosedCrown) {
  AuthoringPipeline pipeline = open_sample("tree.obj");
  std::vector<std::shared_ptr<const Model>> models;
  for (const char* params : {"tree_twigs.json", "tree_foliage.json", "tree_crown.json", "tree_envelope.json"})
    models.push_back(make_sample(pipeline, params));
  for (std::size_t i = 0; i < models.size(); ++i) {
    EXPECT_GE(models[i]->quality.coverage, 0.95) << i;
    EXPECT_EQ(models[i]->quality.inverted, 0) << i;
    EXPECT_GE(models[i]->quality.min_dihedral_deg, 20.0) << i;
    if (i > 0) {
      EXPECT_GT(models[i]->quality.volume, 1.8 * models[i - 1]->quality.volume) << i;
    }
  }
  EXPECT_LT(euler_characteristic(models.front()->mesh()), 0) << "gaps between branches are handles";
  EXPECT_EQ(euler_characteristic(models.back()->mesh()), 2) << "a closed crown has none";
  EXPECT_EQ(models.back()->lattice->components, 1);
}

/// Largest distance from a mirrored vertex near a leg's end to the next vertex, in cells.
double mirror_error(const TetMesh& mesh, int axis) {
  double low = 1e300;
  for (const Vec3& p : mesh.positions) low = std::min(low, p.y());
  std::vector<Vec3> end;
  for (const Vec3& p : mesh.positions)
    if (p.x() > 0 && p.z() > 0 && p.y() < low + 5 * mesh.grid.spacing) end.push_back(p);
  const auto [first, last] = std::ranges::minmax(end, {}, [&](const Vec3& p) { return p[axis]; });
  double error = 0.0;
  for (Vec3 mirrored : end) {
    mirrored[axis] = first[axis] + last[axis] - mirrored[axis];
    double nearest = 1e300;
    for (const Vec3& p : end) nearest = std::min(nearest, (p - mirrored).norm());
    error = std::max(error, nearest / mesh.grid.spacing);
  }
  return error;
}

// Diziol 2009, Figure 2: a leg is symmetric about its own middle, through the middle of cells, where the
// diagonals of the five-tet pattern are not.
TEST(Figures, AxisAlignedSmoothingKeepsTheTablesLegsSymmetric) {
  AuthoringPipeline pipeline = open_sample("table.obj");
  const auto ours = make_sample(pipeline, "table_axis_aligned.json");
  const auto all = make_sample(pipeline, "table_all_edges.json");
  ASSERT_EQ(ours->mesh().cells.size(), all->mesh().cells.size());
  for (const int axis : {0, 2}) {
    EXPECT_LT(mirror_error(*ours->unsmoothed, axis), 1e-12);
    EXPECT_LT(mirror_error(ours->mesh(), axis), 1e-12);
    EXPECT_GT(mirror_error(all->mesh(), axis), 0.1);
  }
  EXPECT_NEAR(ours->quality.volume / total_volume(*ours->unsmoothed), 1.0, 1e-12);
}

// From a hull of a few hundred tets to a fine model, by parameters alone.
TEST(Figures, ParametersReachFromACoarseHullToAFineModel) {
  AuthoringPipeline pipeline = open_sample("tree.obj");
  Progress progress;
  const auto hull = pipeline.run(preset_options("hull"), progress);
  MeshingOptions options = preset_options("fine");
  options.pseudo_volume.p_in_voxels = 2.0, options.pseudo_volume.p_subs_voxels = 3.0;
  const auto fine = pipeline.run(options, progress);
  EXPECT_LT(hull->mesh().tets.size(), 2000U);
  EXPECT_GT(fine->mesh().tets.size(), 30U * hull->mesh().tets.size());
  EXPECT_EQ(euler_characteristic(hull->mesh()), 2);
  EXPECT_EQ(hull->quality.coverage, 1.0);
  EXPECT_GT(fine->quality.coverage, 0.95);
  EXPECT_GT(hull->quality.volume, 3.0 * fine->quality.volume);
}

}  // namespace
}  // namespace isochor

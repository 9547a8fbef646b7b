#include "core/dynamics/newton_checkerboards.h"

#include <gtest/gtest.h>

#include "tests/newton/body.h"

namespace isochor::newton {
namespace {

using testing::Body;

/// Three bars that cross: most of the box around them is empty.
Body make_bars(int n) {
  return testing::make_masked(n, [](const Vec3& p) {
    return std::ranges::count_if(p, [](double x) { return std::abs(x) < 0.25; }) >= 2;
  });
}

TEST(Checkerboards, InvertTheMatrixBetweenThem) {
  const Body body = make_bars(12);
  const auto layout = make_lattice_layout(body.mesh);
  ASSERT_TRUE(layout);
  AlignedArray<float> entries(stencil_size * layout->slots);
  Stencil stencil;
  for (int k = 0; k < stencil_size; ++k) stencil.entry[k] = entries.data() + k * layout->slots;
  const auto apart = [](int k) {
    return std::abs(neighbor(k).x) + std::abs(neighbor(k).y) + std::abs(neighbor(k).z);
  };
  for (const std::int32_t slot : layout->cell_slots)
    for (int k = 0; k < stencil_size; ++k)
      if (layout->kinds[slot + neighbor(k).offset(layout->strides)] != LatticeLayout::none)
        stencil.entry[k][slot] = k == stencil_center ? 3.0F : -0.05F * static_cast<float>(apart(k));
  Checkerboards checkerboards(*layout, stencil);

  std::mt19937 random(3);
  std::uniform_real_distribution<float> any(-1.0F, 1.0F);
  std::vector<float> wanted(layout->cell_slots.size());
  for (float& height : wanted) height = any(random);
  const CheckerboardHeights found = checkerboards.heights();
  const auto value = [&](std::int64_t slot) { return found.signs[slot] * wanted[found.blocks[slot]]; };
  AlignedArray<float> residual(layout->slots);
  for (const std::int32_t slot : layout->cell_slots)
    for (int k = 0; k < stencil_size; ++k)
      residual[slot] += stencil.entry[k][slot] * value(slot + neighbor(k).offset(layout->strides));
  checkerboards.solve(residual.data());
  for (const std::int32_t slot : layout->cell_slots)
    ASSERT_NEAR(found.signs[slot] * found.heights[found.blocks[slot]], value(slot), 1e-3);
}

// With the diagonal alone it takes 86 iterations.
TEST(Checkerboards, TakeFewIterationsThroughThinBodies) {
  const Body body = make_bars(24);
  const Coordinates start(body.mesh.positions);
  Coordinates points = transformed(body, Vec3(1.0, 0.8, 1.0).asDiagonal());
  const VolumeModel model = body.model();
  std::vector<BlockedParticle> blocked;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (body.mesh.nodes[i][1] == 0)
      blocked.push_back({static_cast<std::int32_t>(i),
                         model.inverse_masses[i] * Vec3(1.0, 0.0, 1.0).asDiagonal().toDenseMatrix()});
  const auto projector = make_newton_projector(model);
  const ProjectionResult result =
      projector->project({.start = &start, .blocked = blocked, .tolerance = 1e-9}, points);
  EXPECT_TRUE(result.converged) << result.max_error;
  EXPECT_TRUE(result.kept_directions);
  EXPECT_LT(result.linear_iterations, 75);
}

}  // namespace
}  // namespace isochor::newton

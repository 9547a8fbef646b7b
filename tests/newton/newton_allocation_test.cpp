#include <gtest/gtest.h>

#include "tests/newton/body.h"
#include "tests/support/counted_new.h"

namespace isochor {
namespace {

using namespace testing;

TEST(NewtonAllocation, AllocatesNothingOnceWarm) {
  for (const bool per_tet : {false, true}) {
    const Body body = make_box({6, 5, 4});
    const VolumeModel model = body.model(per_tet);
    const auto projector = make_newton_projector(model);
    const Coordinates start(body.mesh.positions), predicted = randomized(body, 0.02);
    std::vector<BlockedParticle> blocked;
    for (std::int32_t i = 0; i < 20; ++i)
      blocked.push_back({i, model.inverse_masses[i] * Vec3(1.0, 0.0, 1.0).asDiagonal().toDenseMatrix()});
    std::vector<Vec3> forces(blocked.size());
    const auto project = [&] {
      Coordinates points = predicted;
      ProjectionRequest request;
      request.start = &start;
      request.blocked = blocked;
      request.blocked_forces = forces;
      request.max_iterations = per_tet ? 2 : 40;
      const std::int64_t before = allocations.load();
      projector->project(request, points);
      return allocations.load() - before;
    };
    project();
    EXPECT_EQ(project(), 0) << (per_tet ? "per tet" : "per cell");
  }
}

}  // namespace
}  // namespace isochor

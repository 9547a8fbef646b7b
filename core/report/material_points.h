#pragma once
#include <vector>

#include "core/embedding/embedding.h"
#include "core/scene/simulation.h"

namespace isochor {

/// Points of the bodies at rest, so that runs of different resolutions can be compared: particles of the
/// deformable bodies, every so many, and of each rigid one the middles of the six sides of its bounding box,
/// which turn with it; of a plane, which has none, its position.
struct MaterialPoints {
  struct Body {
    int id = 0;
    std::vector<Vec3> rest;  ///< of a deformable body in the world at rest, of a rigid one in its own frame
  };
  std::vector<Body> bodies;
};
MaterialPoints choose_material_points(const std::vector<BodyTopology>& topology, int per_body);

/// Follows material points through the snapshots of one simulation.
class PointTracker {
 public:
  PointTracker(const MaterialPoints& points, const std::vector<BodyTopology>& topology);
  /// World positions of all points, bodies in order.
  std::vector<Vec3> locate(const Snapshot& snapshot) const;

 private:
  struct Bound {
    int id = 0;
    std::vector<Vec3> fixed;  ///< of a rigid body, in its own frame
    TetMesh rest;             ///< of a deformable body: its mesh in the world at rest
    Embedding embedding;
  };
  std::vector<Bound> bodies_;
};

}  // namespace isochor

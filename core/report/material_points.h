#pragma once
#include <vector>

#include "core/embedding/embedding.h"
#include "core/scene/simulation.h"

namespace isochor {

/// Points of the bodies at rest, so that runs of different resolutions can be compared: particles of the
/// deformable bodies, every so many, and the position of each rigid one.
struct MaterialPoints {
  struct Body {
    int id = 0;
    std::vector<Vec3> rest;  ///< world coordinates at rest; empty for a rigid body
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
    TetMesh rest;  ///< of a deformable body: its mesh in the world at rest
    Embedding embedding;
  };
  std::vector<Bound> bodies_;
};

}  // namespace isochor

#pragma once
#include <optional>

#include "core/collision/manifold.h"
#include "core/rigid/body_record.h"

namespace isochor {

/// A body's path through the step under way: free flight under gravity, or its motion.
struct BodyPath {
  const BodyRecord& body;
  Vec3 gravity;

  Pose at(double t) const;
  Vec3 velocity(double t) const;
};

/// Largest speed at which any two points of the bodies can approach each other within [0, h].
double approach_bound(const BodyPath& a, const BodyPath& b, double h);

struct Impact {
  double time = 0.0;
  Pose pose_a, pose_b;
  Manifold manifold;  ///< the points that touch, or will soon
};

struct ImpactSearch {
  double from = 0.0, until = 0.0;  ///< seconds into the step
  double least_speed = 0.0;        ///< m/s: slower ones do not count
};

/// First time at which two bodies touch and approach, by conservative advancement [Mirtich 1996] and, near
/// it, by the speed of approach of the closest points. False when there is none.
bool find_impact(const BodyPath& a, const BodyPath& b, const ImpactSearch& search, Impact& impact);

}  // namespace isochor

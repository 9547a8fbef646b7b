#pragma once
#include <span>
#include <utility>
#include <vector>

#include "core/rigid/body_record.h"

namespace isochor {

using BodyPair = std::pair<int, int>;  ///< first < second

/// The pairs of bodies that can meet within a step: sweep and prune along x over the boxes that the bodies
/// pass through [Baraff 1992]. Pairs without a dynamic body and pairs held by a joint are left out.
class BroadPhase {
 public:
  /// jointed is sorted. The pairs come sorted.
  void find(std::span<const BodyRecord> bodies, std::span<const BodyPair> jointed, const Vec3& gravity,
            double h);
  std::span<const BodyPair> pairs() const { return pairs_; }

 private:
  std::vector<Box> boxes_;
  std::vector<int> order_;
  std::vector<BodyPair> pairs_;
};

}  // namespace isochor

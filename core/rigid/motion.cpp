#include "core/rigid/motion.h"

#include <algorithm>

namespace isochor {
namespace {

Pose interpolate(const std::vector<Keyframe>& keys, double t) {
  const auto next = std::upper_bound(keys.begin(), keys.end(), t,
                                     [](double time, const Keyframe& key) { return time < key.t; });
  const Keyframe& b = next == keys.end() ? keys.back() : *next;
  const Keyframe& a = next == keys.begin() ? keys.front() : *std::prev(next);
  const double span = b.t - a.t, s = span > 0.0 ? std::clamp((t - a.t) / span, 0.0, 1.0) : 0.0;
  return {a.position + s * (b.position - a.position),
          a.orientation.normalized().slerp(s, b.orientation.normalized()).normalized()};
}

}  // namespace

Pose pose_at(const Motion& motion, const Pose& start, double t) {
  if (!motion.keyframes.empty()) return interpolate(motion.keyframes, t);
  const double moving = std::min(t, motion.until);
  return {start.position + moving * motion.velocity,
          (rotation_exp(moving * motion.angular_velocity) * start.orientation).normalized()};
}

}  // namespace isochor

#include "core/rigid/broad_phase.h"

#include <algorithm>

namespace isochor {
namespace {

/// What the shape passes through within h, with room for impulses within the step to change its course.
Box swept_box(const BodyRecord& body, const Vec3& gravity, double h) {
  Box local = body.shape->bounds();
  if (local.max.x() >= 1e300) return local;  // a plane is everywhere
  const Eigen::Matrix3d turn = body.state.pose.orientation.toRotationMatrix().cwiseAbs();
  const Vec3 center = body.state.pose.to_world(local.center()), half = turn * (0.5 * local.size());
  const double spun = std::min(1.0, h * body.angular_velocity().norm()) * body.reach;
  const Vec3 moved = (h * body.velocity()).cwiseAbs() + (0.5 * h * h * gravity).cwiseAbs();
  const Vec3 margin = 2.0 * moved + Vec3::Constant(2.0 * spun + 0.01 * body.reach);
  return {center - half - margin, center + half + margin};
}

bool overlap(const Box& a, const Box& b) {
  return (a.min.array() <= b.max.array()).all() && (b.min.array() <= a.max.array()).all();
}

}  // namespace

void BroadPhase::find(std::span<const BodyRecord> bodies, std::span<const BodyPair> jointed,
                      const Vec3& gravity, double h) {
  boxes_.clear(), order_.clear(), pairs_.clear();
  for (const BodyRecord& body : bodies) {
    order_.push_back(static_cast<int>(boxes_.size()));
    boxes_.push_back(swept_box(body, gravity, h));
  }
  const auto box = [&](int i) -> const Box& { return boxes_[static_cast<std::size_t>(i)]; };
  const auto dynamic = [&](int i) { return bodies[static_cast<std::size_t>(i)].dynamic(); };
  std::sort(order_.begin(), order_.end(),
            [&](int i, int j) { return std::pair(box(i).min.x(), i) < std::pair(box(j).min.x(), j); });
  for (auto i = order_.begin(); i != order_.end(); ++i)
    for (auto j = i + 1; j != order_.end() && box(*j).min.x() <= box(*i).max.x(); ++j) {
      const BodyPair pair = std::minmax(*i, *j);
      if ((!dynamic(*i) && !dynamic(*j)) || !overlap(box(*i), box(*j))) continue;
      if (!std::binary_search(jointed.begin(), jointed.end(), pair)) pairs_.push_back(pair);
    }
  std::sort(pairs_.begin(), pairs_.end());
}

}  // namespace isochor

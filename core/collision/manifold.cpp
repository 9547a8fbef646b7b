#include "core/collision/manifold.h"

#include <algorithm>
#include <utility>

#include "core/collision/pair_tests.h"

namespace isochor {
namespace {

template <class Shape>
Placed<Shape> as(const PlacedShape& placed) {
  return {static_cast<const Shape&>(placed.shape), placed.pose};
}

/// Pairs in ascending order of type, `a` the higher one.
double collide_ordered(const PlacedShape& a, const PlacedShape& b, double margin, Manifold& out) {
  const ShapeType type = b.shape.type();
  switch (a.shape.type()) {
    case ShapeType::sphere:
      return collide_sphere(as<CollisionSphere>(a), b, margin, out);
    case ShapeType::box:
      if (type == ShapeType::plane)
        return collide_box_plane(as<CollisionBox>(a), as<CollisionPlane>(b), margin, out);
      return collide_boxes(as<CollisionBox>(a), as<CollisionBox>(b), margin, out);
    case ShapeType::capsule:
      if (type == ShapeType::plane)
        return collide_capsule_plane(as<CollisionCapsule>(a), as<CollisionPlane>(b), margin, out);
      if (type == ShapeType::box)
        return collide_capsule_box(as<CollisionCapsule>(a), as<CollisionBox>(b), margin, out);
      return collide_capsules(as<CollisionCapsule>(a), as<CollisionCapsule>(b), margin, out);
    case ShapeType::mesh:
      return collide_mesh(as<CollisionMesh>(a), b, margin, out);
    default:
      return 1e300;  // planes do not meet
  }
}

}  // namespace

void Manifold::add(const ManifoldPoint& point) {
  if (count_ == capacity) reduce(16);
  points_[static_cast<std::size_t>(count_++)] = point;
}

void Manifold::reduce(int limit) {
  if (count_ <= limit) return;
  const auto first = points_.begin(), last = first + count_;
  const auto deepest =
      std::min_element(first, last, [](const auto& p, const auto& q) { return p.gap() < q.gap(); });
  std::iter_swap(first, deepest);
  for (int kept = 1; kept < limit; ++kept) {
    const auto spread = [&](const ManifoldPoint& p) {
      double least = 1e300;
      for (int i = 0; i < kept; ++i)
        least = std::min(least, (p.point() - points_[static_cast<std::size_t>(i)].point()).squaredNorm());
      return least;
    };
    const auto farthest = std::max_element(
        first + kept, last, [&](const auto& p, const auto& q) { return spread(p) < spread(q); });
    std::iter_swap(first + kept, farthest);
  }
  count_ = limit;
}

void Manifold::flip() {
  for (ManifoldPoint& p : points()) {
    std::swap(p.core_a, p.core_b);
    std::swap(p.radius_a, p.radius_b);
    p.normal = -p.normal;
    if (p.owner != NormalOwner::world) p.owner = p.owner == NormalOwner::a ? NormalOwner::b : NormalOwner::a;
  }
}

double collide(const PlacedShape& a, const PlacedShape& b, double margin, Manifold& manifold) {
  manifold.clear();
  // A sphere needs nothing but the other's distance; else the higher type comes first.
  const auto rank = [](const PlacedShape& s) {
    return s.shape.type() == ShapeType::sphere ? 100 : static_cast<int>(s.shape.type());
  };
  if (rank(a) >= rank(b)) return collide_ordered(a, b, margin, manifold);
  const double separation = collide_ordered(b, a, margin, manifold);
  manifold.flip();
  return separation;
}

}  // namespace isochor

#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "core/collision/pose.h"
#include "core/collision/shape.h"

namespace isochor {

/// Which body's rotation the contact normal follows: that of the face it belongs to.
enum class NormalOwner : std::uint8_t { world, a, b };

/// One point of contact between shapes a and b, world coordinates. The core points belong to the bodies'
/// material (a sphere's centre, a box's corner); the surfaces stand off them by `radius` along the normal.
struct ManifoldPoint {
  Vec3 core_a = Vec3::Zero(), core_b = Vec3::Zero();
  Vec3 normal = Vec3::UnitY();            ///< from b to a
  double radius_a = 0.0, radius_b = 0.0;  ///< of the roundings
  NormalOwner owner = NormalOwner::world;

  double gap() const { return normal.dot(core_a - core_b) - radius_a - radius_b; }
  /// Where impulses act: on b's surface.
  Vec3 point() const { return core_b + radius_b * normal; }
};

/// The points at which two shapes touch or nearly touch, without an allocation.
class Manifold {
 public:
  static constexpr int capacity = 64;

  std::span<const ManifoldPoint> points() const { return {points_.data(), static_cast<std::size_t>(count_)}; }
  std::span<ManifoldPoint> points() { return {points_.data(), static_cast<std::size_t>(count_)}; }
  void clear() { count_ = 0; }
  /// A full manifold is reduced to 16 points first.
  void add(const ManifoldPoint& point);
  /// Keeps at most `limit` points: the deepest, then always the one farthest from those kept.
  void reduce(int limit);
  /// Exchanges the roles of a and b.
  void flip();

 private:
  std::array<ManifoldPoint, capacity> points_;
  int count_ = 0;
};

struct PlacedShape {
  const CollisionShape& shape;
  const Pose& pose;
};

/// Finds the points of a and b that are closer than margin. Returns the separation: negative when they
/// overlap, else a lower bound of their distance that reaches zero only where they touch (for meshes up to
/// the spacing of their sample points).
double collide(const PlacedShape& a, const PlacedShape& b, double margin, Manifold& manifold);

}  // namespace isochor

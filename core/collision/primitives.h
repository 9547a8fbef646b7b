#pragma once
#include "core/collision/shape.h"

namespace isochor {

/// The shapes with a closed formula, their sizes open to the pair tests of the narrow phase.

class CollisionPlane final : public CollisionShape {
 public:
  CollisionPlane(const Vec3& n, double d) : normal(n), offset(d) {}
  ShapeType type() const override { return ShapeType::plane; }
  SurfaceQuery query(const Vec3& point) const override { return {normal.dot(point) - offset, normal}; }
  std::optional<SweepHit> sweep(const Vec3& from, const Vec3& to) const override;
  Box bounds() const override;
  double volume() const override { return 0.0; }
  Eigen::Matrix3d unit_inertia() const override { return Eigen::Matrix3d::Zero(); }

  const Vec3 normal;
  const double offset;
};

class CollisionSphere final : public CollisionShape {
 public:
  explicit CollisionSphere(double r) : radius(r) {}
  ShapeType type() const override { return ShapeType::sphere; }
  SurfaceQuery query(const Vec3& point) const override;
  std::optional<SweepHit> sweep(const Vec3& from, const Vec3& to) const override;
  Box bounds() const override;
  double volume() const override;
  Eigen::Matrix3d unit_inertia() const override;

  const double radius;
};

class CollisionBox final : public CollisionShape {
 public:
  explicit CollisionBox(const Vec3& h) : half_extents(h) {}
  ShapeType type() const override { return ShapeType::box; }
  SurfaceQuery query(const Vec3& point) const override;
  std::optional<SweepHit> sweep(const Vec3& from, const Vec3& to) const override;
  Box bounds() const override;
  double volume() const override { return 8.0 * half_extents.prod(); }
  Eigen::Matrix3d unit_inertia() const override;

  const Vec3 half_extents;
};

class CollisionCapsule final : public CollisionShape {
 public:
  CollisionCapsule(double r, double h) : radius(r), half_height(h) {}
  ShapeType type() const override { return ShapeType::capsule; }
  SurfaceQuery query(const Vec3& point) const override;
  std::optional<SweepHit> sweep(const Vec3& from, const Vec3& to) const override;
  Box bounds() const override;
  double volume() const override;
  Eigen::Matrix3d unit_inertia() const override;

  const double radius, half_height;
};

}  // namespace isochor

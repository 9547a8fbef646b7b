#pragma once
#include <memory>
#include <optional>

#include "core/common/types.h"
#include "core/mesh_input/triangle_soup.h"

namespace isochor {

/// Closest surface point of a shape as seen from a point: negative distance inside, unit normal outward.
struct SurfaceQuery {
  double distance = 0.0;
  Vec3 normal = Vec3::UnitY();
};

struct SweepHit {
  double fraction = 1.0;  ///< along the segment
  Vec3 normal = Vec3::UnitY();
};

/// A rigid shape in its own frame, centred on its centre of mass. Knows positions only, no dynamics.
class CollisionShape {
 public:
  virtual ~CollisionShape() = default;
  virtual SurfaceQuery query(const Vec3& point) const = 0;
  /// First entry of the segment into the shape; nullopt when it stays outside or starts inside.
  virtual std::optional<SweepHit> sweep(const Vec3& from, const Vec3& to) const = 0;
  virtual Box bounds() const = 0;                    ///< infinite for a plane
  virtual double volume() const = 0;                 ///< m³; 0 for a plane
  virtual Eigen::Matrix3d unit_inertia() const = 0;  ///< inertia tensor of mass 1, m²
};

std::unique_ptr<CollisionShape> make_plane(const Vec3& normal, double offset);
std::unique_ptr<CollisionShape> make_sphere(double radius);
std::unique_ptr<CollisionShape> make_box(const Vec3& half_extents);
std::unique_ptr<CollisionShape> make_capsule(double radius, double half_height);

}  // namespace isochor

#pragma once
#include <cstdint>
#include <memory>
#include <optional>

#include "core/common/types.h"
#include "core/mesh_input/triangle_soup.h"

namespace isochor {

/// Closest surface point of a shape as seen from a point: negative distance inside, unit normal outward. The
/// normal is the gradient of the distance; where there is none (a sphere's centre, a box's medial planes) it
/// is one of the closest directions, always the same one.
struct SurfaceQuery {
  double distance = 0.0;
  Vec3 normal = Vec3::UnitY();
};

struct SweepHit {
  double fraction = 1.0;  ///< along the segment
  Vec3 normal = Vec3::UnitY();
};

enum class ShapeType { plane, sphere, box, capsule, mesh };

/// A rigid shape in its own frame, centred on its centre of mass. Knows positions only, no dynamics. All
/// lengths in metres.
class CollisionShape {
 public:
  virtual ~CollisionShape() = default;
  virtual ShapeType type() const = 0;
  virtual SurfaceQuery query(const Vec3& point) const = 0;
  /// First entry of the segment into the shape, at fraction 0 when it starts on the surface and heads inward;
  /// nullopt when it stays outside or starts inside.
  virtual std::optional<SweepHit> sweep(const Vec3& from, const Vec3& to) const = 0;
  virtual Box bounds() const = 0;                    ///< ±1e300 for a plane
  virtual double volume() const = 0;                 ///< m³; 0 for a plane
  virtual Eigen::Matrix3d unit_inertia() const = 0;  ///< inertia tensor of mass 1, m²; 0 for a plane
  virtual std::int64_t bytes() const { return 0; }   ///< of what it keeps beside a few numbers
};

/// Points with normal·p ≤ offset are inside. All four throw invalid_argument on sizes that are not positive
/// and finite.
std::unique_ptr<CollisionShape> make_plane(const Vec3& normal, double offset);
std::unique_ptr<CollisionShape> make_sphere(double radius);
std::unique_ptr<CollisionShape> make_box(const Vec3& half_extents);
/// Points within radius of the segment from −half_height to +half_height on the y axis.
std::unique_ptr<CollisionShape> make_capsule(double radius, double half_height);

}  // namespace isochor

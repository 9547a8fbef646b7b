#pragma once
#include "core/collision/manifold.h"
#include "core/collision/mesh_shape.h"
#include "core/collision/primitives.h"

namespace isochor {

/// The tests of the narrow phase, one a pair of shape types; collide() picks one. Each adds the points closer
/// than margin and returns the separation.
template <class Shape>
struct Placed {
  const Shape& shape;
  const Pose& pose;

  SurfaceQuery query(const Vec3& world) const {
    SurfaceQuery q = shape.query(pose.to_local(world));
    q.normal = pose.orientation * q.normal;
    return q;
  }
};

double collide_sphere(const Placed<CollisionSphere>& a, const PlacedShape& b, double margin, Manifold& out);
double collide_capsule_plane(const Placed<CollisionCapsule>& a, const Placed<CollisionPlane>& b,
                             double margin, Manifold& out);
double collide_capsules(const Placed<CollisionCapsule>& a, const Placed<CollisionCapsule>& b, double margin,
                        Manifold& out);
double collide_capsule_box(const Placed<CollisionCapsule>& a, const Placed<CollisionBox>& b, double margin,
                           Manifold& out);
double collide_box_plane(const Placed<CollisionBox>& a, const Placed<CollisionPlane>& b, double margin,
                         Manifold& out);
/// Separating axes, then the incident face clipped against the reference face, or the closest points of two
/// edges [Gottschalk 1996].
double collide_boxes(const Placed<CollisionBox>& a, const Placed<CollisionBox>& b, double margin,
                     Manifold& out);
/// Surface points of each against the distance of the other.
double collide_mesh(const Placed<CollisionMesh>& a, const PlacedShape& b, double margin, Manifold& out);
}  // namespace isochor

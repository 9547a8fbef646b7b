#pragma once
#include "core/collision/box_hash.h"
#include "core/dynamics/surface_contacts.h"
#include "core/scene/world.h"

namespace isochor {

/// Deformable bodies against each other and against themselves: finds which vertex has gone through which
/// triangle, by a spatial hash of what the triangles sweep.
class SurfaceCollision {
 public:
  explicit SurfaceCollision(const World& world);

  /// A substep of h begins: finds contacts, the bodies at their predicted positions.
  void begin(World& world, double h);
  /// Contacts turn with their triangles, or move on to the nearest on their side, and those that have come up
  /// since are added. True for an addition.
  bool update(bool may_move_on);
  /// Is nothing behind a triangle by more than the tolerance, in cells, or than it was at the start?
  bool keeps_apart(double tolerance);

  SurfaceContacts& contacts() { return contacts_; }
  const SurfaceContacts& contacts() const { return contacts_; }
  bool touches(std::size_t body) const { return bodies_[body].touched; }
  /// Is it in another, or another in it, as keeps_apart() has seen it?
  bool is_entered(std::size_t body) const { return surfaces_[body].entered; }

  struct Penetration {
    double depth = 0.0;  ///< m
    double cells = 0.0;  ///< the same in cells, of the body that has the smaller ones
  };
  /// Deepest surface vertex in a tet of another body, or of its own that it is no corner of, below the
  /// nearest triangle.
  Penetration deepest_penetration(const World& world);

  std::int64_t bytes() const;

 private:
  struct Surface {
    bool meets_itself = false, entered = false;
    double friction = 0.0, restitution = 0.0;
    Box swept;
    Coordinates normals;                ///< of its surface vertices
    Coordinates seen;                   ///< its positions when candidates were listed last
    std::vector<std::int32_t> cells;    ///< of its triangles, where it meets itself
    std::vector<std::int32_t> watched;  ///< a vertex: where it stands in watched_, or −1
  };
  struct SurfaceTriangle {
    int body = 0;
    std::int32_t cell = -1;  ///< where its body meets itself; the cell's own vertices do not touch it
    Triangle corners{};
  };
  /// A triangle that a vertex may touch.
  struct Candidate {
    std::int32_t triangle = 0;
    bool faces = false;  ///< turned towards the vertex's side of its surface
  };
  struct Watched {
    int owner = 0;
    std::int32_t vertex = 0;
    std::ptrdiff_t begin = 0, end = 0;  ///< in candidates_
  };
  /// A vertex that has gone through a triangle.
  struct Entry {
    double time = 1.0;
    Candidate through;
  };

  void find_normals(std::size_t body);
  void look_at(const World& world);
  void hash_triangles(bool swept);
  void hash_tets();
  bool may_meet(std::size_t body, const Box& box) const;
  bool find_contacts(bool first);
  bool find_contacts_of(int owner, std::int32_t vertex, bool first);
  bool meets(const SurfaceTriangle& triangle, int owner, std::int32_t vertex) const;
  double least_gap(int owner, std::int32_t vertex, int other, const Triangle& triangle) const;
  /// Is the triangle turned towards the vertex's side of its surface?
  bool faces(const SurfaceTriangle& triangle, int owner, std::int32_t vertex) const;
  bool comes_near(int owner, std::int32_t vertex, const SurfaceTriangle& triangle) const;
  void watch();
  void watch(int owner, std::int32_t vertex);
  /// Where particles have moved too far for the candidates to hold.
  void watch_again();
  std::span<const Candidate> candidates(int owner, std::int32_t vertex) const;
  /// What the vertex is to be in front of: the nearest triangle that faces it, of those that it is behind now
  /// and came from the front of; where there is none, the one that it has entered in this substep.
  std::optional<Triangle> nearest_front(int owner, std::int32_t vertex, const Candidate& entered) const;
  /// Was the vertex in front of the triangle as the substep began?
  bool stood_before(int owner, std::int32_t vertex, int other, const Triangle& triangle) const;
  bool brings_out(int owner, std::int32_t vertex, int other, const Triangle& triangle) const;
  bool add_contact(int owner, std::int32_t vertex, const Candidate& entered, bool first);
  /// Keeps the vertex that has entered in front of a triangle. True when that is new.
  bool hold(int owner, std::int32_t vertex, const Candidate& entered, const Triangle& triangle, bool first);
  /// In front of that triangle, by a contact?
  bool is_held(int owner, std::int32_t vertex, int other, const Triangle& triangle) const;
  void follow(std::int32_t index, bool may_move_on);
  double depth_below_surface(int body, int owner, std::int32_t vertex);
  const SoftBody& soft(int body) const { return *soft_[body]; }

  double h_ = 0.0;
  std::vector<SurfaceBody> bodies_;
  std::vector<const SoftBody*> soft_;
  std::vector<Surface> surfaces_;
  SurfaceContacts contacts_;
  BoxHash triangle_hash_, tet_hash_;
  std::vector<Box> boxes_;
  std::vector<SurfaceTriangle> triangles_;          ///< those in the hash
  std::vector<std::pair<int, std::int32_t>> tets_;  ///< body and tet of those in the hash
  std::vector<Watched> watched_;
  std::vector<Candidate> candidates_;
  std::vector<Entry> entries_;
};

}  // namespace isochor

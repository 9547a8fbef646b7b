#pragma once
#include "core/dynamics/surface_contact.h"

namespace isochor {

/// Brings the cells of a body back to their rest volumes, its contacts with rigid bodies held.
class BodyProjector {
 public:
  virtual ~BodyProjector() = default;
  virtual void project(int body, double tolerance) = 0;
};

/// The contacts of deformable bodies with each other and with themselves within one substep: of all motions
/// that keep the volumes, the one nearest to the predicted (in the metric of the masses) whose gaps are not
/// negative. Its dual is min ½λᵀDλ − eᵀλ over pressures λ ≥ 0, where D is the response of the gaps to λ with
/// all volumes kept; conjugate gradients solve it, a projection of the touched bodies each, and pressures
/// that turn negative are set to zero [as MPRGP, Dostál 2005]. Forces are equal and opposite, so that no
/// momentum is lost wherever it stops.
class SurfaceContacts {
 public:
  explicit SurfaceContacts(std::span<const std::size_t> particles);  ///< of each body

  /// Memory for a contact at each of so many vertices, and as many again.
  void reserve(std::size_t vertices);
  /// A new substep: no contact.
  void begin(std::span<SurfaceBody> bodies, double h);
  /// The substep stands: the next one starts from its pressures.
  void remember();
  bool empty() const { return contacts_.empty(); }
  std::span<SurfaceContact> contacts() { return contacts_; }
  std::span<const SurfaceContact> contacts() const { return contacts_; }
  /// The first contact of a vertex, or −1.
  std::int32_t first(int body, std::int32_t vertex) const { return slots_[body][vertex]; }
  /// Of the vertex in front of the triangle, at the body's positions, m.
  double gap(const SurfaceContact& contact) const {
    return contact.normal.dot(arm(contact, &SoftBody::positions));
  }
  /// Did this vertex touch that body in the substep before?
  bool knows(int owner, std::int32_t vertex, int other) const;

  void add(SurfaceContact contact);
  /// The contact goes on with another triangle or normal, what it has pressed so far included.
  void renew(std::int32_t index, const Triangle& triangle, const Vec3& normal, const Vec3& weights,
             double least_gap);
  /// The contacts press as they did in the substep before, as far as that moves no particle by more than a
  /// fifth of a cell.
  void recall();

  /// Until no active gap is off by more than the tolerance, in cells. True when that was reached.
  bool solve(BodyProjector& projector, double volume_tolerance, double tolerance);
  /// Is every active gap within the tolerance already?
  bool holds(double tolerance);

  /// Reads what the last projections press on the contacts with rigid bodies; scaled, where they were.
  void take_forces(double scale = 1.0);
  /// Friction for the pressures of now: nearer to what ends the slip, cut to Coulomb's cone. True when it
  /// changed by more than a twentieth of its limit.
  bool rub();
  /// v_n = −e·(approach) for the contacts that press.
  void bounce();

  std::int64_t bytes() const;

 private:
  struct Memory {
    int owner = 0, other = 0;
    std::int32_t vertex = 0;
    double pressure = 0.0;         ///< N
    Vec3 friction = Vec3::Zero();  ///< N
  };
  /// What conjugate gradients keep of a contact.
  struct Row {
    double lack = 0.0;  ///< e: displacement that is missing along the normal, m
    double lack_before = 0.0;
    double direction = 0.0;  ///< p, kg·m
  };
  enum class Step { none, bounded, whole };  ///< after a bounded one, conjugacy is lost

  const Memory* recall(int owner, std::int32_t vertex, int other) const;
  Vec3 arm(const SurfaceContact& contact, Coordinates SoftBody::*positions) const;
  Vec3 slip(const SurfaceContact& contact) const;
  /// Pushes the particles of a contact by λ; the force counts for rigid contacts as well.
  void push(const SurfaceContact& contact, const Vec3& impulse);
  void displace(const SurfaceContact& contact, const Vec3& impulse);
  void load(const SurfaceContact& contact, const Vec3& impulse);
  double find_lack();
  void choose_direction(bool restart);
  double farthest_from_base() const;
  void scale_from_base(double factor);
  void back_to_base();
  double probe(BodyProjector& projector, double volume_tolerance);
  Step step(BodyProjector& projector, double volume_tolerance);

  std::span<SurfaceBody> bodies_;
  std::vector<SurfaceContact> contacts_;
  std::vector<std::vector<std::int32_t>> slots_;  ///< a body, a particle: its first contact, or −1
  std::vector<Memory> memory_;                    ///< sorted
  std::vector<Row> rows_;
  double size_before_ = 0.0;       ///< eᵀz of the direction before
  std::vector<Coordinates> base_;  ///< a body: positions that a step starts from
  std::vector<double> bounces_;
  double h_ = 0.0;
};

}  // namespace isochor

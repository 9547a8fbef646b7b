#include "core/scene/surface_collision.h"

#include <algorithm>
#include <limits>

#include "core/collision/contact_response.h"
#include "core/collision/vertex_triangle.h"
#include "core/distance_field/closest_point.h"
#include "core/parallel/cancel_scope.h"
#include "core/scene/detect_contacts.h"

namespace isochor {
namespace {

/// A vertex that starts a substep behind a triangle by up to this came from its front, in cells. What is
/// deeper belongs to the far side of a thin part.
constexpr double front_depth = 0.3;
/// How far around a vertex its depth is looked for first, in cells.
constexpr double reach = 0.5;
/// Normals closer than this (60°) are of the same side.
constexpr double same_side = 0.5;
/// Neighbouring triangles overlap by this much, in weights, so that nothing slips through between them.
constexpr double seam = 1e-4;
/// Those that face the vertex by more: where rims lie on rims, they would let go and catch in turn.
constexpr double rim = 0.05;
/// Of the triangles that a vertex is behind at the end, the nearest counts that it was in front of by no less
/// than minus this, in cells: what slides along a surface does not run into its rim.
constexpr double rim_depth = 0.1;
/// Contacts lie in the normal cones of both surfaces where they can: the normals of vertex and triangle are
/// opposed by no less than this (75°). A vertex that slides under a rim is held by what is above the side.
constexpr double opposed = -0.26;
/// A vertex that starts a substep behind a triangle by no more than this goes through it now, in cells.
constexpr double at_front = 1e-3;
constexpr int most_contacts = 3;              ///< of a vertex with one body
constexpr std::size_t usual_candidates = 32;  ///< of a vertex
/// Weights may lie outside of the triangle by this much, where the vertex slides over its edge.
constexpr double most_overhang = 0.5;
/// By this much it may slide out, in weights, before its contact goes on to the next triangle.
constexpr double kept_overhang = 1e-3;
/// A vertex stood behind a triangle where it was over it, or beside it by this much, in weights.
constexpr double start_overhang = 0.05;

TrianglePoints points_of(const Coordinates& x, const Triangle& triangle) {
  return {x.at(triangle[0]), x.at(triangle[1]), x.at(triangle[2])};
}

Vec3 closest_point(const Vec3& p, const TrianglePoints& t) {
  return closest_point_on_triangle(p, t[0], t[1], t[2]);
}

bool has_corner(const auto& corners, std::int32_t vertex) {
  return std::ranges::find(corners, vertex) != corners.end();
}

std::vector<std::size_t> particle_counts(const World& world) {
  std::vector<std::size_t> counts;
  for (const SceneSoftBody& soft : world.soft) counts.push_back(soft.body.size());
  return counts;
}

/// Where the vertex stands on the triangle at the substep's start, seen along the normal; where that is far
/// off, at its end.
Vec3 contact_weights(const SoftBody& owner, std::int32_t vertex, const SoftBody& other,
                     const Triangle& triangle, const Vec3& normal) {
  for (const bool at_start : {true, false}) {
    const Coordinates& from = at_start ? owner.start_positions : owner.positions;
    const Coordinates& to = at_start ? other.start_positions : other.positions;
    const auto weights = weights_along(from.at(vertex), normal, points_of(to, triangle));
    if (weights && is_within(*weights, most_overhang)) return *weights;
  }
  return Vec3::Constant(1.0 / 3.0);
}

/// The cell of each triangle.
std::vector<std::int32_t> cells_of_surface(const TetMesh& mesh) {
  std::vector<std::vector<std::int32_t>> around(mesh.positions.size());
  for (std::size_t c = 0; c < mesh.cells.size(); ++c)
    for (const auto i : mesh.cells[c].corners) around[i].push_back(static_cast<std::int32_t>(c));
  std::vector<std::int32_t> cells;
  for (const Triangle& triangle : mesh.surface)
    cells.push_back(*std::ranges::find_if(around[triangle[0]], [&](std::int32_t cell) {
      const auto& corners = mesh.cells[cell].corners;
      return has_corner(corners, triangle[1]) && has_corner(corners, triangle[2]);
    }));
  return cells;
}

bool ends_over(const VertexSweep& sweep) {
  const auto weights = weights_along(sweep.to, normal_of(sweep.end), sweep.end);
  return weights && is_within(*weights, 0.0);
}

bool is_in_tet(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return tet_volume(p, b, c, d) > 0.0 && tet_volume(a, p, c, d) > 0.0 && tet_volume(a, b, p, d) > 0.0 &&
         tet_volume(a, b, c, p) > 0.0;
}

}  // namespace

World::World() = default;
World::World(World&&) noexcept = default;
World::~World() = default;

SurfaceCollision::SurfaceCollision(const World& world) : contacts_(particle_counts(world)) {
  bodies_.resize(world.soft.size());
  soft_.resize(world.soft.size());
  std::size_t triangles = 0, vertices = 0;
  for (const SceneSoftBody& soft : world.soft) {
    const SceneBody& source = world.scene.bodies[soft.id];
    Surface& surface = surfaces_.emplace_back();
    surface.meets_itself = std::get<DeformableBody>(source.kind).self_contact;
    surface.friction = source.friction;
    surface.restitution = source.restitution;
    surface.normals = surface.seen = Coordinates(soft.body.size());
    surface.watched.assign(soft.body.size(), -1);
    if (surface.meets_itself) surface.cells = cells_of_surface(*soft.body.mesh);
    triangles += soft.body.mesh->surface.size();
    vertices += soft.body.surface_particles.size();
  }
  contacts_.reserve(vertices);
  boxes_.reserve(triangles);
  triangles_.reserve(triangles);
  triangle_hash_.reserve(triangles);
  watched_.reserve(vertices);
  candidates_.reserve(usual_candidates * vertices);
  entries_.reserve(usual_candidates);
}

void SurfaceCollision::begin(World& world, double h) {
  look_at(world);
  h_ = h;
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    bodies_[b] = {&world.soft[b].body, world.soft[b].contacts.get(), false};
  contacts_.begin(bodies_, h);
  hash_triangles(true);
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (may_meet(b, surfaces_[b].swept)) find_normals(b);
  watch();
  find_contacts(true);
}

/// Of its surface vertices as the substep begins, weighted by area.
void SurfaceCollision::find_normals(std::size_t body) {
  const SoftBody& of = *soft_[body];
  Coordinates& normals = surfaces_[body].normals;
  for (const auto i : of.surface_particles) normals.set(i, Vec3::Zero());
  for (const Triangle& triangle : of.mesh->surface) {
    const TrianglePoints t = points_of(of.start_positions, triangle);
    const Vec3 area = (t[1] - t[0]).cross(t[2] - t[0]);
    for (const auto i : triangle) normals.add(i, area);
  }
  for (const auto i : of.surface_particles) normals.set(i, normals.at(i).normalized());
}

void SurfaceCollision::look_at(const World& world) {
  for (std::size_t b = 0; b < soft_.size(); ++b) soft_[b] = &world.soft[b].body;
}

bool SurfaceCollision::update(bool may_move_on) {
  watch_again();
  for (std::int32_t c = 0; c < std::ssize(contacts_.contacts()); ++c) follow(c, may_move_on);
  return find_contacts(false);
}

bool SurfaceCollision::keeps_apart(double tolerance) {
  watch_again();
  find_contacts(false);
  for (Surface& surface : surfaces_) surface.entered = false;
  bool apart = true;
  for (const SurfaceContact& contact : contacts_.contacts()) {
    const SoftBody &body = soft(contact.owner), &other = soft(contact.other);
    const Vec3 p = body.positions.at(contact.vertex);
    const TrianglePoints now = points_of(other.positions, contact.triangle);
    const Vec3 normal = normal_of(now);
    const auto weights = weights_along(p, normal, now);
    const double left = tolerance * std::min(body.cell_size, other.cell_size);
    if (!weights || !is_within(*weights, 0.0) || normal.dot(p - now[0]) >= contact.least_gap - left) continue;
    surfaces_[contact.owner].entered = surfaces_[contact.other].entered = true;
    apart = false;
  }
  return apart;
}

/// Can something of the box touch another body, or this one itself?
bool SurfaceCollision::may_meet(std::size_t body, const Box& box) const {
  if (surfaces_[body].meets_itself) return true;
  for (std::size_t other = 0; other < surfaces_.size(); ++other)
    if (other != body && overlaps(surfaces_[other].swept, box)) return true;
  return false;
}

/// Triangles that may meet something, with all that they sweep in the substep, or where they are.
void SurfaceCollision::hash_triangles(bool swept) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const SoftBody& body = *soft_[b];
    Box box;
    for (const auto i : body.surface_particles) {
      box.extend(body.positions.at(i));
      if (swept) box.extend(body.start_positions.at(i));
    }
    surfaces_[b].swept = grown(box, front_depth * body.cell_size);
  }
  boxes_.clear();
  triangles_.clear();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const SoftBody& body = *soft_[b];
    if (!may_meet(b, surfaces_[b].swept)) continue;
    for (std::size_t t = 0; t < body.mesh->surface.size(); ++t) {
      const Triangle& triangle = body.mesh->surface[t];
      Box box;
      for (const auto i : triangle) {
        box.extend(body.positions.at(i));
        if (swept) box.extend(body.start_positions.at(i));
      }
      box = grown(box, front_depth * body.cell_size);
      if (!may_meet(b, box)) continue;
      boxes_.push_back(box);
      const std::int32_t cell = surfaces_[b].meets_itself ? surfaces_[b].cells[t] : -1;
      triangles_.push_back({static_cast<int>(b), cell, triangle});
    }
  }
  throw_if_scope_cancelled();
  triangle_hash_.build(boxes_);
}

bool SurfaceCollision::meets(const SurfaceTriangle& triangle, int owner, std::int32_t vertex) const {
  if (triangle.body != owner) return true;
  return surfaces_[owner].meets_itself && !has_corner(soft(owner).mesh->cells[triangle.cell].corners, vertex);
}

/// No deeper than it stood as the substep began, and out of there at no more than the recovery's speed.
double SurfaceCollision::least_gap(int owner, std::int32_t vertex, int other,
                                   const Triangle& triangle) const {
  const Vec3 from = soft(owner).start_positions.at(vertex);
  const TrianglePoints there = points_of(soft(other).start_positions, triangle);
  const Vec3 normal = normal_of(there);
  const auto weights = weights_along(from, normal, there);
  if (!weights || !is_within(*weights, start_overhang)) return 0.0;
  return std::min(0.0, normal.dot(from - there[0]) + recovery_speed * h_ * soft(other).cell_size);
}

bool SurfaceCollision::faces(const SurfaceTriangle& triangle, int owner, std::int32_t vertex) const {
  const Vec3 normal = normal_of(points_of(soft(triangle.body).positions, triangle.corners));
  return normal.dot(surfaces_[owner].normals.at(vertex)) < opposed;
}

bool SurfaceCollision::comes_near(int owner, std::int32_t vertex, const SurfaceTriangle& triangle) const {
  const SoftBody &body = soft(owner), &other = soft(triangle.body);
  const TrianglePoints before = points_of(other.start_positions, triangle.corners);
  const TrianglePoints now = points_of(other.positions, triangle.corners);
  const Vec3 from = body.start_positions.at(vertex), to = body.positions.at(vertex);
  const double near = front_depth * other.cell_size;
  for (int k = 0; k < 3; ++k)
    if (((to - from) - (now[k] - before[k])).norm() > near) return true;
  return (to - closest_point(to, now)).norm() <= near || (from - closest_point(from, before)).norm() <= near;
}

/// Lists what may touch while particles stay within a part of front_depth of where they are.
void SurfaceCollision::watch() {
  for (const Watched& watched : watched_) surfaces_[watched.owner].watched[watched.vertex] = -1;
  watched_.clear();
  candidates_.clear();
  if (triangles_.empty()) return;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!may_meet(b, surfaces_[b].swept)) continue;
    surfaces_[b].seen = soft_[b]->positions;
    for (const auto vertex : soft_[b]->surface_particles) watch(static_cast<int>(b), vertex);
  }
}

void SurfaceCollision::watch(int owner, std::int32_t vertex) {
  throw_if_scope_cancelled();
  Box path;
  path.extend(soft(owner).start_positions.at(vertex)), path.extend(soft(owner).positions.at(vertex));
  Watched watched{owner, vertex, std::ssize(candidates_), 0};
  for (const auto t : triangle_hash_.find(path))
    if (meets(triangles_[t], owner, vertex) && comes_near(owner, vertex, triangles_[t]))
      candidates_.push_back({t, faces(triangles_[t], owner, vertex)});
  watched.end = std::ssize(candidates_);
  if (watched.end == watched.begin) return;
  surfaces_[owner].watched[vertex] = static_cast<std::int32_t>(watched_.size());
  watched_.push_back(watched);
}

void SurfaceCollision::watch_again() {
  bool moved = false;
  for (std::size_t b = 0; b < bodies_.size() && !moved; ++b) {
    if (!may_meet(b, surfaces_[b].swept)) continue;
    const SoftBody& body = *soft_[b];
    const double far = 0.25 * front_depth * body.cell_size;
    moved = std::ranges::any_of(body.surface_particles, [&](std::int32_t i) {
      return (body.positions.at(i) - surfaces_[b].seen.at(i)).squaredNorm() > far * far;
    });
  }
  if (!moved) return;
  hash_triangles(true);
  watch();
}

std::span<const SurfaceCollision::Candidate> SurfaceCollision::candidates(int owner,
                                                                          std::int32_t vertex) const {
  const std::int32_t slot = surfaces_[owner].watched[vertex];
  if (slot < 0) return {};
  const Watched& watched = watched_[slot];
  return {candidates_.begin() + watched.begin, candidates_.begin() + watched.end};
}

bool SurfaceCollision::find_contacts(bool first) {
  bool found = false;
  for (const Watched& watched : watched_) found |= find_contacts_of(watched.owner, watched.vertex, first);
  return found;
}

bool SurfaceCollision::find_contacts_of(int owner, std::int32_t vertex, bool first) {
  const SoftBody& body = soft(owner);
  VertexSweep sweep;
  sweep.from = body.start_positions.at(vertex), sweep.to = body.positions.at(vertex);
  entries_.clear();
  for (const Candidate& candidate : candidates(owner, vertex)) {
    const SurfaceTriangle& triangle = triangles_[candidate.triangle];
    const SoftBody& other = soft(triangle.body);
    sweep.start = points_of(other.start_positions, triangle.corners);
    sweep.end = points_of(other.positions, triangle.corners);
    const double slop = first ? 0.0 : contact_slop * other.cell_size;
    const double beyond = candidate.faces || ends_over(sweep) ? rim : seam;
    if (const auto time = sweep.entry(front_depth * other.cell_size, slop, beyond))
      entries_.push_back({*time, candidate});
  }
  std::ranges::sort(entries_, {}, &Entry::time);
  bool found = false;
  for (const Entry& entry : entries_) found |= add_contact(owner, vertex, entry.through, first);
  return found;
}

std::optional<Triangle> SurfaceCollision::nearest_front(int owner, std::int32_t vertex,
                                                        const Candidate& entered) const {
  const SurfaceTriangle& first = triangles_[entered.triangle];
  const SoftBody& other = soft(first.body);
  const Vec3 from = soft(owner).start_positions.at(vertex), to = soft(owner).positions.at(vertex);
  std::optional<Triangle> nearest;
  double distance = std::numeric_limits<double>::infinity();
  // What lies on a surface to within the slop does not run into the side below it.
  const double clear = entered.faces ? 0.0 : contact_slop * other.cell_size;
  if (entered.faces) {
    nearest = first.corners;
    distance = (to - closest_point(to, points_of(other.positions, first.corners))).norm();
  }
  for (const Candidate& candidate : candidates(owner, vertex)) {
    const SurfaceTriangle& triangle = triangles_[candidate.triangle];
    if (triangle.body != first.body || !candidate.faces) continue;
    const TrianglePoints before = points_of(other.start_positions, triangle.corners);
    const TrianglePoints now = points_of(other.positions, triangle.corners);
    const double away = (to - closest_point(to, now)).norm();
    if (away >= distance || normal_of(now).dot(to - now[0]) >= clear ||
        normal_of(before).dot(from - before[0]) < -rim_depth * other.cell_size)
      continue;
    distance = away;
    nearest = triangle.corners;
  }
  if (nearest) return nearest;
  // A corner that comes sideways meets nothing that faces it, and goes in all the same.
  if (stood_before(owner, vertex, first.body, first.corners)) nearest = first.corners;
  return nearest;
}

bool SurfaceCollision::stood_before(int owner, std::int32_t vertex, int other,
                                    const Triangle& triangle) const {
  const TrianglePoints there = points_of(soft(other).start_positions, triangle);
  return normal_of(there).dot(soft(owner).start_positions.at(vertex) - there[0]) >=
         -at_front * soft(other).cell_size;
}

bool SurfaceCollision::add_contact(int owner, std::int32_t vertex, const Candidate& entered, bool first) {
  const int against = triangles_[entered.triangle].body;
  const Triangle& through = triangles_[entered.triangle].corners;
  const auto front = nearest_front(owner, vertex, entered);
  if (!front) return false;
  bool added = hold(owner, vertex, entered, *front, first);
  // What comes in beside a rim is lifted over it in good time, and kept out until then.
  if (*front != through && stood_before(owner, vertex, against, through) &&
      !brings_out(owner, vertex, against, *front))
    added |= hold(owner, vertex, entered, through, first);
  return added;
}

/// Would the vertex be out of the body by this substep's end, were it in front of the triangle as far as the
/// contact asks for?
bool SurfaceCollision::brings_out(int owner, std::int32_t vertex, int other, const Triangle& triangle) const {
  const Vec3 p = soft(owner).positions.at(vertex);
  const double slop = contact_slop * soft(other).cell_size;
  const TrianglePoints now = points_of(soft(other).positions, triangle);
  if (normal_of(now).dot(p - now[0]) < -slop) return least_gap(owner, vertex, other, triangle) == 0.0;
  return std::ranges::any_of(candidates(owner, vertex), [&](const Candidate& candidate) {
    const SurfaceTriangle& near = triangles_[candidate.triangle];
    return near.body == other &&
           (p - closest_point(p, points_of(soft(other).positions, near.corners))).norm() <= slop;
  });
}

bool SurfaceCollision::hold(int owner, std::int32_t vertex, const Candidate& entered,
                            const Triangle& triangle, bool first) {
  const int against = triangles_[entered.triangle].body;
  const SoftBody &body = soft(owner), &other = soft(against);
  const TrianglePoints there = points_of(other.positions, triangle);
  SurfaceContact contact;
  contact.normal = normal_of(there);
  int known = 0;
  for (auto c = contacts_.first(owner, vertex); c >= 0; c = contacts_.contacts()[c].next) {
    const SurfaceContact& before = contacts_.contacts()[c];
    if (before.other != against) continue;
    // Beyond a ridge one plane is enough; in a valley the others come up once the first is met.
    const bool met = contacts_.gap(before) >= before.least_gap - contact_slop * other.cell_size;
    if (before.triangle == triangle || (!met && before.normal.dot(contact.normal) >= same_side)) return false;
    const bool holds = !met || before.pressure() > 0.0;
    if (holds && ++known == most_contacts) return false;
  }
  const Vec3 p = body.positions.at(vertex);
  // What the slop leaves behind a neighbouring triangle has not come in through this one.
  const bool resumed = first && contacts_.knows(owner, vertex, against);
  if (!resumed && (p - closest_point(p, there)).norm() <= contact_slop * other.cell_size) return false;
  contact.owner = owner, contact.other = against;
  contact.vertex = vertex, contact.triangle = triangle;
  contact.weights = contact_weights(body, vertex, other, contact.triangle, contact.normal);
  contact.least_gap = least_gap(owner, vertex, contact.other, contact.triangle);
  contact.friction = combined_friction(surfaces_[owner].friction, surfaces_[contact.other].friction);
  contact.restitution =
      combined_restitution(surfaces_[owner].restitution, surfaces_[contact.other].restitution);
  contacts_.add(contact);
  return true;
}

bool SurfaceCollision::is_held(int owner, std::int32_t vertex, int other, const Triangle& triangle) const {
  for (auto c = contacts_.first(owner, vertex); c >= 0; c = contacts_.contacts()[c].next) {
    const SurfaceContact& contact = contacts_.contacts()[c];
    if (contact.other == other && contact.triangle == triangle) return true;
  }
  return false;
}

/// The triangle on the same side that is nearest now, of those that do not hold the vertex already.
void SurfaceCollision::follow(std::int32_t index, bool may_move_on) {
  const SurfaceContact& contact = contacts_.contacts()[index];
  const SoftBody& body = soft(contact.owner);
  const SoftBody& other = soft(contact.other);
  const Vec3 p = body.positions.at(contact.vertex);
  Triangle nearest = contact.triangle;
  const TrianglePoints now = points_of(other.positions, nearest);
  const auto weights = weights_along(p, normal_of(now), now);
  if (may_move_on && (!weights || !is_within(*weights, kept_overhang))) {
    double distance = (p - closest_point(p, now)).norm();
    for (const Candidate& candidate : candidates(contact.owner, contact.vertex)) {
      const SurfaceTriangle& triangle = triangles_[candidate.triangle];
      if (triangle.body != contact.other || !candidate.faces) continue;
      const TrianglePoints there = points_of(other.positions, triangle.corners);
      const double away = (p - closest_point(p, there)).norm();
      if (away >= distance || normal_of(there).dot(contact.normal) < same_side ||
          is_held(contact.owner, contact.vertex, contact.other, triangle.corners))
        continue;
      distance = away;
      nearest = triangle.corners;
    }
  }
  const Vec3 normal = normal_of(points_of(other.positions, nearest));
  if (normal.isZero(0.0)) return;
  contacts_.renew(index, nearest, normal, contact_weights(body, contact.vertex, other, nearest, normal),
                  least_gap(contact.owner, contact.vertex, contact.other, nearest));
}

void SurfaceCollision::hash_tets() {
  boxes_.clear();
  tets_.clear();
  for (std::size_t b = 0; b < soft_.size(); ++b) {
    const SoftBody& body = *soft_[b];
    for (std::size_t t = 0; t < body.mesh->tets.size(); ++t) {
      Box box;
      for (const auto i : body.mesh->tets[t]) box.extend(body.positions.at(i));
      if (!may_meet(b, box)) continue;
      boxes_.push_back(box);
      tets_.emplace_back(static_cast<int>(b), static_cast<std::int32_t>(t));
    }
  }
  throw_if_scope_cancelled();
  tet_hash_.build(boxes_);
  throw_if_scope_cancelled();
}

double SurfaceCollision::depth_below_surface(int body, int owner, std::int32_t vertex) {
  const SoftBody& other = soft(body);
  const Vec3 p = soft(owner).positions.at(vertex);
  Box point;
  point.extend(p);
  for (double radius = reach * other.cell_size;; radius *= 2.0) {
    double nearest = radius;
    for (const auto t : triangle_hash_.find(grown(point, radius))) {
      const SurfaceTriangle& triangle = triangles_[t];
      if (triangle.body != body || !meets(triangle, owner, vertex)) continue;
      nearest =
          std::min(nearest, (p - closest_point(p, points_of(other.positions, triangle.corners))).norm());
    }
    if (nearest < radius || radius > surfaces_[body].swept.size().norm()) return nearest;
  }
}

SurfaceCollision::Penetration SurfaceCollision::deepest_penetration(const World& world) {
  look_at(world);
  hash_triangles(false);
  hash_tets();
  Penetration deepest;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const int owner = static_cast<int>(b);
    const SoftBody& body = soft(owner);
    if (!may_meet(b, surfaces_[b].swept)) continue;
    for (const auto vertex : body.surface_particles) {
      throw_if_scope_cancelled();
      const Vec3 p = body.positions.at(vertex);
      Box point;
      point.extend(p);
      for (const auto t : tet_hash_.find(point)) {
        const auto [inside, tet] = tets_[t];
        const Tet& corners = soft(inside).mesh->tets[tet];
        if (inside == owner && (!surfaces_[owner].meets_itself || has_corner(corners, vertex))) continue;
        const Coordinates& x = soft(inside).positions;
        if (!is_in_tet(p, x.at(corners[0]), x.at(corners[1]), x.at(corners[2]), x.at(corners[3]))) continue;
        const double depth = depth_below_surface(inside, owner, vertex);
        deepest.depth = std::max(deepest.depth, depth);
        deepest.cells = std::max(deepest.cells, depth / std::min(body.cell_size, soft(inside).cell_size));
      }
    }
  }
  return deepest;
}

std::int64_t SurfaceCollision::bytes() const {
  return contacts_.bytes() + triangle_hash_.bytes() + tet_hash_.bytes() +
         static_cast<std::int64_t>(boxes_.capacity() * sizeof(Box) +
                                   triangles_.capacity() * sizeof(SurfaceTriangle) +
                                   tets_.capacity() * sizeof(tets_[0]));
}

}  // namespace isochor

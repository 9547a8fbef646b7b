#include "core/rigid/impacts.h"

#include <algorithm>

#include "core/collision/contact_response.h"

namespace isochor {
namespace {

constexpr int max_meetings = 8;    // of a pair within a step
constexpr double together = 1e-4;  // of the reach: corners that land at the same time

/// Slower impacts would come again within the step; they are the step's own business.
double least_speed(const StepWorld& world) {
  return world.gravity.norm() * world.h;
}

double restitution_at(const StepWorld& world, BodyPair pair, double approach) {
  const BodyRecord &a = world.bodies[index(pair.first)], &b = world.bodies[index(pair.second)];
  return approach > least_speed(world) ? combined_restitution(a.restitution, b.restitution) : 0.0;
}

Vec3 material_velocity(const BodyRecord& body, const Vec3& point) {
  return body.velocity() + body.angular_velocity().cross(point - body.state.pose.position);
}

void apply_momenta(RigidBodyState& state, const Vec3& impulse, const Vec3& angular_impulse) {
  if (!state.dynamic()) return;
  state.velocity += state.inverse_mass * impulse;
  state.angular_momentum += angular_impulse;
}

/// The state at time t as if it were the step's start, and back.
void advance(BodyRecord& body, const Vec3& gravity, double t) {
  body.state.pose = BodyPath{body, gravity}.at(t);
  if (body.dynamic()) body.state.velocity += t * gravity;
}
void rewind(BodyRecord& body, const Pose& before, const Vec3& gravity, double t) {
  if (!body.dynamic()) {
    body.state.pose = before;
    return;
  }
  body.state.velocity -= t * gravity;
  body.state.pose.position -= t * body.state.velocity + 0.5 * t * t * gravity;
  body.state.pose.orientation = rotate_freely(body.state, -t);
}

}  // namespace

void append_contacts(BodyPair pair, std::span<const BodyRecord> bodies, const Manifold& manifold,
                     const Pose& pose_a, const Pose& pose_b, std::vector<RigidContact>& contacts) {
  const BodyRecord &a = bodies[index(pair.first)], &b = bodies[index(pair.second)];
  for (const ManifoldPoint& point : manifold.points()) {
    contacts.push_back(make_contact(pair.first, pair.second, point, pose_a, pose_b));
    contacts.back().friction = combined_friction(a.friction, b.friction);
    contacts.back().restitution = combined_restitution(a.restitution, b.restitution);
  }
}

void Impacts::look(const StepWorld& world, Meeting& meeting, double from) {
  const BodyPath a{world.bodies[index(meeting.pair.first)], world.gravity};
  const BodyPath b{world.bodies[index(meeting.pair.second)], world.gravity};
  meeting.time = 2.0 * world.h;
  if (meeting.met == max_meetings) return;
  const double apart =
      collide({*a.body.shape, a.at(from)}, {*b.body.shape, b.at(from)}, 0.0, impact_.manifold);
  if (apart > world.h * approach_bound(a, b, world.h)) return;
  if (find_impact(a, b, {from, world.h, least_speed(world)}, impact_)) meeting.time = impact_.time;
}

/// Makes b a member when a is one, or the other way round. True when that is news. Bodies without mass pass
/// no impulse on: they become members, but nothing spreads from them.
bool Impacts::join(const StepWorld& world, int a, int b) {
  const auto member = [&](int body) { return member_of_[index(body)] >= 0; };
  const auto spreads = [&](int body) { return member(body) && world.bodies[index(body)].dynamic(); };
  if (member(a) == member(b) || (!spreads(a) && !spreads(b))) return false;
  const int added = member(a) ? b : a;
  member_of_[index(added)] = static_cast<int>(members_.size());
  members_.push_back(added);
  return true;
}

void Impacts::gather(const StepWorld& world, BodyPair pair, std::span<const RigidContact> contacts) {
  member_of_.assign(world.bodies.size(), -1);
  members_.assign({pair.first, pair.second});
  member_of_[index(pair.first)] = 0;
  member_of_[index(pair.second)] = 1;
  for (bool grown = true; grown;) {
    grown = false;
    for (const RigidContact& contact : contacts) grown |= !contact.ahead && join(world, contact.a, contact.b);
    for (const RigidJoint& joint : world.joints) grown |= join(world, joint.a, joint.b);
  }
}

/// Rates of the rows from first_row on, whose bodies become the members' numbers.
void Impacts::add_rates(const StepWorld& world, std::size_t first_row) {
  for (std::size_t i = first_row; i < set_.rows.size(); ++i) {
    ConstraintRow& row = set_.rows[i];
    const BodyRecord &a = world.bodies[index(row.a)], &b = world.bodies[index(row.b)];
    row.residual = row.impulse_on.linear.dot(a.velocity() - b.velocity()) +
                   row.impulse_on.angular_a.dot(a.angular_velocity()) -
                   row.impulse_on.angular_b.dot(b.angular_velocity());
    row.a = member_of_[index(row.a)], row.b = member_of_[index(row.b)];
  }
}

void Impacts::add_meeting_rows(const StepWorld& world, BodyPair pair) {
  const BodyRecord &a = world.bodies[index(pair.first)], &b = world.bodies[index(pair.second)];
  const double limit = together * std::min(a.reach, b.reach);
  for (const ManifoldPoint& point : impact_.manifold.points()) {
    if (point.gap() >= limit) continue;
    const std::size_t first = set_.rows.size();
    RigidContact contact = make_contact(pair.first, pair.second, point, a.state.pose, b.state.pose);
    contact.friction = combined_friction(a.friction, b.friction);
    append_contact_rows(contact, a.state.pose, b.state.pose, set_);
    add_rates(world, first);
    const double approach = -set_.rows[first].residual;  // Newton's rule
    set_.rows[first].residual -= std::max(0.0, restitution_at(world, pair, approach) * approach);
  }
}

/// What the members touch and are jointed to.
void Impacts::add_lasting_rows(const StepWorld& world, std::span<const RigidContact> contacts) {
  const std::size_t first = set_.rows.size();
  const auto pose = [&](int body) -> const Pose& { return world.bodies[index(body)].state.pose; };
  const auto inside = [&](int a, int b) { return member_of_[index(a)] >= 0 && member_of_[index(b)] >= 0; };
  for (const RigidContact& contact : contacts)
    if (!contact.ahead && inside(contact.a, contact.b) &&
        contact_gap(contact, pose(contact.a), pose(contact.b)) <
            together * world.bodies[index(contact.a)].reach)
      append_contact_rows(contact, pose(contact.a), pose(contact.b), set_);
  for (const RigidJoint& joint : world.joints)
    if (inside(joint.a, joint.b)) append_joint_rows(joint, pose(joint.a), pose(joint.b), set_);
  add_rates(world, first);
}

/// Two bodies at one point by the closed formula; else all points and members at once.
void Impacts::push_apart(const StepWorld& world, BodyPair pair, std::span<const RigidContact> contacts) {
  set_.clear();
  add_meeting_rows(world, pair);
  add_lasting_rows(world, contacts);
  if (set_.rows.size() == 3) {
    BodyRecord &a = world.bodies[index(pair.first)], &b = world.bodies[index(pair.second)];
    const auto closest = std::min_element(impact_.manifold.points().begin(), impact_.manifold.points().end(),
                                          [](const auto& p, const auto& q) { return p.gap() < q.gap(); });
    const Vec3 point = closest->point(), relative = material_velocity(a, point) - material_velocity(b, point);
    const Eigen::Matrix3d k = inverse_mass_at(a.state, point) + inverse_mass_at(b.state, point);
    const double restitution = restitution_at(world, pair, -closest->normal.dot(relative));
    const Vec3 impulse =
        impact_impulse(relative, closest->normal, k, combined_friction(a.friction, b.friction), restitution);
    apply_impulse(a.state, point, impulse);
    apply_impulse(b.state, point, -impulse);
    return;
  }
  solver_bodies_.clear();
  for (const int body : members_) {
    const RigidBodyState& state = world.bodies[index(body)].state;
    solver_bodies_.push_back({state.inverse_mass, state.world_inverse_inertia()});
  }
  solver_.prepare(set_, solver_bodies_);
  solver_.solve(set_, solver_bodies_, 1e-9);
  for (std::size_t i = 0; i < members_.size(); ++i)
    apply_momenta(world.bodies[index(members_[i])].state, solver_bodies_[i].impulse,
                  solver_bodies_[i].angular_impulse);
}

void Impacts::resolve_one(const StepWorld& world, const Meeting& meeting,
                          std::vector<RigidContact>& contacts) {
  const auto [a, b] = meeting.pair;
  find_impact({world.bodies[index(a)], world.gravity}, {world.bodies[index(b)], world.gravity},
              {meeting.time, world.h, least_speed(world)}, impact_);
  gather(world, meeting.pair, contacts);
  member_poses_.clear();
  for (const int body : members_) {
    member_poses_.push_back(world.bodies[index(body)].state.pose);
    advance(world.bodies[index(body)], world.gravity, meeting.time);
  }
  push_apart(world, meeting.pair, contacts);
  for (std::size_t i = 0; i < members_.size(); ++i)
    rewind(world.bodies[index(members_[i])], member_poses_[i], world.gravity, meeting.time);
  std::erase_if(contacts, [&](const RigidContact& c) { return pair_of(c) == meeting.pair; });
  append_contacts(meeting.pair, world.bodies, impact_.manifold, impact_.pose_a, impact_.pose_b, contacts);
}

void Impacts::resolve(const StepWorld& world, std::span<const BodyPair> apart,
                      std::vector<RigidContact>& contacts) {
  meetings_.clear();
  for (const BodyPair& pair : apart) {
    meetings_.push_back({pair});
    look(world, meetings_.back(), 0.0);
  }
  const std::size_t most = 4 * world.bodies.size() + 16;
  for (std::size_t i = 0; i < most && !meetings_.empty(); ++i) {
    const auto first = std::min_element(meetings_.begin(), meetings_.end(),
                                        [](const auto& p, const auto& q) { return p.time < q.time; });
    if (first->time >= world.h) break;
    const double now = first->time;
    resolve_one(world, *first, contacts);
    ++first->met;
    const auto moved = [&](int body) {
      return member_of_[index(body)] >= 0 && world.bodies[index(body)].dynamic();
    };
    for (Meeting& other : meetings_)
      if (moved(other.pair.first) || moved(other.pair.second)) look(world, other, now);
  }
}

}  // namespace isochor

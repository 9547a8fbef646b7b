#include "core/rigid/step_contacts.h"

#include <algorithm>
#include <utility>

namespace isochor {
namespace {

constexpr double same_place = 0.05;  // of the reach: a contact that goes on
constexpr double shallow = 0.01;     // of the reach: what is less deep comes out as though it were that deep

bool by_pair(const RigidContact& p, const RigidContact& q) {
  return pair_of(p) < pair_of(q);
}

double smaller_reach(std::span<const BodyRecord> bodies, BodyPair pair) {
  return std::min(bodies[index(pair.first)].reach, bodies[index(pair.second)].reach);
}

/// How far any point of the body gets on its way to the pose.
double moved(const BodyRecord& body, const Pose& to) {
  const double turn = body.state.pose.orientation.angularDistance(to.orientation);
  return (to.position - body.state.pose.position).norm() + (turn > 0.0 ? turn * body.reach : 0.0);
}

}  // namespace

void StepContacts::begin(const StepWorld& world, std::span<const BodyPair> jointed) {
  std::swap(last_, contacts);
  contacts.clear();
  broad_phase_.find(world.bodies, jointed, world.gravity, world.h);
  find_touching(world);
  impacts_.resolve(world, apart_, contacts);
  find_ahead(world);
  std::sort(contacts.begin(), contacts.end(), by_pair);
  continue_from_last();
}

/// Of bodies that touch, all points that may do so by the step's end.
void StepContacts::find_touching(const StepWorld& world) {
  apart_.clear();
  for (const BodyPair& pair : broad_phase_.pairs()) {
    const BodyRecord &a = world.bodies[index(pair.first)], &b = world.bodies[index(pair.second)];
    const double reachable =
        world.h * approach_bound({a, world.gravity}, {b, world.gravity}, world.h) + world.slop;
    const double gap =
        collide({*a.shape, a.state.pose}, {*b.shape, b.state.pose}, reachable, impact_.manifold);
    if (gap <= world.slop)
      append_contacts(pair, world.bodies, impact_.manifold, a.state.pose, b.state.pose, contacts);
    else
      apart_.push_back(pair);
    if (gap >= -world.slop)
      std::erase(emerging_, pair);
    else if (!started_)
      emerging_.push_back(pair);
  }
  started_ = true;
  for (RigidContact& contact : contacts) let_emerge(world, contact);
}

void StepContacts::leave_within(BodyPair pair) {
  if (std::ranges::find(emerging_, pair) == emerging_.end()) emerging_.push_back(pair);
}

void StepContacts::let_emerge(const StepWorld& world, RigidContact& contact) const {
  if (std::ranges::find(emerging_, pair_of(contact)) == emerging_.end()) return;
  const double gap = contact_gap(contact, world.bodies[index(contact.a)].state.pose,
                                 world.bodies[index(contact.b)].state.pose);
  const double deep = std::max(-gap, shallow * smaller_reach(world.bodies, pair_of(contact)));
  contact.least_gap = std::min(0.0, gap + emerging_rate * world.h * deep);
}

/// Bodies that settle on each other too slowly for an impact: the points where they will.
void StepContacts::find_ahead(const StepWorld& world) {
  const std::size_t known = contacts.size();
  for (const BodyPair& pair : apart_) {
    const auto end = contacts.begin() + static_cast<std::ptrdiff_t>(known);
    if (std::any_of(contacts.begin(), end, [&](const auto& c) { return pair_of(c) == pair; })) continue;
    const BodyPath a{world.bodies[index(pair.first)], world.gravity},
        b{world.bodies[index(pair.second)], world.gravity};
    const PlacedShape shape_a{*a.body.shape, a.body.state.pose}, shape_b{*b.body.shape, b.body.state.pose};
    const double reachable = world.h * approach_bound(a, b, world.h);
    if (collide(shape_a, shape_b, 0.0, impact_.manifold) > reachable) continue;
    if (!find_impact(a, b, {0.0, world.h}, impact_)) continue;
    append_contacts(pair, world.bodies, impact_.manifold, impact_.pose_a, impact_.pose_b, contacts);
  }
  for (std::size_t i = known; i < contacts.size(); ++i) contacts[i].ahead = true;
}

void StepContacts::continue_from_last() {
  for (RigidContact& contact : contacts) {
    const auto [first, last] = std::equal_range(last_.begin(), last_.end(), contact, by_pair);
    const double reach = same_place * (contact.local_b.norm() + contact.local_a.norm());
    auto nearest = last;
    double least = reach * reach;
    for (auto old = first; old != last; ++old) {
      const double distance = std::min((old->local_b - contact.local_b).squaredNorm(),
                                       (old->local_a - contact.local_a).squaredNorm());
      if (distance < least) least = distance, nearest = old;
    }
    if (nearest == last) continue;
    contact.impulse = nearest->impulse;
    contact.approach = nearest->approach;
    nearest->impulse = Vec3::Zero();  // goes to one contact only
  }
}

void StepContacts::renew(const StepWorld& world, double closed) {
  std::swap(last_, contacts);
  contacts.clear();
  for (const BodyPair& pair : broad_phase_.pairs()) {
    const BodyRecord &a = world.bodies[index(pair.first)], &b = world.bodies[index(pair.second)];
    const double near = std::max(closed, 1e-3 * smaller_reach(world.bodies, pair));
    if (collide({*a.shape, a.state.pose}, {*b.shape, b.state.pose}, near, impact_.manifold) > near) continue;
    append_contacts(pair, world.bodies, impact_.manifold, a.state.pose, b.state.pose, contacts);
  }
  continue_from_last();
  std::erase_if(contacts, [&](const RigidContact& contact) {
    const Pose &a = world.bodies[index(contact.a)].state.pose, &b = world.bodies[index(contact.b)].state.pose;
    return contact.impulse.isZero(0.0) && contact_gap(contact, a, b) > closed;
  });
}

RigidContact* StepContacts::find_known(const RigidContact& contact, double near) {
  const auto [first, last] = std::equal_range(contacts.begin(), contacts.end(), contact, by_pair);
  const auto known = std::find_if(first, last, [&](const RigidContact& other) {
    return (other.local_a - contact.local_a).norm() < near || (other.local_b - contact.local_b).norm() < near;
  });
  return known == last ? nullptr : &*known;
}

/// Of edges that cross, bodies that turn change the normal.
bool StepContacts::follow(const StepWorld& world, const RigidContact& contact, std::span<const Pose> poses,
                          RigidContact& known) const {
  const Pose &a = poses[index(known.a)], &b = poses[index(known.b)];
  const double tolerated = 1e-6 * smaller_reach(world.bodies, pair_of(known));
  if (contact_gap(contact, a, b) - contact.least_gap > contact_gap(known, a, b) - known.least_gap - tolerated)
    return false;
  const RigidContact before = std::exchange(known, contact);
  known.ahead = before.ahead;
  known.approach = before.approach;
  known.impulse = before.impulse;
  return true;
}

bool StepContacts::complete(const StepWorld& world, std::span<const Pose> predicted) {
  bool changed = false;
  fresh_.clear();
  for (const BodyPair& pair : broad_phase_.pairs()) {
    const BodyRecord &a = world.bodies[index(pair.first)], &b = world.bodies[index(pair.second)];
    const Pose &pose_a = predicted[index(pair.first)], &pose_b = predicted[index(pair.second)];
    const double small = smaller_reach(world.bodies, pair), travel = moved(a, pose_a) + moved(b, pose_b);
    const auto start = collide({*a.shape, a.state.pose}, {*b.shape, b.state.pose}, 0.0, impact_.manifold);
    if (start > travel) continue;
    if (collide({*a.shape, pose_a}, {*b.shape, pose_b}, -1e-7 * small, impact_.manifold) > 0.0) continue;
    append_contacts(pair, world.bodies, impact_.manifold, pose_a, pose_b, fresh_);
  }
  std::size_t added = 0;
  for (RigidContact& contact : fresh_) {
    contact.ahead = true;
    let_emerge(world, contact);
    RigidContact* known = find_known(contact, 1e-2 * smaller_reach(world.bodies, pair_of(contact)));
    if (known)
      changed |= follow(world, contact, predicted, *known);
    else
      fresh_[added++] = contact;
  }
  if (!changed && added == 0) return false;
  contacts.insert(contacts.end(), fresh_.begin(), fresh_.begin() + static_cast<std::ptrdiff_t>(added));
  std::sort(contacts.begin(), contacts.end(), by_pair);
  return true;
}

}  // namespace isochor

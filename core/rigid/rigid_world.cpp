#include "core/rigid/rigid_world.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/common/error.h"
#include "core/rigid/body_record.h"
#include "core/rigid/step_solver.h"

namespace isochor {
namespace {

double reach_of(const CollisionShape& shape) {
  const Box box = shape.bounds();
  return box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs()).stableNorm();
}

void set_mass(BodyRecord& body, double mass) {
  if (!(std::isfinite(mass) && mass > 0.0))
    throw Error(ErrorCode::invalid_argument, fmt::format("a rigid body's mass is {} kg", mass),
                "give a mass above 0, or none for a body that stands still");
  if (body.shape->volume() <= 0.0)
    throw Error(ErrorCode::invalid_argument, "a plane has no volume, so it cannot have a mass",
                "leave the mass out: a plane stands still or follows a motion");
  body.mass = mass;
  body.inertia = mass * body.shape->unit_inertia();
  body.state.inverse_mass = 1.0 / mass;
  body.state.inertia = body.inertia;
  body.state.inverse_inertia = body.inertia.inverse();
}

/// Impulses since the last load have moved the body with it; the next one takes its share of what is owed.
void take_load(BodyRecord& body, double factor) {
  RigidBodyState& state = body.state;
  CarriedLoad& load = body.load;
  Vec3 turning = state.angular_momentum / load.factor;
  load.owed += (load.factor - 1.0) * body.mass * (state.velocity - load.velocity);
  load.owed_moment += (load.factor - 1.0) * (turning - load.angular_momentum);
  state.velocity += load.owed / (factor * body.mass);
  turning += load.owed_moment / factor;
  load.owed *= 1.0 - 1.0 / factor;
  load.owed_moment *= 1.0 - 1.0 / factor;
  load.factor = factor;
  load.velocity = state.velocity;
  load.angular_momentum = turning;
  state.angular_momentum = factor * turning;
  state.inverse_mass = 1.0 / (factor * body.mass);
  state.inertia = factor * body.inertia;
  state.inverse_inertia = state.inertia.inverse();
}

/// Velocities that lead a body without mass to where its motion has it at `time`.
void aim(BodyRecord& body, double time, double h) {
  body.target = body.motion ? pose_at(*body.motion, body.start, time) : body.state.pose;
  body.motion_velocity = (body.target.position - body.state.pose.position) / h;
  body.motion_spin = rotation_log(body.target.orientation * body.state.pose.orientation.conjugate()) / h;
}

}  // namespace

struct RigidWorld::Impl {
  std::vector<BodyRecord> bodies;
  Vec3 gravity = Vec3::Zero();
  double time = 0.0, h = 0.0;  ///< h: of the step under way, else 0
  bool moved = false;          ///< the poses are those of its end already
  StepSolver solver;
  std::vector<BodyRecord> saved;  ///< at the start of the step, to take it again

  BodyRecord& at(int body) { return bodies[static_cast<std::size_t>(body)]; }
  void kick(double seconds) {
    for (BodyRecord& body : bodies)
      if (body.dynamic()) body.state.velocity += seconds * gravity;
  }
};

RigidWorld::RigidWorld() : impl_(std::make_unique<Impl>()) {}
RigidWorld::~RigidWorld() = default;
RigidWorld::RigidWorld(RigidWorld&&) noexcept = default;
RigidWorld& RigidWorld::operator=(RigidWorld&&) noexcept = default;

int RigidWorld::add_body(const RigidBodyDesc& desc) {
  BodyRecord body;
  body.shape = desc.shape;
  body.friction = desc.friction;
  body.restitution = desc.restitution;
  body.reach = reach_of(*desc.shape);
  body.motion = desc.motion;
  body.state.pose = {desc.pose.position, desc.pose.orientation.normalized()};
  body.start = body.target = body.state.pose;
  if (desc.mass && !desc.motion) {
    set_mass(body, *desc.mass);
    body.state.velocity = desc.velocity;
    const Eigen::Quaterniond& q = body.state.pose.orientation;
    body.state.angular_momentum = q * (body.state.inertia * (q.conjugate() * desc.angular_velocity));
  }
  if (desc.motion) body.state.pose = pose_at(*desc.motion, body.start, impl_->time);
  impl_->bodies.push_back(std::move(body));
  return size() - 1;
}

void RigidWorld::set_gravity(const Vec3& gravity) {
  impl_->gravity = gravity;
}

void RigidWorld::add_joint(const JointDesc& desc) {
  for (const int body : {desc.a, desc.b})
    if (body < 0 || body >= size())
      throw Error(ErrorCode::invalid_argument, fmt::format("a joint names body {} of {}", body, size()),
                  "add the bodies before their joints");
  if (desc.a == desc.b || (!dynamic(desc.a) && !dynamic(desc.b)))
    throw Error(ErrorCode::invalid_argument, "a joint needs two bodies, one of them with a mass",
                "give one of the bodies a mass, or leave the joint out");
  if (desc.kind == JointKind::hinge && !(desc.axis.norm() > 0.0))
    throw Error(ErrorCode::invalid_argument, "a hinge's axis has no direction",
                "give an axis such as [0, 1, 0]");
  impl_->solver.add_joint(make_joint(desc, pose(desc.a), pose(desc.b)));
  impl_->at(desc.a).jointed = impl_->at(desc.b).jointed = true;
}

int RigidWorld::substeps_for(double h) const {
  const double rate = impl_->solver.fastest_rate(impl_->bodies);
  return static_cast<int>(std::clamp(std::ceil(h * rate), 1.0, 64.0));
}

/// A substep that could not be solved is taken again in halves: what joints hold is met by then in most
/// cases, while contacts of bodies that are in each other hardly ever are.
int RigidWorld::step(double h) {
  const double end = impl_->time + h;
  int halvings = 0, substeps = 0;
  while (impl_->time < end - 1e-9 * h) {
    const double left = end - impl_->time;
    keep_start();
    begin_step(std::min(left, std::max(left / substeps_for(left), h / 64.0) / (1 << halvings)));
    solve();
    if (!metrics().converged && halvings < (metrics().gave_up ? 1 : 5)) {
      restore_start();
      ++halvings;
      continue;
    }
    end_step();
    ++substeps;
  }
  impl_->time = end;
  return substeps;
}

void RigidWorld::keep_start() {
  impl_->saved = impl_->bodies;
}

void RigidWorld::restore_start() {
  impl_->bodies = impl_->saved;
  impl_->h = 0.0;
}

void RigidWorld::begin_step(double h) {
  impl_->h = h;
  impl_->moved = false;
  for (BodyRecord& body : impl_->bodies)
    if (!body.dynamic()) aim(body, impl_->time + h, h);
  impl_->solver.begin(impl_->bodies, impl_->gravity, h);
}

void RigidWorld::solve() {
  impl_->solver.solve_positions(impl_->bodies);
}

void RigidWorld::move() {
  for (BodyRecord& body : impl_->bodies) body.state.pose = body.predicted(impl_->h);
  impl_->moved = true;
}

void RigidWorld::end_step() {
  if (!impl_->moved) move();
  impl_->kick(0.5 * impl_->h);
  impl_->solver.solve_velocities(impl_->bodies);
  impl_->time += impl_->h;
  impl_->h = 0.0;
}

int RigidWorld::size() const {
  return static_cast<int>(impl_->bodies.size());
}
const CollisionShape& RigidWorld::shape(int body) const {
  return *impl_->at(body).shape;
}
double RigidWorld::friction(int body) const {
  return impl_->at(body).friction;
}
double RigidWorld::restitution(int body) const {
  return impl_->at(body).restitution;
}
bool RigidWorld::dynamic(int body) const {
  return impl_->at(body).dynamic();
}
bool RigidWorld::immobile(int body) const {
  return !dynamic(body) && !impl_->at(body).motion;
}
bool RigidWorld::jointed(int body) const {
  return impl_->at(body).jointed;
}
const RigidBodyState& RigidWorld::state(int body) const {
  return impl_->at(body).state;
}

Pose RigidWorld::predicted_pose(int body) const {
  return impl_->h > 0.0 && !impl_->moved ? impl_->at(body).predicted(impl_->h) : pose(body);
}

Vec3 RigidWorld::velocity_at(int body, const Vec3& point) const {
  const BodyRecord& b = impl_->at(body);
  return b.velocity() + b.angular_velocity().cross(point - b.state.pose.position);
}

Eigen::Matrix3d RigidWorld::inverse_mass_at(int body, const Vec3& point) const {
  return isochor::inverse_mass_at(state(body), point);
}

Eigen::Matrix<double, 6, 6> RigidWorld::compliance(int body) const {
  return impl_->solver.compliance(body);
}

void RigidWorld::list_pairs(std::vector<std::pair<int, int>>& pairs) const {
  impl_->solver.list_pairs(pairs);
}

void RigidWorld::apply_impulse(int body, const Vec3& point, const Vec3& impulse) {
  isochor::apply_impulse(impl_->at(body).state, point, impulse);
}

void RigidWorld::apply_wrench(int body, const Vec3& about, const Vec3& impulse, const Vec3& moment) {
  RigidBodyState& state = impl_->at(body).state;
  if (!state.dynamic()) return;
  state.velocity += state.inverse_mass * impulse;
  state.angular_momentum += moment + (about - state.pose.position).cross(impulse);
}

void RigidWorld::carry(int body, double mass) {
  BodyRecord& b = impl_->at(body);
  if (!b.dynamic() || (mass == 0.0 && b.load.factor == 1.0)) return;
  b.load.center = b.state.pose.position;
  take_load(b, 1.0 + mass / b.mass);
  impl_->solver.weigh(impl_->bodies);
}

void RigidWorld::put_down() {
  for (BodyRecord& b : impl_->bodies) {
    if (b.load.factor == 1.0) continue;
    const Vec3 before = b.state.velocity;
    take_load(b, 1.0);
    const Vec3 given = b.mass * (b.state.velocity - before);  // where its centre was, not where it is now
    b.state.angular_momentum += (b.load.center - b.state.pose.position).cross(given);
    b.load = {};
  }
}

void RigidWorld::move_body(int body, const Pose& pose, double duration) {
  BodyRecord& b = impl_->at(body);
  if (b.dynamic()) return;
  const double now = impl_->time;
  if (duration <= 0.0) b.state.pose = pose;
  b.motion = Motion{};
  b.motion->keyframes = {{now, b.state.pose.position, b.state.pose.orientation},
                         {now + duration, pose.position, pose.orientation}};
}

double RigidWorld::time() const {
  return impl_->time;
}

void RigidWorld::set_time(double seconds) {
  impl_->time = seconds;
  for (BodyRecord& body : impl_->bodies)
    if (body.motion) body.state.pose = pose_at(*body.motion, body.start, seconds);
}

void RigidWorld::set_state(int body, const RigidBodyState& state) {
  RigidBodyState& mine = impl_->at(body).state;
  if (!mine.dynamic()) return;
  mine.pose = state.pose;
  mine.velocity = state.velocity;
  const Eigen::Quaterniond& q = mine.pose.orientation;
  mine.angular_momentum = q * (mine.inertia * (q.conjugate() * state.angular_velocity()));
}

double RigidWorld::kinetic_energy() const {
  double sum = 0.0;
  for (const BodyRecord& body : impl_->bodies) sum += isochor::kinetic_energy(body.state);
  return sum;
}

double RigidWorld::gravity_energy() const {
  double sum = 0.0;
  for (const BodyRecord& body : impl_->bodies)
    if (body.dynamic()) sum -= impl_->gravity.dot(body.state.pose.position) / body.state.inverse_mass;
  return sum;
}

Vec3 RigidWorld::linear_momentum() const {
  Vec3 sum = Vec3::Zero();
  for (const BodyRecord& body : impl_->bodies)
    if (body.dynamic()) sum += body.state.velocity / body.state.inverse_mass;
  return sum;
}

Vec3 RigidWorld::angular_momentum() const {
  Vec3 sum = Vec3::Zero();
  for (const BodyRecord& body : impl_->bodies) {
    if (!body.dynamic()) continue;
    sum += body.state.angular_momentum;
    sum += body.state.pose.position.cross(body.state.velocity) / body.state.inverse_mass;
  }
  return sum;
}

const RigidMetrics& RigidWorld::metrics() const {
  return impl_->solver.metrics();
}
std::int64_t RigidWorld::bytes() const {
  auto bytes =
      static_cast<std::int64_t>((impl_->bodies.capacity() + impl_->saved.capacity()) * sizeof(BodyRecord));
  std::set<const CollisionShape*> shapes;  // bodies may share one
  for (const BodyRecord& body : impl_->bodies)
    if (shapes.insert(body.shape.get()).second) bytes += body.shape->bytes();
  return bytes;
}

}  // namespace isochor

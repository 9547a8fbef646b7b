#include "server/stream/simulation_runner.h"

#include <algorithm>
#include <future>
#include <utility>

#include "core/parallel/cancel_scope.h"
#include "server/job_queue/guarded.h"
#include "server/job_queue/lower_priority.h"
#include "server/job_queue/retry_allocation.h"
#include "server/problem.h"

namespace isochor {

std::string simulation_url(const std::string& id) {
  return "/api/v1/simulations/" + id;
}

std::string_view state_name(RunState state) {
  switch (state) {
    case RunState::preparing:
      return "preparing";
    case RunState::paused:
      return "paused";
    case RunState::playing:
      return "playing";
    case RunState::finished:
      return "finished";
    case RunState::failed:
      break;
  }
  return "failed";
}

SimulationRunner::SimulationRunner(Build build, const RunOptions& options, std::shared_ptr<FrameFeed> feed)
    : build_(std::move(build)), options_(options), feed_(std::move(feed)), want_play_(options.playing) {
  view_.id = options.id;
  view_.fast = options.fast;
  feed_->set_state(state_name(RunState::preparing));
  thread_ = std::thread([this] { run(); });
}

SimulationRunner::~SimulationRunner() {
  cancel();
  thread_.join();
}

void SimulationRunner::cancel() {
  feed_->end("deleted");
  {
    std::lock_guard lock(mutex_);
    cancelled_ = true;
  }
  wake_.notify_all();
}

void SimulationRunner::run() {
  lower_priority();
  Progress progress({}, &cancelled_);
  const CancelScope scope(progress);
  try {
    prepare(progress);
    run_frames(progress);
  } catch (const std::exception&) {
    retry_allocation([&] { fail(current_error()); });
  }
}

void SimulationRunner::fail(const Error& error) {
  if (error.code() == ErrorCode::cancelled) return;
  feed_->fail(encode_error(error));
  {
    std::lock_guard lock(mutex_);
    view_.failure = error;
    set_state(RunState::failed);
  }
  feed_->end("failed");
}

void SimulationRunner::prepare(Progress& progress) {
  simulation_.reset();  // not beside the new one in memory
  simulation_ = build_(progress);
  const auto facts = std::make_shared<const HelloFacts>(hello_facts(*simulation_));
  {
    std::lock_guard lock(mutex_);
    facts_ = facts;
    for (const auto& [name, change] : persistent_) changes_[name] = change;
  }
  refresh_view();
  feed_->set_hello([facts, id = options_.id](Encoding encoding, bool inline_topology) {
    return encode_hello(*facts, {encoding, id, inline_topology ? "" : simulation_url(id) + "/topology"});
  });
  feed_->post(simulation_->snapshot());
}

void SimulationRunner::run_frames(Progress& progress) {
  Clock::time_point due = Clock::now();
  std::unique_lock lock(mutex_);
  while (wait_for_turn(lock, due)) {
    const bool restarts = std::exchange(want_restart_, false);
    const bool steps = !restarts && (view_.pending_steps > 0 || plays());
    const auto changes = std::exchange(changes_, {});
    if (steps) due = next_due(due);
    lock.unlock();
    for (const auto& [name, change] : changes) change(*simulation_);
    if (!changes.empty()) refresh_view();
    if (restarts) {
      feed_->restart();
      prepare(progress);
    }
    if (steps) feed_->post(simulation_->step(progress));
    if (steps) refresh_view();
    lock.lock();
    if (steps && view_.pending_steps > 0) --view_.pending_steps;
    if (simulation_->finished()) view_.pending_steps = 0;
  }
}

bool SimulationRunner::plays() const {
  return want_play_ && !simulation_->finished();
}

bool SimulationRunner::runs_for_nobody() const {
  return !simulation_->scene().duration && feed_->left_alone(options_.patience) &&
         Clock::now() - last_request_ >= options_.patience;
}

/// Behind schedule, time is not made up for: a slow scene plays slowly, never in bursts.
SimulationRunner::Clock::time_point SimulationRunner::next_due(Clock::time_point due) const {
  const std::chrono::duration<double> period(1.0 / (view_.frame_rate * view_.speed));
  return std::max(due, Clock::now() - std::chrono::milliseconds(5)) +
         std::chrono::duration_cast<Clock::duration>(period);
}

/// False when the runner goes.
bool SimulationRunner::wait_for_turn(std::unique_lock<std::mutex>& lock, Clock::time_point due) {
  for (;;) {
    if (cancelled_) return false;
    if (want_play_ && runs_for_nobody()) want_play_ = false;
    if (want_restart_ || !changes_.empty() || view_.pending_steps > 0) return true;
    set_state(simulation_->finished() ? RunState::finished
              : want_play_            ? RunState::playing
                                      : RunState::paused);
    if (std::exchange(view_.taken, requests_) != requests_) feed_->notify();
    if (!plays())
      wake_.wait(lock);
    else if (view_.fast || Clock::now() >= due)
      return true;
    else
      wake_.wait_until(lock, due);
  }
}

void SimulationRunner::set_state(RunState state) {
  if (view_.state == state) return;
  view_.state = state;
  feed_->set_state(state_name(state));
}

void SimulationRunner::refresh_view() {
  auto plan = simulation_->plan();
  const Scene& scene = simulation_->scene();
  std::lock_guard lock(mutex_);
  view_.name = scene.name;
  view_.frame_rate = scene.frame_rate;
  view_.duration = scene.duration;
  view_.plan = std::move(plan);
  view_.gravity = scene.gravity;
  view_.solver = scene.solver;
}

RunView SimulationRunner::view() const {
  std::lock_guard lock(mutex_);
  return view_;
}

std::int64_t SimulationRunner::requests() const {
  std::lock_guard lock(mutex_);
  return requests_;
}

std::shared_ptr<const HelloFacts> SimulationRunner::facts() const {
  std::lock_guard lock(mutex_);
  return facts_;
}

template <class Edit>
void SimulationRunner::edit(const Edit& make) {
  {
    std::lock_guard lock(mutex_);
    make();
    ++requests_;
    last_request_ = Clock::now();
  }
  wake_.notify_all();
}

void SimulationRunner::play() {
  edit([&] { want_play_ = true; });
}

void SimulationRunner::pause() {
  edit([&] { want_play_ = false; });
}

void SimulationRunner::restart() {
  edit([&] { want_restart_ = true; });
}

void SimulationRunner::step(std::int64_t count) {
  edit([&] { view_.pending_steps += count; });
}

void SimulationRunner::set_pace(bool fast) {
  edit([&] { view_.fast = fast; });
}

void SimulationRunner::set_speed(double speed) {
  edit([&] { view_.speed = speed; });
}

void SimulationRunner::look(const std::function<void(const Simulation&)>& at, const Progress& progress) {
  // Nothing of a caller that no longer waits is touched.
  const auto wanted = std::make_shared<Guarded<const std::function<void(const Simulation&)>*>>(&at);
  const auto task =
      std::make_shared<std::packaged_task<void(const Simulation&)>>([wanted](const Simulation& simulation) {
        wanted->with([&](const auto* look) {
          if (look) (*look)(simulation);
        });
      });
  std::future<void> seen = task->get_future();
  change(
      "look", [task](Simulation& simulation) { (*task)(simulation); }, false);
  try {
    while (seen.wait_for(std::chrono::milliseconds(10)) == std::future_status::timeout) {
      progress.throw_if_cancelled();
      if (const RunView now = view(); now.failure) throw *now.failure;
    }
  } catch (...) {
    wanted->with([](auto& look) { look = nullptr; });
    throw;
  }
  seen.get();
}

void SimulationRunner::change(const std::string& name, Change change, bool persists) {
  edit([&] {
    if (persists) persistent_[name] = change;
    changes_[name] = std::move(change);
  });
}

}  // namespace isochor

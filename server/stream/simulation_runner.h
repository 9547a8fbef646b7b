#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/scene/simulation.h"
#include "server/stream/frame_feed.h"

namespace isochor {

enum class RunState { preparing, paused, playing, finished, failed };
std::string_view state_name(RunState state);
std::string simulation_url(const std::string& id);

/// What can be seen of a simulation from outside: a value.
struct RunView {
  std::string id, name;
  RunState state = RunState::preparing;
  bool fast = false;  ///< as fast as it goes, instead of real time × speed
  double speed = 1.0;
  std::int64_t pending_steps = 0;
  double frame_rate = 60.0;
  std::optional<double> duration;
  Vec3 gravity = Vec3::Zero();
  SolverOptions solver;
  std::vector<PlannedPhase> plan;
  std::optional<Error> failure;
  std::int64_t taken = 0;  ///< of the requests() made, those that have taken effect
};

struct RunOptions {
  std::string id;
  bool fast = false;
  bool playing = false;
  /// An endless run that was watched pauses when nobody has watched or asked for anything this long: it would
  /// keep a core busy until the server ends.
  std::chrono::milliseconds patience{30'000};
};

/// A simulation on a thread of its own, which posts frames to its feed. Everything here may be called from
/// any thread and returns at once; changes are taken before the next step.
class SimulationRunner {
 public:
  using Build = std::function<std::unique_ptr<Simulation>(Progress&)>;
  SimulationRunner(Build build, const RunOptions& options, std::shared_ptr<FrameFeed> feed);
  ~SimulationRunner();  ///< cancels, and waits for the thread
  SimulationRunner(const SimulationRunner&) = delete;
  SimulationRunner& operator=(const SimulationRunner&) = delete;

  RunView view() const;
  std::int64_t requests() const;  ///< made so far
  const std::shared_ptr<FrameFeed>& feed() const { return feed_; }
  std::shared_ptr<const HelloFacts> facts() const;  ///< null while preparing

  /// For good: its streams end, and the step under way stops.
  void cancel();
  void play();
  void pause();
  void restart();
  void step(std::int64_t count);
  void set_pace(bool fast);
  void set_speed(double speed);
  /// A change under its name: the latest of a name wins, and those that persist are made again after a
  /// restart.
  using Change = std::function<void(Simulation&)>;
  void change(const std::string& name, Change change, bool persists);
  /// Shows the simulation between two steps, and returns when that is done. Throws cancelled with the
  /// caller's progress, and what became of a run that failed.
  void look(const std::function<void(const Simulation&)>& at, const Progress& progress);

 private:
  using Clock = std::chrono::steady_clock;
  void run();
  void prepare(Progress& progress);
  void fail(const Error& error);
  void run_frames(Progress& progress);
  bool wait_for_turn(std::unique_lock<std::mutex>& lock, Clock::time_point due);
  bool plays() const;
  bool runs_for_nobody() const;
  Clock::time_point next_due(Clock::time_point due) const;
  void set_state(RunState state);
  void refresh_view();
  template <class Edit>
  void edit(const Edit& make);

  Build build_;
  RunOptions options_;
  std::shared_ptr<FrameFeed> feed_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  RunView view_;
  std::shared_ptr<const HelloFacts> facts_;
  std::map<std::string, Change> changes_, persistent_;
  bool want_play_ = false, want_restart_ = false;
  std::int64_t requests_ = 0;
  Clock::time_point last_request_;
  std::atomic<bool> cancelled_{false};
  std::unique_ptr<Simulation> simulation_;  ///< of the thread alone
  std::thread thread_;
};

}  // namespace isochor

#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/common/progress.h"
#include "server/job_queue/guarded.h"
#include "server/job_queue/numbered_id.h"
#include "server/job_queue/worker_pool.h"

namespace isochor {

enum class JobStatus { queued, running, done, failed, cancelled };
std::string_view status_name(JobStatus status);

/// What can be seen of a job: a value.
struct JobView {
  std::string id, kind;
  JobStatus status = JobStatus::queued;
  std::string phase;
  double fraction = 0.0;
  std::optional<double> eta_s;
  std::string result, problem;  ///< JSON texts, empty while there is none
  bool ended() const { return status != JobStatus::queued && status != JobStatus::running; }
};

/// What a job's work reports to: its progress, and on the way what it has of its result.
class JobProgress : public Progress {
 public:
  using Publish = std::function<void(std::string part)>;
  JobProgress(Sink sink, const std::atomic<bool>* cancel, Publish publish)
      : Progress(std::move(sink), cancel), publish_(std::move(publish)) {}
  void publish(std::string part) const { publish_(std::move(part)); }

 private:
  Publish publish_;
};

/// Measurements go one after another, in a line of their own: they would disturb each other's times, and they
/// are long, so that other work must not wait for them.
enum class Line { work, measurements };

/// Long work, in the order asked for. Its progress can be asked at any time, and it can be cancelled at any
/// time: then it has ended at once, while its work polls its Progress, stops and frees what it holds, which
/// of gigabytes takes a while, before its thread takes the next. Ended jobs are remembered, the oldest
/// forgotten.
class JobQueue {
 public:
  /// Returns the result as JSON text; its progress takes the fraction of the whole. Work that returns
  /// although it was cancelled leaves a part: the job is cancelled, and has a result.
  using Work = std::function<std::string(JobProgress&)>;

  /// on_end is called from a worker's thread after each job's end.
  JobQueue(int threads, std::function<void()> on_end);
  ~JobQueue();  ///< cancels all

  /// Throws a RefusalException (503) when too many wait.
  JobView submit(std::string kind, Work work, Line line = Line::work);
  JobView add_done(std::string kind, std::string result);  ///< when the result is there already
  /// nullopt: unknown, or forgotten (an id below next_id).
  std::optional<JobView> find(const std::string& id) const;
  bool under_way(const std::string& id) const;  ///< known, and not ended
  std::int64_t next_id() const;
  std::vector<JobView> all() const;  ///< by age
  bool cancel(const std::string& id);

 private:
  using Clock = std::chrono::steady_clock;
  struct Job {
    JobView view;
    Work work;
    Clock::time_point started;
    std::atomic<bool> cancelled{false};
  };
  struct Table {
    std::map<std::string, std::shared_ptr<Job>, ByAge> jobs;
    std::deque<std::string> ended;
    std::int64_t next = 1;
  };

  std::shared_ptr<Job> add(std::string kind, JobStatus status);
  void run(Job& job);
  Work begin(Job& job);
  void end(Job& job, JobStatus status, std::string result, std::string problem);
  static void forget_oldest(Table& table);

  std::function<void()> on_end_;
  Guarded<Table> table_;
  WorkerPool pool_, measurements_;  ///< last: their threads use the rest
};

}  // namespace isochor

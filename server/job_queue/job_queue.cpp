#include "server/job_queue/job_queue.h"

#include <algorithm>
#include <utility>

#include "server/job_queue/retry_allocation.h"
#include "server/memory_reserve.h"
#include "server/messages/problem_messages.h"
#include "server/problem.h"

namespace isochor {
namespace {

constexpr std::size_t max_waiting = 64, max_remembered = 256;

std::string cancelled_problem() {
  return encode_problem(Error(ErrorCode::cancelled, "cancelled"));
}

JobView visible(const JobView& view, std::chrono::steady_clock::time_point started) {
  JobView copy = view;
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - started;
  // A fraction too small to extrapolate from gives no estimate.
  if (view.status == JobStatus::running && view.fraction > 0.02)
    copy.eta_s = elapsed.count() * (1.0 - view.fraction) / view.fraction;
  return copy;
}

}  // namespace

std::string_view status_name(JobStatus status) {
  switch (status) {
    case JobStatus::queued:
      return "queued";
    case JobStatus::running:
      return "running";
    case JobStatus::done:
      return "done";
    case JobStatus::failed:
      return "failed";
    case JobStatus::cancelled:
      break;
  }
  return "cancelled";
}

JobQueue::JobQueue(int threads, std::function<void()> on_end)
    : on_end_(std::move(on_end)), pool_(threads, max_waiting), measurements_(1, max_waiting) {}

JobQueue::~JobQueue() {
  table_.with([](Table& table) {
    for (auto& [id, job] : table.jobs) job->cancelled = true;
  });
}

std::shared_ptr<JobQueue::Job> JobQueue::add(std::string kind, JobStatus status) {
  auto job = std::make_shared<Job>();
  job->view.kind = std::move(kind);
  job->view.status = status;
  table_.with([&](Table& table) {
    job->view.id = "j" + std::to_string(table.next++);
    table.jobs[job->view.id] = job;
  });
  return job;
}

JobView JobQueue::submit(std::string kind, Work work, Line line) {
  const auto job = add(std::move(kind), JobStatus::queued);
  job->work = std::move(work);
  JobView view = job->view;  // before a worker may change it
  if (!(line == Line::work ? pool_ : measurements_).submit([this, job] {
        run(*job);
        return_free_memory();
      })) {
    table_.with([&](Table& table) { table.jobs.erase(view.id); });
    throw RefusalException{{503, "busy", "too many jobs are waiting", "wait for one to end, or cancel some"}};
  }
  return view;
}

JobView JobQueue::add_done(std::string kind, std::string result) {
  const auto job = add(std::move(kind), JobStatus::running);
  end(*job, JobStatus::done, std::move(result), {});
  return *find(job->view.id);
}

/// The work, empty when the job was cancelled while it waited.
JobQueue::Work JobQueue::begin(Job& job) {
  return table_.with([&](Table&) -> Work {
    Work work = std::exchange(job.work, nullptr);
    if (job.view.ended()) return {};
    job.view.status = JobStatus::running;
    job.started = Clock::now();
    return work;
  });
}

void JobQueue::run(Job& job) {
  const Work work = begin(job);
  if (!work) return;
  JobProgress progress(
      [&](std::string_view phase, double fraction) {
        table_.with([&](Table&) {
          job.view.phase = phase;
          job.view.fraction = std::clamp(fraction, 0.0, 1.0);
        });
      },
      &job.cancelled,
      [&](std::string part) { table_.with([&](Table&) { job.view.result = std::move(part); }); });
  try {
    std::string result = work(progress);
    if (job.cancelled)
      end(job, JobStatus::cancelled, std::move(result), cancelled_problem());
    else
      end(job, JobStatus::done, std::move(result), {});
  } catch (const std::exception&) {
    JobStatus status = JobStatus::failed;
    std::string problem;
    retry_allocation([&] {
      const Error error = current_error();
      if (error.code() == ErrorCode::cancelled) status = JobStatus::cancelled;
      problem = encode_problem(error);
    });
    end(job, status, {}, std::move(problem));
  }
}

void JobQueue::end(Job& job, JobStatus status, std::string result, std::string problem) {
  table_.with([&](Table& table) {
    if (!result.empty() || status == JobStatus::failed) job.view.result = std::move(result);
    if (job.view.ended()) return;
    retry_allocation([&] { table.ended.push_back(job.view.id); });
    job.view.status = status;
    if (status == JobStatus::done) job.view.fraction = 1.0;
    job.view.problem = std::move(problem);
    forget_oldest(table);
  });
  on_end_();
}

void JobQueue::forget_oldest(Table& table) {
  while (table.ended.size() > max_remembered) {
    table.jobs.erase(table.ended.front());
    table.ended.pop_front();
  }
}

std::optional<JobView> JobQueue::find(const std::string& id) const {
  return table_.with([&](const Table& table) -> std::optional<JobView> {
    const auto found = table.jobs.find(id);
    if (found == table.jobs.end()) return std::nullopt;
    return visible(found->second->view, found->second->started);
  });
}

bool JobQueue::under_way(const std::string& id) const {
  return table_.with([&](const Table& table) {
    const auto found = table.jobs.find(id);
    return found != table.jobs.end() && !found->second->view.ended();
  });
}

std::int64_t JobQueue::next_id() const {
  return table_.with([](const Table& table) { return table.next; });
}

std::vector<JobView> JobQueue::all() const {
  return table_.with([](const Table& table) {
    std::vector<JobView> views;
    for (const auto& [id, job] : table.jobs) views.push_back(visible(job->view, job->started));
    return views;
  });
}

bool JobQueue::cancel(const std::string& id) {
  const auto job = table_.with([&](const Table& table) {
    const auto found = table.jobs.find(id);
    return found == table.jobs.end() ? nullptr : found->second;
  });
  if (!job) return false;
  job->cancelled = true;
  end(*job, JobStatus::cancelled, {}, cancelled_problem());
  return true;
}

}  // namespace isochor

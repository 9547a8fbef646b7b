#include "server/http/api.h"
#include "server/http/query.h"
#include "server/http/service.h"
#include "server/messages/api_messages.h"

namespace isochor {
namespace {

JobView find_job(const Api& api, const std::string& id) {
  if (auto job = api.jobs.find(id)) return std::move(*job);
  throw Missing{"job", id, id.starts_with('j') && was_issued(id, api.jobs.next_id())};
}

Response job_document(const JobView& job, int status, const std::string& drawing = {}) {
  std::string text = to_text(job_json(job));
  if (!drawing.empty()) text.back() = ',', text += "\"drawing\":" + drawing + '}';
  Response response = Response::json(std::move(text), status);
  response.headers.emplace_back("Location", std::string(api_base) + "/jobs/" + job.id);
  return response;
}

Response get_job(Api& api, const Request& request) {
  const std::string& id = request.segment("id");
  find_job(api, id);
  return job_response(api, id, query_integer(request, "wait_ms", 0, 0, 10000), 200);
}

Response cancel_job(Api& api, const Request& request) {
  const std::string& id = request.segment("id");
  find_job(api, id);
  api.jobs.cancel(id);
  return job_document(find_job(api, id), 200);
}

Response list_jobs(const Api& api) {
  Json jobs = Json::array();
  for (const JobView& job : api.jobs.all()) jobs.push_back(job_json(job));
  return Response::json(to_text({{"jobs", jobs}}));
}

}  // namespace

Response job_response(Api& api, const std::string& id, std::int64_t wait_ms, int unfinished_status,
                      const std::shared_ptr<const std::string>& beside) {
  const auto poll = [&api, id, unfinished_status, beside](bool deadline_passed) -> std::optional<Response> {
    // Asked at each wake, by all who wait: nothing is copied until then.
    if (!deadline_passed && api.jobs.under_way(id)) return std::nullopt;
    const JobView job = find_job(api, id);
    const bool written = beside && job.status == JobStatus::done;
    return job_document(job, job.ended() ? 200 : unfinished_status, written ? *beside : "");
  };
  Response response;
  response.pending = std::make_shared<PendingAnswer>(
      PendingAnswer{poll, std::chrono::steady_clock::now() + std::chrono::milliseconds(wait_ms)});
  return response;
}

std::vector<Route> job_routes(Api& api) {
  const auto to = [&](auto handler) { return [&api, handler](const Request& r) { return handler(api, r); }; };
  return {
      {.method = "GET",
       .pattern = "/api/v1/jobs",
       .operation = "listJobs",
       .summary = "All jobs, the recently ended ones included",
       .handler = [&](const Request&) { return list_jobs(api); },
       .answers = {{200, "JobList"}}},
      {.method = "GET",
       .pattern = "/api/v1/jobs/{id}",
       .operation = "getJob",
       .summary = "Progress, result or problem of a job",
       .handler = to(get_job),
       .answers = {{200, "Job"}},
       .query = {{"wait_ms", R"({"type":"integer","minimum":0,"maximum":10000})",
                  "Answer once it has ended, or after this time"}}},
      {.method = "DELETE",
       .pattern = "/api/v1/jobs/{id}",
       .operation = "cancelJob",
       .summary = "Cancel a job",
       .handler = to(cancel_job),
       .answers = {{200, "Job"}}},
  };
}

}  // namespace isochor

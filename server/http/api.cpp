#include "server/http/api.h"

#include "server/messages/openapi.h"
#include "server/store/content_id.h"

namespace isochor {
namespace {

/// Meshing runs in parallel by itself; a second so that a long one does not hold up a short one.
constexpr int job_threads = 2;
/// Of the memory for models and simulations, what the frames of one simulation may take.
constexpr std::int64_t frame_share = 16;

Response page(const SharedBytes& html) {
  Response response;
  response.content_type = "text/html; charset=utf-8";
  response.body = html;
  return response;
}

/// The table describes itself, these two rows included.
void add_description(std::vector<Route>& routes) {
  const auto document = std::make_shared<SharedBytes>(), html = std::make_shared<SharedBytes>();
  routes.push_back({.method = "GET",
                    .pattern = "/api/v1/openapi.json",
                    .operation = "getOpenApi",
                    .summary = "This description for machines",
                    .handler =
                        [document](const Request&) {
                          Response response;
                          response.body = *document;
                          return response;
                        },
                    .answers = {{200, "OpenApi"}},
                    .open = true});
  routes.push_back({.method = "GET",
                    .pattern = "/api/v1/docs",
                    .operation = "getDocs",
                    .summary = "This description for readers",
                    .handler = [html](const Request&) { return page(*html); },
                    .answers = {{200, "", "text/html; charset=utf-8"}},
                    .open = true});
  *document = std::make_shared<const std::string>(encode_openapi(routes));
  *html = std::make_shared<const std::string>(encode_api_page(routes));
}

}  // namespace

Api::Api(Samples samples_, std::shared_ptr<Waker> waker_, std::int64_t memory_limit_)
    : samples(std::move(samples_)),
      waker(std::move(waker_)),
      memory_limit(memory_limit_),
      catalog(memory_limit_),
      simulations(waker, memory_limit_, memory_limit_ / frame_share),
      jobs(job_threads, [wake = waker] { wake->wake(); }) {}

Response shared_answer(Api& api, const std::string& key, const std::string& etag,
                       const std::function<void(const TextSink&)>& encode) {
  const auto answer = api.texts.get(key, [&] {
    TaggedAnswer made{etag, LargeAnswer(api.disposal)};
    ContentHash hash;
    encode([&](std::string_view piece) {
      if (etag.empty()) hash.add(piece);
      made.content.append(piece);
    });
    if (etag.empty()) made.etag = hash.id("t");
    return made;
  });
  Response response = answer->content.respond(answer);
  response.headers.emplace_back("ETag", '"' + answer->etag + '"');
  return response;
}

std::vector<Route> api_routes(Api& api) {
  std::vector<Route> routes;
  for (auto& more : {meta_routes(api), sample_routes(api), mesh_routes(api), model_routes(api),
                     job_routes(api), simulation_routes(api), frame_routes(api), report_routes(api)})
    routes.insert(routes.end(), more.begin(), more.end());
  add_description(routes);
  return routes;
}

}  // namespace isochor

#include "server/build_info.h"
#include "server/http/api.h"
#include "server/messages/model_messages.h"

namespace isochor {

std::vector<Route> meta_routes(Api&) {
  const auto text = [](const auto& make) {
    return [make](const Request&) { return Response::json(to_text(make())); };
  };
  return {
      {.method = "GET",
       .pattern = "/api/v1/health",
       .operation = "getHealth",
       .summary = "Answers while the server lives",
       .handler = text([] {
         return Json{{"status", "ok"}};
       }),
       .answers = {{200, "Health"}},
       .immediate = true,
       .open = true},
      {.method = "GET",
       .pattern = "/api/v1/version",
       .operation = "getVersion",
       .summary = "Name, version and commit of the program",
       .handler = text([] {
         return Json{{"name", "isochor"}, {"version", build_info().version}, {"commit", build_info().commit}};
       }),
       .answers = {{200, "Version"}},
       .open = true},
      {.method = "GET",
       .pattern = "/api/v1/parameters",
       .operation = "getParameters",
       .summary = "JSON Schema of the meshing parameters",
       .handler = text([] { return parameters_schema(); }),
       .answers = {{200, "Parameters"}}},
      {.method = "GET",
       .pattern = "/api/v1/formats",
       .operation = "getFormats",
       .summary = "The export formats",
       .handler = text([] {
         return Json{{"formats", export_formats_json()}};
       }),
       .answers = {{200, "Formats"}}},
  };
}

}  // namespace isochor

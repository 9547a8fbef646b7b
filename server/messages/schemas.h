#pragma once
#include <string_view>

namespace isochor {

/// JSON Schemas (2020-12) of everything that the API takes and answers, by name: OpenAPI's components.
std::string_view api_schemas();

}  // namespace isochor

#pragma once
#include <cstdint>
#include <map>

#include "core/pipeline/pipeline.h"

namespace isochor {

/// Bytes by object, so that stages which models share count once.
using MemoryParts = std::map<const void*, std::int64_t>;
void add_parts(MemoryParts& parts, const TriangleSoup* soup);
void add_parts(MemoryParts& parts, const Model& model);
std::int64_t sum(const MemoryParts& parts);

}  // namespace isochor

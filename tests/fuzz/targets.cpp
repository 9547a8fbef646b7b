#include "tests/fuzz/targets.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/common/error.h"
#include "core/mesh_input/inspect.h"
#include "core/mesh_input/read_mesh.h"
#include "core/scene/read_scene.h"

namespace isochor {
namespace {

/// Of larger soups nearly all time would go into pairs of triangles, and hardly any into reading.
constexpr std::size_t most_inspected = 50;

void check_soup(const TriangleSoup& soup) {
  if (soup.triangles.empty()) fuzz_finding("no triangle, and no error");
  for (const Vec3& p : soup.positions)
    if (!p.allFinite()) fuzz_finding("a coordinate is not finite");
  const auto count = static_cast<std::int32_t>(soup.positions.size());
  for (const Triangle& t : soup.triangles)
    for (std::int32_t corner : t)
      if (corner < 0 || corner >= count) fuzz_finding("an index is out of range");
  if (soup.triangles.size() > most_inspected) return;
  const MeshReport report = inspect(soup);
  if (!(report.area >= 0.0)) fuzz_finding("the area is not a number");
}

void read(std::string_view reader, std::span<const char> bytes) {
  if (reader == "http") {
    fuzz_http(std::string_view(bytes.data(), bytes.size()));
  } else if (reader == "scene") {
    read_scene(std::string_view(bytes.data(), bytes.size()), std::filesystem::path("/nonexistent"));
  } else if (reader == "params") {
    read_meshing_options(std::string_view(bytes.data(), bytes.size()));
  } else {
    Progress progress;
    check_soup(read_mesh(bytes, mesh_format("x." + std::string(reader)), progress));
  }
}

}  // namespace

void fuzz_finding(const std::string& what) {
  std::fprintf(stderr, "finding: %s\n", what.c_str());
  std::abort();
}

void fuzz_reader(std::string_view reader, std::span<const char> bytes) {
  try {
    read(reader, bytes);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::internal) fuzz_finding(error.what());
  }
}

}  // namespace isochor

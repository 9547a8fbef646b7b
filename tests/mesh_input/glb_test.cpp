#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/common/error.h"
#include "core/mesh_input/inspect.h"
#include "core/mesh_input/read_mesh.h"

namespace isochor {
namespace {

using testing::HasSubstr;

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string glb(std::string json, std::string binary) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  std::string bytes = "glTF";
  append<std::uint32_t>(bytes, 2);
  append<std::uint32_t>(bytes, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + binary.size()));
  append<std::uint32_t>(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  append<std::uint32_t>(bytes, static_cast<std::uint32_t>(binary.size()));
  bytes += std::string("BIN\0", 4) + binary;
  return bytes;
}

/// A tetrahedron, volume 1/6: positions first, then its indices as 16-bit numbers.
std::string tet_binary() {
  std::string binary;
  for (float x : {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}) append(binary, x);
  for (std::uint16_t i : {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}) append(binary, i);
  return binary;
}

std::string tet_json(const std::string& nodes, const std::string& extra = "") {
  return R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":72}],"bufferViews":[)"
         R"({"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24}],"accessors":[)"
         R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},)"
         R"({"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}],)"
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"nodes":)" +
         nodes + extra + "}";
}

TriangleSoup read(const std::string& bytes) {
  Progress progress;
  return read_mesh(bytes, MeshFormat::glb, progress);
}

Error failure(const std::string& bytes) {
  try {
    read(bytes);
  } catch (const Error& error) {
    return error;
  }
  return {ErrorCode::internal, "nothing was thrown"};
}

TEST(Glb, ABufferOfNoBytesIsAnError) {
  const Error error = failure(glb(R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":0}]})", "1234"));
  EXPECT_EQ(error.code(), ErrorCode::cannot_read);
  EXPECT_THAT(error.what(), HasSubstr("the glTF content cannot be read"));
}

/// As gzip bombs are to bytes: a mesh of 20,000 vertices, placed 5,000 times.
TEST(Glb, ASmallFileThatPlacesAMeshTooOftenIsRefused) {
  constexpr int vertices = 20000;
  std::string nodes = "[{}", binary(vertices * 12, '\0');
  for (int i = 0; i < 5000; ++i) nodes += R"(,{"mesh":0})";
  const std::string count = std::to_string(vertices), bytes = std::to_string(binary.size());
  const std::string json = R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":)" + bytes +
                           R"(}],"bufferViews":[{"buffer":0,"byteLength":)" + bytes +
                           R"(}],"accessors":[{"bufferView":0,"componentType":5126,"count":)" + count +
                           R"(,"type":"VEC3"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)" +
                           R"("nodes":)" + nodes + "]}";
  const Error error = failure(glb(json, binary));
  EXPECT_EQ(error.code(), ErrorCode::over_budget);
  EXPECT_THAT(error.what(), HasSubstr("more than 20000000 triangles or vertices"));
}

TEST(Glb, PlacesMeshesByTheirNodes) {
  const std::string nodes =
      R"([{"mesh":0,"scale":[-2,1,1]},{"children":[2],"translation":[10,0,0]},)"
      R"({"mesh":0,"rotation":[0,0,0.70710678118654757,0.70710678118654757],"translation":[0,5,0]}])";
  const TriangleSoup soup = read(glb(tet_json(nodes), tet_binary()));
  const MeshReport report = inspect(soup);
  EXPECT_EQ(report.triangles, 8);
  EXPECT_EQ(report.components, 2);
  EXPECT_TRUE(report.closed);
  // The mirrored one is turned right side out again.
  EXPECT_NEAR(report.volume, 2.0 / 6.0 + 1.0 / 6.0, 1e-12);
  // (1,0,0) turned by 90° about z is (0,1,0), then moved by (10,5,0).
  EXPECT_TRUE(soup.positions[5].isApprox(Vec3(10, 6, 0), 1e-12)) << soup.positions[5].transpose();
}

TEST(Glb, ReadsTheSceneThatIsShown) {
  const std::string nodes = R"([{"mesh":0},{"mesh":0,"translation":[9,0,0]},{"mesh":0}])";
  const std::string scenes = R"(,"scenes":[{"nodes":[0,2]},{"nodes":[1]}])";
  EXPECT_EQ(read(glb(tet_json(nodes), tet_binary())).triangles.size(), 12U);
  EXPECT_EQ(read(glb(tet_json(nodes, scenes), tet_binary())).triangles.size(), 8U);
  const TriangleSoup second = read(glb(tet_json(nodes, scenes + R"(,"scene":1)"), tet_binary()));
  EXPECT_EQ(second.triangles.size(), 4U);
  EXPECT_EQ(second.positions[0], Vec3(9, 0, 0));
  EXPECT_THAT(failure(glb(tet_json(nodes, scenes + R"(,"scene":2)"), tet_binary())).what(),
              HasSubstr("scene 2"));
}

/// Their accessors have no data, which must not be what is said of them.
TEST(Glb, NamesTheCompressionOfAMesh) {
  for (const std::string extension : {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}) {
    std::string json = tet_json(R"([{"mesh":0}])", ",\"extensionsRequired\":[\"" + extension + "\"]");
    for (const std::string view : {R"("bufferView":0,)", R"("bufferView":1,)"})
      json.erase(json.find(view, json.find("accessors")), view.size());
    const Error error = failure(glb(json, tet_binary()));
    EXPECT_THAT(error.what(), HasSubstr(extension));
    EXPECT_EQ(error.hint(), "export the file without compression");
  }
}

TEST(Glb, RefusesWhatIsNotThere) {
  const std::string nodes = R"([{"mesh":0}])", good = glb(tet_json(nodes), tet_binary());
  EXPECT_EQ(read(good).triangles.size(), 4U);
  for (std::size_t length = 0; length < good.size(); ++length)
    EXPECT_EQ(failure(good.substr(0, length)).code(), ErrorCode::cannot_read) << length;
  EXPECT_THAT(failure(glb(tet_json(R"([{"mesh":7}])"), tet_binary())).what(), HasSubstr("mesh 7"));
  EXPECT_THAT(failure(glb(tet_json(R"([{"mesh":0,"children":[0]}])"), tet_binary())).what(),
              HasSubstr("node 0"));
  EXPECT_EQ(failure(glb(tet_json("[]"), tet_binary())).code(), ErrorCode::empty_result);
  std::string binary = tet_binary();
  binary[48] = 4;  // the first index
  EXPECT_THAT(failure(glb(tet_json(nodes), binary)).what(), HasSubstr("vertex index 4"));
  binary = tet_binary();
  binary.replace(0, 4, "\xff\xff\xff\x7f");
  EXPECT_THAT(failure(glb(tet_json(nodes), binary)).what(), HasSubstr("node 0, vertex 0"));
  const std::string draco = R"(,"extensionsRequired":["KHR_draco_mesh_compression"])";
  EXPECT_THAT(failure(glb(tet_json(nodes, draco), tet_binary())).what(),
              HasSubstr("KHR_draco_mesh_compression"));
  const std::string instancing = R"(,"extensionsRequired":["EXT_mesh_gpu_instancing"])";
  EXPECT_EQ(failure(glb(tet_json(nodes, instancing), tet_binary())).hint(), "export the file without it");
}

TEST(Glb, RefusesCountsBeyondTheBufferAndDeepJson) {
  std::string json = tet_json(R"([{"mesh":0}])");
  json.replace(json.find("\"count\":4"), 9, "\"count\":4000000000");
  EXPECT_THAT(failure(glb(json, tet_binary())).what(), HasSubstr("beyond its buffer"));
  const std::string deep = std::string(100000, '[') + std::string(100000, ']');
  EXPECT_THAT(failure(glb(tet_json(R"([{"mesh":0}])", ",\"extras\":" + deep), tet_binary())).what(),
              HasSubstr("nested"));
}

TEST(Glb, OpensNoOtherFile) {
  std::string json = tet_json(R"([{"mesh":0}])");
  json.replace(json.find("{\"byteLength\":72}"), 17, R"({"byteLength":72,"uri":"/etc/hostname"})");
  EXPECT_EQ(failure(glb(json, tet_binary())).code(), ErrorCode::cannot_read);
}

}  // namespace
}  // namespace isochor

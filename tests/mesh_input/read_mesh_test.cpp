#include "core/mesh_input/read_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

#include "core/common/error.h"
#include "core/mesh_input/inspect.h"

namespace isochor {
namespace {

TriangleSoup read(const std::string& text, MeshFormat format) {
  Progress progress;
  return read_mesh(text, format, progress);
}

void append_float(std::string& bytes, float value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// A tetrahedron with corners at the origin and the unit points, outward, in each format.
const char* const tet_obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

std::string tet_stl_binary() {
  const TriangleSoup tet = read(tet_obj, MeshFormat::obj);
  std::string bytes = "solid that is not text";
  bytes.resize(80, ' ');
  const std::uint32_t count = 4;
  bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
  for (const Triangle& triangle : tet.triangles) {
    for (int i = 0; i < 3; ++i) append_float(bytes, 0.0F);
    for (std::int32_t corner : triangle)
      for (int axis = 0; axis < 3; ++axis)
        append_float(bytes, static_cast<float>(tet.positions[corner][axis]));
    bytes.append(2, '\0');
  }
  return bytes;
}

std::string tet_ply_binary(bool big_endian) {
  std::string bytes =
      big_endian ? "ply\nformat binary_big_endian 1.0\n" : "ply\nformat binary_little_endian 1.0\n";
  bytes +=
      "comment a vertex carries a colour, a face a flag\nelement vertex 4\nproperty float x\nproperty float "
      "y\n"
      "property uchar red\nproperty double z\nelement face 4\nproperty list uchar ushort vertex_index\n"
      "property char flag\nend_header\n";
  const auto put = [&](auto value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    if (big_endian) std::reverse(raw, raw + sizeof value);
    bytes.append(raw, sizeof value);
  };
  const TriangleSoup tet = read(tet_obj, MeshFormat::obj);
  for (const Vec3& p : tet.positions) {
    put(static_cast<float>(p.x())), put(static_cast<float>(p.y()));
    put(std::uint8_t{255}), put(p.z());
  }
  for (const Triangle& triangle : tet.triangles) {
    put(std::uint8_t{3});
    for (std::int32_t corner : triangle) put(static_cast<std::uint16_t>(corner));
    put(std::int8_t{-1});
  }
  return bytes;
}

void expect_tet(const TriangleSoup& soup) {
  const MeshReport report = inspect(soup);
  EXPECT_EQ(report.vertices, 4);
  EXPECT_EQ(report.triangles, 4);
  EXPECT_TRUE(report.closed);
  EXPECT_DOUBLE_EQ(report.volume, 1.0 / 6.0);
}

TEST(ReadMesh, ReadsATetrahedronInEveryFormat) {
  expect_tet(read(tet_obj, MeshFormat::obj));
  expect_tet(
      read("OFF # comment\n\n4 4 6\n0 0 0\n1 0 0 # x\n0 1 0\n# y\n0 0 1\n3 0 2 1 255 0 0\n3 0 1 3\n"
           "3 0 3 2\n3 1 2 3\n",
           MeshFormat::off));
  expect_tet(
      read("CNOFF\n4 4 0\n0 0 0 0 0 1 9 9 9 9\n1 0 0 0 0 1 9 9 9 9\n0 1 0 0 0 1 9 9 9 9\n"
           "0 0 1 0 0 1 9 9 9 9\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n",
           MeshFormat::off));
  expect_tet(read(tet_stl_binary(), MeshFormat::stl));
  expect_tet(read(tet_ply_binary(false), MeshFormat::ply));
  expect_tet(read(tet_ply_binary(true), MeshFormat::ply));
  expect_tet(
      read("ply\nformat ascii 1.0\nelement vertex 4\nproperty int x\nproperty int y\nproperty int z\n"
           "element face 4\nproperty list uchar int vertex_indices\nelement edge 1\nproperty int a\n"
           "end_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n7\n",
           MeshFormat::ply));
}

TEST(ReadMesh, ReadsAsciiStlWithAwkwardNames) {
  std::string text = "solid solid facet endsolid\n";
  const TriangleSoup tet = read(tet_obj, MeshFormat::obj);
  for (const Triangle& triangle : tet.triangles) {
    text += " facet normal nan nan nan\n  outer loop\n";
    for (std::int32_t corner : triangle) {
      const Vec3& p = tet.positions[corner];
      text += "   vertex " + std::to_string(p.x()) + " " + std::to_string(p.y()) + "\t" +
              std::to_string(p.z()) + "\r\n";
    }
    text += "  endloop\n endfacet\n";
  }
  text += "endsolid solid facet\n";
  expect_tet(read(text, MeshFormat::stl));
}

TEST(ReadMesh, ReadsAsciiStlInCapitals) {
  const TriangleSoup soup = read(
      "SOLID CAD\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\nVERTEX 0 1 "
      "0\nENDLOOP\nENDFACET\n"
      "ENDSOLID\n",
      MeshFormat::stl);
  EXPECT_EQ(soup.triangles.size(), 1u);
}

TEST(ReadMesh, PassesOverTheTailOfABinaryStl) {
  expect_tet(read(tet_stl_binary() + "padding", MeshFormat::stl));
  EXPECT_THROW(read(tet_stl_binary() + std::string(50, ' '), MeshFormat::stl), Error);
}

TEST(ReadMesh, ReadsTriangleStripsOfPly) {
  // The last strip is too short for a triangle.
  expect_tet(
      read("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
           "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
           "0 0 0\n1 0 0\n0 1 0\n0 0 1\n14 0 2 1 3 -1 0 1 3 -1 0 3 2 -1 1\n",
           MeshFormat::ply));
}

TEST(ReadMesh, ReadsTextWithAByteOrderMarkOrWithCarriageReturnsAlone) {
  expect_tet(read("\xef\xbb\xbf" + std::string(tet_obj), MeshFormat::obj));
  std::string old_mac = tet_obj;
  std::ranges::replace(old_mac, '\n', '\r');
  expect_tet(read(old_mac, MeshFormat::obj));
}

TEST(ReadMesh, NamesTheFormatOfAFileUnderAnothersName) {
  for (const MeshFormat format : {MeshFormat::stl, MeshFormat::obj, MeshFormat::off, MeshFormat::glb}) {
    try {
      read(tet_ply_binary(false), format);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::cannot_read);
      EXPECT_TRUE(std::string_view(error.hint()).starts_with("it begins like PLY")) << error.hint();
    }
  }
}

TEST(ReadMesh, SaysWhatToDoAboutFilesThatAreNoMesh) {
  const auto hint = [](std::string_view bytes, MeshFormat format = MeshFormat::obj) -> std::string {
    try {
      read(std::string(bytes), format);
    } catch (const Error& error) {
      return error.hint();
    }
    return "it was read";
  };
  EXPECT_EQ(hint({"\xff\xfev\0 \0", 6}), "it is UTF-16 text: save it as UTF-8");
  EXPECT_EQ(hint("\x1f\x8b\x08 packed"), "it is compressed: unpack it first");
  EXPECT_EQ(hint("<!DOCTYPE html>\n"), "it is a web page or XML: download the mesh itself");
  EXPECT_EQ(hint("v 0,5 0 0\n"), "export the file with points, not commas, in its numbers");
  const std::string anew = "mend the file there, or export the mesh anew";
  EXPECT_EQ(hint("ply\nformat ascii 1.0\nwidth 3\nend_header\n", MeshFormat::ply), anew);
  EXPECT_EQ(hint("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", MeshFormat::off), anew);
}

TEST(ReadMesh, ReadsTheDialectsOfObj) {
  const TriangleSoup plain = read(tet_obj, MeshFormat::obj);
  const TriangleSoup other = read(
      "# comment\nmtllib a.mtl\no tet\nv\t0 0 0 1.0\r\nv 1 0 0 0.5 0.5 0.5\nv 0 1. 0 # y\nv 0 0 +1e0\nvt 0 "
      "0\n"
      "vn 0 0 1\ng a b\nusemtl m\ns off\nl 1 2\nf 1/1\t3/1 2/1\nf -4//1 -3//1 -1//1\nf 1/1/1 \\\n 4/1/1 "
      "3/1/1\n"
      "f +2 3 4",
      MeshFormat::obj);
  EXPECT_EQ(plain.positions, other.positions);
  EXPECT_EQ(plain.triangles, other.triangles);
}

TEST(ReadMesh, KeepsEveryBitOfACoordinate) {
  const TriangleSoup soup =
      read("v 0.1 1e-400 4.9e-324\nv 123456789.123456789 -2.2250738585072014e-308 1e29\nv 0 0 1\nf 1 2 3\n",
           MeshFormat::obj);
  EXPECT_EQ(soup.positions[0], Vec3(0.1, 0.0, 4.9e-324));
  EXPECT_EQ(soup.positions[1], Vec3(123456789.123456789, -2.2250738585072014e-308, 1e29));
}

double area(const TriangleSoup& soup) {
  return inspect(soup).area;
}

TEST(ReadMesh, TriangulatesPolygons) {
  const TriangleSoup quad = read("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nf 1 2 3 4\n", MeshFormat::obj);
  EXPECT_EQ(quad.triangles.size(), 2U);
  EXPECT_DOUBLE_EQ(area(quad), 2.0);
  // A fan from the first corner of this arrowhead would cover area outside it.
  const TriangleSoup arrow = read("v 2 2 0\nv 0 0 0\nv 2 1 0\nv 4 0 0\nf 1 2 3 4\n", MeshFormat::obj);
  EXPECT_EQ(arrow.triangles.size(), 2U);
  EXPECT_DOUBLE_EQ(area(arrow), 2.0);
  const TriangleSoup dart = read("v 0 0 0\nv 2 1 0\nv 4 0 0\nv 2 2 0\nf 1 2 3 4\n", MeshFormat::obj);
  EXPECT_DOUBLE_EQ(area(dart), 2.0);
}

TEST(ReadMesh, TriangulatesACombOfManyTeeth) {
  // Upper side at y = 1 on even and y = 2 on odd x; the lower side a straight line.
  std::string text;
  const int teeth = 200;
  for (int i = 0; i <= teeth; ++i)
    text += "v " + std::to_string(i) + " " + std::to_string(1 + i % 2) + " 3\n";
  text += "v " + std::to_string(teeth) + " 0 3\nv 0 0 3\nf";
  for (int i = 1; i <= teeth + 3; ++i) text += " " + std::to_string(i);
  const TriangleSoup comb = read(text + "\n", MeshFormat::obj);
  EXPECT_EQ(comb.triangles.size(), static_cast<std::size_t>(teeth + 1));
  EXPECT_NEAR(area(comb), 1.5 * teeth, 1e-9);
}

TEST(ReadMesh, CancelsAndReportsProgress) {
  std::string text;
  for (int i = 0; i < 20000; ++i) text += "v 0 0 " + std::to_string(i) + "\n";
  text += "f 1 2 3\n";
  std::atomic<bool> cancel{false};
  double last = -1.0;
  Progress progress(
      [&](std::string_view phase, double fraction) {
        EXPECT_EQ(phase, "reading");
        EXPECT_GE(fraction, last);
        last = fraction;
        if (fraction > 0.0) cancel = true;
      },
      &cancel);
  try {
    read_mesh(text, MeshFormat::obj, progress);
    FAIL() << "not cancelled";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
  }
}

TEST(ReadMesh, KnowsFormatsByExtension) {
  EXPECT_EQ(mesh_format("a.b/c.OBJ"), MeshFormat::obj);
  EXPECT_EQ(mesh_format("x.Stl"), MeshFormat::stl);
  EXPECT_THROW(mesh_format("x.fbx"), Error);
  EXPECT_THROW(mesh_format("obj"), Error);
}

TEST(ReadMesh, ReadsRealMeshes) {
  const char* folder = std::getenv("ISOCHOR_MESHES");
  if (folder == nullptr) GTEST_SKIP() << "set ISOCHOR_MESHES to a folder of meshes";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".md") continue;
    Progress progress;
    const TriangleSoup soup = read_mesh(entry.path(), progress);
    EXPECT_GT(soup.triangles.size(), 0U) << entry.path();
    const Box box = bounding_box(soup);
    EXPECT_NEAR(box.size().maxCoeff(), 1.0, 1e-6) << entry.path();
  }
}

}  // namespace
}  // namespace isochor

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>

#include "core/common/error.h"
#include "core/mesh_input/read_mesh.h"

namespace isochor {
namespace {

using testing::HasSubstr;

struct Malformed {
  const char* name;
  MeshFormat format;
  std::string bytes;
  ErrorCode code;
  const char* message;
};
void PrintTo(const Malformed& mesh, std::ostream* out) {
  *out << mesh.name;
}

std::string obj(const std::string& face) {
  return "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + face + "\n";
}

std::string off(const std::string& counts, const std::string& face) {
  return "OFF\n" + counts + "\n0 0 0\n1 0 0\n0 1 0\n" + face + "\n";
}

std::string ply(const std::string& vertices, const std::string& data) {
  return "ply\nformat ascii 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
         "property list uchar int vertex_indices\nend_header\n" +
         data;
}

std::string stl(std::uint32_t claimed, int triangles, float coordinate) {
  std::string bytes(80, ' ');
  bytes.append(reinterpret_cast<const char*>(&claimed), sizeof claimed);
  for (int i = 0; i < triangles; ++i) {
    for (int j = 0; j < 12; ++j) bytes.append(reinterpret_cast<const char*>(&coordinate), sizeof coordinate);
    bytes.append(2, '\0');
  }
  return bytes;
}

class MalformedMesh : public testing::TestWithParam<Malformed> {};

TEST_P(MalformedMesh, IsRefusedWithThePlace) {
  Progress progress;
  try {
    read_mesh(GetParam().bytes, GetParam().format, progress);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), GetParam().code);
    EXPECT_THAT(error.what(), HasSubstr(GetParam().message));
  }
}

const ErrorCode unreadable = ErrorCode::cannot_read;
const ErrorCode empty = ErrorCode::empty_result;
const MeshFormat o = MeshFormat::obj, f = MeshFormat::off, p = MeshFormat::ply, s = MeshFormat::stl;

INSTANTIATE_TEST_SUITE_P(
    Obj, MalformedMesh,
    testing::Values(
        Malformed{"empty", o, "", empty, "no triangle"},
        Malformed{"points_only", o, "v 0 0 0\n", empty, "no triangle"},
        Malformed{"free_form", o, "v 0 0 0\ncstype bezier\ndeg 1\ncurv 0 1 1 1\nend\n", empty, "no triangle"},
        Malformed{"not_obj", o, "hello\nworld\n", unreadable, "no OBJ file"},
        Malformed{"index_zero", o, obj("f 0 1 2"), unreadable, "line 4: the vertex index 0"},
        Malformed{"index_beyond", o, obj("f 1 2 4"), unreadable, "line 4: the vertex index 4"},
        Malformed{"index_negative", o, obj("f 1 2 -4"), unreadable, "line 4: the vertex index -4"},
        Malformed{"index_2_31", o, obj("f 1 2 2147483648"), unreadable, "line 4"},
        Malformed{"index_2_64", o, obj("f 1 2 18446744073709551617"), unreadable, "line 4"},
        Malformed{"index_fraction", o, obj("f 1 2 2.5"), unreadable, "line 4: \"2.5\""},
        Malformed{"two_corners", o, obj("f 1 2"), unreadable, "line 4: a face needs"},
        Malformed{"nan", o, "v 0 nan 0\n", unreadable, "line 1: a coordinate is not finite"},
        Malformed{"inf", o, "\nv 0 0 -inf\n", unreadable, "line 2: a coordinate is not finite"},
        Malformed{"1e308", o, "v 1e308 0 0\n", unreadable, "line 1: the coordinate 1e308"},
        Malformed{"1e999", o, "v 1e999 0 0\n", unreadable, "line 1: a coordinate is not finite"},
        Malformed{"cut_vertex", o, "v 0 0\n", unreadable, "line 1: a coordinate is missing"},
        Malformed{"call", o, obj("f 1 2 3\ncall other.obj"), unreadable,
                  "line 5: a mesh in another file is called"},
        Malformed{"word", o, "v 0 zero 0\n", unreadable, "line 1: \"zero\" is not a number"},
        Malformed{"two_signs", o, "v 0 0 +-0\n", unreadable, "line 1: \"+-0\" is not a number"}));

INSTANTIATE_TEST_SUITE_P(
    Off, MalformedMesh,
    testing::Values(
        Malformed{"empty", f, "", unreadable, "no OFF file"},
        Malformed{"no_faces", f, off("3 0 0", ""), empty, "no triangle"},
        Malformed{"count_lies", f, off("3 1000000000 0", "3 0 1 2"), unreadable, "line 2: the header"},
        Malformed{"count_negative", f, off("-3 1 0", "3 0 1 2"), unreadable, "line 2: the count"},
        Malformed{"cut", f, off("3 2 0", "3 0 1 2"), unreadable, "a whole number is missing"},
        Malformed{"index", f, off("3 1 0", "3 0 1 3"), unreadable, "line 6: the vertex index 3"},
        Malformed{"index_minus", f, off("3 1 0", "3 0 1 -1"), unreadable, "line 6: the vertex index -1"},
        Malformed{"list_lies", f, off("3 1 0", "1000000000 0 1 2"), unreadable, "line 6"},
        Malformed{"binary", f, "OFF BINARY\n", unreadable, "binary OFF"},
        Malformed{"homogeneous", f, "4OFF\n1 1 1\n", unreadable, "three-dimensional"}));

INSTANTIATE_TEST_SUITE_P(
    Ply, MalformedMesh,
    testing::Values(
        Malformed{"empty", p, "", unreadable, "no PLY file"},
        Malformed{"no_end", p, "ply\nformat ascii 1.0\n", unreadable, "the header has no end"},
        Malformed{"count_lies", p, ply("2000000000", "0 0 0"), unreadable, "more than the file can hold"},
        Malformed{"count_huge", p, ply("9000000000000000000", "0 0 0"), unreadable,
                  "more than the file can hold"},
        Malformed{"cut", p, ply("3", "0 0 0 1 0 0 0 1 0 3 0 1"), unreadable, "line 10"},
        Malformed{"nan", p, ply("3", "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2"), unreadable,
                  "line 11: the coordinate nan"},
        Malformed{"index", p, ply("3", "0 0 0\n1 0 0\n0 1 0\n3 0 1 3"), unreadable,
                  "line 13: the vertex index 3"},
        Malformed{"index_minus", p, ply("3", "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1"), unreadable, "line 13: -1"},
        Malformed{"list_lies", p, ply("3", "0 0 0\n1 0 0\n0 1 0\n250 0 1 2"), unreadable,
                  "line 13: a list claims"},
        Malformed{"no_xyz", p, "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
                  unreadable, "no x, y and z"}));

INSTANTIATE_TEST_SUITE_P(
    Stl, MalformedMesh,
    testing::Values(Malformed{"empty", s, "", unreadable, "no STL file"},
                    Malformed{"none", s, stl(0, 0, 0.0F), empty, "no triangle"},
                    Malformed{"count_lies_up", s, stl(4000000000U, 2, 0.0F), unreadable,
                              "claims 4000000000 triangles"},
                    Malformed{"count_lies_down", s, stl(1, 2, 0.0F), unreadable, "claims 1 triangles"},
                    Malformed{"binary_cut_that_begins_with_solid", s, "solid" + stl(3, 2, 0.0F).substr(5),
                              unreadable, "claims 3 triangles"},
                    Malformed{"nan", s, stl(1, 1, std::numeric_limits<float>::quiet_NaN()), unreadable,
                              "byte 96: the coord"},
                    Malformed{"inf", s, stl(1, 1, std::numeric_limits<float>::infinity()), unreadable,
                              "byte 96: the coord"},
                    Malformed{"ascii_cut", s, "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n",
                              unreadable, "line 4"},
                    Malformed{"ascii_open", s, "solid a\n", unreadable, "ends inside a solid"},
                    Malformed{"ascii_word", s, "solid a\nfacets\n", unreadable, "line 2: expected facet"}));

TEST(MissingFile, IsNamed) {
  Progress progress;
  try {
    read_mesh(std::filesystem::path("/no/such/file.obj"), progress);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cannot_read);
    EXPECT_THAT(error.what(), HasSubstr("/no/such/file.obj"));
  }
}

}  // namespace
}  // namespace isochor

#include "core/export/export.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/common/error.h"
#include "core/common/text_sink.h"
#include "core/export/atomic_file.h"
#include "core/lattice/lattice.h"

namespace isochor {
namespace {

namespace fs = std::filesystem;

/// A bent, twisted L of cells, so that no coordinate is a round number and the shape is not convex.
TetMesh bent_model() {
  Lattice lattice;
  lattice.grid = Grid{{4, 3, 2}, 0.1, Vec3(-0.123, 0.456, 1e-3)};
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 4; ++i) lattice.kept.push_back(i < 2 || j == 0);
  lattice.kept_count = 16;
  TetMesh mesh = make_tetrahedra(lattice);
  for (Vec3& p : mesh.positions)
    p += 0.02 * Vec3(std::sin(7 * p.y()), std::cos(5 * p.z() + p.x()), std::sin(3 * p.x() * p.y()));
  return mesh;
}

class Export : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              ("isochor_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Writes the model and returns the path of the first file.
  fs::path write(const std::string& format) {
    const auto files = export_model(model_, export_format(format));
    const auto paths = export_paths(folder_ / ("model" + files.front().name_suffix), files);
    for (std::size_t i = 0; i < files.size(); ++i) write_file(paths[i], files[i].content);
    return paths.front();
  }

  nlohmann::json read_back(const std::string& reader, const fs::path& file) {
    const std::string command = std::string(ISOCHOR_PYTHON) +
                                " " ISOCHOR_SOURCE "/tests/export/read_back.py " + reader + " " +
                                file.string();
    std::string output;
    std::array<char, 4096> buffer{};
    FILE* pipe = popen(command.c_str(), "r");
    while (std::fgets(buffer.data(), buffer.size(), pipe)) output += buffer.data();
    EXPECT_EQ(pclose(pipe), 0) << command;
    return nlohmann::json::parse(output);
  }

  void expect_model(const nlohmann::json& found, const char* what) {
    EXPECT_EQ(found["points"], mesh_.positions.size()) << what;
    EXPECT_EQ(found["tets"], mesh_.tets.size()) << what;
    EXPECT_NEAR(found["volume"].get<double>() / total_volume(mesh_), 1.0, 1e-12) << what;
    EXPECT_GT(found["smallest"].get<double>(), 0.0) << what;
    EXPECT_EQ(found["orphans"], 0) << what;
  }

  void expect_surface(const nlohmann::json& found, double tolerance, const char* what) {
    EXPECT_EQ(found["triangles"], mesh_.surface.size()) << what;
    EXPECT_NEAR(found["enclosed"].get<double>() / total_volume(mesh_), 1.0, tolerance) << what;
  }

  TetMesh mesh_ = bent_model();
  ExportModel model_{mesh_, nullptr, "isochor voxels=128 -- cells=24", "model"};
  fs::path folder_;
};

TEST_F(Export, GmshReadsMsh2) {
  expect_model(read_back("gmsh", write("msh2")), "gmsh");
  expect_model(read_back("meshio", folder_ / "model.msh"), "meshio");
}

TEST_F(Export, GmshReadsMsh4) {
  expect_model(read_back("gmsh", write("msh4")), "gmsh");
  expect_model(read_back("meshio", folder_ / "model.msh"), "meshio");
}

TEST_F(Export, Msh4IsTheDialectOfFlexcomp) {
  const auto files = export_model(model_, export_format("msh4"));
  const std::string n = std::to_string(mesh_.positions.size()), t = std::to_string(mesh_.tets.size());
  EXPECT_NE(files[0].content.find("$Nodes\n1 " + n + " 1 " + n + "\n3 1 0 " + n + "\n1\n2\n"),
            std::string::npos);
  EXPECT_NE(files[0].content.find("$Elements\n1 " + t + " 1 " + t + "\n3 1 4 " + t + "\n1 "),
            std::string::npos);
  ASSERT_EQ(files[1].name_suffix, ".xml");
  EXPECT_NE(files[1].content.find("type=\"gmsh\" dim=\"3\" file=\"model.msh\""), std::string::npos);
  EXPECT_EQ(files[1].content.find("-- cells"), std::string::npos) << "two hyphens end an XML comment";
}

TEST_F(Export, VtkReadsVtuWithItsCellData) {
  const fs::path file = write("vtu");
  const auto found = read_back("vtk", file);
  expect_model(found, "vtk");
  EXPECT_NEAR(found["cell_data:volume"].get<double>() / total_volume(mesh_), 1.0, 1e-12);
  const auto cells = static_cast<double>(mesh_.cells.size());
  EXPECT_EQ(found["cell_data:cell"].get<double>(), 5 * cells * (cells - 1) / 2);
  expect_model(read_back("meshio", file), "meshio");
}

TEST_F(Export, VtkReadsLegacyVtk) {
  const fs::path file = write("vtk");
  expect_model(read_back("vtk", file), "vtk");
  expect_model(read_back("meshio", file), "meshio");
}

TEST_F(Export, TetGenReconstructsItsSet) {
  const fs::path file = write("tetgen");
  const auto found = read_back("tetgen", file);
  expect_model(found, "tetgen");
  EXPECT_EQ(found["boundary_faces"], mesh_.surface.size());
  expect_model(read_back("meshio", file), "meshio");
}

TEST_F(Export, GmshAndMeshioReadMedit) {
  const fs::path file = write("medit");
  for (const char* reader : {"gmsh", "meshio"}) {
    const auto found = read_back(reader, file);
    expect_model(found, reader);
    expect_surface(found, 1e-12, reader);
  }
}

TEST_F(Export, ThreeReadsUsdaAndDrawsItsCompanion) {
  const auto found = read_back("three", write("usda"));
  expect_model(found, "usda");
  expect_surface(found, 1e-12, "usda");
  EXPECT_LT(found["shift_of_drawn"].get<double>(), 1e-6) << "drawn in single precision";
}

TEST_F(Export, ThreeReadsTheArraysOfTenMinutePhysics) {
  const auto found = read_back("three", write("json"));
  expect_model(found, "json");
  expect_surface(found, 1e-12, "json");
  EXPECT_EQ(found["shift_of_drawn"].get<double>(), 0.0);
  EXPECT_GT(found["edges"], mesh_.positions.size());
}

TEST_F(Export, BoundaryFormatsEncloseTheSameVolume) {
  expect_surface(read_back("meshio", write("obj")), 1e-12, "obj");
  expect_surface(read_back("meshio", write("ply")), 1e-12, "ply");
  expect_surface(read_back("vtk", write("stl")), 1e-5, "stl in single precision");
}

TEST_F(Export, EmbeddingBindsEachVertexToFourOfTheModel) {
  Embedding embedding;
  embedding.tet = {0, 7};
  embedding.weights = {{0.25F, 0.25F, 0.25F, 0.25F}, {1.5F, -0.5F, 0, 0}};
  EXPECT_THROW(export_model(model_, export_format("embedding")), Error);
  model_.embedding = &embedding;
  const auto json = nlohmann::json::parse(export_model(model_, export_format("embedding"))[0].content);
  EXPECT_EQ(json["count"], 2);
  EXPECT_EQ(json["tet"], (std::vector<int>{0, 7}));
  EXPECT_EQ(json["vertices"][1], mesh_.tets[7]);
  EXPECT_EQ(json["weights"][1], (std::vector<double>{1.5, -0.5, 0, 0}));
}

TEST_F(Export, TheSameModelGivesTheSameBytesWithTheParametersInside) {
  Embedding embedding;
  embedding.tet = {0};
  embedding.weights = {{1, 0, 0, 0}};
  model_.embedding = &embedding;
  const TetMesh copy = bent_model();
  for (const ExportFormat& format : export_formats()) {
    const auto first = export_model(model_, format);
    const auto second = export_model({copy, &embedding, model_.comment, "model"}, format);
    ASSERT_EQ(first.size(), second.size());
    EXPECT_EQ(format.is_set, first.size() > 1) << format.name;
    EXPECT_EQ(first.front().name_suffix, format.extension);
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(first[i].content, second[i].content) << format.name;
      EXPECT_NE(first[i].content.find("voxels=128"), std::string::npos) << format.name;
    }
  }
}

class LongestPiece final : public ExportSink {
 public:
  void begin(std::string_view) override {}
  void write(std::string_view bytes) override {
    all += bytes;
    longest = std::max(longest, bytes.size());
  }
  std::string all;
  std::size_t longest = 0;
};

TEST(ExportPieces, AreShortAndTheWholeFile) {
  Lattice lattice;
  lattice.grid = Grid{{24, 24, 24}, 0.1, Vec3::Zero()};
  lattice.kept.assign(24 * 24 * 24, 1);
  lattice.kept_count = 24 * 24 * 24;
  const TetMesh mesh = make_tetrahedra(lattice);
  Embedding embedding;
  embedding.tet.assign(5000, 7);
  embedding.weights.assign(5000, {0.1, 0.2, 0.3, 0.4});
  const ExportModel model{.mesh = mesh, .embedding = &embedding, .comment = "a cube"};
  for (const ExportFormat& format : export_formats()) {
    std::string whole;
    for (const ExportFile& file : export_model(model, format)) whole += file.content;
    LongestPiece pieces;
    export_model(model, format, pieces);
    EXPECT_EQ(pieces.all, whole) << format.name;
    EXPECT_GT(whole.size(), 2 * text_piece_bytes) << format.name;
    EXPECT_LE(pieces.longest, 2 * text_piece_bytes) << format.name;
  }
}

TEST(ExportFormats, AreFoundByNameAndByExtension) {
  EXPECT_EQ(export_format("msh4").name, "msh4");
  EXPECT_EQ(export_format(".msh").name, "msh2");
  EXPECT_EQ(export_format_of("a/model.Embedding.JSON").name, "embedding");
  EXPECT_EQ(export_format_of("a.msh/embedding.json").name, "json");
  EXPECT_EQ(export_format_of("model.ele").name, "tetgen");
  EXPECT_EQ(export_format(".VTU").name, "vtu");
  EXPECT_EQ(export_format(".ele").name, "tetgen");
  try {
    export_format(".xyz");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::unsupported_format);
    EXPECT_NE(error.hint().find("msh2"), std::string::npos);
  }
}

TEST(ExportPaths, PutASetBesideEachOther) {
  const std::vector<ExportFile> set{{".node", ""}, {".ele", ""}};
  EXPECT_EQ(export_paths("a/tree.node", set), (std::vector<fs::path>{"a/tree.node", "a/tree.ele"}));
  EXPECT_EQ(export_paths("a/tree.v2", set), (std::vector<fs::path>{"a/tree.v2.node", "a/tree.v2.ele"}));
  EXPECT_EQ(export_paths("out.anything", {set.data(), 1}), (std::vector<fs::path>{"out.anything"}));
}

}  // namespace
}  // namespace isochor

#include "core/scene/read_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace isochor {
namespace {

using testing::Contains;
using testing::Field;
using testing::HasSubstr;

/// Everything that a scene file may say.
constexpr std::string_view full_scene = R"({
 "name":"drop","duration":null,"frame_rate":30,"gravity":[0,-1.62,0],
 "solver":{"volume":"gradient","constraint":"per_tet","tolerance":1e-8,"springs":"implicit","substeps":7,"max_iterations":9},
 "bodies":[
  {"name":"cube","type":"deformable","lattice":{"cells":[8,4,2],"cell_size":0.125,"origin":[-0.5,1.0,-0.5]},
   "density":500,"densities":[{"inside":{"min":[0,0,0],"max":[1,1,1]},"density":2000}],
   "masses":"equal","edge_stiffness":5e4,"diagonal_stiffness":2e3,"damping":0.01,
   "edge_modulus":1e5,"diagonal_modulus":2e5,"position":[1,2,3],"orientation":[0,0,2,0],"scale":2,
   "velocity":[1,0,0],"angular_velocity":[0,3,0],"friction":0.7,"restitution":0.25,"self_contact":true,
   "start":{"randomize":0.5,"seed":9,"flatten":"line","affine":[[1,0,0],[0,2,0],[0,0,3]],"twist_deg":90,"invert":true}},
  {"name":"tree","type":"deformable","mesh":"meshes/tree.obj","meshing":{"voxels":64,"cells":12}},
  {"name":"ball","type":"rigid","shape":{"sphere":{"radius":0.5}},"static":true},
  {"name":"floor","type":"rigid","shape":{"plane":{"normal":[0,2,0],"offset":-1}},"static":true},
  {"name":"plate","type":"rigid","shape":{"box":{"half_extents":[1,0.05,1]}},"motion":{"velocity":[0,-0.5,0],"until":1.0}},
  {"name":"door","type":"rigid","shape":{"mesh":"door.stl"},"motion":{"keyframes":[{"t":0},{"t":1,"position":[1,0,0]}]}},
  {"name":"crate","type":"rigid","shape":{"capsule":{"radius":0.1,"half_height":0.4}},"mass":10}],
 "pins":[{"body":"cube","inside":{"min":[-1,0.9,-1],"max":[1,1.01,1]},"to":"crate"},{"body":"tree","to":null}],
 "joints":[{"type":"hinge","a":"crate","b":"ball","anchor":[0,1,0],"axis":[0,0,5]}]})";

TEST(ReadScene, EveryFieldArrives) {
  const Scene scene = read_scene(full_scene, "/folder");
  EXPECT_EQ(scene.name, "drop");
  EXPECT_FALSE(scene.duration.has_value());
  EXPECT_EQ(scene.frame_rate, 30.0);
  EXPECT_EQ(scene.gravity, Vec3(0, -1.62, 0));
  EXPECT_EQ(scene.solver.volume, VolumeSolver::gradient);
  EXPECT_EQ(scene.solver.constraint, ConstraintScope::per_tet);
  EXPECT_EQ(scene.solver.springs, SpringIntegrator::implicit);
  EXPECT_EQ(scene.solver.tolerance, 1e-8);
  EXPECT_EQ(scene.solver.substeps, 7);
  EXPECT_EQ(scene.solver.max_iterations, 9);
  ASSERT_EQ(scene.bodies.size(), 7u);

  const SceneBody& cube = scene.bodies[0];
  EXPECT_EQ(cube.position, Vec3(1, 2, 3));
  EXPECT_EQ(cube.orientation.coeffs(), Eigen::Vector4d(0, 0, 1, 0));
  EXPECT_EQ(cube.scale, 2.0);
  EXPECT_EQ(cube.angular_velocity, Vec3(0, 3, 0));
  EXPECT_EQ(cube.friction, 0.7);
  EXPECT_EQ(cube.restitution, 0.25);
  const auto& soft = std::get<DeformableBody>(cube.kind);
  EXPECT_EQ(std::get<LatticeShape>(soft.shape).cells, Vec3i(8, 4, 2));
  EXPECT_EQ(soft.masses, MassLumping::equal);
  EXPECT_EQ(soft.densities.at(0).density, 2000.0);
  EXPECT_EQ(soft.edge_modulus, 1e5);
  EXPECT_EQ(soft.damping, 0.01);
  EXPECT_TRUE(soft.self_contact);
  EXPECT_EQ(soft.start.flatten, StartState::Flatten::line);
  EXPECT_EQ(soft.start.affine.diagonal(), Vec3(1, 2, 3));
  EXPECT_EQ(soft.start.seed, 9u);

  const auto& tree = std::get<MeshShape>(std::get<DeformableBody>(scene.bodies[1].kind).shape);
  EXPECT_EQ(tree.file, "/folder/meshes/tree.obj");
  EXPECT_EQ(tree.meshing.voxels, 64);
  EXPECT_EQ(tree.meshing.lattice.cells, 12);
  EXPECT_EQ(std::get<PlaneShape>(std::get<RigidBody>(scene.bodies[3].kind).shape).normal, Vec3::UnitY());
  EXPECT_EQ(std::get<RigidBody>(scene.bodies[4].kind).motion->until, 1.0);
  EXPECT_EQ(std::get<RigidBody>(scene.bodies[5].kind).motion->keyframes.size(), 2u);
  EXPECT_EQ(std::get<RigidBody>(scene.bodies[6].kind).mass, 10.0);
  EXPECT_EQ(scene.pins.at(0).to, "crate");
  EXPECT_FALSE(scene.pins.at(1).to.has_value());
  EXPECT_EQ(scene.joints.at(0).type, JointType::hinge);
  EXPECT_EQ(scene.joints.at(0).axis, Vec3::UnitZ());
}

std::vector<ErrorDetail> faults_of(std::string_view json) {
  try {
    read_scene(json, {});
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::invalid_argument);
    return error.details();
  }
  ADD_FAILURE() << "was accepted: " << json;
  return {};
}

struct Fault {
  std::string_view json, pointer, detail;
};

void PrintTo(const Fault& fault, std::ostream* out) {
  *out << fault.json;
}

class FaultyScene : public testing::TestWithParam<Fault> {};

TEST_P(FaultyScene, IsNamedByItsPointer) {
  const auto& [json, pointer, detail] = GetParam();
  EXPECT_THAT(faults_of(json), Contains(testing::AllOf(Field(&ErrorDetail::pointer, pointer),
                                                       Field(&ErrorDetail::detail, HasSubstr(detail)))));
}

TEST(ReadScene, ANameOfMegabytesIsAFault) {
  const std::string name(1 << 20, 'n');
  EXPECT_THAT(faults_of(R"({"name":")" + name + "\"}"),
              Contains(testing::AllOf(Field(&ErrorDetail::pointer, "/name"),
                                      Field(&ErrorDetail::detail, HasSubstr("at most 255")))));
  EXPECT_THAT(faults_of(R"({"bodies":[{"type":"deformable","mesh":")" + name + "\"}]}"),
              Contains(testing::AllOf(Field(&ErrorDetail::pointer, "/bodies/0/mesh"),
                                      Field(&ErrorDetail::detail, HasSubstr("at most 4096")))));
}

TEST(ReadScene, FaultsThatRepeatEndWhenNobodyReadsOn) {
  std::string list = "0", members = R"("m0":0)";
  for (int i = 1; i < 5000; ++i) {
    list += ",0";
    members += ",\"m" + std::to_string(i) + "\":0";
  }
  const std::string keyframes = R"({"bodies":[{"type":"rigid","motion":{"keyframes":[)" + list + "]}}]}";
  const std::string regions = R"({"bodies":[{"type":"deformable","densities":[)" + list + "]}]}";
  for (const std::string& scene : {R"({"bodies":[)" + list + "]}", R"({"pins":[)" + list + "]}",
                                   "{" + members + "}", keyframes, regions}) {
    const std::size_t faults = faults_of(scene).size();
    EXPECT_GE(faults, 100u) << scene.substr(0, 60);
    EXPECT_LT(faults, 200u) << scene.substr(0, 60);
  }
}

INSTANTIATE_TEST_SUITE_P(
    ReadScene, FaultyScene,
    testing::Values(
        Fault{R"([])", "", "object"}, Fault{R"({"gravitas":[0,0,0]})", "/gravitas", "not known"},
        Fault{R"({"a/b~":1})", "/a~1b~0", "not known"},
        Fault{R"({"solver":{"step":1}})", "/solver/step", "not known"},
        Fault{R"({"bodies":[{"type":"deformable","lattice":{"cell":1}}]})", "/bodies/0/lattice/cell",
              "not known"},
        Fault{R"({"bodies":[{"type":"deformable","start":{"twist":1}}]})", "/bodies/0/start/twist",
              "not known"},
        Fault{R"({"bodies":[{"type":"rigid","shape":{"sphere":{"r":1}}}]})", "/bodies/0/shape/sphere/r",
              "not known"},
        Fault{R"({"bodies":[{"type":"rigid","motion":{"keyframes":[{"time":0}]}}]})",
              "/bodies/0/motion/keyframes/0/time", "not known"},
        Fault{R"({"pins":[{"at":1}]})", "/pins/0/at", "not known"},
        Fault{R"({"joints":[{"kind":1}]})", "/joints/0/kind", "not known"},
        Fault{R"({"frame_rate":0})", "/frame_rate", "from"},
        Fault{R"({"frame_rate":"60"})", "/frame_rate", "number"},
        Fault{R"({"gravity":[0,1]})", "/gravity", "three"},
        Fault{R"({"gravity":[0,1,"x"]})", "/gravity/2", "number"},
        Fault{R"({"solver":{"tolerance":1}})", "/solver/tolerance", "1e-12 to 0.1"},
        Fault{R"({"solver":{"max_iterations":1e300}})", "/solver/max_iterations", "from 1"},
        Fault{R"({"solver":{"max_iterations":2.5}})", "/solver/max_iterations", "whole"},
        Fault{R"({"solver":{"substeps":"many"}})", "/solver/substeps", "number"},
        Fault{R"({"solver":{"volume":"magic"}})", "/solver/volume", "newton, scaling, gradient"},
        Fault{R"({"bodies":{}})", "/bodies", "list"},
        Fault{R"({"bodies":[{}]})", "/bodies/0/type", "missing"},
        Fault{R"({"bodies":[{"type":"deformable"}]})", "/bodies/0/lattice", "either"},
        Fault{R"({"bodies":[{"type":"deformable","lattice":{"cells":[2147483648,1,1]}}]})",
              "/bodies/0/lattice/cells/0", "from 1 to 1024"},
        Fault{R"({"bodies":[{"type":"deformable","lattice":{"cells":[1.5,1,1]}}]})",
              "/bodies/0/lattice/cells", "whole"},
        Fault{R"({"bodies":[{"type":"deformable","mesh":"a.obj","meshing":{"voxels":1e9}}]})",
              "/bodies/0/meshing/voxels", "from"},
        Fault{R"({"bodies":[{"type":"deformable","mesh":"a.obj","meshing":{"voxel":64}}]})",
              "/bodies/0/meshing/voxel", "not a parameter"},
        Fault{R"({"bodies":[{"type":"rigid","shape":{"sphere":{"radius":-1}},"static":true}]})",
              "/bodies/0/shape/sphere/radius", "from"},
        Fault{R"({"bodies":[{"type":"rigid","shape":{"sphere":{},"box":{}},"static":true}]})",
              "/bodies/0/shape", "exactly one"},
        Fault{R"({"bodies":[{"type":"rigid","shape":{"sphere":{}}}]})", "/bodies/0/static", "exactly one"},
        Fault{R"({"bodies":[{"type":"rigid","shape":{"plane":{}},"mass":1}]})", "/bodies/0/mass", "plane"},
        Fault{R"({"bodies":[{"type":"rigid","shape":{"plane":{"normal":[0,0,0]}},"static":true}]})",
              "/bodies/0/shape/plane/normal", "zero"},
        Fault{
            R"({"bodies":[{"name":"a","type":"deformable","lattice":{}},{"name":"a","type":"deformable","lattice":{}}]})",
            "/bodies/1/name", "taken"},
        Fault{R"({"pins":[{"body":"nobody"}]})", "/pins/0/body", "deformable"},
        Fault{R"({"joints":[{"type":"ball","a":"x","b":"y"}]})", "/joints/0/a", "rigid"}));

TEST(ReadScene, AllFaultsAreToldAtOnce) {
  const auto faults = faults_of(R"({"frame_rate":-1,"solver":{"tolerance":5},"bodies":[{"type":"soft"}]})");
  EXPECT_EQ(faults.size(), 3u);
}

TEST(ReadScene, SyntaxIsNamedByItsByte) {
  try {
    read_scene(R"({"name": })", {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cannot_read);
    EXPECT_THAT(error.what(), HasSubstr("byte 10"));
  }
}

TEST(ReadScene, DeepAndHugeTextIsRefusedBeforeATreeIsBuilt) {
  EXPECT_THROW(read_scene(std::string(1000000, '['), {}), Error);
  EXPECT_THROW(read_scene(std::string(32 << 20, ' '), {}), Error);
  EXPECT_THROW(read_scene(R"({"duration":1e999})", {}), Error);
  EXPECT_THROW(read_scene_file("/nowhere/scene.json"), Error);
  EXPECT_THROW(read_scene_file("/"), Error);
}

TEST(ReadScene, ABracketInsideAStringDoesNotNest) {
  EXPECT_EQ(read_scene("{\"name\":\"" + std::string(100, '[') + "\\\"\"}", {}).name.size(), 101u);
}

TEST(MeshingOptions, TravelThroughJsonUnchanged) {
  MeshingOptions options;
  options.voxels = 96;
  options.pseudo_volume.rays = 14;
  options.lattice.density = 0.25;
  options.smoothing.iterations = 5;
  EXPECT_EQ(read_meshing_options(write_meshing_options(options)), options);
  EXPECT_EQ(read_meshing_options("{}"), MeshingOptions{});
}

TEST(MeshingOptions, APresetIsTheBaseOfWhatStandsBesideIt) {
  const MeshingOptions thin = read_meshing_options(R"({"preset":"thin","cells":20})");
  EXPECT_EQ(thin.pseudo_volume.p_in_voxels, 4.0);
  EXPECT_EQ(thin.lattice.cells, 20);
  // Beyond the preset's p_subs_voxels of 6, which then follows.
  const MeshingOptions thick = read_meshing_options(R"({"preset":"thin","p_in_voxels":7})");
  EXPECT_EQ(thick.pseudo_volume.p_in_voxels, 7.0);
  EXPECT_EQ(thick.pseudo_volume.p_subs_voxels, 7.0);
  EXPECT_THROW(read_meshing_options(R"({"preset":"thick"})"), Error);
}

}  // namespace
}  // namespace isochor

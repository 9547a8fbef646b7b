#include "core/export/animation.h"

#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <bit>
#include <cstring>

namespace isochor {
namespace {

/// A box whose vertices drift apart, each along its own line; three frames.
Animation drifting_box() {
  const TetMesh mesh = make_box_lattice({1, 1, 1}, 1.0, Vec3(0.1, 0.2, 0.3));
  Animation animation{mesh.surface, mesh.positions, {}, 25.0, "isochor drift"};
  for (int frame = 0; frame < 3; ++frame) {
    animation.frames.push_back(mesh.positions);
    for (Vec3& p : animation.frames.back()) p += 0.1 * frame * Vec3(p.y(), 1.0, -p.x());
  }
  return animation;
}

template <class Number>
Number at(const std::string& bytes, std::size_t offset, std::endian order) {
  std::array<char, sizeof(Number)> raw{};
  std::memcpy(raw.data(), bytes.data() + offset, sizeof(Number));
  if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<Number>(raw);
}

void expect_positions(const std::string& bytes, std::size_t offset, std::endian order,
                      const Animation& animation) {
  ASSERT_EQ(bytes.size(), offset + animation.frames.size() * animation.rest.size() * 12);
  for (const auto& frame : animation.frames)
    for (const Vec3& p : frame)
      for (int axis = 0; axis < 3; ++axis, offset += 4)
        EXPECT_EQ(at<float>(bytes, offset, order), static_cast<float>(p[axis]));
}

TEST(Animations, MddIsBigEndianWithCountsTimesAndPositions) {
  const Animation animation = drifting_box();
  const std::string bytes = write_mdd(animation);
  EXPECT_EQ(at<std::int32_t>(bytes, 0, std::endian::big), 3);
  EXPECT_EQ(at<std::int32_t>(bytes, 4, std::endian::big), 8);
  for (int frame = 0; frame < 3; ++frame)
    EXPECT_FLOAT_EQ(at<float>(bytes, 8 + 4 * frame, std::endian::big), static_cast<float>(frame) / 25.0F);
  expect_positions(bytes, 8 + 3 * 4, std::endian::big, animation);
}

TEST(Animations, Pc2IsLittleEndianBehindAHeaderOf32Bytes) {
  const Animation animation = drifting_box();
  const std::string bytes = write_pc2(animation);
  EXPECT_EQ(bytes.substr(0, 12), std::string("POINTCACHE2\0", 12));
  EXPECT_EQ(at<std::int32_t>(bytes, 12, std::endian::little), 1);
  EXPECT_EQ(at<std::int32_t>(bytes, 16, std::endian::little), 8);
  EXPECT_EQ(at<float>(bytes, 20, std::endian::little), 0.0F);
  EXPECT_EQ(at<float>(bytes, 24, std::endian::little), 1.0F);
  EXPECT_EQ(at<std::int32_t>(bytes, 28, std::endian::little), 3);
  expect_positions(bytes, 32, std::endian::little, animation);
}

class Glb : public testing::Test {
 protected:
  void SetUp() override {
    const std::string bytes = write_glb(animation_);
    ASSERT_EQ(bytes.size() % 4, 0U);
    std::string error, warning;
    ASSERT_TRUE(tinygltf::TinyGLTF().LoadBinaryFromMemory(
        &model_, &error, &warning, reinterpret_cast<const unsigned char*>(bytes.data()),
        static_cast<unsigned>(bytes.size())))
        << error;
    EXPECT_EQ(error + warning, "");
  }

  template <class Number>
  std::vector<Number> numbers(int accessor_index) {
    const tinygltf::Accessor& accessor = model_.accessors.at(accessor_index);
    const tinygltf::BufferView& view = model_.bufferViews.at(accessor.bufferView);
    const auto& data = model_.buffers.at(view.buffer).data;
    std::vector<Number> values(accessor.count * tinygltf::GetNumComponentsInType(accessor.type));
    EXPECT_EQ(values.size() * sizeof(Number), view.byteLength);
    std::memcpy(values.data(), data.data() + view.byteOffset, view.byteLength);
    return values;
  }

  Animation animation_ = drifting_box();
  tinygltf::Model model_;
};

TEST_F(Glb, HasAMorphTargetAFrameThatGivesTheFrameBack) {
  const tinygltf::Primitive& primitive = model_.meshes.at(0).primitives.at(0);
  const auto rest = numbers<float>(primitive.attributes.at("POSITION"));
  ASSERT_EQ(primitive.targets.size(), animation_.frames.size());
  for (std::size_t frame = 0; frame < animation_.frames.size(); ++frame) {
    const auto offset = numbers<float>(primitive.targets[frame].at("POSITION"));
    for (std::size_t i = 0; i < rest.size(); ++i)
      EXPECT_NEAR(rest[i] + offset[i], animation_.frames[frame][i / 3][static_cast<int>(i % 3)], 1e-6);
  }
  const auto indices = numbers<std::uint32_t>(primitive.indices);
  ASSERT_EQ(indices.size(), 3 * animation_.triangles.size());
  for (std::size_t i = 0; i < indices.size(); ++i)
    EXPECT_EQ(static_cast<std::int32_t>(indices[i]), animation_.triangles[i / 3][i % 3]);
}

TEST_F(Glb, StepsThroughTheTargetsInTime) {
  const tinygltf::Animation& clip = model_.animations.at(0);
  EXPECT_EQ(clip.channels.at(0).target_path, "weights");
  const auto times = numbers<float>(clip.samplers.at(0).input);
  const auto weights = numbers<float>(clip.samplers.at(0).output);
  ASSERT_EQ(times.size(), 3U);
  EXPECT_FLOAT_EQ(times[2], 2.0F / 25.0F);
  ASSERT_EQ(weights.size(), 9U);
  for (int frame = 0; frame < 3; ++frame)
    for (int target = 0; target < 3; ++target)
      EXPECT_EQ(weights[3 * frame + target], frame == target ? 1 : 0);
}

TEST_F(Glb, StatesTheBoundsOfItsPositions) {
  const auto& accessor = model_.accessors.at(model_.meshes[0].primitives[0].attributes.at("POSITION"));
  ASSERT_EQ(accessor.minValues.size(), 3U);
  EXPECT_NEAR(accessor.minValues[0], 0.1, 1e-6);
  EXPECT_NEAR(accessor.maxValues[2], 1.3, 1e-6);
}

TEST(Animations, AVtuSeriesListsItsFilesWithTheirTimes) {
  const TetMesh mesh = make_box_lattice({1, 1, 1}, 1.0, Vec3::Zero());
  const std::vector<std::vector<Vec3>> frames(3, mesh.positions);
  const auto files = write_vtu_series(mesh, frames, 25.0, "run", "isochor drift");
  ASSERT_EQ(files.size(), 4U);
  EXPECT_EQ(files[0].name_suffix, ".pvd");
  EXPECT_NE(files[0].content.find("timestep=\"0.08\" part=\"0\" file=\"run_000002.vtu\""), std::string::npos);
  EXPECT_EQ(files[3].name_suffix, "_000002.vtu");
  EXPECT_EQ(files[3].content, files[1].content) << "the same positions, the same bytes";
}

}  // namespace
}  // namespace isochor

#include "server/messages/frame_codec.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/fake_simulation.h"
#include "tests/support/typed_array.h"

namespace isochor {
namespace {

using nlohmann::json;

json parse_line(const std::string& line) {
  EXPECT_EQ(line.find('\n'), line.size() - 1) << "one document a line";
  return json::parse(line);
}

class FrameCodec : public testing::Test {
 protected:
  test::FakeSimulation simulation_{Vec3i(2, 1, 1), 0.5, 10};
};

TEST_F(FrameCodec, AFrameCarriesPositionsInTheEncodingAskedFor) {
  Snapshot frame = simulation_.step(Progress{});
  frame.bodies[0].positions[3] = Vec3(0.1, 1.0 / 3.0, -2.0);
  const auto f32 = test::decode_typed_array<float>(
      parse_line(encode_frame(frame, Encoding::f32))["bodies"][0]["positions"]);
  const auto f64 = test::decode_typed_array<double>(
      parse_line(encode_frame(frame, Encoding::f64))["bodies"][0]["positions"]);
  const json plain = parse_line(encode_frame(frame, Encoding::array))["bodies"][0]["positions"];
  ASSERT_EQ(f64.size(), 3 * frame.bodies[0].positions.size());
  ASSERT_EQ(plain.size(), frame.bodies[0].positions.size());
  for (std::size_t v = 0; v < plain.size(); ++v)
    for (int axis = 0; axis < 3; ++axis) {
      const double value = frame.bodies[0].positions[v][axis];
      const std::size_t i = 3 * v + static_cast<std::size_t>(axis);
      EXPECT_EQ(f64[i], value);
      EXPECT_EQ(f32[i], static_cast<float>(value));
      EXPECT_EQ(plain[v][axis].get<float>(), static_cast<float>(value));
    }
}

TEST_F(FrameCodec, AFrameIsItsHeadAndTheSharedTail) {
  const Snapshot frame = simulation_.step(Progress{});
  const json line = parse_line(encode_frame_head(frame, 3) + encode_frame_tail(frame, Encoding::f32));
  EXPECT_EQ(line["type"], "frame");
  EXPECT_EQ(line["seq"], 1);
  EXPECT_EQ(line["dropped"], 3);
  EXPECT_DOUBLE_EQ(line["t"].get<double>(), 1.0 / 60.0);
  EXPECT_EQ(line["bodies"][1]["pose"], json({0.0, -1.0, 0.25, 0.0, 0.0, 0.0, 1.0}));
}

TEST_F(FrameCodec, NoMetricIsEverNotANumber) {
  Snapshot frame = simulation_.snapshot();
  frame.metrics.kinetic_energy = std::nan("");
  frame.metrics.linear_momentum.x() = std::numeric_limits<double>::infinity();
  const json metrics = parse_line(encode_frame(frame, Encoding::f32))["metrics"];
  EXPECT_TRUE(metrics["kinetic_energy"].is_null());
  EXPECT_TRUE(metrics["linear_momentum"][0].is_null());
  EXPECT_EQ(metrics["linear_momentum"][1], 0.0);
}

TEST_F(FrameCodec, HelloOfARecordingHoldsTheWholeTopology) {
  const json hello = parse_line(encode_hello(simulation_, Encoding::f32));
  EXPECT_EQ(hello["type"], "hello");
  EXPECT_EQ(hello["plan"][1]["reason"], "no rigid body");
  const json& box = hello["bodies"][0];
  EXPECT_EQ(box["type"], "deformable");
  EXPECT_EQ(box["tets"].size(), 10U);
  EXPECT_EQ(box["cells"], json({{0, 1, 2, 3, 4}, {5, 6, 7, 8, 9}}));
  EXPECT_EQ(box["masses"]["dtype"], "float64");
  const auto rest = test::decode_typed_array<double>(box["rest_positions"]);
  ASSERT_EQ(rest.size(), 36U);
  double volume = 0.0;  // of the box 1 × 0.5 × 0.5, from the line alone
  for (const auto& tet : box["tets"]) {
    const auto at = [&](int corner) { return Vec3(&rest[3 * tet[corner].get<std::size_t>()]); };
    volume += tet_volume(at(0), at(1), at(2), at(3));
  }
  EXPECT_NEAR(volume, 0.25, 1e-15);
  EXPECT_EQ(hello["bodies"][1]["shape"], json::parse(R"({"sphere":{"radius":0.5}})"));
  EXPECT_EQ(hello["bodies"][1]["bounds"], json::parse(R"({"min":[-0.5,-0.5,-0.5],"max":[0.5,0.5,0.5]})"));
}

TEST_F(FrameCodec, HelloOfAStreamNamesTheTopologyInstead) {
  const json hello =
      parse_line(encode_hello(hello_facts(simulation_), {.encoding = Encoding::array,
                                                         .simulation_id = "s1",
                                                         .topology_url = "/api/v1/simulations/s1/topology"}));
  EXPECT_EQ(hello["simulation"], "s1");
  EXPECT_EQ(hello["topology"], "/api/v1/simulations/s1/topology");
  EXPECT_EQ(hello["encoding"], "array");
  EXPECT_FALSE(hello.contains("bodies"));
}

TEST_F(FrameCodec, OtherLines) {
  EXPECT_EQ(parse_line(encode_heartbeat(4, 0.5)), json::parse(R"({"type":"heartbeat","seq":4,"t":0.5})"));
  EXPECT_EQ(parse_line(encode_state("paused", 4, 0.5))["state"], "paused");
  EXPECT_EQ(parse_line(encode_end("finished", 9))["reason"], "finished");
  const json error = parse_line(encode_error(
      Error(ErrorCode::over_budget, "too large", "use 12 cells", {{"/cells", "at most 12", 2.0, 12.0}})));
  EXPECT_EQ(error["problem"]["code"], "over_budget");
  EXPECT_EQ(error["problem"]["hint"], "use 12 cells");
  EXPECT_EQ(error["problem"]["errors"][0]["max"], 12.0);
}

TEST(Encodings, NamesReadBack) {
  for (const Encoding encoding : {Encoding::f32, Encoding::f64, Encoding::array})
    EXPECT_EQ(parse_encoding(encoding_name(encoding)), encoding);
  EXPECT_EQ(parse_encoding("f16"), std::nullopt);
}

}  // namespace
}  // namespace isochor

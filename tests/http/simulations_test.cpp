#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/support/running_server.h"
#include "tests/support/typed_array.h"

namespace isochor {
namespace {

using nlohmann::json;
using test::HttpResponse;
using test::StreamReader;

const json falling_box = json::parse(R"({
  "name": "fall", "duration": null,
  "bodies": [
    {"name": "box", "type": "deformable", "lattice": {"cells": [2, 2, 2], "cell_size": 0.25, "origin": [0, 5, 0]}},
    {"name": "ball", "type": "rigid", "shape": {"sphere": {"radius": 0.5}}, "motion": {"velocity": [0, 0, 0]},
     "position": [0, 0, 0]}]})");

class SimulationsApi : public testing::Test {
 protected:
  std::string create(const json& scene, const std::string& query = "") {
    const HttpResponse response = client_.send_json("POST", "/api/v1/simulations" + query, scene);
    EXPECT_EQ(response.status, 201) << response.body;
    return "/api/v1/simulations/" + response.json()["id"].get<std::string>();
  }
  HttpResponse patch(const std::string& path, const json& change) {
    return client_.send_json("PATCH", path, change);
  }

  test::RunningServer running_;
  test::HttpClient client_ = running_.client();
};

TEST_F(SimulationsApi, TheTagOfATopologyIsThatOfNoOtherLaunch) {
  const auto tag = [](const test::HttpClient& client, int cells) {
    json scene = falling_box;
    scene["bodies"][0]["lattice"]["cells"][0] = cells;
    const json made = client.send_json("POST", "/api/v1/simulations", scene).json();
    const std::string path = made["topology"], found = client.get(path).header("etag");
    EXPECT_EQ(client.get(path, {{"If-None-Match", found}}).status, 304);
    return path + found;
  };
  test::RunningServer other;
  EXPECT_EQ(tag(client_, 2), tag(other.client(), 2));
  EXPECT_NE(tag(client_, 1), tag(other.client(), 3));
}

TEST_F(SimulationsApi, WhileAllAreInUseAnotherIsAskedToComeBack) {
  std::vector<std::string> playing;
  HttpResponse response;
  const auto ask = [&] {
    return client_.send_json("POST", "/api/v1/simulations?state=playing", falling_box);
  };
  for (response = ask(); response.status == 201 && playing.size() < 100; response = ask())
    playing.push_back("/api/v1/simulations/" + response.json()["id"].get<std::string>());
  EXPECT_EQ(response.status, 503) << response.body;
  EXPECT_EQ(response.json()["code"], "busy");
  EXPECT_EQ(response.header("retry-after"), "1");
  EXPECT_EQ(patch(playing.front(), {{"state", "paused"}}).status, 200);
  EXPECT_EQ(ask().status, 201);
  EXPECT_EQ(client_.get(playing.front()).status, 410);
}

TEST_F(SimulationsApi, ASceneStartsPausedWithItsPlan) {
  const HttpResponse response = client_.send_json("POST", "/api/v1/simulations", falling_box);
  const json simulation = response.json();
  EXPECT_EQ(response.header("location"), "/api/v1/simulations/" + simulation["id"].get<std::string>());
  EXPECT_EQ(simulation["state"], "paused");
  EXPECT_EQ(simulation["seq"], 0);
  EXPECT_EQ(simulation["name"], "fall");
  bool absent_with_reason = false;
  for (const json& phase : simulation["plan"])
    absent_with_reason |= !phase["included"].get<bool>() && !phase["reason"].get<std::string>().empty();
  EXPECT_TRUE(absent_with_reason);
}

TEST(SimulationsInLittleMemory, TheOldestGivesWayAndWhatDoesNotFitIsRefused) {
  ServeOptions options;
  options.memory_limit = std::int64_t{64} << 20;
  test::RunningServer running(options);
  test::HttpClient client = running.client();
  const auto post = [&](int cells, const std::string& state) {
    json scene = falling_box;
    scene["bodies"][0]["lattice"]["cells"] = {cells, cells, cells};
    return client.send_json("POST", "/api/v1/simulations?wait_ms=10000&state=" + state, scene);
  };
  EXPECT_EQ(post(16, "paused").status, 201);
  EXPECT_EQ(post(16, "playing").status, 201);
  for (int more = 0; more < 6; ++more) EXPECT_EQ(post(16, "paused").status, 201);
  EXPECT_EQ(client.get("/api/v1/simulations/s1").status, 410);
  EXPECT_EQ(client.get("/api/v1/simulations/s2").status, 200) << "it plays";
  EXPECT_EQ(client.get("/api/v1/simulations/s8").status, 200);
  const HttpResponse refused = post(64, "paused");
  EXPECT_EQ(refused.status, 422);
  EXPECT_EQ(refused.json()["code"], "over_budget");
  EXPECT_NE(refused.json()["hint"].get<std::string>().find("take at most"), std::string::npos);
}

TEST_F(SimulationsApi, ARunGoesOnWithOtherBodies) {
  const std::string path = create(falling_box);
  client_.send_json("POST", path + "/steps", {{"count", 6}});
  json scene = falling_box;
  scene["bodies"][1]["shape"]["sphere"]["radius"] = 0.7;
  const std::string id = path.substr(path.rfind('/') + 1), next = create(scene, "?continues=" + id);
  EXPECT_EQ(client_.get(next).json()["seq"], 6);
  EXPECT_EQ(client_.get(next + "/frames/6?encoding=f64").json()["bodies"],
            client_.get(path + "/frames/6?encoding=f64").json()["bodies"]);
  client_.send("DELETE", path);
  EXPECT_EQ(client_.send("POST", next + "/steps").json()["seq"], 7);
  patch(next, {{"restart", true}});
  EXPECT_EQ(client_.get(next).json()["seq"], 0);
  EXPECT_EQ(client_.send_json("POST", "/api/v1/simulations?continues=s999", scene).status, 404);
}

TEST_F(SimulationsApi, StepsAreFramesAndCanBeReadAgain) {
  const std::string path = create(falling_box);
  const HttpResponse stepped = client_.send_json("POST", path + "/steps", {{"count", 6}});
  EXPECT_EQ(stepped.json()["seq"], 6);
  EXPECT_EQ(client_.send("POST", path + "/steps").json()["seq"], 7);
  const json first = client_.get(path + "/frames/0?encoding=f64").json();
  const json sixth = client_.get(path + "/frames/6?encoding=f64").json();
  EXPECT_DOUBLE_EQ(sixth["t"].get<double>(), 0.1);
  const auto start = test::decode_typed_array<double>(first["bodies"][0]["positions"]);
  const auto later = test::decode_typed_array<double>(sixth["bodies"][0]["positions"]);
  EXPECT_LT(later[1], start[1]) << "it falls";
  EXPECT_EQ(client_.get(path + "/frames/8").status, 404);
  EXPECT_EQ(client_.get(path + "/frames/x").status, 404);
}

TEST_F(SimulationsApi, PlayPauseRestart) {
  const std::string path = create(falling_box, "?pace=fast");
  StreamReader stream(client_, path + "/frames");
  EXPECT_EQ(stream.next_line()["type"], "hello");
  EXPECT_EQ(patch(path, {{"state", "playing"}}).json()["state"], "playing");
  while (stream.next_of_type("frame")["seq"] < 5) {
  }
  const json paused = patch(path, {{"state", "paused"}}).json();
  EXPECT_EQ(paused["state"], "paused");
  EXPECT_EQ(client_.get(path).json()["seq"], paused["seq"]);
  const json restarted = patch(path, {{"restart", true}}).json();
  EXPECT_EQ(restarted["seq"], 0);
  EXPECT_EQ(client_.send_json("POST", path + "/steps", {{"count", 1}}).json()["seq"], 1);
}

TEST_F(SimulationsApi, AChangeThatALongStepHoldsUpIsAccepted) {
  json scene = falling_box;
  scene["bodies"][0]["lattice"]["cells"] = {8, 8, 8};
  scene["solver"] = {{"substeps", 256}};
  const std::string path = create(scene, "?pace=fast&state=playing");
  const HttpResponse accepted = patch(path + "?wait_ms=0", {{"state", "paused"}});
  EXPECT_EQ(accepted.status, 202);
  EXPECT_EQ(accepted.json()["state"], "playing");
  const HttpResponse taken = patch(path + "?wait_ms=60000", {{"state", "paused"}});
  EXPECT_EQ(taken.status, 200);
  EXPECT_EQ(taken.json()["state"], "paused");
  EXPECT_EQ(client_.send("POST", path + "/steps?wait_ms=0").status, 202);
  EXPECT_EQ(client_.send("POST", path + "/steps?wait_ms=60000").status, 200);
}

TEST_F(SimulationsApi, AreListedByAge) {
  json ids = json::array();
  for (int i = 1; i <= 11; ++i) {
    const std::string path = create(falling_box);
    ids.push_back(path.substr(path.rfind('/') + 1));
  }
  const json all = client_.get("/api/v1/simulations").json();
  json listed = json::array();
  for (const json& simulation : all["simulations"]) listed.push_back(simulation["id"]);
  EXPECT_EQ(listed, ids);
}

TEST_F(SimulationsApi, LiveChangesTakeEffectAndSurviveARestart) {
  const std::string path = create(falling_box);
  json changed = patch(path, {{"gravity", {0, 0, 0}}, {"solver", {{"tolerance", 1e-8}}}}).json();
  EXPECT_EQ(changed["gravity"], json({0.0, 0.0, 0.0}));
  EXPECT_EQ(changed["solver"]["tolerance"], 1e-8);
  EXPECT_EQ(changed["solver"]["volume"], "newton");
  for (const bool restart : {false, true}) {
    if (restart) patch(path, {{"restart", true}});
    client_.send_json("POST", path + "/steps", {{"count", 30}});
    const json metrics = client_.get(path).json()["metrics"];
    EXPECT_NEAR(metrics["linear_momentum"][1].get<double>(), 0.0, 1e-9) << "nothing pulls it down";
  }
  EXPECT_EQ(patch(path, {{"materials", {{{"body", 0}, {"edge_stiffness", 2e4}, {"diagonal_stiffness", 0}}}}})
                .status,
            200);
  EXPECT_EQ(
      patch(path, {{"materials", {{{"body", 7}, {"edge_stiffness", 1}, {"diagonal_stiffness", 1}}}}}).status,
      422);
  EXPECT_EQ(
      patch(path, {{"materials", {{{"body", 0}, {"edge_modulus", 1e5}, {"diagonal_modulus", 0}}}}}).status,
      200);
  EXPECT_EQ(patch(path, {{"materials", {{{"body", 0}, {"edge_modulus", 1e5}}}}}).status, 422);
  EXPECT_EQ(patch(path, {{"gravity", {0, 0}}}).status, 422);
  EXPECT_EQ(patch(path, {{"colour", "red"}}).status, 422);
}

TEST_F(SimulationsApi, AGrabPullsAndACollidersPoseIsTaken) {
  json scene = falling_box;
  scene["gravity"] = {0, 0, 0};
  const std::string path = create(scene);
  EXPECT_EQ(
      client_.send_json("PUT", path + "/grabs/mouse", {{"body", 0}, {"vertex", 0}, {"target", {0, 4, 0}}})
          .status,
      204);
  client_.send_json("POST", path + "/steps", {{"count", 20}});
  const auto frame = test::decode_typed_array<double>(
      client_.get(path + "/frames/20?encoding=f64").json()["bodies"][0]["positions"]);
  EXPECT_LT(frame[1], 5.0) << "pulled downwards";
  EXPECT_EQ(client_.send("DELETE", path + "/grabs/mouse").status, 204);
  EXPECT_EQ(
      client_.send_json("PUT", path + "/grabs/mouse", {{"body", 0}, {"vertex", 999}, {"target", {0, 0, 0}}})
          .status,
      422);
  EXPECT_EQ(
      client_.send_json("PUT", path + "/grabs/mouse", {{"body", 1}, {"vertex", 0}, {"target", {0, 0, 0}}})
          .status,
      422);

  EXPECT_EQ(client_.send_json("PUT", path + "/colliders/1", {{"position", {0, -1, 0}}}).status, 204);
  client_.send_json("POST", path + "/steps", {{"count", 2}});
  const json pose = client_.get(path + "/frames/22").json()["bodies"][1]["pose"];
  EXPECT_NEAR(pose[1].get<double>(), -1.0, 1e-9);
  EXPECT_EQ(client_.send_json("PUT", path + "/colliders/0", {{"position", {0, 0, 0}}}).status, 422);
  EXPECT_EQ(client_.send_json("PUT", path + "/colliders/x", {{"position", {0, 0, 0}}}).status, 422);
  EXPECT_EQ(
      client_
          .send_json("PUT", path + "/colliders/1", {{"position", {0, 0, 0}}, {"orientation", {0, 0, 0, 0}}})
          .status,
      422);
}

TEST_F(SimulationsApi, ARunThatEndsIsFinishedAndItsFramesStay) {
  json scene = falling_box;
  scene["duration"] = 0.1;
  const std::string path = create(scene, "?pace=fast&state=playing");
  StreamReader stream(client_, path + "/frames?pace=every&encoding=f64&topology=inline");
  const json hello = stream.next_line();
  EXPECT_EQ(hello["bodies"][0]["tets"].size(), 40U);
  std::int64_t expected = 0;
  for (json line = stream.next_line(); !line.is_null(); line = stream.next_line()) {
    if (line["type"] == "frame") {
      EXPECT_EQ(line["seq"], expected++);
    }
    if (line["type"] == "end") {
      EXPECT_EQ(line["reason"], "finished");
    }
  }
  EXPECT_EQ(expected, 7) << "frames 0 to 6, duration included";
  EXPECT_EQ(client_.get(path).json()["state"], "finished");
  EXPECT_EQ(client_.get(path + "/frames/6").status, 200);
  EXPECT_EQ(patch(path, {{"state", "playing"}}).status, 409);
  EXPECT_EQ(client_.send("POST", path + "/steps").status, 409);
}

TEST_F(SimulationsApi, ServerSentEventsCarryTheSameLines) {
  const std::string path = create(falling_box);
  StreamReader stream(client_, path + "/frames?encoding=array", {{"Accept", "text/event-stream"}});
  EXPECT_EQ(stream.head().header("content-type"), "text/event-stream");
  EXPECT_EQ(stream.next_text_line(), "event: hello");
  EXPECT_EQ(json::parse(stream.next_text_line().substr(6))["type"], "hello");
  EXPECT_EQ(stream.next_text_line(), "");
  while (stream.next_text_line() != "event: frame") {
  }
  EXPECT_EQ(stream.next_text_line(), "id: 0");
  EXPECT_TRUE(json::parse(stream.next_text_line().substr(6))["bodies"][0]["positions"][0].is_array());
  EXPECT_EQ(stream.next_text_line(), "");
}

TEST_F(SimulationsApi, WhoComesBackGetsTheRest) {
  json scene = falling_box;
  scene["duration"] = 0.1;
  const std::string path = create(scene, "?pace=fast&state=playing");
  while (client_.get(path).json()["state"] != "finished") {
  }
  const auto frames_after = [&](const std::string& last) {
    StreamReader stream(client_, path + "/frames?pace=every", {{"Last-Event-ID", last}});
    int frames = 0;
    for (json line = stream.next_line(); line["type"] != "end"; line = stream.next_line())
      frames += line["type"] == "frame" ? 1 : 0;
    return frames;
  };
  EXPECT_EQ(frames_after("4"), 2);
  EXPECT_EQ(frames_after("6"), 0);
  EXPECT_EQ(frames_after("9007199254740992"), 0) << "it was elsewhere";
  for (const std::string none : {"", "x", "4x", "-9223372036854775808", "9223372036854775807"})
    EXPECT_EQ(frames_after(none), 7) << none;
}

TEST_F(SimulationsApi, ADeletedSimulationEndsItsStreams) {
  const std::string path = create(falling_box);
  StreamReader stream(client_, path + "/frames");
  stream.next_of_type("frame");
  EXPECT_EQ(client_.send("DELETE", path).status, 204);
  EXPECT_EQ(stream.next_of_type("end")["reason"], "deleted");
  EXPECT_TRUE(stream.next_line().is_null());
  EXPECT_EQ(client_.get(path).status, 410);
  EXPECT_EQ(client_.get("/api/v1/simulations/s99").status, 404);
}

TEST_F(SimulationsApi, AMeshBecomesABodyByItsName) {
  const std::string mesh = client_.send("POST", "/api/v1/meshes?sample=cube").json()["id"];
  json scene = falling_box;
  scene["bodies"][0] = {
      {"name", "cube"}, {"type", "deformable"}, {"mesh", mesh}, {"meshing", {{"voxels", 32}, {"cells", 4}}}};
  const std::string path = create(scene, "?wait_ms=10000");
  const json topology = client_.get(path + "/topology").json();
  EXPECT_EQ(topology["bodies"][0]["embedded"]["positions"]["shape"][1], 3);
  scene["bodies"][0]["mesh"] = "../../etc/passwd";
  EXPECT_EQ(client_.send_json("POST", "/api/v1/simulations", scene).status, 422);
  scene["bodies"][0]["mesh"] = "meshes/cube.obj";
  EXPECT_EQ(client_.send_json("POST", "/api/v1/simulations?wait_ms=10000", scene).status, 201);
}

TEST_F(SimulationsApi, EverySampleSceneIsPrepared) {
  const json samples = client_.get("/api/v1/samples").json();
  EXPECT_GE(samples["scenes"].size(), 14U);
  for (const json& scene : samples["scenes"])
    client_.send("DELETE", create({{"sample", scene["name"]}}, "?wait_ms=10000"));
}

TEST_F(SimulationsApi, FaultyScenesAreNamedProblems) {
  const auto post = [&](const json& scene) {
    return client_.send_json("POST", "/api/v1/simulations", scene);
  };
  json scene = falling_box;
  scene["bodies"][0]["lattice"]["cells"] = {0, 2, 2};
  EXPECT_EQ(post(scene).status, 422);
  scene = falling_box;
  scene["colour"] = 1;
  EXPECT_EQ(post(scene).json()["errors"][0]["pointer"], "/colour");
  EXPECT_EQ(post({{"sample", "nothing"}}).status, 404);
  EXPECT_EQ(client_.send("POST", "/api/v1/simulations", "{", {{"Content-Type", "application/json"}}).status,
            400);
}

}  // namespace
}  // namespace isochor

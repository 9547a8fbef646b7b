#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>

#include "tests/support/running_server.h"
#include "tests/support/typed_array.h"

namespace isochor {
namespace {

using nlohmann::json;
using test::HttpResponse;

class Resources : public testing::Test {
 protected:
  explicit Resources(const ServeOptions& options = {}, const FrontLimits& limits = {})
      : running_(options, limits) {}
  std::string upload(const std::string& sample) {
    return client_.send("POST", "/api/v1/meshes?sample=" + sample).json()["id"];
  }
  json make_model(const std::string& mesh_id, const json& params) {
    const json job = client_.finish(
        client_.send_json("POST", "/api/v1/models", {{"mesh_id", mesh_id}, {"params", params}}).json());
    EXPECT_EQ(job["status"], "done") << job;
    return job["result"];
  }
  /// Of the first sample, made at the start.
  std::size_t warm_models() {
    for (;;) {
      const json jobs = client_.get("/api/v1/jobs").json()["jobs"];
      for (const json& job : jobs)
        if (job["kind"] == "warm" && job["status"] == "done") return 1;
    }
  }
  const json coarse_ = {{"voxels", 32}, {"cells", 8}};
  test::RunningServer running_;
  test::HttpClient client_ = running_.client();
};

TEST_F(Resources, AMeshIsKnownByItsContent) {
  std::ifstream file(ISOCHOR_SAMPLES "/meshes/cube.obj");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const HttpResponse first = client_.send("POST", "/api/v1/meshes?name=cube.obj", text);
  EXPECT_EQ(first.status, 201);
  const std::string id = first.json()["id"];
  EXPECT_EQ(first.header("location"), "/api/v1/meshes/" + id);
  EXPECT_EQ(client_.send("PUT", "/api/v1/meshes/other.obj", text).status, 200);
  EXPECT_EQ(client_.send("POST", "/api/v1/meshes?sample=cube").json()["id"], id);
  const json report = client_.get("/api/v1/meshes/" + id + "/report").json();
  EXPECT_EQ(report["closed"], true);
  EXPECT_NEAR(report["volume"].get<double>(), 1.0, 1e-12);
  const json geometry = client_.get("/api/v1/meshes/" + id + "/geometry").json();
  EXPECT_EQ(test::decode_typed_array<std::uint32_t>(geometry["triangles"]).size(),
            3 * report["triangles"].get<std::size_t>());
}

TEST_F(Resources, BadMeshesAreNamedProblems) {
  const auto code = [&](const std::string& query, const std::string& body) {
    const HttpResponse response = client_.send("POST", "/api/v1/meshes" + query, body);
    return std::to_string(response.status) + " " + response.json()["code"].get<std::string>();
  };
  EXPECT_EQ(code("?name=a.obj", "v 0 0 0\nf 1 2 9\n"), "422 cannot_read");
  EXPECT_EQ(code("?name=a.obj", "v 0 0 nan\n"), "422 cannot_read");
  EXPECT_EQ(code("?name=a.obj", ""), "422 empty_result");
  EXPECT_EQ(code("?name=a.xyz", "whatever"), "415 unsupported_format");
  EXPECT_EQ(code("", "whatever"), "415 unsupported_format");
  EXPECT_EQ(code("?sample=nothing", ""), "404 not_found");
}

TEST_F(Resources, AModelIsWhatItsPartsSay) {
  const json result = make_model(upload("cube"), coarse_);
  const std::string path = "/api/v1/models/" + result["model_id"].get<std::string>();
  const HttpResponse response = client_.get(path);
  for (const std::string& known : {response.header("etag"), "W/" + response.header("etag"), std::string("*")})
    EXPECT_EQ(client_.get(path, {{"If-None-Match", known}}).status, 304) << known;
  EXPECT_EQ(client_.get(path, {{"If-None-Match", "\"other\""}}).status, 200);
  EXPECT_EQ(client_.get("/api/v1/models/none", {{"If-None-Match", "*"}}).status, 404);
  const json model = response.json();
  EXPECT_EQ(model["params"]["voxels"], 32);
  std::vector<std::string> stages;
  for (const json& stage : model["stages"]) stages.push_back(stage["name"]);
  EXPECT_EQ(stages, (std::vector<std::string>{"distance_field", "pseudo_volume", "lattice", "tetrahedra",
                                              "smoothing", "embedding"}));

  const json tets = client_.get(path + "/tets").json();
  const auto positions = test::decode_typed_array<float>(tets["positions"]);
  const auto indices = test::decode_typed_array<std::uint32_t>(tets["tets"]);
  ASSERT_EQ(indices.size(), 4 * model["tets"].get<std::size_t>());
  double volume = 0.0;
  for (std::size_t t = 0; t < indices.size(); t += 4) {
    const auto at = [&](std::size_t corner) {
      const float* p = &positions[3 * indices[t + corner]];
      return Vec3(p[0], p[1], p[2]);
    };
    volume += tet_volume(at(0), at(1), at(2), at(3));
  }
  EXPECT_NEAR(volume, model["volume"].get<double>(), 1e-5);
  const json quality = client_.get(path + "/quality").json();
  const auto angles = test::decode_typed_array<float>(quality["min_dihedral_deg"]);
  EXPECT_NEAR(*std::min_element(angles.begin(), angles.end()), model["min_dihedral_deg"].get<double>(), 1e-3);
  const json embedding = client_.get(path + "/embedding").json();
  for (const std::int32_t tet : test::decode_typed_array<std::int32_t>(embedding["tet"]))
    EXPECT_LT(static_cast<std::size_t>(tet), indices.size() / 4);
}

TEST_F(Resources, FarFromTheOriginDoublesTellPointsApart) {
  constexpr double far = 1 << 22;  // single precision has halves there
  std::string obj;
  for (const int corner : {0, 1, 2, 3, 4, 5, 6, 7})
    obj += fmt::format("v {} {} {}\n", far + 0.25 * (corner & 1), 0.25 * (corner >> 1 & 1),
                       0.25 * (corner >> 2));
  obj += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
  const std::string mesh = client_.send("POST", "/api/v1/meshes?name=far.obj", obj).json()["id"];
  const json geometry = client_.get("/api/v1/meshes/" + mesh + "/geometry?encoding=f64").json();
  EXPECT_EQ(test::decode_typed_array<double>(geometry["positions"])[3], far + 0.25);
  const std::string model = make_model(mesh, coarse_)["model_id"];
  const json tets = client_.get("/api/v1/models/" + model + "/tets?encoding=f64").json();
  const auto positions = test::decode_typed_array<double>(tets["positions"]);
  double low = 2.0 * far, high = 0.0;
  for (std::size_t i = 0; i < positions.size(); i += 3)
    low = std::min(low, positions[i]), high = std::max(high, positions[i]);
  EXPECT_NEAR(high - low, 0.25, 0.05);
}

TEST_F(Resources, VoxelsAndRaysTellTheSame) {
  const json result = make_model(upload("cube"), coarse_);
  const std::string path = "/api/v1/models/" + result["model_id"].get<std::string>();
  const json all = client_.get(path + "/voxels?shell=false").json(),
             shell = client_.get(path + "/voxels").json();
  const auto inside = test::decode_typed_array<std::uint32_t>(all["index"]);
  EXPECT_EQ(inside.size(), all["inside_count"].get<std::size_t>());
  const auto outer = test::decode_typed_array<std::uint32_t>(shell["index"]);
  EXPECT_TRUE(std::includes(inside.begin(), inside.end(), outer.begin(), outer.end()));
  EXPECT_LT(outer.size(), inside.size());

  const json ray = client_.get(path + "/ray?point=0.01,0.01,0.01&direction=1,0,0").json();
  const auto flags = test::decode_typed_array<std::uint8_t>(ray["inside"]);
  ASSERT_EQ(flags.size(), all["grid"]["size"][0].get<std::size_t>());
  const auto positions = test::decode_typed_array<double>(ray["positions"]);
  const std::size_t picked = ray["picked"];
  EXPECT_NEAR(positions[3 * picked], 0.01, all["grid"]["spacing"].get<double>());
  EXPECT_EQ(client_.get(path + "/ray?point=99,0,0&direction=1,0,0").status, 422);
  EXPECT_EQ(client_.get(path + "/ray?point=0,0,0&direction=0,0,0").status, 422);
  EXPECT_EQ(client_.get(path + "/ray?point=0,0&direction=1,0,0").status, 422);
}

TEST_F(Resources, TheSameRequestIsTheSameModelAndWhatStaysIsReused) {
  const std::string mesh = upload("cube");
  const json first = make_model(mesh, coarse_), again = make_model(mesh, coarse_);
  EXPECT_EQ(first["model_id"], again["model_id"]);
  json params = coarse_;
  params["density"] = 0.4;
  const json other = make_model(mesh, params);
  EXPECT_NE(first["model_id"], other["model_id"]);
  EXPECT_EQ(other["model"]["stages"][0]["reused"], true);
  EXPECT_EQ(other["model"]["stages"][1]["reused"], true);
  EXPECT_EQ(other["model"]["stages"][2]["reused"], false);
}

TEST_F(Resources, APreviewIsCoarseWhereRaysAreCastAnewOrThereAreManyCells) {
  const std::string mesh = upload("cube");
  const auto preview = [&](const json& params, int cells = 32) {
    const json request = {
        {"mesh_id", mesh}, {"params", params}, {"quality", "preview"}, {"preview_cells", cells}};
    return client_.finish(client_.send_json("POST", "/api/v1/models", request).json())["result"];
  };
  const json moved = {{"voxels", 128}, {"cells", 16}, {"p_in_voxels", 2.0}, {"p_subs_voxels", 3.0}};
  make_model(mesh, {{"voxels", 128}, {"cells", 12}});
  EXPECT_EQ(preview({{"voxels", 128}, {"cells", 16}})["model"]["params"]["voxels"], 128);
  EXPECT_EQ(preview({{"voxels", 128}, {"cells", 48}})["model"]["params"]["cells"], 24);
  EXPECT_EQ(preview({{"voxels", 128}, {"cells", 48}}, 16)["model"]["params"]["cells"], 12);
  EXPECT_EQ(preview({{"voxels", 128}, {"cells", 16}, {"p_in_voxels", 1.2}})["model"]["params"]["voxels"], 64);
  const json coarse = preview(moved), exact = make_model(mesh, moved);
  EXPECT_EQ(coarse["model"]["params"]["voxels"], 64);
  EXPECT_EQ(coarse["model"]["params"]["p_in_voxels"], 1.0);
  EXPECT_EQ(exact["model"]["params"]["voxels"], 128);
  json asked = moved;
  asked.update({{"voxels", 64}, {"p_in_voxels", 1.0}, {"p_subs_voxels", 1.5}});
  EXPECT_NE(make_model(mesh, asked)["model_id"], coarse["model_id"]);  // whose voxels stand elsewhere
}

TEST_F(Resources, APreviewBringsItsDrawingAndLeavesOutWhatAsksTheInputAgain) {
  json request = {
      {"mesh_id", upload("cube")}, {"params", coarse_}, {"quality", "preview"}, {"drawing", true}};
  const json job = client_.send_json("POST", "/api/v1/models?wait_ms=10000", request).json();
  const json& result = job["result"];
  const std::string id = result["model_id"], path = "/api/v1/models/" + id;
  const json tets = client_.get(path + "/tets").json(), quality = client_.get(path + "/quality").json();
  for (const char* name : {"grid", "positions", "tets", "cells"}) EXPECT_EQ(job["drawing"][name], tets[name]);
  for (const char* name : {"min_dihedral_deg", "scaled_jacobian"})
    EXPECT_EQ(job["drawing"][name], quality[name]);
  EXPECT_FALSE(result["model"].contains("coverage"));
  EXPECT_FALSE(client_.get("/api/v1/jobs/" + job["id"].get<std::string>()).json().contains("drawing"));
  for (const char* what : {"/embedding", "/exports/embedding"}) {
    const HttpResponse answer = client_.get(path + what);
    EXPECT_EQ(answer.status, 409) << what;
    EXPECT_EQ(answer.json()["detail"], "a preview has no embedding") << answer.body;
  }
  const json scene = {{"bodies", {{{"name", "b"}, {"type", "deformable"}, {"mesh", id}}}}};
  const json refused =
      client_.finish(client_.send_json("POST", "/api/v1/simulations?wait_ms=10000", scene).json());
  EXPECT_TRUE(refused.dump().find("is a preview") != std::string::npos) << refused;
  request.erase("quality"), request.erase("drawing");
  const json whole = client_.finish(client_.send_json("POST", "/api/v1/models", request).json());
  EXPECT_NE(whole["result"]["model_id"], id);
  EXPECT_TRUE(whole["result"]["model"].contains("coverage"));
  request["quality"] = "preview";
  const json again = client_.finish(client_.send_json("POST", "/api/v1/models", request).json());
  EXPECT_EQ(again["result"]["model_id"], whole["result"]["model_id"]);  // which is there
}

TEST_F(Resources, CellsOfAPreviewAreFewAndOfPreviewsAlone) {
  const json request = {{"mesh_id", upload("cube")}, {"params", coarse_}};
  for (const json& more :
       {json{{"preview_cells", 16}}, json{{"quality", "preview"}, {"preview_cells", 33}}}) {
    json asked = request;
    asked.update(more);
    const HttpResponse refused = client_.send_json("POST", "/api/v1/models", asked);
    EXPECT_EQ(refused.status, 422) << asked;
    EXPECT_EQ(refused.json()["errors"][0]["pointer"], "/preview_cells") << refused.body;
  }
}

TEST_F(Resources, ADrawingIsOfPreviewsThatAreMade) {
  const json request = {{"mesh_id", upload("cube")}, {"params", coarse_}, {"drawing", true}};
  for (const json& more :
       {json::object(), json{{"quality", "full"}}, json{{"quality", "preview"}, {"dry_run", true}}}) {
    json asked = request;
    asked.update(more);
    const HttpResponse refused = client_.send_json("POST", "/api/v1/models", asked);
    EXPECT_EQ(refused.status, 422) << asked;
    EXPECT_EQ(refused.json()["errors"][0]["pointer"], "/drawing") << refused.body;
  }
}

TEST_F(Resources, FaultyParametersAreListedWithTheirRanges) {
  const HttpResponse response =
      client_.send_json("POST", "/api/v1/models",
                        {{"mesh_id", upload("cube")},
                         {"params", {{"voxels", 1e9}, {"cells", -1}, {"colour", "red"}}},
                         {"extra", 1}});
  EXPECT_EQ(response.status, 422);
  std::set<std::string> pointers;
  const json problem = response.json();
  for (const json& error : problem["errors"]) pointers.insert(error["pointer"]);
  for (const char* expected : {"/params/voxels", "/params/cells", "/params/colour", "/extra"})
    EXPECT_TRUE(pointers.contains(expected)) << expected << response.body;
  EXPECT_EQ(client_.send_json("POST", "/api/v1/models", json::object()).json()["errors"][0]["pointer"],
            "/mesh_id");
  EXPECT_EQ(client_.send_json("POST", "/api/v1/models", {{"mesh_id", "m0"}}).status, 404);
}

TEST_F(Resources, AQueryNamesWhatTheRouteKnowsOnce) {
  const auto first_error = [&](const std::string& path) {
    const HttpResponse response = client_.get(path);
    EXPECT_EQ(response.status, 422) << path;
    return response.json()["errors"][0];
  };
  const std::string job =
      client_.send_json("POST", "/api/v1/models", {{"mesh_id", upload("cube")}}).json()["id"];
  const json mistyped = first_error("/api/v1/jobs/" + job + "?wait=100");
  EXPECT_EQ(mistyped["pointer"], "?wait");
  EXPECT_EQ(mistyped["detail"], "is not known here; known are wait_ms");
  EXPECT_EQ(first_error("/api/v1/jobs/" + job + "?wait_ms=1&wait_ms=2")["pointer"], "?wait_ms");
  EXPECT_EQ(first_error("/api/v1/meshes?a")["pointer"], "?a");
}

TEST_F(Resources, AProblemDoesNotRepeatMegabytes) {
  const std::string long_text(1 << 19, 'a');
  for (const json& body : {json{{"mesh_id", long_text}}, json{{long_text, 1}}}) {
    const HttpResponse response = client_.send_json("POST", "/api/v1/models", body);
    EXPECT_GE(response.status, 400);
    EXPECT_LT(response.body.size(), 10'000U);
    EXPECT_FALSE(response.json()["detail"].get<std::string>().empty());
  }
}

TEST_F(Resources, MalformedJsonIsNamed) {
  const auto post = [&](const std::string& body) {
    return client_.send("POST", "/api/v1/models", body, {{"Content-Type", "application/json"}});
  };
  EXPECT_EQ(post("{").status, 400);
  EXPECT_EQ(post("").status, 400);
  EXPECT_EQ(post("[]").status, 422);
  EXPECT_EQ(post(std::string(100000, '[')).status, 400);
  EXPECT_EQ(post("{\"mesh_id\":" + std::string(100000, '[') + std::string(100000, ']') + "}").status, 400);
  EXPECT_EQ(post("{\"mesh_id\":\"\xff\"}").status, 400);
  EXPECT_EQ(post("{\"mesh_id\":1e999}").status, 400);
}

TEST_F(Resources, NamesAreAsLongAsFileSystemsLetThemBe) {
  const std::string file = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const std::string fits = std::string(251, 'n') + ".obj", too_long = 'n' + fits;
  EXPECT_EQ(client_.send("POST", "/api/v1/meshes?name=" + fits, file).json()["name"], fits);
  for (const auto& [method, path] :
       {std::pair{"POST", "/api/v1/meshes?name="}, std::pair{"PUT", "/api/v1/meshes/"}}) {
    const HttpResponse response = client_.send(method, path + too_long, file + "\n");
    EXPECT_EQ(response.status, 422) << method;
    EXPECT_EQ(response.json()["detail"], "the mesh's name is 256 bytes long");
    EXPECT_EQ(response.json()["hint"], "give a name of at most 255 bytes");
  }
}

TEST_F(Resources, AnEstimateCostsNothing) {
  const HttpResponse response = client_.send_json(
      "POST", "/api/v1/models", {{"mesh_id", upload("cube")}, {"params", coarse_}, {"dry_run", true}});
  EXPECT_EQ(response.status, 200);
  EXPECT_GT(response.json()["estimate"]["bytes"].get<double>(), 0.0);
}

TEST_F(Resources, ExportsAreFilesWithNames) {
  const json result = make_model(upload("cube"), coarse_);
  const std::string path = "/api/v1/models/" + result["model_id"].get<std::string>() + "/exports/";
  const HttpResponse msh = client_.get(path + "msh2");
  EXPECT_EQ(msh.header("content-disposition"), "attachment; filename=\"cube.msh\"");
  EXPECT_EQ(msh.body.find("$MeshFormat"), 0U);
  EXPECT_EQ(client_.get(path + "msh2").body, msh.body);
  const HttpResponse archive = client_.get(path + "tetgen");
  EXPECT_EQ(archive.header("content-type"), "application/x-tar");
  EXPECT_EQ(archive.body.substr(257, 5), "ustar");
  EXPECT_NE(archive.body.find(client_.get(path + "tetgen?file=.node").body), std::string::npos);
  EXPECT_EQ(client_.get(path + "tetgen?file=.exe").status, 404);
  EXPECT_EQ(client_.get(path + "nothing").status, 415);
}

TEST_F(Resources, WhatWasDeletedIsGone) {
  const json result = make_model(upload("cube"), coarse_);
  const std::string model = "/api/v1/models/" + result["model_id"].get<std::string>();
  EXPECT_EQ(client_.send("DELETE", model).status, 204);
  EXPECT_EQ(client_.get(model).status, 410);
  EXPECT_EQ(client_.send("DELETE", model).status, 410);
  EXPECT_EQ(client_.get("/api/v1/models/dffff").status, 404);
  EXPECT_EQ(client_.get("/api/v1/jobs/j999").status, 404);
}

/// A server whose memory a few models fill.
class Evicting : public Resources {
 protected:
  Evicting() : Resources(small(), patient()) {}

 private:
  static ServeOptions small() {
    ServeOptions options;
    options.memory_limit = 32 << 20;
    return options;
  }
  /// Readers that take nothing meanwhile are not dropped.
  static FrontLimits patient() {
    FrontLimits limits;
    limits.connection.stalled_write = limits.connection.whole_answer = std::chrono::hours(1);
    return limits;
  }
};

TEST_F(Evicting, WhatIsBeingReadIsReadToItsEnd) {
  const std::string model = make_model(upload("cube"), {{"voxels", 64}, {"cells", 24}})["model_id"];
  const std::string path = "/api/v1/models/" + model;
  std::map<std::string, std::string> whole;
  for (const char* part : {"/tets", "/voxels?shell=false", "/exports/vtk"})
    whole[path + part] = client_.get(path + part).body;
  std::vector<std::pair<std::string, test::RawSocket>> readers;
  for (int i = 0; i < 8; ++i)
    for (const auto& [part, body] : whole) {
      test::RawSocket& reader = readers.emplace_back(part, client_.port()).second;
      reader.shrink_receive_buffer(1 << 16);
      reader.send(client_.request("GET", part, "", {}));
    }
  std::vector<std::string> begun;
  for (auto& [part, reader] : readers) begun.push_back(reader.receive(1000));  // it is being sent
  const auto is_there = [&] { return client_.get("/api/v1/models").body.find(model) != std::string::npos; };
  for (int cells = 9; is_there() && cells < 28; ++cells)  // asked for itself, it would be the newest in use
    make_model(upload("cube"), {{"voxels", 36 + cells}, {"cells", cells}});
  EXPECT_EQ(client_.get(path).status, 410);
  for (std::size_t i = 0; i < readers.size(); ++i) {
    auto& [part, reader] = readers[i];
    EXPECT_GT(whole[part].size(), 500000U) << part;
    EXPECT_TRUE(test::parse_response(begun[i] + reader.receive_all()).body == whole[part]) << part;
  }
}

TEST_F(Resources, TheNewestRequestCancelsTheOneUnderWay) {
  const std::string mesh = upload("tree");
  const auto post = [&] {
    const json request{{"mesh_id", mesh}, {"params", {{"voxels", 400}, {"cells", 150}}}};
    return client_.send_json("POST", "/api/v1/models", request).json()["id"].get<std::string>();
  };
  const std::string first = post();
  json running;
  do running = client_.get("/api/v1/jobs/" + first).json();
  while (running["status"] == "queued" || running["phase"] == "");
  const json newest =
      client_.finish(client_
                         .send_json("POST", "/api/v1/models",
                                    {{"mesh_id", mesh}, {"params", coarse_}, {"supersedes", first}})
                         .json());
  EXPECT_EQ(newest["status"], "done") << "it did not have to wait for the other";
  const json old = client_.get("/api/v1/jobs/" + first).json();
  EXPECT_EQ(old["status"], "cancelled");
  EXPECT_EQ(old["problem"]["code"], "cancelled");
  const std::size_t warm = warm_models();  // waits until there is one
  EXPECT_EQ(client_.get("/api/v1/models").json()["models"].size(), 1U + warm);

  const std::string stopped = post();
  EXPECT_EQ(client_.send("DELETE", "/api/v1/jobs/" + stopped).json()["status"], "cancelled");
}

TEST(Memory, TheOldestUnusedModelGivesWayAndTheAnswerSaysSo) {
  ServeOptions options;
  options.memory_limit = std::int64_t{24} << 20;
  test::RunningServer running(options);
  const test::HttpClient client = running.client();
  const std::string mesh = client.send("POST", "/api/v1/meshes?sample=cube").json()["id"];
  std::string first;
  for (int cells = 8; cells < 24; ++cells) {
    const json job =
        client.finish(client
                          .send_json("POST", "/api/v1/models",
                                     {{"mesh_id", mesh}, {"params", {{"voxels", 48}, {"cells", cells}}}})
                          .json());
    ASSERT_EQ(job["status"], "done") << job;
    const std::string path = "/api/v1/models/" + job["result"]["model_id"].get<std::string>();
    EXPECT_EQ(client.get(path).status, 200) << "the newest stays";
    if (first.empty()) first = path;
  }
  const HttpResponse gone = client.get(first);
  EXPECT_EQ(gone.status, 410);
  EXPECT_EQ(gone.json()["code"], "gone");
  EXPECT_FALSE(gone.json()["hint"].get<std::string>().empty());
  EXPECT_LT(client.get("/api/v1/models").json()["models"].size(), 16U);
}

TEST_F(Resources, TheTableDescribesItself) {
  const json document = client_.get("/api/v1/openapi.json").json();
  std::size_t operations = 0;
  for (const auto& [path, methods] : document["paths"].items()) operations += methods.size();
  EXPECT_EQ(operations, running_.server().routes().size());
  for (const Route& route : running_.server().routes())
    EXPECT_TRUE(document["paths"].contains(std::string(route.pattern))) << route.pattern;
  EXPECT_NE(client_.get("/api/v1/docs").body.find("/api/v1/simulations/{id}/frames"), std::string::npos);
  for (const std::string path :
       {"/api/v1/parameters", "/api/v1/formats", "/api/v1/version", "/api/v1/samples", "/api/v1/meshes",
        "/api/v1/models", "/api/v1/jobs", "/api/v1/simulations"})
    EXPECT_EQ(client_.get(path).status, 200) << path;
  const HttpResponse wrong = client_.send("PATCH", "/api/v1/models");
  EXPECT_EQ(wrong.status, 405);
  EXPECT_EQ(wrong.header("allow"), "GET, HEAD, POST");
  EXPECT_EQ(client_.send("HEAD", "/api/v1/health").body, "");
}

TEST_F(Resources, AssetsAreCompressedOnceAndTagged) {
  const HttpResponse plain = client_.get("/main.js"),
                     small = client_.get("/main.js", {{"Accept-Encoding", "gzip, br"}});
  EXPECT_EQ(small.header("content-encoding"), "gzip");
  EXPECT_EQ(small.body.substr(0, 2), "\x1f\x8b");
  EXPECT_LT(small.body.size(), plain.body.size());
  EXPECT_EQ(client_.get("/main.js", {{"If-None-Match", plain.header("etag")}}).status, 304);
  EXPECT_EQ(plain.header("content-type"), "text/javascript; charset=utf-8");
}

}  // namespace
}  // namespace isochor

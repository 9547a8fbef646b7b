#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <set>

#include "tests/support/running_server.h"

namespace isochor {
namespace {

using nlohmann::json;
using test::HttpResponse;

/// Free fall: every solver and step is exact, so the times differ and the errors are round-off.
json falling_box(double duration) {
  return {{"name", "fall"},
          {"duration", duration},
          {"bodies",
           {{{"name", "box"},
             {"type", "deformable"},
             {"lattice", {{"cells", {2, 2, 2}}, {"cell_size", 0.25}, {"origin", {0, 5, 0}}}}}}}};
}

class ReportsApi : public testing::Test {
 protected:
  HttpResponse post(const json& request) { return client_.send_json("POST", "/api/v1/reports", request); }
  /// Follows a job until its result has a point.
  json wait_for_a_point(const std::string& id) {
    for (;;) {
      json job = client_.get("/api/v1/jobs/" + id).json();
      if (job["result"].is_object() && !job["result"]["report"]["points"].empty()) return job;
      EXPECT_EQ(job["problem"], nullptr);
    }
  }
  /// Minutes of work, a point in milliseconds.
  const json endless_ = {{"kind", "scene"},
                         {"scene", falling_box(20.0)},
                         {"axes", {{"substeps", {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}}}},
                         {"refinement", 1},
                         {"repeats", 20}};

  test::RunningServer running_;
  test::HttpClient client_ = running_.client();
};

TEST_F(ReportsApi, AScenesErrorsAndTimesComeAsData) {
  const json job = client_.finish(post({{"kind", "scene"},
                                        {"scene", falling_box(0.2)},
                                        {"axes",
                                         {{"solvers", {"newton", "scaling"}},
                                          {"substeps", {1, 4}},
                                          {"tolerances", json::array()},
                                          {"resolutions", json::array()}}},
                                        {"refinement", 2},
                                        {"repeats", 2},
                                        {"budget_ms", 1000}})
                                      .json());
  ASSERT_EQ(job["status"], "done") << job;
  EXPECT_EQ(job["kind"], "report");
  const json report = job["result"]["report"];
  EXPECT_EQ(report["complete"], true);
  ASSERT_EQ(report["points"].size(), 4U);
  for (const json& point : report["points"]) {
    EXPECT_EQ(point["outcome"], "converged");
    EXPECT_LT(point["errors"]["trajectory_max"].get<double>(), 1e-9) << "free fall is exact";
    EXPECT_GT(point["ms_per_step"]["median"].get<double>(), 0.0);
    EXPECT_LE(point["ms_per_step"]["min"], point["ms_per_step"]["max"]);
  }
  for (const auto& [field, front] : report["fronts"].items()) EXPECT_FALSE(front.empty()) << field;
  EXPECT_EQ(report["reference"]["settings"]["substeps"], 8);
}

TEST_F(ReportsApi, ABudgetGetsTheSmallestErrorThatFits) {
  json request{{"kind", "scene"},
               {"scene", falling_box(0.1)},
               {"axes", {{"solvers", {"newton"}}, {"substeps", {1, 2}}}},
               {"refinement", 4},
               {"repeats", 1},
               {"budget_ms", 1e5}};
  const json report = client_.finish(post(request).json())["result"]["report"];
  double least = 1e300;
  for (const json& point : report["points"])
    least = std::min(least, point["errors"]["trajectory_rms"].get<double>());
  const json& chosen = report["points"][report["proposal"]["point"].get<std::size_t>()];
  EXPECT_EQ(chosen["errors"]["trajectory_rms"], least);
  EXPECT_EQ(chosen["settings"]["substeps"], report["proposal"]["solver"]["substeps"]);

  const std::string path =
      "/api/v1/simulations/" +
      client_.send_json("POST", "/api/v1/simulations", falling_box(0.1)).json()["id"].get<std::string>();
  const HttpResponse taken = client_.send_json("PATCH", path, {{"solver", report["proposal"]["solver"]}});
  EXPECT_EQ(taken.json()["solver"]["substeps"], chosen["settings"]["substeps"]);

  request["budget_ms"] = 0.001;
  EXPECT_EQ(client_.finish(post(request).json())["result"]["report"]["proposal"], nullptr);
}

TEST_F(ReportsApi, MeshingIsMeasuredOverItsGrid) {
  const std::string mesh = client_.send("POST", "/api/v1/meshes?sample=cube").json()["id"];
  const json report = client_.finish(
      post({{"kind", "mesh"},
            {"mesh_id", mesh},
            {"axes",
             {{"voxels", {32}}, {"cells", {6, 12}}, {"smoothing_iterations", {0}}, {"p_in_voxels", {4}}}},
            {"repeats", 1},
            {"budget_ms", 1e5}})
          .json())["result"]["report"];
  ASSERT_EQ(report["points"].size(), 2U);
  EXPECT_LT(report["points"][0]["tets"], report["points"][1]["tets"]);
  for (const json& point : report["points"]) EXPECT_LT(point["errors"]["volume"].get<double>(), 0.3);
  EXPECT_EQ(report["proposal"]["params"]["voxels"], 32);
}

TEST_F(ReportsApi, ANumberOfTetsChoosesTheLattice) {
  json request{{"mesh_id", client_.send("POST", "/api/v1/meshes?sample=sphere").json()["id"]},
               {"params", {{"voxels", 48}}}};
  const auto tets = [&] {
    return client_
        .finish(client_.send_json("POST", "/api/v1/models", request).json())["result"]["model"]["tets"]
        .get<int>();
  };
  constexpr int wanted = 2500;
  int closest = 1 << 30;
  for (const int cells : {8, 10, 12, 14, 16}) {
    request["params"]["cells"] = cells;
    closest = std::min(closest, std::abs(tets() - wanted));
  }
  request["budget_tets"] = wanted;
  EXPECT_EQ(std::abs(tets() - wanted), closest);
}

TEST_F(ReportsApi, WhenTooManyWaitOneIsAskedToComeBack) {
  std::vector<std::string> ids;
  HttpResponse response;
  for (response = post(endless_); response.status == 202 && ids.size() < 1000; response = post(endless_))
    ids.push_back(response.json()["id"]);
  EXPECT_EQ(response.status, 503);
  EXPECT_EQ(response.json()["code"], "busy");
  EXPECT_EQ(response.header("retry-after"), "1");
  for (const std::string& id : ids) client_.send("DELETE", "/api/v1/jobs/" + id);
}

TEST_F(ReportsApi, ACancelledReportKeepsWhatIsDone) {
  const HttpResponse response = post(endless_);
  EXPECT_EQ(response.status, 202);
  const std::string id = response.json()["id"];
  EXPECT_EQ(response.header("location"), "/api/v1/jobs/" + id);
  const json running = wait_for_a_point(id);
  EXPECT_EQ(running["status"], "running");
  EXPECT_GT(running["fraction"].get<double>(), 0.0);
  EXPECT_LT(running["fraction"].get<double>(), 1.0);
  EXPECT_EQ(running["result"]["report"]["complete"], false);
  const json cancelled = client_.send("DELETE", "/api/v1/jobs/" + id).json();
  EXPECT_EQ(cancelled["status"], "cancelled");
  EXPECT_EQ(cancelled["problem"]["code"], "cancelled");
  EXPECT_GE(cancelled["result"]["report"]["points"].size(), running["result"]["report"]["points"].size());
}

TEST_F(ReportsApi, ReportsStandInALineOfTheirOwn) {
  const std::string first = post(endless_).json()["id"];
  wait_for_a_point(first);
  const std::string second = post(endless_).json()["id"];
  const std::string mesh = client_.send("POST", "/api/v1/meshes?sample=cube").json()["id"];
  const json model =
      client_.finish(client_
                         .send_json("POST", "/api/v1/models",
                                    {{"mesh_id", mesh}, {"params", {{"voxels", 32}, {"cells", 8}}}})
                         .json());
  EXPECT_EQ(model["status"], "done") << "a model does not wait for reports";
  EXPECT_EQ(client_.get("/api/v1/jobs/" + second).json()["status"], "queued");
  json newest = endless_;
  newest["supersedes"] = first;
  const std::string third = post(newest).json()["id"];
  EXPECT_EQ(client_.finish(client_.get("/api/v1/jobs/" + first).json())["status"], "cancelled");
  for (const std::string& id : {second, third})
    EXPECT_EQ(client_.send("DELETE", "/api/v1/jobs/" + id).json()["status"], "cancelled");
}

TEST_F(ReportsApi, FaultsAreNamedBeforeAnythingRuns) {
  const auto pointers = [&](const json& request) {
    const HttpResponse response = post(request);
    EXPECT_EQ(response.status, 422) << response.body;
    std::set<std::string> found;
    for (const json& error : response.json().value("errors", json::array())) found.insert(error["pointer"]);
    return found;
  };
  using Set = std::set<std::string>;
  EXPECT_EQ(pointers(json::object()), (Set{"/kind", "/scene"}));
  EXPECT_EQ(pointers({{"kind", "scene"}, {"colour", 1}, {"sample", "drop"}, {"repeats", 0}}),
            (Set{"/colour", "/repeats"}));
  json scene = falling_box(0.1);
  scene["bodies"][0]["colour"] = "red";
  EXPECT_EQ(pointers({{"kind", "scene"}, {"scene", scene}}), (Set{"/scene/bodies/0/colour"}));
  scene = falling_box(0.1);
  scene["duration"] = nullptr;
  EXPECT_EQ(pointers({{"kind", "scene"}, {"scene", scene}}), (Set{"/duration"}));
  scene["duration"] = 1e9;
  EXPECT_EQ(pointers({{"kind", "scene"}, {"scene", scene}}), (Set{"/duration"})) << "it would not fit";
  json axes{{"solvers", {"newton", "magic"}}, {"substeps", {1.5}}, {"tolerances", {0}}, {"colours", {1}}};
  EXPECT_EQ(pointers({{"kind", "scene"}, {"scene", falling_box(0.1)}, {"axes", axes}}),
            (Set{"/axes/solvers/1", "/axes/substeps/0", "/axes/tolerances/0", "/axes/colours"}));
  json long_axis = json::array();
  for (int i = 1; i <= 30; ++i) long_axis.push_back(i);
  EXPECT_EQ(pointers({{"kind", "scene"},
                      {"scene", falling_box(0.1)},
                      {"axes", {{"substeps", long_axis}, {"tolerances", json(30, 1e-3)}}}}),
            (Set{"/axes"}));
  EXPECT_EQ(post({{"kind", "scene"}, {"sample", "nothing"}}).status, 404);
  EXPECT_EQ(post({{"kind", "mesh"}, {"mesh_id", "m0"}}).status, 404);
  EXPECT_TRUE(client_.get("/api/v1/jobs").json()["jobs"].size() <= 1) << "only the first model's own";
}

}  // namespace
}  // namespace isochor

// What is asked of the daemon, without a socket: docs/control-api.md.
#include "daemon/control_api.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <semaphore>
#include <thread>

#include "tests/daemon/fake_bench.h"
#include "tests/daemon/slow_names.h"

namespace gyrobench::daemon {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Not;

constexpr const char* kTurnAMinute = "bench.turn{ axis='inner', angle_deg=90, rate_deg_s=1.5 }";

// Whatever is asked, the answer is JSON.
json BodyOf(const HttpReply& reply) {
  json body = json::parse(reply.body, nullptr, false);
  EXPECT_FALSE(body.is_discarded()) << reply.body;
  return body;
}

void ExpectError(const HttpReply& reply, unsigned status, const std::string& code) {
  EXPECT_EQ(reply.status, status) << reply.body;
  EXPECT_EQ(BodyOf(reply)["error"]["code"], code) << reply.body;
  EXPECT_NE(BodyOf(reply)["error"]["message"], "");
}

class ControlApiTest : public testing::Test {
 protected:
  std::string StateNow() { return BodyOf(bench_.Ask("GET", "/v1/status"))["state"]; }
  void StartMinuteLongTurn() {
    bench_.Script("turn", kTurnAMinute);
    ASSERT_EQ(bench_.Ask("POST", "/v1/runs", R"({"procedure": "turn"})").status, 201u);
    ASSERT_TRUE(bench_.InnerTurns());
  }

  FakeBench bench_;
};

TEST_F(ControlApiTest, DevicesWithoutALineHaveNoFiguresOfOne) {
  const HttpReply reply = bench_.Ask("GET", "/v1/bus");
  EXPECT_EQ(reply.status, 200u);
  EXPECT_EQ(BodyOf(reply), (json{{"buses", json::array()}}));
}

TEST_F(ControlApiTest, StatusOfAnIdleBenchNamesItsDevicesAndNoRun) {
  const HttpReply reply = bench_.Ask("GET", "/v1/status");
  EXPECT_EQ(reply.status, 200u);
  const json status = BodyOf(reply);
  EXPECT_EQ(status["state"], "idle");
  EXPECT_EQ(status["stand"], "fakes");
  EXPECT_TRUE(status["run"].is_null());
  EXPECT_TRUE(status["fault"].is_null());
  std::vector<std::string> names;
  for (const json& device : status["devices"]) {
    names.push_back(device["name"]);
    EXPECT_TRUE(device["ok"]) << device;
  }
  EXPECT_THAT(names, IsSupersetOf({"axis.inner", "encoder.outer", "gyro", "relays"}));
  EXPECT_EQ(status["outputs"], json({{"fan", false}, {"heater", false}}));
}

TEST_F(ControlApiTest, ARunIsCheckedMadeAndToldOf) {
  bench_.Script("there", "bench.turn{ axis='inner', angle_deg=20, rate_deg_s=10 }");
  const json plan = BodyOf(bench_.Ask("POST", "/v1/check", R"({"procedure": "there"})"));
  EXPECT_EQ(plan["moves"].size(), 1u);
  EXPECT_EQ(plan["moves"][0]["to_deg"], 20.0);
  EXPECT_THAT(bench_.CallsOf("inner"), Each(Not(HasSubstr("move"))));

  const HttpReply started = bench_.Ask("POST", "/v1/runs", R"({"procedure": "there"})");
  EXPECT_EQ(started.status, 201u);
  EXPECT_EQ(StateNow(), "preparing");
  ASSERT_TRUE(bench_.InnerTurns());
  EXPECT_EQ(StateNow(), "running");
  bench_.Ended();
  const json run = BodyOf(bench_.Ask("GET", "/v1/status"))["run"];
  EXPECT_EQ(run["run_id"], BodyOf(started)["run_id"]);
  EXPECT_EQ(run["outcome"], "done");
  EXPECT_EQ(run["progress"], 1.0);
}

TEST_F(ControlApiTest, WhatIsWrongWithARequestIsSaidByItsCode) {
  bench_.Script("far", "bench.turn{ axis='inner', angle_deg=720, rate_deg_s=10 }");
  bench_.Script("fine", "bench.rest{ duration_s=1 }");
  ExpectError(bench_.Ask("GET", "/v1/nothing"), 404, "no_such_request");
  ExpectError(bench_.Ask("POST", "/v1/runs", "{"), 400, "bad_json");
  ExpectError(bench_.Ask("POST", "/v1/runs", "[]"), 422, "refused");
  ExpectError(bench_.Ask("POST", "/v1/runs", R"({"procedure": 3})"), 422, "refused");
  ExpectError(bench_.Ask("POST", "/v1/runs", R"({"procedure": "none"})"), 404, "no_such_procedure");
  ExpectError(bench_.Ask("POST", "/v1/runs", R"({"procedure": "fine", "parameters": {"x": 1}})"),
              422, "bad_parameter");
  ExpectError(bench_.Ask("POST", "/v1/runs", R"({"procedure": "far"})"), 422, "beyond_limit");
  ExpectError(bench_.Ask("POST", "/v1/pause"), 409, "wrong_state");
  ExpectError(bench_.Ask("POST", "/v1/answer", R"({"answer": "yes"})"), 409, "wrong_state");
  EXPECT_EQ(StateNow(), "idle");
  EXPECT_THAT(bench_.CallsOf("inner"), Each(Not(HasSubstr("move"))));
}

// It ended the daemon, and the axis went on.
TEST_F(ControlApiTest, BytesThatAreNoTextAreAnsweredInText) {
  bench_.Script("bad", "error('a\\xff')");
  const HttpReply of_script = bench_.Ask("POST", "/v1/check", R"({"procedure": "bad"})");
  for (const HttpReply& reply :
       {bench_.Ask("GET", "/v1/\xff"), bench_.Ask("\xff", "/v1/status"),
        bench_.Ask("POST", "/v1/runs", "\xff"), bench_.Ask("POST", "/v1/runs", "{\"\xff\": 1}"),
        bench_.Ask("POST", "/v1/runs", "{\"procedure\": \"\xff\"}"), of_script}) {
    EXPECT_GE(reply.status, 400u);
    EXPECT_NE(BodyOf(reply)["error"]["message"], "");
  }
  EXPECT_THAT(BodyOf(of_script)["error"]["message"].get<std::string>(),
              HasSubstr("bad.lua:3: a\xEF\xBF\xBD"));
}

TEST_F(ControlApiTest, StopEndsMotionWhateverStandsInItsBody) {
  for (const char* body : {"", "{}", "\xff", "[1]", "{"}) {
    StartMinuteLongTurn();
    const HttpReply reply = bench_.Ask("POST", "/v1/stop", body);
    EXPECT_EQ(reply.status, 200u) << reply.body;
    EXPECT_EQ(bench_.Ended().outcome, Outcome::kAborted);
    EXPECT_THAT(bench_.CallsOf("inner"), Contains("stop"));
    const double stopped_deg = bench_.devices.drives.at("inner")->AngleDeg();
    EXPECT_LT(stopped_deg, 80.0);
    bench_.Wait(5.0);
    EXPECT_EQ(bench_.devices.drives.at("inner")->AngleDeg(), stopped_deg);
    bench_.acquisition->MoveBy(bench_.me(), "inner", -stopped_deg, 50.0, 100.0, [] {});
    bench_.Wait(3.0);
  }
}

TEST_F(ControlApiTest, StopWithoutARunTellsEveryDrive) {
  EXPECT_EQ(bench_.Ask("POST", "/v1/stop").status, 200u);
  bench_.Wait(1.0);
  EXPECT_THAT(bench_.CallsOfAll(), Each(Contains("stop")));
}

TEST_F(ControlApiTest, AStartThatCameBeforeAStopIsRefused) {
  bench_.Script("turn", kTurnAMinute);
  const std::int64_t stamp = bench_.Stamp();
  EXPECT_EQ(bench_.Ask("POST", "/v1/stop").status, 200u);
  ExpectError(bench_.AskLate(stamp, "/v1/runs", R"({"procedure": "turn"})"), 409, "wrong_state");
  bench_.Wait(60.0);
  EXPECT_THAT(bench_.CallsOf("inner"), Each(Not(HasSubstr("move"))));
  EXPECT_EQ(bench_.AskLate(bench_.Stamp(), "/v1/runs", R"({"procedure": "turn"})").status, 201u);
}

TEST_F(ControlApiTest, APausedRunGoesOn) {
  bench_.Script("rests", "for i = 1, 3 do bench.rest{ duration_s=5 } end");
  ASSERT_EQ(bench_.Ask("POST", "/v1/runs", R"({"procedure": "rests"})").status, 201u);
  bench_.Wait(30.0);
  EXPECT_EQ(bench_.Ask("POST", "/v1/pause").status, 200u);
  bench_.Wait(30.0);
  EXPECT_EQ(StateNow(), "paused");
  EXPECT_EQ(bench_.Ask("POST", "/v1/resume").status, 200u);
  EXPECT_EQ(bench_.Ended().outcome, Outcome::kDone);
}

TEST_F(ControlApiTest, WhatADeviceIsAndWhereAScriptIsAreFieldsOfAnError) {
  bench_.Script("far", "bench.turn{ axis='inner', angle_deg=720, rate_deg_s=10 }");
  const json far = BodyOf(bench_.Ask("POST", "/v1/runs", R"({"procedure": "far"})"))["error"];
  EXPECT_EQ(far["script"], json({{"file", "far.lua"}, {"line", 3}}));
  EXPECT_TRUE(far["device"].is_null());

  bench_.Script("fine", "bench.rest{ duration_s=1 }");
  drivers::FaultScript& faults = bench_.devices.encoders.at("outer")->faults();
  faults.fields = {.device = "axis.outer encoder", .action = "angle", .address = 7};
  faults.FailAlways("no answer");
  bench_.Wait(5.0);
  const json expected = {{"name", "axis.outer encoder"},
                         {"action", "angle"},
                         {"code_kind", nullptr},
                         {"code", nullptr},
                         {"address", 7}};
  const json silent = BodyOf(bench_.Ask("POST", "/v1/runs", R"({"procedure": "fine"})"))["error"];
  EXPECT_EQ(silent["code"], "device");
  EXPECT_EQ(silent["device"], expected);
  const json status = BodyOf(bench_.Ask("GET", "/v1/status"));
  for (const json& device : status["devices"]) {
    if (device["name"] == "encoder.outer") {
      EXPECT_EQ(device["failure"], expected);
    } else {
      EXPECT_TRUE(device["failure"].is_null()) << device;
    }
  }
}

TEST_F(ControlApiTest, AFaultIsShownUntilItIsReset) {
  StartMinuteLongTurn();
  bench_.devices.drives.at("inner")->SetAlarm(4);
  EXPECT_EQ(bench_.Ended().outcome, Outcome::kFault);
  const json status = BodyOf(bench_.Ask("GET", "/v1/status"));
  EXPECT_EQ(status["state"], "fault");
  EXPECT_THAT(status["fault"]["source"].get<std::string>(), HasSubstr("inner"));
  EXPECT_EQ(status["fault"]["device"]["code"], 4);
  EXPECT_EQ(status["fault"]["script"]["line"], 3);
  EXPECT_EQ(status["fault"]["last_samples"]["gyro"].size(), 20u);
  EXPECT_EQ(status["run"]["failures"][0], status["fault"]);
  ExpectError(bench_.Ask("POST", "/v1/runs", R"({"procedure": "turn"})"), 409, "wrong_state");
  EXPECT_EQ(bench_.Ask("POST", "/v1/reset").status, 200u);
  EXPECT_EQ(StateNow(), "idle");
}

// Of somebody who can connect and is not among those who may move the stand.
TEST_F(ControlApiTest, WhoMayOnlyLookLooksRehearsesAndStopsAndMovesNothing) {
  ControlApi api({bench_.stand, *bench_.clock, *bench_.time, *bench_.acquisition, *bench_.engine,
                  bench_.control, bench_.publisher, bench_.notices, Access({"@sys"})});
  const auto ask = [&api](const char* method, const char* path) {
    HttpRequest request{method, path, R"({"procedure": "turn", "answer": "yes"})"};
    request.peer = Peer{4711, 3'999'999'999u, 3'999'999'998u};
    return api.Handle(request);
  };
  bench_.Script("turn", kTurnAMinute);
  for (const char* path :
       {"/v1/runs", "/v1/pause", "/v1/resume", "/v1/abort", "/v1/answer", "/v1/reset"}) {
    const HttpReply reply = ask("POST", path);
    ExpectError(reply, 403, "not_permitted");
    EXPECT_THAT(reply.body, AllOf(HasSubstr("3999999999"), HasSubstr("4711"), HasSubstr("@sys")));
  }
  EXPECT_THAT(bench_.CallsOf("inner"), Each(Not(HasSubstr("move"))));
  EXPECT_EQ(ask("GET", "/v1/status").status, 200u);
  EXPECT_EQ(ask("GET", "/v1/procedures").status, 200u);
  EXPECT_EQ(ask("POST", "/v1/check").status, 200u);
  StartMinuteLongTurn();
  EXPECT_EQ(ask("POST", "/v1/abort").status, 403u);
  EXPECT_EQ(ask("POST", "/v1/stop").status, 200u);
  EXPECT_EQ(bench_.Ended().outcome, Outcome::kAborted);
}

// A directory service that hangs: it is asked for the name that is written to the log, by a thread
// that nobody waits for.
TEST_F(ControlApiTest, WhoStopsAbortsOrMovesWaitsForNobodysName) {
  std::binary_semaphore looked_up{0}, goes_on{0};
  std::atomic<bool> hangs = true;
  int in_my_thread = 0;
  const SlowNames names([&, me = std::this_thread::get_id()] {
    if (std::this_thread::get_id() == me) {
      ++in_my_thread;
    } else if (hangs.exchange(false)) {
      looked_up.release();
      goes_on.acquire();
    }
  });
  const LogLines log;
  {
    ControlApi api({bench_.stand, *bench_.clock, *bench_.time, *bench_.acquisition, *bench_.engine,
                    bench_.control, bench_.publisher, bench_.notices, Access({"@sys"})});
    const auto ask = [&api](const char* path) {
      HttpRequest request{"POST", path, R"({"procedure": "turn"})"};
      request.peer = Peer{4711, UserByName("daemon"), 3'999'999'998u, {GroupByName("sys")}};
      return api.Handle(request).status;
    };
    StartMinuteLongTurn();
    EXPECT_EQ(ask("/v1/stop"), 200u);
    EXPECT_TRUE(looked_up.try_acquire_for(std::chrono::minutes(1)));
    EXPECT_EQ(bench_.Ended().outcome, Outcome::kAborted);
    EXPECT_EQ(ask("/v1/runs"), 201u);
    EXPECT_EQ(ask("/v1/resume"), 409u);
    EXPECT_EQ(ask("/v1/abort"), 200u);
    EXPECT_EQ(bench_.Ended().outcome, Outcome::kAborted);
    EXPECT_EQ(in_my_thread, 0);
    goes_on.release();
  }
  EXPECT_THAT(log.text(), AllOf(HasSubstr("daemon (process 4711) asked for /v1/stop\n"),
                                HasSubstr("asked for /v1/resume: refused (409)\n")));
}

}  // namespace
}  // namespace gyrobench::daemon

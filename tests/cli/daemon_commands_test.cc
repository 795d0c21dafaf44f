// Commands that are one request, against a daemon that answers what the test says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/cli/child_process.h"
#include "tests/cli/fake_daemon.h"
#include "tests/temporary_folder.h"
#include "tests/words.h"

namespace gyrobench::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

class DaemonCommands : public testing::Test {
 protected:
  Finished Gyrobench(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), GYROBENCH_PROGRAM);
    arguments.insert(arguments.end(), {"--socket", socket_});
    return RunToEnd(arguments);
  }

  TemporaryFolder folder_;
  std::string socket_ = folder_ / "control.sock";
  FakeReply reply_;
  FakeDaemon daemon_{socket_, [this](const FakeRequest&) { return reply_; }};
};

json ExampleStatus() {
  return {{"state", "fault"},
          {"run",
           {{"run_id", "20260101-000000-scale"},
            {"procedure", "scale"},
            {"record", "/records/20260101-000000-scale"},
            {"state", "ended"},
            {"outcome", "fault"},
            {"message", "table stuck"}}},
          {"question", nullptr},
          {"fault",
           {{"source", "axis.inner"},
            {"message", "moved 8.71 deg, commanded 9.00 deg"},
            {"left", {"axis.inner: at 8.710 deg, at rest", "heater: off"}}}},
          {"devices",
           {{{"name", "axis.inner"},
             {"kind", "drive"},
             {"bus", "a"},
             {"unit", 3},
             {"ok", true},
             {"message", ""}},
            {{"name", "gyro"},
             {"kind", "gyro"},
             {"bus", "b"},
             {"unit", 21},
             {"ok", false},
             {"message", "silent"}}}},
          {"utime", 1},
          {"lcm",
           {{"url", "udpm://239.255.76.67:7667"},
            {"channel_prefix", "GYROBENCH"},
            {"ok", true},
            {"message", ""}}},
          {"version", "0.1.0"}};
}

TEST_F(DaemonCommands, StatusShowsFaultDevicesAndWhatToDo) {
  reply_.body = ExampleStatus();
  const Finished finished = Gyrobench({"status"});
  EXPECT_EQ(finished.status, 0);
  EXPECT_THAT(finished.out, HasSubstr("axis.inner: moved 8.71 deg"));
  EXPECT_THAT(finished.out, HasSubstr("left: axis.inner: at 8.710 deg, at rest"));
  EXPECT_THAT(finished.out, HasSubstr("left: heater: off"));
  EXPECT_THAT(finished.out, HasSubstr("gyrobench reset"));
  EXPECT_THAT(finished.out, HasSubstr("NOT OK"));
  EXPECT_THAT(finished.out, HasSubstr("silent"));
  // No colour where nobody looks.
  EXPECT_THAT(finished.out, Not(HasSubstr("\x1b")));
}

TEST_F(DaemonCommands, JsonIsTheDaemonsAnswer) {
  reply_.body = ExampleStatus();
  EXPECT_EQ(json::parse(Gyrobench({"status", "--json"}).out), reply_.body);
}

// Fields that a later daemon leaves out, or has not set yet, must not break the client.
TEST_F(DaemonCommands, StatusOfAFreshDaemonNeedsNoField) {
  reply_.body = {{"state", "idle"}, {"run", nullptr}};
  const Finished finished = Gyrobench({"status"});
  EXPECT_EQ(finished.status, 0);
  EXPECT_THAT(finished.out, HasSubstr("idle"));
}

TEST_F(DaemonCommands, ProceduresShowParametersWithUnitAndRange) {
  reply_.body = {{"procedures",
                  {{{"name", "scale"},
                    {"summary", "Scale factor by turns of the shaft"},
                    {"parameters",
                     {{{"name", "rate"},
                       {"type", "number"},
                       {"default", 9.0},
                       {"unit", "deg/s"},
                       {"min", 0.5},
                       {"max", 60.0},
                       {"help", "rate of the table"}}}},
                    {"problem", ""}}}}};
  const Finished finished = Gyrobench({"procedures"});
  EXPECT_EQ(finished.status, 0);
  EXPECT_THAT(finished.out, HasSubstr("rate  9 deg/s  0.5 .. 60  rate of the table"));
}

int Widest(const std::string& text) {
  int widest = 0;
  for (const std::string& line : Lines(text))
    widest = std::max(widest, static_cast<int>(line.size()));
  return widest;
}

TEST_F(DaemonCommands, LongTextsAreBrokenBetweenWordsAndStayInTheirColumn) {
  const std::string words =
      "one two three four five six seven eight nine ten eleven twelve "
      "thirteen fourteen fifteen sixteen seventeen eighteen nineteen";
  json status = ExampleStatus();
  status["fault"]["message"] = status["run"]["message"] = status["devices"][1]["message"] = words;
  reply_.body = status;
  const std::string shown = Gyrobench({"status"}).out;
  EXPECT_LE(Widest(shown), 100);
  EXPECT_THAT(Flat(shown), HasSubstr(words));
  reply_.body = {{"procedures",
                  {{{"name", "scale"},
                    {"summary", words + words},
                    {"parameters",
                     {{{"name", "rate"}, {"type", "number"}, {"default", 9.0}, {"help", words}}}},
                    {"problem", ""}}}}};
  const std::string procedures = Gyrobench({"procedures"}).out;
  EXPECT_LE(Widest(procedures), 100);
  EXPECT_THAT(Flat(procedures), HasSubstr(words));
  reply_.body = {{"duration_s", 10.0},
                 {"segments", 1},
                 {"moves", json::array()},
                 {"notes", {words + " " + words}}};
  EXPECT_LE(Widest(Gyrobench({"check", "scale"}).out), 100);
}

TEST_F(DaemonCommands, CheckTellsTimeAndMovesAndSendsTypedParameters) {
  const json move = {{"axis", "inner"}, {"angle_deg", 9.0}, {"rate_deg_s", 9.0}};
  reply_.body = {{"duration_s", 3725.0}, {"segments", 5}, {"moves", {move, move}}};
  const Finished finished = Gyrobench({"check", "scale", "-p", "turns=20", "-p", "rate=4.5", "-p",
                                       "axis=inner", "-p", "both=true"});
  EXPECT_EQ(finished.status, 0);
  EXPECT_THAT(finished.out, HasSubstr("1 h 02 min"));
  EXPECT_THAT(finished.out, HasSubstr("2 x  inner by 9 deg at 9 deg/s"));
  EXPECT_EQ(
      json::parse(daemon_.WaitForRequest("POST /v1/check")),
      (json{{"procedure", "scale"},
            {"parameters", {{"turns", 20}, {"rate", 4.5}, {"axis", "inner"}, {"both", true}}}}));
}

TEST_F(DaemonCommands, CheckTellsWhenTheOperatorIsNeededAndForWhat) {
  reply_.body = {{"duration_s", 3725.0},
                 {"segments", 5},
                 {"moves", json::array()},
                 {"questions",
                  {{{"at_s", 905.4}, {"text", "Fan on?"}, {"choices", {"done", "skip"}}},
                   {{"at_s", 3600.0},
                    {"text", "Fan off?"},
                    {"choices", json::array()},
                    {"configured_answer", "done"}}}}};
  const Finished finished = Gyrobench({"check", "thermal"});
  EXPECT_EQ(finished.status, 0);
  EXPECT_THAT(finished.out, HasSubstr("asks at about 15:05 min:s: Fan on? [done | skip]\n"));
  EXPECT_THAT(finished.out,
              HasSubstr("asks at about 60:00 min:s: Fan off? (the stand file answers: done)\n"));
}

TEST_F(DaemonCommands, CheckTellsWhyTheRunCannotBeginNow) {
  const json checked = {{"duration_s", 10.0}, {"segments", 1}, {"moves", json::array()}};
  for (const auto& [now, says] : std::vector<std::pair<json, std::string>>{
           {{{"state", "fault"},
             {"fault", {{"source", "axis.inner"}, {"message", "emergency stop"}}}},
            "in the state fault: axis.inner: emergency stop. When its cause is gone: gyrobench "
            "reset"},
           {{{"state", "disconnected"},
             {"devices",
              {{{"name", "gyro"}, {"ok", true}, {"message", ""}},
               {{"name", "relays"}, {"ok", false}, {"message", "no answer"}}}}},
            "the bench is disconnected: relays: no answer"},
           {{{"state", "paused"}, {"run", {{"run_id", "20260101-000000-bias"}}}},
            "the bench is paused: run 20260101-000000-bias is under way"}}) {
    reply_.body = checked;
    reply_.body.update(now);
    EXPECT_THAT(Flat(Gyrobench({"check", "scale"}).out), HasSubstr("cannot begin now, "));
    EXPECT_THAT(Flat(Gyrobench({"check", "scale"}).out), HasSubstr(says));
  }
  reply_.body = checked;
  reply_.body["state"] = "idle";
  EXPECT_THAT(Gyrobench({"check", "scale"}).out, Not(HasSubstr("cannot begin now")));
}

TEST_F(DaemonCommands, ResetTellsWhatKeepsARunFromBeginning) {
  reply_.body = {{"state", "disconnected"},
                 {"devices", {{{"name", "relays"}, {"ok", false}, {"message", "no answer"}}}}};
  const Finished finished = Gyrobench({"reset"});
  EXPECT_EQ(finished.status, 0);
  EXPECT_THAT(Flat(finished.out),
              HasSubstr("a run cannot begin: the bench is disconnected: relays: "
                        "no answer"));
}

TEST_F(DaemonCommands, StatusNamesTheInputsThatAct) {
  reply_.body = {{"state", "idle"},
                 {"axes",
                  {{{"name", "outer"}, {"reference_deg", 0.0}, {"inputs", json::array()}},
                   {{"name", "inner"}, {"reference_deg", 54.2}, {"inputs", {"limit +"}}}}}};
  EXPECT_THAT(Flat(Gyrobench({"status"}).out),
              HasSubstr("outer 0.00 deg, inner 54.20 deg (limit + input acts)"));
}

TEST_F(DaemonCommands, ARefusalNamesThePlaceAndEndsWithOne) {
  reply_ = Refusal(422, "limit", "turn of 400 deg: limit 360 deg", "scale.lua:12");
  const Finished finished = Gyrobench({"check", "scale"});
  EXPECT_EQ(finished.status, 1);
  EXPECT_THAT(finished.err, HasSubstr("scale.lua:12: turn of 400 deg: limit 360 deg"));
}

TEST_F(DaemonCommands, AMistypedProcedureOrParameterIsUsage) {
  for (const auto& [status, code] : std::vector<std::pair<unsigned, std::string>>{
           {404, "no_such_procedure"}, {422, "bad_parameter"}}) {
    reply_ = Refusal(status, code, "scale: parameter turns = 0: expected 1 .. 4000");
    const Finished finished = Gyrobench({"check", "scale", "-p", "turns=0"});
    EXPECT_EQ(finished.status, 2) << code;
    EXPECT_THAT(finished.err, HasSubstr("turns = 0: expected 1 .. 4000"));
  }
}

TEST_F(DaemonCommands, OperatorsCommandsPostAndTellTheNewState) {
  for (const std::string command : {"pause", "resume", "abort", "stop", "reset"}) {
    const std::string state = command == "reset" ? "idle" : "paused";
    reply_.body = {{"state", state}};
    const Finished finished = Gyrobench({command});
    EXPECT_EQ(finished.status, 0) << command;
    EXPECT_EQ(finished.out, state + "\n");
    daemon_.WaitForRequest("POST /v1/" + command);
  }
  EXPECT_EQ(Gyrobench({"answer", "it is cold"}).status, 0);
  EXPECT_EQ(json::parse(daemon_.WaitForRequest("POST /v1/answer")),
            (json{{"answer", "it is cold"}}));
}

TEST_F(DaemonCommands, AnAnswerThatIsNoJsonIsAnError) {
  reply_.body = "hello";
  const Finished finished = Gyrobench({"status"});
  EXPECT_EQ(finished.status, 1);
  EXPECT_THAT(finished.err, HasSubstr(socket_));
}

}  // namespace
}  // namespace gyrobench::cli

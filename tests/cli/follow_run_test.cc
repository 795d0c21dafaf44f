// `gyrobench run` from the start to the results, without LCM: nothing may depend on a lossy feed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <nlohmann/json.hpp>
#include <tuple>

#include "tests/cli/child_process.h"
#include "tests/cli/fake_daemon.h"
#include "tests/temporary_folder.h"

namespace gyrobench::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr const char* kRunId = "20260101-000000-scale";

// A daemon with one run that lasts until the test, or an operator, ends it.
class FollowRun : public testing::Test {
 protected:
  FakeReply Reply(const FakeRequest& request) {
    if (request.what == "POST /v1/runs") {
      return {201, {{"run_id", kRunId}, {"record", Record()}, {"duration_s", 100.0}}};
    }
    const std::lock_guard lock(mutex_);
    if (request.what == "POST /v1/answer") {
      question_ = nullptr;
      outcome_ = "done";
    }
    if (request.what == "POST /v1/stop") outcome_ = "aborted";
    const json run = {{"run_id", kRunId},     {"procedure", "scale"}, {"record", Record()},
                      {"outcome", outcome_},  {"segment", "turn 3"},  {"segments_done", 2},
                      {"progress", 0.25},     {"elapsed_s", 25.0},    {"remaining_s", 75.0},
                      {"message", "as asked"}};
    return {200,
            {{"state", question_.is_null() ? "running" : "asking"},
             {"run", run},
             {"question", question_}}};
  }

  std::string Record() const { return (folder_ / kRunId).string(); }
  void EndRun(const std::string& outcome) {
    const std::lock_guard lock(mutex_);
    outcome_ = outcome;
  }
  std::vector<std::string> Command(std::vector<std::string> more = {}) const {
    // No LCM: the group of the URL is none.
    std::vector<std::string> command = {GYROBENCH_PROGRAM, "run",   "scale",         "--socket",
                                        folder_ / "s",     "--lcm", "no-such-lcm://"};
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }

  TemporaryFolder folder_;
  std::mutex mutex_;
  std::string outcome_;
  json question_ = nullptr;
  FakeDaemon daemon_{folder_ / "s", [this](const FakeRequest& request) { return Reply(request); }};
};

json ExampleResult() {
  return {{"samples", 1000},
          {"scale",
           {{{"axis", "z"},
             {"unit", "LSB"},
             {"turns", 40},
             {"alpha", 0.0076204},
             {"alpha_std_error", 0.0000313}}}},
          {"defects", json::array()}};
}

TEST_F(FollowRun, EndsWithTheResultsOfTheRecordAndItsPlace) {
  folder_.Write(std::string(kRunId) + "/result.json", ExampleResult().dump());
  EndRun("done");
  const Finished finished = RunToEnd(Command());
  EXPECT_EQ(finished.status, 0);
  EXPECT_THAT(finished.out, HasSubstr("0.007620 ± 0.000031"));
  EXPECT_THAT(finished.out, HasSubstr("deg/s per LSB"));
  EXPECT_THAT(finished.out, HasSubstr("record: " + Record()));
  // Said once, and followed all the same.
  EXPECT_THAT(finished.err, HasSubstr("without live estimates"));
}

TEST_F(FollowRun, ExitStatusTellsAFailedPartFromAFailedRun) {
  for (const auto& [outcome, status] : std::vector<std::pair<std::string, int>>{
           {"done", 0}, {"failed_limits", 3}, {"aborted", 1}, {"fault", 1}, {"error", 1}}) {
    EndRun(outcome);
    EXPECT_EQ(RunToEnd(Command()).status, status) << outcome;
  }
}

TEST_F(FollowRun, JsonIsOneObjectWithOutcomeAndResult) {
  folder_.Write(std::string(kRunId) + "/result.json", ExampleResult().dump());
  EndRun("done");
  const json whole = json::parse(RunToEnd(Command({"--json"})).out);
  EXPECT_EQ(whole.at("run_id"), kRunId);
  EXPECT_EQ(whole.at("outcome"), "done");
  EXPECT_EQ(whole.at("result"), ExampleResult());
}

TEST_F(FollowRun, DetachReturnsWhileTheRunGoesOn) {
  const Finished finished = RunToEnd(Command({"--detach"}));
  EXPECT_EQ(finished.status, 0);
  EXPECT_THAT(finished.out, HasSubstr(kRunId));
}

TEST_F(FollowRun, FirstInterruptAbortsInOrderSecondStops) {
  ChildProcess run(Command());
  run.WaitFor("turn 3");
  run.Signal(SIGINT);
  daemon_.WaitForRequest("POST /v1/abort");
  run.WaitFor("aborted in order");
  run.Signal(SIGINT);
  daemon_.WaitForRequest("POST /v1/stop");
  EXPECT_EQ(run.Wait().status, 1);
}

TEST_F(FollowRun, ShowsABarOnATerminalAndTakesTheOperatorsAnswer) {
  ChildProcess run(Command(), {"TERM=xterm"}, true);
  run.WaitFor("25 %");
  {
    const std::lock_guard lock(mutex_);
    question_ = {{"id", "place"}, {"text", "Is the gyro in place?"}, {"choices", {"yes", "no"}}};
  }
  run.WaitFor("[yes | no] > ");
  run.Type("yes\n");
  EXPECT_EQ(json::parse(daemon_.WaitForRequest("POST /v1/answer")), (json{{"answer", "yes"}}));
  EXPECT_EQ(run.Wait().status, 0);
}

TEST_F(FollowRun, TellsHowToAnswerWhereNobodySits) {
  question_ = {{"id", "place"}, {"text", "Is the gyro in place?"}, {"choices", json::array()}};
  ChildProcess run(Command());
  run.WaitFor("gyrobench answer TEXT");
  EndRun("done");
  EXPECT_EQ(run.Wait().status, 0);
}

// Told to end, the daemon ends its run in order, and is gone before anybody asks how.
TEST_F(FollowRun, ADaemonThatIsGoneLeavesTheEndInItsRecord) {
  for (const auto& [outcome, status, says] : std::vector<std::tuple<std::string, int, std::string>>{
           {"aborted", 1, "aborted: the daemon was told to end"},
           {"running", 1, "lost the daemon while run " + std::string(kRunId)}}) {
    const std::string socket = folder_ / ("gone-" + outcome);
    auto daemon = std::make_unique<FakeDaemon>(
        socket, [this](const FakeRequest& request) { return Reply(request); });
    std::vector<std::string> command = Command();
    std::ranges::replace(command, std::string(folder_ / "s"), socket);
    ChildProcess run(command);
    run.WaitFor("turn 3");
    folder_.Write(std::string(kRunId) + "/run.json",
                  json{{"outcome", outcome}, {"message", "the daemon was told to end"}}.dump());
    daemon.reset();
    run.WaitFor(says);
    EXPECT_EQ(run.Wait().status, status) << outcome;
  }
}

TEST_F(FollowRun, ARefusedRunDoesNotStart) {
  FakeDaemon refusing(folder_ / "r", [](const FakeRequest& request) {
    return request.what == "POST /v1/runs"
               ? Refusal(422, "bad_parameter", "turns = 0: expected 1 .. 1000", "scale")
               : FakeReply{200, {{"state", "idle"}}};
  });
  const Finished finished = RunToEnd({GYROBENCH_PROGRAM, "run", "scale", "-p", "turns=0",
                                      "--socket", folder_ / "r", "--lcm", "no-such-lcm://"});
  EXPECT_EQ(finished.status, 2);
  EXPECT_THAT(finished.err, HasSubstr("turns = 0: expected 1 .. 1000"));
}

}  // namespace
}  // namespace gyrobench::cli

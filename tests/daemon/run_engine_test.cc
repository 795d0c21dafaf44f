// From a procedure's name to a closed record, on devices in memory.
#include "daemon/run_engine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "tests/daemon/fake_bench.h"

namespace gyrobench::daemon {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kTurn = "bench.turn{ axis='inner', angle_deg=90, rate_deg_s=3 }";

json RunFileOf(const RunView& run) {
  std::ifstream file(fs::path(run.record) / "run.json");
  return json::parse(file);
}

class RunEngineTest : public testing::Test {
 protected:
  // Starts it and waits until the inner axis is on its way.
  void StartTurn() {
    bench_.Script("turn", kTurn);
    bench_.engine->Start("turn", {});
    ASSERT_TRUE(bench_.InnerTurns());
  }
  void ExpectNoMotionEver() const {
    EXPECT_THAT(bench_.CallsOfAll(), Each(Each(Not(HasSubstr("move")))));
  }

  FakeBench bench_;
};

TEST_F(RunEngineTest, ARunIsDoneAndItsRecordSaysSo) {
  bench_.Script("turn", kTurn);
  const StartedRun started = bench_.engine->Start("turn", {});
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kDone) << run.progress.message;
  EXPECT_EQ(run.run_id, started.run_id);
  EXPECT_NEAR(bench_.devices.drives.at("inner")->AngleDeg(), 90.0, 1e-9);
  const json file = RunFileOf(run);
  EXPECT_EQ(file["outcome"], "done");
  EXPECT_EQ(file["procedure"], "turn");
  EXPECT_TRUE(fs::exists(fs::path(run.record) / "result.json"));
  EXPECT_EQ(bench_.control.state(), State::kIdle);
}

TEST_F(RunEngineTest, AnAbortedRunStopsEveryDriveAndLeavesNothingOn) {
  bench_.Script("heats", "bench.switch{ output='heater', on=true } bench.rest{ duration_s=600 }");
  bench_.engine->Start("heats", {});
  const auto heats = [&] { return bench_.acquisition->outputs()->States().at("heater") == true; };
  ASSERT_TRUE(bench_.WaitFor(heats));
  bench_.control.Abort();
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kAborted);
  EXPECT_THAT(RunFileOf(run)["message"].get<std::string>(), HasSubstr("operator"));
  EXPECT_FALSE(heats());
  EXPECT_THAT(bench_.CallsOfAll(), Each(Contains("stop")));
}

TEST_F(RunEngineTest, ADeviceThatFallsSilentIsAFault) {
  StartTurn();
  bench_.devices.encoders.at("inner")->faults().FailAlways("no answer");
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kFault);
  EXPECT_THAT(run.progress.message, HasSubstr("encoder.inner"));
  EXPECT_THAT(bench_.CallsOf("inner"), Contains("stop"));
  EXPECT_EQ(bench_.control.state(), State::kFault);
  EXPECT_THROW(bench_.engine->Start("turn", {}), StateError);
}

TEST_F(RunEngineTest, NothingIsStartedBesideARunOrOnABenchThatIsNotWell) {
  StartTurn();
  EXPECT_THROW(bench_.engine->Start("turn", {}), StateError);
  EXPECT_THROW(bench_.engine->Reset(), StateError);
  EXPECT_EQ(bench_.Ended().outcome, Outcome::kDone);

  FakeBench other;
  other.Script("turn", kTurn);
  other.devices.encoders.at("outer")->faults().FailAlways("no answer");
  other.Wait(5.0);
  EXPECT_THROW(other.engine->Start("turn", {}), DeviceError);
}

TEST_F(RunEngineTest, WithoutARecordNothingMoves) {
  std::ofstream(bench_.stand.records) << "a file, where the folder should be";
  bench_.Script("turn", kTurn);
  EXPECT_THROW(bench_.engine->Start("turn", {}), DataError);
  EXPECT_FALSE(bench_.control.run_is_on());
  bench_.Wait(30.0);
  ExpectNoMotionEver();
  fs::remove(bench_.stand.records);
  bench_.engine->Start("turn", {});
  EXPECT_EQ(bench_.Ended().outcome, Outcome::kDone);
}

TEST_F(RunEngineTest, ADryRunMovesNothing) {
  bench_.Script("turn", kTurn);
  const procedures::Plan plan = bench_.engine->Check("turn", {});
  EXPECT_EQ(plan.moves.size(), 1u);
  bench_.Wait(10.0);
  ExpectNoMotionEver();
}

// The daemon is told to end.
TEST(RunEngineAtItsEnd, EndsTheRunInOrder) {
  auto bench = std::make_unique<FakeBench>();
  bench->Script("turn", kTurn);
  bench->engine->Start("turn", {});
  bench->Wait(40.0);
  bench->EndRun();
  const json file = RunFileOf(*bench->engine->View());
  EXPECT_EQ(file["outcome"], "aborted");
  EXPECT_THAT(file["message"].get<std::string>(), HasSubstr("told to end"));
  EXPECT_THAT(bench->CallsOf("inner"), Contains("stop"));
}

}  // namespace
}  // namespace gyrobench::daemon

// From a procedure's name to a closed record, on devices in memory.
#include "daemon/run_engine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "gyrobench/fault_t.hpp"
#include "gyrobench/run_t.hpp"
#include "tests/daemon/fake_bench.h"
#include "tests/daemon/no_threads.h"
#include "tests/daemon/published.h"
#include "tests/temporary_folder.h"

namespace gyrobench::daemon {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kTurnScript = "bench.turn{ axis='inner', angle_deg=90, rate_deg_s=3 }";

json RunFileOf(const RunView& run) {
  std::ifstream file(fs::path(run.record) / "run.json");
  return json::parse(file);
}

class RunEngineTest : public testing::Test {
 protected:
  // Starts it and waits until the inner axis is on its way.
  void StartTurn() {
    bench_.Script("turn", kTurnScript);
    bench_.engine->Start("turn", {});
    ASSERT_TRUE(bench_.InnerTurns());
  }
  void ExpectNoMotionEver() const {
    EXPECT_THAT(bench_.CallsOfAll(), Each(Each(Not(HasSubstr("move")))));
  }

  FakeBench bench_;
};

TEST_F(RunEngineTest, ARunIsDoneAndItsRecordSaysSo) {
  bench_.Script("turn", kTurnScript);
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

// Before, the end of the move was awaited, however long it was.
TEST_F(RunEngineTest, AReferenceThatStandsStillWhileItsDriveMovesStopsTheMove) {
  StartTurn();
  const drivers::FakeAxis& inner = *bench_.devices.drives.at("inner");
  const double frozen_deg = inner.AngleDeg();
  for (int i = 0; i < 200 && bench_.control.run_is_on() && !bench_.control.fault(); ++i) {
    bench_.devices.off_deg["inner"] = frozen_deg - inner.AngleDeg();
    bench_.Wait(0.02);
  }
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kFault);
  EXPECT_THAT(run.progress.message, HasSubstr("does not follow its drive"));
  // 3 deg/s: 2.5 deg are allowed, and two polls of the drive are a second.
  EXPECT_LT(inner.AngleDeg() - frozen_deg, 8.0);
}

TEST_F(RunEngineTest, ADeviceThatFallsSilentIsAFault) {
  StartTurn();
  bench_.devices.encoders.at("inner")->faults().FailAlways("no answer");
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kFault);
  EXPECT_THAT(run.progress.message, HasSubstr("encoder.inner"));
  EXPECT_THAT(run.failures.at(0).left, Contains("axis.outer: at 0.000 deg, at rest"));
  EXPECT_THAT(run.failures.at(0).left, Contains("heater: off"));
  EXPECT_EQ(bench_.control.fault()->left, run.failures.at(0).left);
  EXPECT_EQ(RunFileOf(run)["failures"][0]["left"].size(), 5u);
  EXPECT_THAT(bench_.CallsOf("inner"), Contains("stop"));
  EXPECT_EQ(bench_.control.state(), State::kFault);
  EXPECT_THROW(bench_.engine->Start("turn", {}), StateError);
}

// The script's third line is the body's first.
TEST_F(RunEngineTest, AFaultOfTheBenchIsInTheRecordAsFieldsWithTheScriptsLineAndTheLastSamples) {
  bench_.Script("turn", "bench.rest{ duration_s=5 }\n" + std::string(kTurnScript));
  bench_.engine->Start("turn", {});
  ASSERT_TRUE(bench_.InnerTurns());
  bench_.devices.drives.at("inner")->SetAlarm(33);
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kFault);
  const json failures = RunFileOf(run)["failures"];
  ASSERT_EQ(failures.size(), 1u) << failures;
  EXPECT_EQ(failures[0]["source"], "axis.inner");
  EXPECT_EQ(failures[0]["device"], json({{"name", "axis.inner drive"},
                                         {"action", "status"},
                                         {"code_kind", "alarm"},
                                         {"code", 33},
                                         {"address", nullptr}}));
  EXPECT_EQ(failures[0]["script"], json({{"file", "turn.lua"}, {"line", 4}}));
  const json& samples = failures[0]["last_samples"];
  EXPECT_EQ(samples["axes"].back()["drive"]["alarm"], 33);
  EXPECT_EQ(samples["axes"].back()["reference"].size(), 20u);
  EXPECT_EQ(samples["gyro"].size(), 20u);
  EXPECT_EQ(bench_.control.fault()->place->line, 4);
}

// It lost its line, since it is of a type of its own.
TEST_F(RunEngineTest, ACommandThatADeviceRefusesIsAFaultOfItsLine) {
  bench_.Script("turn", kTurnScript);
  bench_.devices.drives.at("inner")->faults().fields = {
      .device = "axis.inner drive",
      .action = "move",
      .code_kind = DeviceFailure::CodeKind::kModbusException,
      .code = 3,
      .address = 0x6200};
  bench_.devices.drives.at("inner")->on_call = [&](const std::string& call) {
    if (call.starts_with("move"))
      bench_.devices.drives.at("inner")->faults().FailNext("exception 03 (illegal data value)");
  };
  bench_.engine->Start("turn", {});
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kFault);
  EXPECT_THAT(run.progress.message, HasSubstr("turn.lua:3: exception 03"));
  ASSERT_EQ(run.failures.size(), 1u);
  EXPECT_EQ(run.failures[0].place->line, 3);
  const json device = RunFileOf(run)["failures"][0]["device"];
  EXPECT_EQ(device["code_kind"], "modbus_exception");
  EXPECT_EQ(device["code"], 3);
  EXPECT_EQ(device["address"], 0x6200);
}

// It does not in the dry run, in which a turn is exact.
TEST_F(RunEngineTest, AScriptThatFailsIsAnErrorOfItsLine) {
  bench_.Script("fails",
                "local turn = bench.turn{ axis='inner', angle_deg=10, rate_deg_s=10 }\n"
                "if turn.moved_deg ~= 10 then bench.fail('no part in the holder') end");
  bench_.engine->Start("fails", {});
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kError);
  const json failures = RunFileOf(run)["failures"];
  ASSERT_EQ(failures.size(), 1u);
  EXPECT_EQ(failures[0]["script"], json({{"file", "fails.lua"}, {"line", 4}}));
  EXPECT_TRUE(failures[0]["device"].is_null());
}

TEST_F(RunEngineTest, EveryLimitThatFailedIsTold) {
  bench_.Script("limits",
                "bench.limit{name='bias', value=3, max=2}\n"
                "bench.limit{name='noise', value=1, max=2}\n"
                "bench.limit{name='scale', value=5, max=4}");
  bench_.engine->Start("limits", {});
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kFailedLimits);
  EXPECT_THAT(run.progress.message, HasSubstr("bias = 3"));
  EXPECT_THAT(run.progress.message, HasSubstr("scale = 5"));
  EXPECT_THAT(run.progress.message, Not(HasSubstr("noise")));
  EXPECT_EQ(RunFileOf(run)["failures"], json::array());
}

TEST_F(RunEngineTest, NothingIsStartedBesideARunOrOnABenchThatIsNotWell) {
  StartTurn();
  EXPECT_THROW(bench_.engine->Start("turn", {}), StateError);
  EXPECT_THROW(bench_.engine->Reset(), StateError);
  EXPECT_EQ(bench_.Ended().outcome, Outcome::kDone);

  FakeBench other;
  other.Script("turn", kTurnScript);
  other.devices.encoders.at("outer")->faults().FailAlways("no answer");
  other.Wait(5.0);
  EXPECT_THROW(other.engine->Start("turn", {}), DeviceError);
}

TEST_F(RunEngineTest, WithoutARecordNothingMoves) {
  std::ofstream(bench_.stand.records) << "a file, where the folder should be";
  bench_.Script("turn", kTurnScript);
  EXPECT_THROW(bench_.engine->Start("turn", {}), DataError);
  EXPECT_FALSE(bench_.control.run_is_on());
  bench_.Wait(30.0);
  ExpectNoMotionEver();
  fs::remove(bench_.stand.records);
  bench_.engine->Start("turn", {});
  EXPECT_EQ(bench_.Ended().outcome, Outcome::kDone);
}

// A daemon that the machine starved for seconds said "done", and no more.
TEST_F(RunEngineTest, ARunThatLostSamplesSaysHowMany) {
  bench_.Script("rests", "bench.rest{ duration_s=30 }");
  bench_.devices.gyro->Miss(55);  // before the run
  bench_.Wait(5.0);
  bench_.engine->Start("rests", {});
  bench_.Wait(40.0);
  bench_.devices.gyro->Miss(150);
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kDone);
  EXPECT_THAT(run.progress.message, HasSubstr("150 samples of the gyro were lost"));
  EXPECT_EQ(RunFileOf(run)["message"], run.progress.message);
}

// Its supply broke down for an instant: too short to be missed.
TEST_F(RunEngineTest, ARunInWhichTheGyroStartedAnewSaysSo) {
  bench_.Script("rests", "bench.rest{ duration_s=30 }");
  bench_.devices.gyro->Restart();  // before the run
  bench_.Wait(5.0);
  bench_.engine->Start("rests", {});
  bench_.Wait(40.0);
  bench_.devices.gyro->Restart();
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kDone);
  EXPECT_THAT(run.progress.message, HasSubstr("started anew within the run (once)"));
  EXPECT_EQ(RunFileOf(run)["message"], run.progress.message);
}

TEST_F(RunEngineTest, AFaultSaysEachCauseOnce) {
  bench_.Script("turn", kTurnScript);
  bench_.engine->Start("turn", {});
  ASSERT_TRUE(bench_.InnerTurns());
  bench_.devices.drives.at("inner")->faults().fields = {
      .device = "axis.inner drive",
      .action = "status",
      .code_kind = DeviceFailure::CodeKind::kSystemError,
      .code = 110};
  bench_.devices.drives.at("inner")->faults().FailAlways("axis.inner drive: no answer");
  const std::string message = bench_.Ended().progress.message;
  EXPECT_THAT(message, testing::StartsWith("axis.inner drive: no answer The run was suspended"));
  EXPECT_THAT(message, testing::EndsWith("; stop: an axis may not have been stopped: axis.inner "
                                         "drive: status: for the same reason"));
}

TEST_F(RunEngineTest, ADryRunMovesNothing) {
  bench_.Script("turn", kTurnScript);
  const procedures::Plan plan = bench_.engine->Check("turn", {});
  EXPECT_EQ(plan.moves.size(), 1u);
  bench_.Wait(10.0);
  ExpectNoMotionEver();
}

// A start that stood in line while a stop came, and was answered.
TEST_F(RunEngineTest, ARunThatWasAskedForBeforeAStopDoesNotBegin) {
  bench_.Script("turn", kTurnScript);
  const std::int64_t asked_at = bench_.control.stops();
  bench_.engine->Stop("stopped by the test");
  EXPECT_THROW(bench_.engine->Start("turn", {}, asked_at), StateError);
  bench_.Wait(60.0);
  ExpectNoMotionEver();
  bench_.engine->Start("turn", {}, bench_.control.stops());
  EXPECT_EQ(bench_.Ended().outcome, Outcome::kDone);
}

// Such a script is over before anybody asks whether it shall go on.
TEST_F(RunEngineTest, NoRunBeginsOnceAllIsStoppedForGood) {
  bench_.Script("turn", kTurnScript);
  bench_.engine->StopForGood("stopped by the test");
  EXPECT_THROW(bench_.engine->Start("turn", {}), StateError);
  bench_.Wait(60.0);
  ExpectNoMotionEver();
  EXPECT_FALSE(bench_.control.run_is_on());
}

TEST_F(RunEngineTest, WithoutAThreadThereIsNoRunAndTheNextOneBegins) {
  bench_.Script("turn", kTurnScript);
  {
    const NoThreads none;
    EXPECT_THROW(bench_.engine->Start("turn", {}), Error);
  }
  EXPECT_FALSE(bench_.control.run_is_on());
  EXPECT_FALSE(bench_.engine->View());
  bench_.engine->Start("turn", {});
  EXPECT_EQ(bench_.Ended().outcome, Outcome::kDone);
}

// It was told as done, and its record said for ever that it was still running.
TEST(RunEngineWithoutRoomForResults, ARunWhoseRecordFailsAtItsEndIsToldAsAFaultEverywhere) {
  const fs::path published = fs::path(testing::TempDir()) / "published_end.lcmlog";
  auto bench = std::make_unique<FakeBench>(LcmUrlOf(published));
  bench->Script("rests", "bench.rest{ duration_s=5 }");
  const StartedRun started = bench->engine->Start("rests", {});
  fs::create_directories(fs::path(started.record) / "result.json" / "in the way");
  const RunView run = bench->Ended();
  EXPECT_EQ(run.outcome, Outcome::kFault);
  EXPECT_THAT(run.progress.message, HasSubstr("result.json"));
  EXPECT_EQ(bench->control.state(), State::kFault);
  EXPECT_EQ(RunFileOf(run)["outcome"], "fault");
  bench.reset();
  std::vector<std::string> told;
  for (const run_t& message : MessagesOn<run_t>("TEST_RUN", EventsOf(published))) {
    if (message.event != run_t::STOP) continue;
    told.push_back(message.outcome);
    EXPECT_EQ(message.run_id, started.run_id);
  }
  EXPECT_THAT(told, ElementsAre("fault"));
  fs::remove(published);
}

// The daemon is told to end.
TEST(RunEngineAtItsEnd, EndsTheRunInOrder) {
  auto bench = std::make_unique<FakeBench>();
  bench->Script("turn", kTurnScript);
  bench->engine->Start("turn", {});
  bench->Wait(40.0);
  bench->EndRun();
  const json file = RunFileOf(*bench->engine->View());
  EXPECT_EQ(file["outcome"], "aborted");
  EXPECT_THAT(file["message"].get<std::string>(), HasSubstr("told to end"));
  EXPECT_THAT(bench->CallsOf("inner"), Contains("stop"));
}

TEST_F(RunEngineTest, ASensorThatIsStillTooHotAfterAResetIsAFaultAgain) {
  bench_.devices.temperature_degC = bench_.stand.gyro.max_degC + 6.0;
  ASSERT_TRUE(bench_.WaitFor([this] { return bench_.control.state() == State::kFault; }));
  bench_.engine->Reset();
  EXPECT_FALSE(bench_.control.fault());
  bench_.Wait(2.0);
  ASSERT_TRUE(bench_.control.fault());
  EXPECT_THAT(bench_.control.fault()->message, HasSubstr("outside the part's range"));
}

TEST_F(RunEngineTest, ATableThatIsStillBeyondItsLimitsInTheNextRunIsAFaultAgain) {
  for (int i = 0; i < 2; ++i) {
    bench_.devices.off_deg["inner"] = 190.0;
    bench_.Script("rests", "bench.turn{ axis='inner', angle_deg=-90, rate_deg_s=3 }");
    bench_.engine->Start("rests", {});
    EXPECT_THAT(bench_.Ended().progress.message, HasSubstr("beyond its soft limits")) << i;
    bench_.engine->Reset();
  }
}

// Between runs that is a line in the status.
TEST_F(RunEngineTest, AResetMakesNoFaultOfADriveThatIsSwitchedOff) {
  bench_.devices.drives.at("inner")->faults().FailAlways("no answer");
  bench_.Wait(5.0);
  bench_.control.Report({"gyro", "too hot"});
  bench_.engine->Reset();
  bench_.Wait(2.0);
  EXPECT_FALSE(bench_.control.fault());
  EXPECT_EQ(bench_.control.state(), State::kDisconnected);
}

// Each with its own name.
TEST(FaultsOnTheAir, ThatOneIsOverIsSaidByItsNameAndBeforeTheNextOne) {
  const TemporaryFolder folder;
  const fs::path log = folder / "published.lcmlog";
  auto bench = std::make_unique<FakeBench>(LcmUrlOf(log));
  bench->devices.temperature_degC = bench->stand.gyro.max_degC + 6.0;
  ASSERT_TRUE(bench->WaitFor([&] { return bench->control.state() == State::kFault; }));
  bench->supervisor->Report({"axis.inner", "a consequence"});
  bench->engine->Reset();
  bench->Wait(2.0);
  bench.reset();
  std::vector<std::pair<std::string, bool>> heard;
  for (const fault_t& message : MessagesOn<fault_t>("TEST_FAULT", EventsOf(log)))
    heard.emplace_back(message.source, message.active);
  EXPECT_THAT(heard, ElementsAre(std::pair("gyro", true), std::pair("gyro", false),
                                 std::pair("gyro", true)));
}

}  // namespace
}  // namespace gyrobench::daemon

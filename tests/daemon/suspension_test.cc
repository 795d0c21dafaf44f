// A device that falls silent in a run: the run waits, and goes on or ends.
#include "daemon/suspension.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "gyrobench/run_t.hpp"
#include "tests/daemon/fake_bench.h"
#include "tests/daemon/published.h"

namespace gyrobench::daemon {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kTurns =
    "bench.rest{ duration_s=20 }\n"
    "bench.turn{ axis='inner', angle_deg=90, rate_deg_s=3 }\n"
    "bench.rest{ duration_s=20 }\n"
    "bench.turn{ axis='inner', angle_deg=-90, rate_deg_s=3 }\n"
    "bench.rest{ duration_s=20 }";

class SuspensionTest : public testing::Test {
 protected:
  void StartTurns() {
    bench_.Script("turns", kTurns);
    bench_.engine->Start("turns", {});
    ASSERT_TRUE(bench_.InnerTurns());
    bench_.Wait(5.0);
  }
  drivers::FakeAxis& Inner() { return *bench_.devices.drives.at("inner"); }
  drivers::FakeAngleSensor& Encoder() { return *bench_.devices.encoders.at("inner"); }
  bool IsSuspended() {
    return bench_.WaitFor([this] { return bench_.control.state() == State::kSuspended; });
  }
  std::vector<std::string> MovesOfInner() {
    std::vector<std::string> moves = bench_.CallsOf("inner");
    std::erase_if(moves, [](const std::string& call) { return !call.starts_with("move"); });
    return moves;
  }
  static std::vector<int> EventsOfRun(const RunView& run, std::initializer_list<int> wanted) {
    std::vector<int> events;
    const auto all = EventsOf(fs::path(run.record) / "events.lcmlog");
    for (const run_t& message : MessagesOn<run_t>("TEST_RUN", all))
      if (std::ranges::find(wanted, message.event) != wanted.end()) events.push_back(message.event);
    return events;
  }
  static double ScaleOf(const RunView& run) {
    std::ifstream file(fs::path(run.record) / "result.json");
    return nlohmann::json::parse(file)["scale"][0]["alpha"];
  }

  FakeBench bench_;
};

TEST_F(SuspensionTest, ARunGoesOnFromTheCommandInWhichADeviceFellSilent) {
  StartTurns();
  Encoder().faults().FailAlways("no answer");
  ASSERT_TRUE(IsSuspended());
  bench_.Wait(1.0);
  const double stopped_deg = Inner().AngleDeg();
  bench_.Wait(4.0);
  EXPECT_EQ(Inner().AngleDeg(), stopped_deg);
  EXPECT_LT(stopped_deg, 40.0);
  Encoder().faults().Recover();
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kDone) << run.progress.message;
  EXPECT_NEAR(Inner().AngleDeg(), 0.0, 1e-9);
  const std::vector<std::string> moves = MovesOfInner();
  ASSERT_EQ(moves.size(), 4u) << testing::PrintToString(moves);
  EXPECT_EQ(moves[0], moves[2]);
  EXPECT_THAT(moves[1], HasSubstr("move -"));
  EXPECT_THAT(EventsOfRun(run, {run_t::SUSPEND, run_t::CONTINUE}),
              ElementsAre(run_t::SUSPEND, run_t::CONTINUE));
  EXPECT_EQ(EventsOfRun(run, {run_t::SEGMENT_END}).size(), 5u);
  EXPECT_EQ(bench_.control.state(), State::kIdle);
}

TEST_F(SuspensionTest, WhatComesOutIsWhatARunGivesThatWasNotInterrupted) {
  StartTurns();
  const double whole = ScaleOf(bench_.Ended());
  FakeBench other;
  other.Script("turns", kTurns);
  other.engine->Start("turns", {});
  ASSERT_TRUE(other.InnerTurns());
  other.Wait(5.0);
  other.devices.encoders.at("inner")->faults().FailAlways("no answer");
  other.Wait(8.0);
  other.devices.encoders.at("inner")->faults().Recover();
  const RunView run = other.Ended();
  ASSERT_EQ(run.outcome, Outcome::kDone) << run.progress.message;
  EXPECT_NEAR(ScaleOf(run) / whole, 1.0, 1e-3);
}

TEST_F(SuspensionTest, ADeviceThatStaysSilentIsAFaultAfterItsTime) {
  StartTurns();
  Encoder().faults().FailAlways("no answer");
  const Utime begin = bench_.clock->Now();
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kFault);
  EXPECT_THAT(run.progress.message, HasSubstr("encoder.inner"));
  EXPECT_THAT(run.progress.message, HasSubstr("did not come back within 30 s"));
  EXPECT_LT(ToSeconds(bench_.clock->Now() - begin), 40.0);
  EXPECT_EQ(bench_.control.state(), State::kFault);
  EXPECT_THAT(bench_.control.fault()->left, Contains(HasSubstr("axis.inner: last read at")));
}

// A silent device is asked every 2 s: at 28 s, and again once its time is over.
TEST(Suspension, WaitsForADeviceThatIsBackAMomentBeforeItsTimeIsOver) {
  FakeBench bench("memq://", [](config::StandConfig& stand) { stand.safety.resume_within_s = 29; });
  bench.Script("turns", kTurns);
  bench.engine->Start("turns", {});
  ASSERT_TRUE(bench.InnerTurns());
  bench.Wait(5.0);
  bench.devices.encoders.at("inner")->faults().FailAlways("no answer");
  ASSERT_TRUE(bench.WaitFor([&] { return bench.control.state() == State::kSuspended; }));
  bench.Wait(28.5);
  bench.devices.encoders.at("inner")->faults().Recover();
  const RunView run = bench.Ended();
  EXPECT_EQ(run.outcome, Outcome::kDone) << run.progress.message;
  EXPECT_THAT(run.progress.message, HasSubstr("the run was suspended once, for "));
  EXPECT_THAT(run.progress.message, HasSubstr("s in all (encoder.inner did not answer)"));
}

TEST_F(SuspensionTest, ASuspendedRunIsAbortedAtOnceAndInOrder) {
  StartTurns();
  Encoder().faults().FailAlways("no answer");
  ASSERT_TRUE(IsSuspended());
  bench_.control.Abort();
  EXPECT_EQ(bench_.control.state(), State::kStopping);
  EXPECT_EQ(bench_.Ended().outcome, Outcome::kAborted);
}

TEST_F(SuspensionTest, ATableThatWasTurnedMeanwhileIsAFault) {
  StartTurns();
  Encoder().faults().FailAlways("no answer");
  ASSERT_TRUE(IsSuspended());
  bench_.devices.off_deg["inner"] = 4.0;
  Encoder().faults().Recover();
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kFault);
  EXPECT_THAT(run.progress.message, HasSubstr("the run does not go on"));
  EXPECT_EQ(MovesOfInner().size(), 1u);
}

// An emergency stop that takes the drive's power with it, and its word.
TEST_F(SuspensionTest, AfterAnEmergencyStopNothingMovesByItself) {
  StartTurns();
  Inner().Stop();
  Inner().LosePower();
  Inner().faults().FailAlways("no answer");
  ASSERT_TRUE(IsSuspended());
  bench_.Wait(5.0);
  Inner().faults().Recover();
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kFault);
  EXPECT_THAT(run.progress.message, HasSubstr("emergency stop"));
  EXPECT_EQ(MovesOfInner().size(), 1u);
}

TEST_F(SuspensionTest, AGyroThatWasSwitchedOffIsNotTheSame) {
  StartTurns();
  bench_.devices.gyro->faults().FailAlways("no answer");
  ASSERT_TRUE(IsSuspended());
  bench_.devices.gyro->Restart();
  bench_.devices.gyro->faults().Recover();
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kFault);
  EXPECT_THAT(run.progress.message, HasSubstr("switched off and on"));
}

// Nothing is measured then; it is missed when the run goes on.
TEST_F(SuspensionTest, ADeviceThatFallsSilentInAPauseIsWaitedForAfterIt) {
  StartTurns();
  bench_.control.Pause();
  ASSERT_TRUE(bench_.WaitFor([this] { return bench_.control.state() == State::kPaused; }));
  Encoder().faults().FailAlways("no answer");
  bench_.Wait(20.0);
  EXPECT_EQ(bench_.control.state(), State::kPaused);
  bench_.control.Resume();
  ASSERT_TRUE(IsSuspended());
  Encoder().faults().Recover();
  EXPECT_EQ(bench_.Ended().outcome, Outcome::kDone);
}

// For as long as in a suspension, each time; the pause itself may last.
TEST_F(SuspensionTest, ADeviceThatStaysSilentInAPauseIsAFaultAfterItsTime) {
  StartTurns();
  bench_.control.Pause();
  ASSERT_TRUE(bench_.WaitFor([this] { return bench_.control.state() == State::kPaused; }));
  for (int times = 0; times < 3; ++times) {
    Encoder().faults().FailAlways("no answer");
    bench_.Wait(20.0);
    Encoder().faults().Recover();
    bench_.Wait(1000.0);
  }
  EXPECT_EQ(bench_.control.state(), State::kPaused);
  Encoder().faults().FailAlways("no answer");
  const Utime begin = bench_.clock->Now();
  const RunView run = bench_.Ended();
  EXPECT_LT(ToSeconds(bench_.clock->Now() - begin), 40.0);
  EXPECT_EQ(run.outcome, Outcome::kFault);
  EXPECT_THAT(run.progress.message, HasSubstr("encoder.inner"));
  EXPECT_THAT(run.progress.message,
              HasSubstr("The run was paused, and it did not come back within 30 s"));
}

class SuspendedHeating : public SuspensionTest {
 protected:
  // Waits until the heater is on and the run is within a rest.
  void StartHeating() {
    bench_.Script("heats",
                  "bench.switch{ output='heater', on=true }\n"
                  "bench.rest{ duration_s=10 }\n"
                  "bench.rest{ duration_s=10 }");
    bench_.engine->Start("heats", {});
    ASSERT_TRUE(bench_.WaitFor([this] { return Heats(); }));
    bench_.Wait(2.0);
  }
  bool Heats() { return bench_.devices.relays->on.at("heater"); }
  std::ptrdiff_t TimesSwitchedOn() {
    return std::ranges::count(bench_.devices.relays->calls, "heater on");
  }
};

// Whatever fell silent: without the gyro nobody knows how warm it is.
TEST_F(SuspendedHeating, TheHeaterIsOffAtOnceAndOnAgainBeforeTheCommandBegins) {
  StartHeating();
  Encoder().faults().FailAlways("no answer");
  ASSERT_TRUE(IsSuspended());
  bench_.Wait(0.1);
  EXPECT_FALSE(Heats());
  bench_.Wait(10.0);
  EXPECT_FALSE(Heats());
  EXPECT_EQ(TimesSwitchedOn(), 1);
  Encoder().faults().Recover();
  ASSERT_TRUE(bench_.WaitFor([this] { return bench_.control.state() == State::kRunning; }));
  EXPECT_TRUE(Heats());
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kDone) << run.progress.message;
  EXPECT_EQ(TimesSwitchedOn(), 2);
  EXPECT_FALSE(Heats());
  std::vector<std::string> said;
  for (const run_t& message :
       MessagesOn<run_t>("TEST_RUN", EventsOf(fs::path(run.record) / "events.lcmlog"))) {
    if (message.event == run_t::SUSPEND || message.event == run_t::CONTINUE)
      said.push_back(message.text);
  }
  EXPECT_THAT(said, ElementsAre(HasSubstr("meanwhile switched off: heater"),
                                HasSubstr("heater switched on again")));
}

TEST_F(SuspendedHeating, TheHeaterIsOffAtOnceWhenTheGyroFallsSilentInAPause) {
  StartHeating();
  bench_.control.Pause();
  ASSERT_TRUE(bench_.WaitFor([this] { return bench_.control.state() == State::kPaused; }));
  EXPECT_TRUE(Heats());
  bench_.devices.gyro->faults().FailAlways("no answer");
  bench_.Wait(3.0);
  EXPECT_FALSE(Heats());
  bench_.devices.gyro->faults().Recover();
  bench_.Wait(20.0);
  EXPECT_EQ(bench_.control.state(), State::kPaused);
  EXPECT_FALSE(Heats());
  bench_.control.Resume();
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kDone) << run.progress.message;
  EXPECT_EQ(TimesSwitchedOn(), 2);
}

// It may be on, and nobody knows.
TEST_F(SuspendedHeating, ASwitchWhoseAnswerIsLostIsAFaultAndNoSuspension) {
  bench_.devices.relays->loses = "heater";
  bench_.Script("heats",
                "bench.switch{ output='heater', on=true }\n"
                "bench.rest{ duration_s=10 }");
  bench_.engine->Start("heats", {});
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kFault);
  ASSERT_TRUE(bench_.control.fault());
  EXPECT_EQ(bench_.control.fault()->source, "relays");
  EXPECT_THAT(EventsOfRun(run, {run_t::SUSPEND}), IsEmpty());
  EXPECT_FALSE(Heats());
}

// Each is told only once, and a stop that it causes leaves the axis on its way.
class SecondSilence : public SuspensionTest {
 protected:
  // Waits until the inner axis is on its way back, several seconds long.
  void StartTheWayBack() {
    StartTurns();
    bench_.Wait(12.0);
    Encoder().faults().FailAlways("no answer");
    ASSERT_TRUE(IsSuspended());
    Encoder().faults().Recover();
    for (int i = 0; i < 300 && MovesOfInner().size() < 2; ++i) bench_.Wait(0.1);
    ASSERT_EQ(MovesOfInner().size(), 2u);
    ASSERT_GT(Inner().AngleDeg(), 30.0);
  }
};

TEST_F(SecondSilence, ADeviceThatFallsSilentOnTheWayBackIsWaitedForToo) {
  StartTheWayBack();
  bench_.devices.encoders.at("outer")->faults().FailAlways("no answer");
  bench_.Wait(2.0);
  const double stopped_deg = Inner().AngleDeg();
  EXPECT_GT(stopped_deg, 1.0);
  bench_.Wait(5.0);
  EXPECT_EQ(Inner().AngleDeg(), stopped_deg);
  EXPECT_EQ(bench_.control.state(), State::kSuspended);
  bench_.devices.encoders.at("outer")->faults().Recover();
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kDone) << run.progress.message;
  // 90 deg and back, from where they began.
  EXPECT_NEAR(Inner().AngleDeg(), 0.0, 1e-9);
}

TEST_F(SecondSilence, OneThatStaysSilentIsTheFaultOfTheRun) {
  StartTheWayBack();
  bench_.devices.gyro->faults().FailAlways("no answer");
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kFault);
  EXPECT_THAT(run.progress.message, HasSubstr("gyro"));
  EXPECT_THAT(run.progress.message, HasSubstr("did not come back within 30 s"));
  EXPECT_EQ(MovesOfInner().size(), 2u);
}

// After the last of the way, when all seems well.
TEST_F(SecondSilence, OneAtTheVeryEndOfTheHoldIsNotForgotten) {
  StartTheWayBack();
  for (int i = 0; i < 100 && Inner().AngleDeg() > 0.0; ++i) bench_.Wait(0.1);
  bench_.devices.gyro->faults().FailAlways("no answer");
  bench_.Wait(5.0);
  EXPECT_EQ(bench_.control.state(), State::kSuspended);
  EXPECT_EQ(MovesOfInner().size(), 2u);
  bench_.devices.gyro->faults().Recover();
  EXPECT_EQ(bench_.Ended().outcome, Outcome::kDone);
}

// What a pause or a question hides: each is compared with the last moment at which all was well.
class BehindAPause : public SuspensionTest {
 protected:
  void PauseTurns() {
    StartTurns();
    bench_.control.Pause();
    ASSERT_TRUE(bench_.WaitFor([this] { return bench_.control.state() == State::kPaused; }));
    moves_ = MovesOfInner().size();
  }
  void ExpectNoWayOn(const std::string& why) {
    bench_.Wait(5.0);
    bench_.control.Resume();
    const RunView run = bench_.Ended();
    EXPECT_EQ(run.outcome, Outcome::kFault);
    EXPECT_THAT(run.progress.message, HasSubstr("the run does not go on"));
    EXPECT_THAT(run.progress.message, HasSubstr(why));
    EXPECT_EQ(MovesOfInner().size(), moves_);
  }
  std::size_t moves_ = 0;
};

TEST_F(BehindAPause, AGyroThatWasExchangedOrSwitchedOffIsSeen) {
  PauseTurns();
  bench_.devices.gyro->faults().FailAlways("no answer");
  bench_.Wait(5.0);
  bench_.devices.gyro->Restart();
  bench_.devices.gyro->faults().Recover();
  ExpectNoWayOn("switched off and on");
}

TEST_F(BehindAPause, AGyroThatWasSwitchedOffTooShortlyToBeMissedIsSeen) {
  PauseTurns();
  bench_.devices.gyro->Restart();
  ExpectNoWayOn("after a pause");
}

TEST_F(BehindAPause, ATableThatWasTurnedWhileItsReferenceWasSilentIsSeen) {
  PauseTurns();
  Encoder().faults().FailAlways("no answer");
  bench_.Wait(5.0);
  bench_.devices.off_deg["inner"] = 4.0;
  Encoder().faults().Recover();
  ExpectNoWayOn("somebody turned it");
}

TEST_F(BehindAPause, AnEmergencyStopIsSeen) {
  PauseTurns();
  Inner().faults().FailAlways("no answer");
  bench_.Wait(5.0);
  Inner().LosePower();
  Inner().faults().Recover();
  ExpectNoWayOn("emergency stop");
}

// It is cooled, or mounted, with its plug drawn.
TEST_F(SuspensionTest, BeforeAnythingIsMeasuredAQuestionMayTakeTheGyrosPower) {
  bench_.Script("asks", "bench.ask{ id='cool', text='Cool it' }\nbench.rest{ duration_s=10 }");
  bench_.engine->Start("asks", {});
  ASSERT_TRUE(bench_.WaitFor([this] { return bench_.control.state() == State::kAsking; }));
  bench_.devices.gyro->faults().FailAlways("no answer");
  bench_.Wait(30.0);
  bench_.devices.gyro->Restart();
  bench_.devices.gyro->faults().Recover();
  bench_.Wait(5.0);
  bench_.control.Answer("done");
  const RunView run = bench_.Ended();
  EXPECT_EQ(run.outcome, Outcome::kDone) << run.progress.message;
}

}  // namespace
}  // namespace gyrobench::daemon

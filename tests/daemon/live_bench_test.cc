// What a procedure's commands do on the stand, and what they refuse.
#include "daemon/live_bench.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <thread>
#include <vector>

#include "base/error.h"
#include "gyrobench/run_t.hpp"
#include "procedures/engine/engine.h"
#include "recording/event_log.h"
#include "tests/daemon/fake_bench.h"
#include "tests/daemon/published.h"

namespace gyrobench::daemon {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

constexpr double kPlanned_s = 100.0;
// A turn of this takes 1 s.
const procedures::TurnCommand kTurn = {"inner", 9.0, 10.0, 100.0};

std::string MessageOf(const std::function<void()>& act) {
  try {
    act();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

// A run without a procedure: the test's thread gives the commands.
class LiveBenchTest : public testing::Test {
 protected:
  LiveBenchTest() {
    host_.control.BeginRun(host_.me());
    host_.control.Prepared();
    const Utime start = host_.clock->Now();
    host_.telemetry.BeginRun("run", Log(), host_.acquisition->Info(), start);
    live_.emplace(
        LiveBench::Context{host_.stand, *host_.clock, host_.me(), *host_.acquisition,
                           host_.telemetry, host_.control, kPlanned_s, [](const std::string&) {},
                           [this](bool asking) {
                             asking_.push_back(asking);
                             return false;
                           },
                           [this](const RunProgress& progress) { progress_ = progress; }},
        start);
  }
  ~LiveBenchTest() override {
    for (std::thread& other : others_) other.join();
    live_->FinishResults();
    live_.reset();
    host_.control.EndRun();
  }
  std::string Log() const { return (host_.folder / "events.lcmlog").string(); }
  // The events of run_t so far.
  std::vector<run_t> Events() {
    host_.telemetry.EndRun();
    return MessagesOn<run_t>("TEST_RUN", EventsOf(Log()));
  }
  std::vector<std::string> Segments() {
    std::vector<std::string> names;
    for (const run_t& event : Events())
      if (event.event == run_t::SEGMENT_END) names.push_back(event.segment_name);
    return names;
  }
  // Somebody does `act` after so much bench time, beside what the test's thread waits for.
  void After(double wait_s, std::function<void()> act) {
    others_.emplace_back([this, act = std::move(act), somebody = host_.clock->Join("operator"),
                          when = host_.clock->Now() + FromSeconds(wait_s)]() mutable {
      somebody->WaitUntil(when);
      act();
      somebody.reset();
    });
  }

  const procedures::Question fan_on_ = {"fan_on", "Switch the fan on", {"done", "no fan"}, 30.0};
  FakeBench host_;
  std::vector<std::thread> others_;
  std::vector<bool> asking_;
  RunProgress progress_;
  std::optional<LiveBench> live_;
};

TEST_F(LiveBenchTest, ATurnIsMeasuredByTheReference) {
  const procedures::TurnOutcome outcome = live_->Turn(kTurn);
  EXPECT_NEAR(outcome.moved_deg, 9.0, 360.0 / drivers::FakeAngleSensor::kCountsPerTurn);
  EXPECT_EQ(outcome.rate_deg_s, 10.0);
  EXPECT_GT(outcome.duration_s, 0.9);
  EXPECT_THAT(Segments(), ElementsAre("inner +9 deg"));
}

TEST_F(LiveBenchTest, ATurnThatTheReferenceDoesNotFollowIsAFault) {
  const double allowed_deg = host_.stand.axes.back().following_error_deg;
  host_.devices.drives.at("inner")->on_call = [&](const std::string& call) {
    if (call.starts_with("move")) host_.devices.off_deg["inner"] -= 3.0 * allowed_deg;
  };
  const std::string message = MessageOf([&] { live_->Turn(kTurn); });
  EXPECT_THAT(message, HasSubstr("axis.inner"));
  EXPECT_THAT(message, HasSubstr("commanded 9.000 deg"));
  EXPECT_THAT(Segments(), IsEmpty());
}

TEST_F(LiveBenchTest, WhatEndsBeyondALimitIsNotBegun) {
  procedures::TurnCommand too_far = kTurn;
  too_far.angle_deg = 400.0;
  EXPECT_THROW(live_->Turn(too_far), LimitError);
  procedures::SwingCommand too_wide = {"inner", 200.0, 0.01, 1};
  EXPECT_THROW(live_->Swing(too_wide), LimitError);
  procedures::TurnCommand nowhere = kTurn;
  nowhere.axis = "fourth";
  EXPECT_ANY_THROW(live_->Turn(nowhere));
  EXPECT_THAT(host_.CallsOf("inner"), Not(Contains(HasSubstr("move"))));
  EXPECT_THAT(Events(), IsEmpty());
}

TEST_F(LiveBenchTest, ASwingGoesToBothSidesAndComesHome) {
  const procedures::SwingOutcome outcome = live_->Swing({"inner", 5.0, 0.5, 2});
  EXPECT_NEAR(host_.devices.drives.at("inner")->AngleDeg(), 0.0, 1e-9);
  EXPECT_GT(outcome.frequency_hz, 0.0);
  EXPECT_LE(outcome.frequency_hz, 0.5 * 1.5);  // a fake needs no time to accelerate
  std::vector<std::string> moves;
  for (const std::string& call : host_.CallsOf("inner"))
    if (call.starts_with("move")) moves.push_back(call.substr(0, call.find(" deg")));
  EXPECT_THAT(moves, ElementsAre("move 5", "move -10", "move 10", "move -10", "move 5"));
}

TEST_F(LiveBenchTest, ARestTakesItsTime) {
  const double begin_s = live_->ElapsedS();
  live_->Rest(12.0);
  EXPECT_NEAR(live_->ElapsedS() - begin_s, 12.0, 1e-6);
  EXPECT_EQ(progress_.segments_done, 1);
  EXPECT_NEAR(progress_.remaining_s, kPlanned_s - live_->ElapsedS(), 1e-6);
}

TEST_F(LiveBenchTest, AnAbortOrAFaultEndsWhateverIsWaitedFor) {
  host_.control.Abort();
  EXPECT_THROW(live_->Rest(3600.0), procedures::Aborted);
  EXPECT_LT(live_->ElapsedS(), 1.0);
  EXPECT_THROW(live_->SafePoint(), procedures::Aborted);
}

TEST_F(LiveBenchTest, ASteadyTemperatureSettlesAfterItsWindow) {
  const procedures::SoakOutcome outcome = live_->Soak({120.0, 0.1, 0.0, 3600.0});
  EXPECT_TRUE(outcome.settled);
  EXPECT_NEAR(outcome.duration_s, 120.0, 2.0);
  EXPECT_DOUBLE_EQ(outcome.temperature_degC, 25.0);
  EXPECT_THAT(Segments(), Not(IsEmpty()));
}

// A minute each, so that there are results on the way.
TEST_F(LiveBenchTest, ALongSoakIsSeveralSegments) {
  const procedures::SoakOutcome outcome = live_->Soak({120.0, 0.1, 300.0, 3600.0});
  EXPECT_NEAR(outcome.duration_s, 300.0, 2.0);
  EXPECT_THAT(Segments(), SizeIs(testing::Ge(4u)));
}

TEST_F(LiveBenchTest, AQuestionThatNobodyAnswersEndsTheRunAndSaysWhich) {
  const double begin_s = live_->ElapsedS();
  const std::string message = MessageOf([&] { live_->Ask(fan_on_); });
  EXPECT_THAT(message, HasSubstr("Switch the fan on"));
  EXPECT_THAT(message, HasSubstr("30 s"));
  EXPECT_NEAR(live_->ElapsedS() - begin_s, 30.0, 0.1);
  EXPECT_THAT(asking_, ElementsAre(true, false));
  EXPECT_THAT(live_->on_by_hand(), IsEmpty());
}

TEST_F(LiveBenchTest, AnAnswerIsGivenBackAndWhatWasSwitchedByHandIsKnown) {
  After(7.0, [this] { host_.control.Answer("done"); });
  const double begin_s = live_->ElapsedS();
  EXPECT_EQ(live_->Ask(fan_on_), "done");
  EXPECT_NEAR(live_->ElapsedS() - begin_s, 7.0, 0.1);
  EXPECT_THAT(live_->on_by_hand(), ElementsAre("fan"));
}

TEST_F(LiveBenchTest, APauseBeginsAtASafePointAndIsNotCountedAsWork) {
  live_->Rest(20.0);
  const double remaining_s = progress_.remaining_s;
  host_.control.Pause();
  EXPECT_EQ(host_.control.state(), State::kPausing);
  After(500.0, [this] {
    EXPECT_EQ(host_.control.state(), State::kPaused);
    host_.control.Resume();
  });
  const double begin_s = live_->ElapsedS();
  live_->SafePoint();
  EXPECT_NEAR(live_->ElapsedS() - begin_s, 500.0, 0.1);
  EXPECT_THAT(asking_, ElementsAre(true, false));
  live_->Rest(1.0);
  EXPECT_NEAR(progress_.remaining_s, remaining_s - 1.0, 0.1);
}

TEST_F(LiveBenchTest, AnOutputIsSwitchedAndWhatItSaidIsKept) {
  live_->SwitchOutput("heater", true);
  EXPECT_TRUE(host_.devices.relays->on.at("heater"));
  ASSERT_THAT(live_->said(), SizeIs(1));
  EXPECT_EQ(live_->said()[0].text, "heater switched on");
  EXPECT_ANY_THROW(live_->SwitchOutput("pump", true));
}

TEST_F(LiveBenchTest, ALimitIsKeptWhetherItHoldsOrNot) {
  procedures::LimitCheck check;
  check.name = "scale error";
  check.passed = false;
  live_->RecordLimit(check);
  ASSERT_THAT(live_->limits(), SizeIs(1));
  EXPECT_FALSE(live_->limits()[0].passed);
  EXPECT_THAT(live_->said(), SizeIs(1));
}

// While the run's thread works a trace out: nobody resumes anything.
TEST_F(LiveBenchTest, AfterAnEmergencyStopBetweenTwoCommandsNothingMovesByItself) {
  drivers::FakeAxis& inner = *host_.devices.drives.at("inner");
  live_->Rest(1.0);
  inner.faults().FailAlways("no answer");
  host_.Wait(5.0);
  inner.LosePower();
  inner.faults().Recover();
  host_.Wait(5.0);
  EXPECT_THAT(MessageOf([&] { live_->Turn(kTurn); }), HasSubstr("emergency stop"));
  EXPECT_THAT(host_.CallsOf("inner"), Not(Contains(HasSubstr("move"))));
}

TEST_F(LiveBenchTest, ADriveThatRefusesAMoveIsNotSilent) {
  drivers::FakeAxis& inner = *host_.devices.drives.at("inner");
  inner.on_call = [&](const std::string& call) {
    if (call.starts_with("move")) inner.SetAlarm(3);
  };
  EXPECT_THAT(MessageOf([&] { live_->Turn(kTurn); }), HasSubstr("move refused"));
  EXPECT_FALSE(host_.control.suspended());
  EXPECT_EQ(host_.control.state(), State::kRunning);
}

TEST_F(LiveBenchTest, AnAnswerThatIsLostBecauseOfAStopIsNoFault) {
  drivers::FakeAxis& inner = *host_.devices.drives.at("inner");
  inner.on_call = [&](const std::string& call) {
    if (!call.starts_with("move")) return;
    host_.control.Stop("stopped by the operator");
    inner.faults().FailNext("the answer was lost");
  };
  EXPECT_THROW(live_->Turn(kTurn), procedures::Aborted);
  EXPECT_FALSE(host_.control.fault());
}

TEST_F(LiveBenchTest, AnEstimateIsThereOnceSomethingWasMeasured) {
  EXPECT_FALSE(live_->ReadEstimate("bias").available);
  live_->Rest(60.0);
  const procedures::Estimate bias = live_->ReadEstimate("bias");
  ASSERT_TRUE(bias.available);
  EXPECT_LT(std::abs(bias.value), 5.0 * bias.std_error);
  EXPECT_FALSE(live_->ReadEstimate("scale_factor").available);
}

}  // namespace
}  // namespace gyrobench::daemon

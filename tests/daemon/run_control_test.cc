#include "daemon/run_control.h"

#include <gtest/gtest.h>

#include <thread>

#include "daemon/progress_meter.h"
#include "procedures/engine/engine.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::daemon {
namespace {

class RunControlTest : public testing::Test {
 protected:
  std::unique_ptr<VirtualClock> clock_ = MakeVirtualClock(kStart);
  std::unique_ptr<Clock::Participant> run_ = clock_->Join("run");
  RunControl control_;
};

TEST_F(RunControlTest, WithoutARunThereIsNothingToPauseAbortOrAnswer) {
  EXPECT_THROW(control_.Pause(), StateError);
  EXPECT_THROW(control_.Resume(), StateError);
  EXPECT_THROW(control_.Abort(), StateError);
  EXPECT_THROW(control_.Answer("yes"), StateError);
}

TEST_F(RunControlTest, OneRunAtATime) {
  control_.BeginRun(*run_);
  EXPECT_THROW(control_.BeginRun(*run_), StateError);
  control_.EndRun();
  control_.BeginRun(*run_);
  control_.EndRun();
  EXPECT_EQ(control_.state(), State::kIdle);
}

TEST_F(RunControlTest, AnAbortEndsAWaitAtOnce) {
  control_.BeginRun(*run_);
  control_.Abort();
  EXPECT_THROW(control_.Wait(*clock_, kStart + 3'600'000'000), procedures::Aborted);
  EXPECT_EQ(clock_->Now(), kStart);
  control_.EndRun();
}

// The thread of a bus reports it; the run, once it hears of it, knows at which command it was.
TEST_F(RunControlTest, AFaultThatIsReportedAgainKeepsAllButTakesTheScriptsPlace) {
  control_.Report({"axis.inner", "lost steps", {.device = "axis.inner"}});
  control_.Report({"gyro", "a consequence", {}, ScriptPlace{"other.lua", 3}});
  EXPECT_FALSE(control_.fault()->place);
  control_.Report({"axis.inner", "lost steps", {}, ScriptPlace{"scale.lua", 41}});
  EXPECT_EQ(control_.fault()->place->line, 41);
  EXPECT_EQ(control_.fault()->failure.device, "axis.inner");
}

TEST_F(RunControlTest, AFaultEndsTheRunAndStaysLatched) {
  control_.BeginRun(*run_);
  control_.Report({"axis.inner", "lost steps"});
  control_.Report({"gyro", "a consequence"});
  EXPECT_THROW(control_.Wait(*clock_, kStart + 1), FaultError);
  EXPECT_THROW(control_.ClearFault(), StateError);
  control_.EndRun();
  EXPECT_EQ(control_.state(), State::kFault);
  ASSERT_TRUE(control_.fault());
  EXPECT_EQ(control_.fault()->source, "axis.inner");
  EXPECT_THROW(control_.BeginRun(*run_), StateError);
  control_.ClearFault();
  EXPECT_EQ(control_.state(), State::kIdle);
}

TEST_F(RunControlTest, TheFirstReasonToAbortIsTheOneThatIsSaid) {
  control_.BeginRun(*run_);
  control_.Abort("the daemon was told to end");
  control_.Abort();
  try {
    control_.ThrowIfToEnd();
    ADD_FAILURE() << "it goes on";
  } catch (const procedures::Aborted& aborted) {
    EXPECT_STREQ(aborted.what(), "the daemon was told to end");
  }
  control_.EndRun();
}

// Tidying up after an abort waits for the axes; the abort must not cut that short.
TEST_F(RunControlTest, WhileStoppingAWaitIsAWait) {
  control_.BeginRun(*run_);
  control_.Abort();
  control_.BeginStopping();
  control_.Wait(*clock_, kStart + 500'000);
  EXPECT_EQ(clock_->Now(), kStart + 500'000);
  EXPECT_EQ(control_.state(), State::kStopping);
  control_.Abort();
  control_.Wait(*clock_, kStart + 600'000);
  control_.EndRun();
}

TEST_F(RunControlTest, AnAnswerMustBeOneOfTheChoices) {
  control_.BeginRun(*run_);
  control_.Prepared();
  const procedures::Question question{"cool", "Cool the gyro", {"done", "skip"}, 100.0};
  std::thread operator_thread([&] {
    while (!control_.question()) std::this_thread::yield();
    EXPECT_EQ(control_.state(), State::kAsking);
    EXPECT_THROW(control_.Answer("maybe"), StateError);
    control_.Answer("skip");
    EXPECT_EQ(control_.state(), State::kRunning);
  });
  clock_->SetPace(0.0);
  const auto answer = control_.WaitForAnswer(*clock_, question, kStart + 100'000'000);
  operator_thread.join();
  EXPECT_EQ(answer, "skip");
  EXPECT_FALSE(control_.question());
  control_.EndRun();
}

TEST_F(RunControlTest, WithoutAnAnswerTheQuestionTimesOut) {
  control_.BeginRun(*run_);
  control_.Prepared();
  const auto answer =
      control_.WaitForAnswer(*clock_, {"cool", "Cool the gyro", {}, 60.0}, kStart + 60'000'000);
  EXPECT_FALSE(answer);
  EXPECT_EQ(clock_->Now(), kStart + 60'000'000);
  EXPECT_EQ(control_.state(), State::kRunning);
  control_.EndRun();
}

// An operator's command is answered with the state that it leads to.
TEST_F(RunControlTest, ACommandShowsInTheStateAtOnce) {
  control_.BeginRun(*run_);
  control_.Prepared();
  control_.Pause();
  EXPECT_EQ(control_.state(), State::kPausing);
  control_.Resume();
  EXPECT_EQ(control_.state(), State::kRunning);
  control_.Abort();
  EXPECT_EQ(control_.state(), State::kStopping);
  control_.EndRun();
  EXPECT_EQ(control_.state(), State::kIdle);
}

TEST_F(RunControlTest, APausedRunWaitsForResume) {
  control_.BeginRun(*run_);
  control_.Prepared();
  control_.Pause();
  clock_->SetPace(0.0);
  std::thread operator_thread([&] {
    while (control_.state() != State::kPaused) std::this_thread::yield();
    control_.Resume();
    EXPECT_EQ(control_.state(), State::kRunning);
  });
  control_.WaitWhilePaused();
  operator_thread.join();
  EXPECT_EQ(control_.state(), State::kRunning);
  EXPECT_THROW(control_.Resume(), StateError);
  control_.EndRun();
}

// Between the checks before a question and the question.
TEST_F(RunControlTest, ASuspendedRunThatAsksIsAnswered) {
  control_.BeginRun(*run_);
  control_.Prepared();
  ASSERT_TRUE(control_.Suspend({"gyro", "no answer"}));
  clock_->SetPace(0.0);
  std::thread operator_thread([&] {
    while (!control_.question()) std::this_thread::yield();
    EXPECT_EQ(control_.state(), State::kAsking);
    control_.Answer("done");
    EXPECT_EQ(control_.state(), State::kSuspended);
  });
  EXPECT_EQ(control_.WaitForAnswer(*clock_, {"cool", "Cool the gyro", {}, 100.0}, kForever),
            "done");
  operator_thread.join();
  control_.EndRun();
}

TEST_F(RunControlTest, ASuspendedRunThatIsToPauseIsPaused) {
  control_.BeginRun(*run_);
  control_.Prepared();
  control_.Pause();
  ASSERT_TRUE(control_.Suspend({"gyro", "no answer"}));
  clock_->SetPace(0.0);
  std::thread operator_thread([&] {
    while (control_.state() != State::kPaused) std::this_thread::yield();
    control_.Resume();
  });
  control_.WaitWhilePaused();
  operator_thread.join();
  EXPECT_EQ(control_.state(), State::kSuspended);
  control_.EndRun();
}

TEST_F(RunControlTest, AHoldDoesNotEndWhereADeviceFellSilentInIt) {
  control_.BeginRun(*run_);
  control_.Prepared();
  ASSERT_TRUE(control_.Suspend({"encoder.inner", "no answer"}));
  control_.BeginHold();
  const int seen = control_.silences();
  ASSERT_TRUE(control_.Suspend({"gyro", "no answer"}));
  EXPECT_FALSE(control_.EndHold(seen));
  EXPECT_EQ(control_.state(), State::kSuspended);
  EXPECT_EQ(control_.suspended()->source, "gyro");
  EXPECT_TRUE(control_.EndHold(control_.silences()));
  EXPECT_EQ(control_.state(), State::kRunning);
  EXPECT_FALSE(control_.suspended());
  control_.EndRun();
}

TEST(ProgressMeter, NeverFallsAndEndsAtOne) {
  for (const double first_s : {0.0, 30.0, 60.0, 99.0, 150.0}) {
    ProgressMeter meter;
    double said = 0.0;
    const auto expect_no_fall = [&] {
      EXPECT_GE(meter.fraction(), said);
      EXPECT_LE(meter.fraction(), 1.0);
      said = meter.fraction();
    };
    // A plan that shrinks and grows on the way, as soaks do.
    for (double t_s = 0.0; t_s < first_s; t_s += 7.0) {
      meter.AtTime(t_s, t_s < 40.0 ? 100.0 : 140.0);
      expect_no_fall();
    }
    for (int turn = 1; turn <= 20; ++turn) {
      meter.Report(turn / 20.0);
      expect_no_fall();
      meter.AtTime(200.0, 100.0);
      expect_no_fall();
    }
    EXPECT_DOUBLE_EQ(said, 1.0);
  }
}

TEST(ProgressMeter, TheProceduresOwnWordGoesOnFromWhereTheTimeHadCome) {
  ProgressMeter meter;
  meter.AtTime(20.0, 100.0);
  meter.Report(0.0);
  EXPECT_DOUBLE_EQ(meter.fraction(), 0.2);
  meter.Report(0.5);
  EXPECT_DOUBLE_EQ(meter.fraction(), 0.6);
  ProgressMeter alone;
  alone.Report(0.5);
  EXPECT_DOUBLE_EQ(alone.fraction(), 0.5);
}

}  // namespace
}  // namespace gyrobench::daemon

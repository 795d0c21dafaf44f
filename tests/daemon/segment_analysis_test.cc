// Results of a run's segments, worked out beside it.
#include "daemon/segment_analysis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <future>
#include <thread>

#include "recording/event_log.h"
#include "tests/daemon/resting_gyro.h"
#include "tests/drivers/manual_clock.h"
#include "tests/temporary_folder.h"

namespace gyrobench::daemon {
namespace {

class SegmentAnalysisTest : public testing::Test {
 protected:
  SegmentAnalysisTest() {
    telemetry_.BeginRun("run", Log(), RestingGyro::Info(), kStart);
    // As in a run, time has passed before the first segment ends: the worker waits.
    me_->WaitUntil(kStart + 1);
  }
  // The analysis ends in a thread of its own, for which a virtual clock must not wait for this one.
  ~SegmentAnalysisTest() override { me_.reset(); }

  std::string Log() const { return (folder_ / "events.lcmlog").string(); }

  void Measure(double duration_s, int lsb) { gyro_.SendTo(telemetry_, duration_s, lsb); }
  // Times of the bias results that were sent, in their order.
  std::vector<Utime> SentBiases() {
    telemetry_.EndRun();
    std::vector<Utime> sent;
    recording::EventLogReader reader(Log());
    for (recording::LogEvent event; reader.Next(event);) {
      if (event.channel == "TEST_BIAS_RESULT") sent.push_back(event.utime);
    }
    return sent;
  }

  TemporaryFolder folder_;
  std::unique_ptr<VirtualClock> clock_ = MakeVirtualClock(kStart);
  std::unique_ptr<Clock::Participant> me_ = clock_->Join("test");
  LcmPublisher publisher_{"memq://", "TEST"};
  Telemetry telemetry_{publisher_, [](const std::string&) {}};
  RestingGyro gyro_{kStart};
  SegmentAnalysis analysis_{*clock_, telemetry_};
};

TEST_F(SegmentAnalysisTest, SendsWhatTheAnalysisOfTheWholeRunSays) {
  Measure(30.0, 100);
  analysis_.Begin(gyro_.utime());
  const calibration::AnalysisResult newest = analysis_.Newest(*me_);
  ASSERT_EQ(newest.bias.size(), 3u);
  EXPECT_NEAR(newest.bias[0].coefficients.at(0), 100.0, 0.1);
  EXPECT_EQ(newest.bias[0].coefficients, telemetry_.Analyse().bias[0].coefficients);
  EXPECT_EQ(SentBiases(), std::vector<Utime>(3, gyro_.utime()));
}

TEST_F(SegmentAnalysisTest, IsOfTheTimeAtWhichItWasBegun) {
  Measure(30.0, 100);
  analysis_.Begin(gyro_.utime());
  Measure(30.0, 200);
  EXPECT_NEAR(analysis_.Newest(*me_).bias.at(0).coefficients.at(0), 100.0, 0.1);
}

TEST_F(SegmentAnalysisTest, HoldsTheTimeOfAVirtualClockUntilItIsDone) {
  Measure(60.0, 100);
  analysis_.Begin(gyro_.utime());
  me_->WaitUntil(clock_->Now() + 1);
  EXPECT_EQ(SentBiases().size(), 3u);
}

TEST_F(SegmentAnalysisTest, EndsWithTheNewestHoweverManyAreBegun) {
  for (int i = 0; i < 20; ++i) {
    Measure(5.0, 100);
    analysis_.Begin(gyro_.utime());
  }
  analysis_.Newest(*me_);
  const std::vector<Utime> sent = SentBiases();
  // On a virtual clock nothing of it runs before this thread waits: the newest alone is worked out.
  EXPECT_EQ(sent, std::vector<Utime>(3, gyro_.utime()));
}

TEST_F(SegmentAnalysisTest, BeginsNothingMoreOnceItIsToFinish) {
  Measure(30.0, 100);
  analysis_.Begin(gyro_.utime());
  analysis_.Finish(*me_);
  EXPECT_THAT(SentBiases(), testing::IsEmpty());
}

// Beside a thread that goes on measuring, as on hardware.
TEST_F(SegmentAnalysisTest, WorksBesideTheMeasurement) {
  const std::unique_ptr<Clock> clock = MakeSystemClock();
  auto caller = clock->Join("test");
  {
    SegmentAnalysis analysis(*clock, telemetry_);
    std::thread measuring([this] { Measure(600.0, 100); });
    for (int i = 0; i < 50; ++i) {
      analysis.Begin(kStart + i);
      if (i % 10 == 0) analysis.Newest(*caller);
    }
    measuring.join();
    analysis.Begin(gyro_.utime());
    EXPECT_NEAR(analysis.Newest(*caller).bias.at(0).coefficients.at(0), 100.0, 0.1);
    caller.reset();
  }
  const std::vector<Utime> sent = SentBiases();
  EXPECT_TRUE(std::ranges::is_sorted(sent));
  EXPECT_EQ(sent.back(), gyro_.utime());
}

// However long a result takes, measuring and segments go on, and what is worked out after it is the
// newest alone.
TEST_F(SegmentAnalysisTest, NothingWaitsForAResultThatIsBeingWorkedOut) {
  const std::unique_ptr<Clock> clock = MakeSystemClock();
  auto caller = clock->Join("test");
  std::promise<void> begun, may_end;
  int evaluations = 0;
  {
    SegmentAnalysis analysis(*clock, telemetry_, [&](const Telemetry::Snapshot& snapshot) {
      if (++evaluations == 1) {
        begun.set_value();
        may_end.get_future().wait();
      }
      return ResultOf(snapshot);
    });
    Measure(30.0, 100);
    analysis.Begin(gyro_.utime());
    begun.get_future().wait();
    for (int segment = 0; segment < 10; ++segment) {
      Measure(30.0, 100);
      analysis.Begin(gyro_.utime());
    }
    may_end.set_value();
    EXPECT_EQ(analysis.Newest(*caller).samples, 33'000);
    caller.reset();
  }
  EXPECT_EQ(evaluations, 2);
}

// Too early to say anything.
TEST_F(SegmentAnalysisTest, OfNothingHasNoResultAndARemark) {
  analysis_.Begin(gyro_.utime());
  const calibration::AnalysisResult newest = analysis_.Newest(*me_);
  EXPECT_TRUE(newest.bias.empty());
  EXPECT_FALSE(newest.remarks.empty());
  EXPECT_TRUE(SentBiases().empty());
}

}  // namespace
}  // namespace gyrobench::daemon

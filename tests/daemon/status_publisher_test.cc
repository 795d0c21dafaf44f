// What a listener hears of the bench's state.
#include "daemon/status_publisher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "gyrobench/status_t.hpp"
#include "tests/daemon/fake_bench.h"
#include "tests/daemon/published.h"
#include "tests/temporary_folder.h"

namespace gyrobench::daemon {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

class StatusPublisherTest : public testing::Test {
 protected:
  // All that was published; the bench is gone then.
  std::vector<status_t> Heard() {
    bench_.reset();
    return MessagesOn<status_t>("TEST_STATUS", EventsOf(log_));
  }

  TemporaryFolder folder_;
  const std::filesystem::path log_ = folder_ / "published.lcmlog";
  std::unique_ptr<FakeBench> bench_ = std::make_unique<FakeBench>(LcmUrlOf(log_));
};

TEST_F(StatusPublisherTest, SpeaksOnceASecondOfBenchTime) {
  const Utime begin = bench_->clock->Now();
  bench_->Wait(30.5);
  const Utime end = bench_->clock->Now();
  std::vector<Utime> times;
  for (const status_t& status : Heard())
    if (status.utime > begin && status.utime <= end) times.push_back(status.utime);
  EXPECT_THAT(times, SizeIs(testing::AllOf(testing::Ge(30u), testing::Le(31u))));
  for (std::size_t i = 1; i < times.size(); ++i)
    EXPECT_EQ(times[i] - times[i - 1], kMicrosecondsPerSecond);
}

TEST_F(StatusPublisherTest, SpeaksAtOnceWhenSomethingChanged) {
  bench_->Wait(5.5);
  const Utime changed = bench_->clock->Now();
  bench_->control.Report({"axis.inner", "lost steps"});
  bench_->status->Changed();
  bench_->Wait(0.01);
  std::vector<status_t> heard;
  for (const status_t& status : Heard())
    if (status.utime >= changed && status.utime <= changed + 10'000) heard.push_back(status);
  ASSERT_THAT(heard, SizeIs(1));
  EXPECT_EQ(heard[0].state, status_t::FAULT);
}

TEST_F(StatusPublisherTest, SaysWhatTheSensorIsAndShows) {
  bench_->Wait(20.0);
  const std::string name = bench_->stand.name;
  const std::vector<status_t> heard = Heard();
  ASSERT_THAT(heard, SizeIs(testing::Ge(10u)));
  const status_t& last = heard.at(15);
  EXPECT_EQ(last.stand, name);
  EXPECT_EQ(last.state, status_t::IDLE);
  EXPECT_FALSE(last.virtual_stand);
  EXPECT_DOUBLE_EQ(last.temperature_degC, 25.0);
  EXPECT_NEAR(last.gyro_rate_hz, 200.0, 15.0);  // of whole blocks
  EXPECT_THAT(last.message, IsEmpty());
}

TEST_F(StatusPublisherTest, SaysWhatIsMostUrgent) {
  bench_->Wait(2.0);
  bench_->devices.encoders.at("outer")->faults().FailAlways("no answer");
  bench_->Wait(5.0);
  const Utime faulty = bench_->clock->Now();
  bench_->control.Report({"axis.inner", "lost steps"});
  bench_->Wait(2.0);
  const Utime cleared = bench_->clock->Now();
  bench_->control.ClearFault();
  bench_->Wait(2.0);
  std::string before, during, after;
  for (const status_t& status : Heard()) {
    (status.utime <= faulty ? before : status.utime <= cleared ? during : after) = status.message;
  }
  EXPECT_THAT(before, HasSubstr("encoder.outer: "));
  EXPECT_THAT(during, StartsWith("axis.inner: lost steps"));
  EXPECT_THAT(after, HasSubstr("encoder.outer: "));
}

TEST_F(StatusPublisherTest, NamesTheRunThatIsOn) {
  bench_->Script("rest", "bench.rest{ duration_s=10 }");
  const std::string run_id = bench_->engine->Start("rest", {}).run_id;
  bench_->Wait(5.0);
  const Utime then = bench_->clock->Now();
  bench_->Ended();
  std::vector<status_t> preparing, running;
  for (const status_t& status : Heard()) {
    if (status.state == status_t::PREPARING) preparing.push_back(status);
    if (status.state == status_t::RUNNING) running.push_back(status);
  }
  ASSERT_THAT(preparing, testing::Not(IsEmpty()));
  EXPECT_LT(preparing.front().utime, then);
  ASSERT_THAT(running, testing::Not(IsEmpty()));
  EXPECT_EQ(running.back().run_id, run_id);
}

}  // namespace
}  // namespace gyrobench::daemon

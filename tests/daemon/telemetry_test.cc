// What is sent is published, and in a run recorded and analysed, in one order.
#include "daemon/telemetry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <future>
#include <memory>
#include <thread>

#include "base/error.h"
#include "calibration/estimators/analyzer.h"
#include "gyrobench/axes_t.hpp"
#include "gyrobench/fault_t.hpp"
#include "gyrobench/gyro_t.hpp"
#include "gyrobench/run_t.hpp"
#include "gyrobench/status_t.hpp"
#include "tests/daemon/published.h"
#include "tests/daemon/resting_gyro.h"
#include "tests/daemon/slow_disk.h"
#include "tests/drivers/manual_clock.h"
#include "tests/temporary_folder.h"

namespace gyrobench::daemon {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class TelemetryTest : public testing::Test {
 protected:
  void BeginRun(const std::string& id) {
    telemetry_->BeginRun(id, Log(id).string(), RestingGyro::Info(), gyro_.utime());
  }
  std::filesystem::path Log(const std::string& id) const { return folder_ / (id + ".lcmlog"); }
  void Measure(double duration_s, int lsb = 100) { gyro_.SendTo(*telemetry_, duration_s, lsb); }
  template <typename Message>
  void Send() {
    Message message{};
    message.utime = gyro_.utime();
    telemetry_->Send(message);
  }
  // Nothing is sent any more.
  std::vector<Published> AllPublished() {
    telemetry_.reset();
    publisher_.reset();
    return EventsOf(published_);
  }

  TemporaryFolder folder_;
  const std::filesystem::path published_ = folder_ / "published.lcmlog";
  std::unique_ptr<LcmPublisher> publisher_ =
      std::make_unique<LcmPublisher>(LcmUrlOf(published_), "TEST");
  std::vector<std::string> failures_;
  std::unique_ptr<Telemetry> telemetry_ = std::make_unique<Telemetry>(
      *publisher_, [this](const std::string& message) { failures_.push_back(message); });
  RestingGyro gyro_{kStart};
};

TEST_F(TelemetryTest, EachChannelCountsItsOwnMessagesWhetherThereIsARunOrNot) {
  Send<status_t>();
  BeginRun("first");
  Send<status_t>();
  Send<run_t>();
  telemetry_->EndRun();
  Send<status_t>();
  BeginRun("second");
  Send<run_t>();
  const std::vector<Published> events = AllPublished();
  std::vector<std::int64_t> numbers;
  for (const auto& message : MessagesOn<status_t>("TEST_STATUS", events))
    numbers.push_back(message.seq);
  EXPECT_THAT(numbers, testing::ElementsAre(0, 1, 2));
  const auto runs = MessagesOn<run_t>("TEST_RUN", events);
  ASSERT_THAT(runs, SizeIs(2));
  EXPECT_EQ(runs[1].seq, 1);
}

TEST_F(TelemetryTest, AMessageNamesTheRunItIsSentInAndNoOther) {
  Send<status_t>();
  BeginRun("first");
  Send<status_t>();
  telemetry_->EndRun();
  Send<status_t>();
  std::vector<std::string> runs;
  for (const auto& message : MessagesOn<status_t>("TEST_STATUS", AllPublished()))
    runs.push_back(message.run_id);
  EXPECT_THAT(runs, testing::ElementsAre("", "first", ""));
}

TEST_F(TelemetryTest, TheRecordHoldsWhatWasPublishedInTheSameOrder) {
  BeginRun("run");
  Send<run_t>();
  Measure(1.0);
  Send<fault_t>();
  Send<axes_t>();
  Measure(1.0);
  telemetry_->SendResults(telemetry_->Analyse(), gyro_.utime(), true);
  EXPECT_EQ(telemetry_->EndRun(), "");
  const std::vector<Published> recorded = EventsOf(Log("run"));
  EXPECT_THAT(recorded, SizeIs(testing::Ge(23u)));
  EXPECT_EQ(recorded, AllPublished());
}

// Several devices send at once, each from a thread of its own.
TEST_F(TelemetryTest, TheOrderIsOneWhenSeveralThreadsSend) {
  constexpr int kEach = 200;
  BeginRun("run");
  const auto send = [this](auto message) {
    for (int i = 0; i < kEach; ++i) telemetry_->Send(message);
  };
  std::thread one(send, axes_t{}), other(send, status_t{});
  Measure(2.0);
  one.join();
  other.join();
  telemetry_->EndRun();
  const std::vector<Published> recorded = EventsOf(Log("run"));
  EXPECT_THAT(recorded, SizeIs(2 * kEach + 20));
  EXPECT_EQ(recorded, AllPublished());
}

TEST_F(TelemetryTest, SamplesAfterTheMeasurementAreHeardButNotRecordedOrAnalysed) {
  BeginRun("run");
  Measure(20.0, 100);
  telemetry_->EndMeasurement();
  const auto bias_lsb = [this] { return telemetry_->Analyse().bias.at(0).coefficients.at(0); };
  const double before_lsb = bias_lsb();
  Measure(20.0, 5000);
  Send<run_t>();
  EXPECT_EQ(bias_lsb(), before_lsb);
  telemetry_->EndRun();
  const std::vector<Published> recorded = EventsOf(Log("run"));
  EXPECT_THAT(MessagesOn<gyro_t>("TEST_GYRO", recorded), SizeIs(200));
  EXPECT_THAT(MessagesOn<run_t>("TEST_RUN", recorded), SizeIs(1));
  EXPECT_THAT(MessagesOn<gyro_t>("TEST_GYRO", AllPublished()), SizeIs(400));
}

TEST_F(TelemetryTest, ASnapshotStaysAsItWas) {
  BeginRun("run");
  Measure(30.0, 100);
  const Telemetry::Snapshot snapshot = telemetry_->TakeSnapshot();
  const calibration::BiasResult then = telemetry_->Analyse().bias.at(0);
  Measure(60.0, 200);
  const calibration::BiasResult kept = ResultOf(snapshot).bias.at(0);
  EXPECT_EQ(kept.coefficients, then.coefficients);
  EXPECT_EQ(kept.std_errors, then.std_errors);
  EXPECT_NE(telemetry_->Analyse().bias.at(0).std_errors, then.std_errors);
}

TEST_F(TelemetryTest, WithoutARunThereIsNothingToAnalyse) {
  EXPECT_EQ(telemetry_->TakeSnapshot(), nullptr);
  EXPECT_THAT(telemetry_->Analyse().bias, IsEmpty());
  Measure(10.0);
  EXPECT_EQ(telemetry_->TakeSnapshot(), nullptr);
  EXPECT_EQ(telemetry_->EndRun(), "");
}

TEST_F(TelemetryTest, ASecondRunKnowsNothingOfTheFirst) {
  BeginRun("first");
  Measure(30.0, 100);
  telemetry_->EndRun();
  BeginRun("second");
  Measure(30.0, 300);
  EXPECT_NEAR(telemetry_->Analyse().bias.at(0).coefficients.at(0), 300.0, 0.1);
}

TEST_F(TelemetryTest, ARecordThatExistsIsNotWrittenOver) {
  BeginRun("run");
  Measure(1.0);
  telemetry_->EndRun();
  EXPECT_THROW(BeginRun("run"), DataError);
  EXPECT_THAT(EventsOf(Log("run")), SizeIs(10));
}

// A full disk, made by a limit on the size of files.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit small = before_;
    small.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &small);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_;
};

// A bus that waited for the disk would miss samples: not for a sync, nor for a write or a look-up
// that hangs, as on a network's disk that is away.
TEST_F(TelemetryTest, NoMessageWaitsForTheDisk) {
  BeginRun("run");
  Measure(1.0);
  int works = 0;
  std::future<void> sending;
  {
    const SlowDisk disk([&] {
      ++works;
      sending = std::async(std::launch::async, [&] { Measure(1.0); });
      EXPECT_EQ(sending.wait_for(std::chrono::seconds(60)), std::future_status::ready);
    });
    telemetry_->Sync();
    telemetry_->EndRun();
  }
  // Twice: it is written, its name is looked up, it is synced.
  EXPECT_EQ(works, 6);
}

// A disk that hangs for long: what memory holds is bounded, and nothing is dropped in silence.
TEST_F(TelemetryTest, ARecordThatCannotKeepUpIsAFailureOfIt) {
  BeginRun("run");
  run_t large{};
  large.text.assign(std::size_t{8} << 20, 'x');
  const SlowDisk disk([&] {
    for (int i = 0; i < 20 && failures_.empty(); ++i) {
      large.utime = gyro_.utime();
      telemetry_->Send(large);
      EXPECT_TRUE(i < 9 || !failures_.empty()) << i;
    }
  });
  telemetry_->Sync();
  ASSERT_THAT(failures_, SizeIs(1));
  EXPECT_THAT(failures_[0], HasSubstr("cannot keep up: the disk has yet to take 64 MiB"));
}

TEST_F(TelemetryTest, ARunMayEndWhileItsRecordIsBeingSynced) {
  BeginRun("run");
  Measure(1.0);
  std::future<std::string> ending;
  {
    const SlowDisk disk([&] {
      if (ending.valid()) return;
      ending = std::async(std::launch::async, [&] { return telemetry_->EndRun(); });
      run_t message{};
      do {
        telemetry_->Send(message);
      } while (!message.run_id.empty());
    });
    telemetry_->Sync();
  }
  EXPECT_EQ(ending.get(), "");
  EXPECT_THAT(failures_, IsEmpty());
}

// Of a telemetry whose messages go nowhere else: what LCM publishes must not meet the limit.
TEST(TelemetryOnAFullDisk, SaysSoOnceAndGoesOnPublishing) {
  const TemporaryFolder folder;
  LcmPublisher publisher("memq://", "TEST");
  std::vector<std::string> failures;
  Telemetry telemetry(publisher, [&](const std::string& message) { failures.push_back(message); });
  telemetry.BeginRun("run", (folder / "events.lcmlog").string(), RestingGyro::Info(), kStart);
  RestingGyro gyro(kStart);
  {
    const FullDisk full(1000);
    gyro.SendTo(telemetry, 10.0, 100);
    telemetry.Sync();
    gyro.SendTo(telemetry, 10.0, 100);
    telemetry.Sync();
  }
  ASSERT_THAT(failures, SizeIs(1));
  EXPECT_THAT(failures[0], HasSubstr("events.lcmlog"));
  run_t message{};
  telemetry.Send(message);
  EXPECT_EQ(message.run_id, "run");
  EXPECT_EQ(telemetry.EndRun(), failures[0]);
}

}  // namespace
}  // namespace gyrobench::daemon

// Fan and heater: off after every end, and never on unseen.
#include "daemon/outputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "tests/drivers/fake_devices.h"

namespace gyrobench::daemon {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class OutputsTest : public testing::Test {
 protected:
  OutputsTest() {
    config_.channels = {{"fan", 0}, {"heater", 1}};
    config_.heater_max_degC = 50;
    auto relays = std::make_unique<drivers::FakeRelays>();
    relays_ = relays.get();
    outputs_ =
        std::make_unique<Outputs>(config_, worker_, std::move(relays),
                                  [this](const Fault& fault) { faults_.push_back(fault.message); });
    worker_.Start();
    worker_.Call(*me_, [this] { outputs_->Open(); });
  }
  ~OutputsTest() override {
    me_.reset();
    worker_.Stop();
  }
  void Switch(const std::string& output, bool on) {
    outputs_->Switch(*me_, output, on, [] {});
  }
  // Everything that was posted has been done.
  void Settle() {
    worker_.Call(*me_, [] {});
  }

  config::RelaysConfig config_;
  std::unique_ptr<VirtualClock> clock_ = MakeVirtualClock(1'700'000'000'000'000);
  std::unique_ptr<Clock::Participant> me_ = clock_->Join("test");
  BusWorker worker_{"a", *clock_};
  drivers::FakeRelays* relays_ = nullptr;
  std::unique_ptr<Outputs> outputs_;
  std::vector<std::string> faults_;
  const std::map<std::string, bool> all_off_ = {{"fan", false}, {"heater", false}};
};

TEST_F(OutputsTest, AllAreTriedTheHeaterFirstWhateverOneOfThemDoes) {
  Switch("fan", true);
  Switch("heater", true);
  relays_->calls.clear();
  relays_->refuses = "heater";
  try {
    outputs_->AllOff(*me_);
    FAIL() << "nothing was said";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the heater cannot be switched off, disconnect it"));
  }
  EXPECT_THAT(relays_->calls, ElementsAre("heater off", "heater off", "heater off", "fan off"));
  EXPECT_FALSE(relays_->on.at("fan"));
}

TEST_F(OutputsTest, WhatCouldNotBeSwitchedOffIsTriedAgainUntilItIs) {
  Switch("heater", true);
  relays_->refuses = "heater";
  outputs_->PostAllOff();
  Settle();
  EXPECT_THAT(faults_, SizeIs(1));
  EXPECT_THROW(worker_.Call(*me_, [this] { outputs_->Check(); }), DeviceError);
  relays_->refuses.clear();
  worker_.Call(*me_, [this] { outputs_->Check(); });
  EXPECT_EQ(relays_->on, all_off_);
}

// A stop that waits for the line leaves a request one try.
TEST_F(OutputsTest, OneLostAnswerLeavesNothingOnAndIsNoFault) {
  Switch("heater", true);
  relays_->faults.FailNext("the answer was lost");
  outputs_->PostAllOff();
  Settle();
  EXPECT_THAT(faults_, IsEmpty());
  EXPECT_EQ(relays_->on, all_off_);
}

// Nor does what turns on the same line wait for more than one of its tries.
TEST_F(OutputsTest, AStopGoesBetweenTheTriesOfAUnitThatIsSilent) {
  std::vector<std::string> order;
  relays_->on_call = [&](const std::string& call) {
    order.push_back(call);
    if (order.size() != 1 && call != "fan off") return;
    worker_.PostUrgent([&order] { order.push_back("stop"); });
  };
  relays_->faults.FailAlways("no answer");
  outputs_->PostAllOff();
  Settle();
  EXPECT_THAT(order, ElementsAre("heater off", "stop", "heater off", "heater off", "fan off",
                                 "stop", "fan off", "stop", "fan off", "stop"));
  EXPECT_THAT(faults_, ElementsAre("the heater and the fan cannot be switched off, disconnect them "
                                   "by hand: no answer"));
}

TEST_F(OutputsTest, WhereASwitchFailsAllAreSwitchedOffAndItIsAFault) {
  Switch("fan", true);
  relays_->loses = "heater";
  EXPECT_THROW(Switch("heater", true), FaultError);
  relays_->loses.clear();
  Settle();
  EXPECT_EQ(relays_->on, all_off_);
}

TEST_F(OutputsTest, WhatSomebodyElseSwitchesIsAFaultAndOffAgain) {
  relays_->on["heater"] = true;
  worker_.Call(*me_, [this] { outputs_->Check(); });
  EXPECT_EQ(relays_->on, all_off_);
  ASSERT_THAT(faults_, SizeIs(1));
  EXPECT_THAT(faults_[0], HasSubstr("heater was switched off and was found on"));
}

TEST_F(OutputsTest, TooHotSwitchesEverythingOffAndSaysSoOnce) {
  outputs_->Watch(90);
  Settle();
  EXPECT_THAT(faults_, IsEmpty()) << "the heater is not on";
  Switch("fan", true);
  Switch("heater", true);
  outputs_->Watch(50);
  Settle();
  EXPECT_THAT(faults_, IsEmpty());
  outputs_->Watch(50.1);
  outputs_->Watch(50.2);
  Settle();
  ASSERT_THAT(faults_, SizeIs(1));
  EXPECT_THAT(faults_[0], HasSubstr("everything was switched off"));
  EXPECT_EQ(relays_->on, all_off_);
}

TEST_F(OutputsTest, ATemperatureThatIsNotANumberCountsAsTooHot) {
  Switch("heater", true);
  outputs_->Watch(std::numeric_limits<double>::quiet_NaN());
  Settle();
  EXPECT_EQ(relays_->on, all_off_);
}

TEST_F(OutputsTest, NothingIsSwitchedOnOnceTheRunIsToEnd) {
  EXPECT_THROW(outputs_->Switch(*me_, "heater", true, [] { throw Error("the run ends"); }), Error);
  EXPECT_EQ(relays_->on, all_off_);
}

TEST_F(OutputsTest, AnUnopenedUnitIsUnknownNotOff) {
  Outputs unopened(config_, worker_, std::make_unique<drivers::FakeRelays>(), [](const Fault&) {});
  for (const auto& [output, on] : unopened.States()) EXPECT_FALSE(on.has_value()) << output;
  for (const auto& [output, on] : outputs_->States()) EXPECT_EQ(on, false) << output;
}

}  // namespace
}  // namespace gyrobench::daemon

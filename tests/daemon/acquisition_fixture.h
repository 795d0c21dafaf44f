// Devices at work, all of them fakes, and what is told of them.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "daemon/acquisition.h"
#include "tests/daemon/fake_stand.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::daemon {

inline constexpr Utime kSecond = kMicrosecondsPerSecond;

class AcquisitionTest : public testing::Test {
 protected:
  explicit AcquisitionTest(config::StandConfig stand = StandOfFakes()) : stand_(std::move(stand)) {
    acquisition_.Start();
    acquisition_.AwaitFirstTry(*me_, 5 * kSecond);
  }
  ~AcquisitionTest() override {
    me_.reset();
    acquisition_.Stop();
  }
  void Wait(Utime duration) { me_->WaitUntil(clock_->Now() + duration); }
  double MoveBy(const std::string& axis, double angle_deg) {
    return acquisition_.MoveBy(*me_, axis, angle_deg, 10.0, 50.0, [] {});
  }
  std::vector<std::string> CallsOf(const std::string& axis) {
    return devices_.drives.at(axis)->calls();
  }

  const config::StandConfig stand_;
  std::unique_ptr<VirtualClock> clock_ = MakeVirtualClock(kStart);
  std::unique_ptr<Clock::Participant> me_ = clock_->Join("test");
  FakeStand devices_{*clock_};
  LcmPublisher publisher_{"memq://", "TEST"};
  Telemetry telemetry_{publisher_, [](const std::string&) {}};
  std::vector<std::string> silent_, faults_;
  Notices notices_;
  std::vector<Fault> told_;  // the same as faults_, with their fields
  Acquisition acquisition_{stand_,
                           *clock_,
                           devices_,
                           telemetry_,
                           [this](const Fault& fault) { silent_.push_back(fault.source); },
                           [this](const Fault& fault) {
                             faults_.push_back(fault.source + ": " + fault.message);
                             told_.push_back(fault);
                           },
                           notices_};
};

}  // namespace gyrobench::daemon

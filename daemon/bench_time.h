// How bench time passes within runs and between them.
#pragma once

#include <atomic>

#include "base/clock.h"
#include "config/stand_config.h"
#include "daemon/acquisition.h"
#include "daemon/run_control.h"
#include "daemon/status_publisher.h"

namespace gyrobench::daemon {

// On hardware time passes as it does, and nothing here has an effect.
//
// With a virtual stand and idle_pace = 0 time stands still between runs and while a person is
// waited for: no device is polled, so nobody waits for time, and it does not pass. What a run
// records then depends on the stand file, the seed and the commands alone, not on how long the
// daemon idled before. Commands to a device (stop, reset) are still carried out; they take the time
// of their bytes. While a device does not answer or a fault is latched, time passes as in the real
// world instead, since the device is to be tried again.
class BenchTime {
 public:
  // `virtual_clock`: null on hardware. All must outlive this object.
  BenchTime(const config::StandConfig& stand, VirtualClock* virtual_clock, Acquisition& acquisition,
            const RunControl& control, StatusPublisher& status);

  // From now on time passes as it does in a run. From any thread that holds time (a participant
  // that is not in WaitUntil), so that what follows begins at this moment.
  void Run();
  // From now on time passes as it does between runs. Returns when it stands still, if it is to.
  // To be called by the thread that waits as `caller`.
  void Idle(Clock::Participant& caller);
  // Whether time stands still now.
  bool stands_still() const { return still_; }

 private:
  bool MayStandStill() const;

  const config::StandConfig& stand_;
  VirtualClock* const virtual_clock_;
  Acquisition& acquisition_;
  const RunControl& control_;
  StatusPublisher& status_;
  std::atomic<bool> still_ = false;
};

}  // namespace gyrobench::daemon

#include "daemon/bench_time.h"

#include <algorithm>

namespace gyrobench::daemon {
namespace {

// While a device is waited for although time is to stand still.
constexpr double kRealTime = 1.0;

}  // namespace

BenchTime::BenchTime(const config::StandConfig& stand, VirtualClock* virtual_clock,
                     Acquisition& acquisition, const RunControl& control, StatusPublisher& status)
    : stand_(stand),
      virtual_clock_(virtual_clock),
      acquisition_(acquisition),
      control_(control),
      status_(status) {}

void BenchTime::Run() {
  if (virtual_clock_ == nullptr) return;
  still_ = false;
  status_.StandStill(false);
  acquisition_.Resume();
  const double pace = stand_.virtual_stand->pace;
  virtual_clock_->SetPace(pace > 0 ? pace : VirtualClock::kUnpaced);
}

bool BenchTime::MayStandStill() const {
  const auto devices = acquisition_.Devices();
  return stand_.virtual_stand->idle_pace <= 0 && !control_.fault() &&
         std::ranges::all_of(devices, [](const DeviceStatus& device) { return device.ok; });
}

void BenchTime::Idle(Clock::Participant& caller) {
  if (virtual_clock_ == nullptr) return;
  if (!MayStandStill()) {
    const double pace = stand_.virtual_stand->idle_pace;
    virtual_clock_->SetPace(pace > 0 ? pace : kRealTime);
    return;
  }
  // Unpaced: a paced transaction that is under way would delay those who wait for it.
  virtual_clock_->SetPace(VirtualClock::kUnpaced);
  acquisition_.Hold(caller);
  still_ = true;
  status_.StandStill(true);
}

}  // namespace gyrobench::daemon

#include "daemon/polled_device.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "base/error.h"

namespace gyrobench::daemon {

PolledDevice::PolledDevice(DeviceStatus identity, Actions actions, Clock& clock, Utime silence,
                           FaultHandler on_silence)
    : actions_(std::move(actions)),
      clock_(clock),
      silence_(silence),
      on_silence_(std::move(on_silence)),
      status_(std::move(identity)) {
  status_.message = "not opened yet";
}

Utime PolledDevice::Poll() {
  try {
    if (!open_) {
      actions_.open();
      open_ = true;
      due_ = clock_.Now();
    } else {
      actions_.read();
      // On the grid of the period; what a slow bus could not keep up with is left out, not caught
      // up.
      const Utime period = actions_.period();
      due_ += period;
      if (due_ < clock_.Now()) due_ = clock_.Now() + period / 2;
    }
    Succeeded(clock_.Now());
    tried_ = true;
    return due_;
  } catch (const std::exception& error) {  // nothing may end a bus's thread while a drive moves
    const Utime now = clock_.Now();
    Failed(now, error);
    const bool answers = dynamic_cast<const MustBeOpenedAgain*>(&error) != nullptr;
    due_ = now + (open_ || answers ? actions_.period() : kReopenAfter);
    tried_ = true;
    return due_;
  }
}

// It was not asked meanwhile, and so was not silent.
void PolledDevice::OpenAnew() {
  open_ = false;
  last_answer_ = due_ = clock_.Now();
}

void PolledDevice::Succeeded(Utime now) {
  if (reported_)
    spdlog::info("{}: answers again, after {:.1f} s", status_.name, ToSeconds(now - last_answer_));
  last_answer_ = now;
  reported_ = false;
  const std::lock_guard lock(mutex_);
  if (status_.ok) return;
  status_.ok = ok_ = true;
  status_.message.clear();
  status_.failure = {};
}

void PolledDevice::Failed(Utime now, const std::exception& error) {
  Fault fault = FaultOf(status_.name, error);  // the name never changes
  {
    const std::lock_guard lock(mutex_);
    status_.ok = ok_ = false;
    status_.message = fault.message;
    status_.failure = fault.failure;
  }
  const bool changed = dynamic_cast<const MustBeOpenedAgain*>(&error) != nullptr;
  if (!open_ || reported_ || (!changed && now - last_answer_ < silence_)) return;
  reported_ = true;
  spdlog::warn("{}", WithSource(fault.source, fault.message));
  fault.may_pass = !changed;
  open_ = false;  // it may have been exchanged or restarted: check its identity again
  on_silence_(fault);
}

DeviceStatus PolledDevice::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

}  // namespace gyrobench::daemon

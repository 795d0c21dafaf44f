// One device that is polled: opened when it is there, read at its rate, and known to be well or
// not.
#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <mutex>
#include <string>

#include "base/clock.h"
#include "daemon/fault.h"

namespace gyrobench::daemon {

struct DeviceStatus {
  std::string name;  // axis.inner, encoder.inner, gyro
  std::string kind;  // drive, encoder, gyro
  std::string bus;
  int unit = 0;
  bool ok = false;
  std::string message;      // why not
  DeviceFailure failure{};  // the same as fields
};

// Thrown by a read of a device that answers and is not as it was opened: told to `on_silence` at
// once, and the device is opened at the next poll.
class MustBeOpenedAgain : public DeviceError {
 public:
  using DeviceError::DeviceError;
};

// A device that does not answer is asked again so long after it was asked in vain.
inline constexpr Utime kReopenAfter = 2 * kMicrosecondsPerSecond;
// After so long one that is back has been asked again, with the patience of a bus for one that is
// silent.
inline constexpr Utime kFoundWithin = 2 * kReopenAfter;

// Poll and the functions given belong to the thread of the bus; status may be asked from any
// thread.
class PolledDevice {
 public:
  struct Actions {
    std::function<void()> open;     // throws DeviceError
    std::function<void()> read;     // throws DeviceError
    std::function<Utime()> period;  // between reads [us]
  };
  // A device that has been silent for `silence` is reported to `on_silence`, once until it answers
  // again.
  PolledDevice(DeviceStatus identity, Actions actions, Clock& clock, Utime silence,
               FaultHandler on_silence);

  // Opens or reads the device, once. Returns when the next poll is due. Does not throw.
  Utime Poll();
  // The next poll opens it. In the thread of its bus.
  void OpenAnew();
  DeviceStatus status() const;
  bool ok() const { return ok_; }
  // Whether it has been polled at all.
  bool tried() const { return tried_; }

 private:
  void Succeeded(Utime now);
  void Failed(Utime now, const std::exception& error);

  const Actions actions_;
  Clock& clock_;
  const Utime silence_;
  const FaultHandler on_silence_;
  Utime due_ = 0;
  bool open_ = false;
  bool reported_ = false;
  std::atomic<bool> tried_ = false;
  std::atomic<bool> ok_ = false;
  Utime last_answer_ = 0;
  mutable std::mutex mutex_;
  DeviceStatus status_;
};

}  // namespace gyrobench::daemon

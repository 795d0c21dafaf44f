// Time of the bench. Everything that waits, waits here, so that hours of virtual bench time pass in
// seconds and in the same order for the same seed.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>

namespace gyrobench {

// Host time in microseconds since the epoch. It never steps: wall clock at start plus steady time
// since.
using Utime = std::int64_t;

inline constexpr std::int64_t kMicrosecondsPerSecond = 1'000'000;
// A wake-up that never comes: only a Notify ends the wait.
inline constexpr Utime kForever = std::numeric_limits<Utime>::max();

constexpr Utime FromSeconds(double seconds) {
  return static_cast<Utime>(seconds * 1e6 + (seconds < 0 ? -0.5 : 0.5));
}
constexpr double ToSeconds(Utime duration_us) { return static_cast<double>(duration_us) * 1e-6; }

// A clock that threads can wait on.
//
// Each thread that waits owns one Participant. With the system clock a wait is a wait. With the
// virtual clock time stands still while any resident is running and jumps to the earliest wake-up
// when all wait; one participant is released at a time, in the order of wake-up time and then of
// joining.
class Clock {
 public:
  class Participant {
   public:
    virtual ~Participant() = default;
    // Waits until `wake_up`, or until Notify. True when notified, false when the time came. A
    // Notify that came since the last wait is not lost: the next wait returns true at once. To be
    // called by the one thread that owns the participant.
    virtual bool WaitUntil(Utime wake_up) = 0;
    // Ends the wait, now. From any thread.
    virtual void Notify() = 0;
  };

  enum class Role {
    // Holds virtual time from joining on, whenever it is not in WaitUntil.
    kResident,
    // Holds no time of its own. It waits in place of a resident that is blocked outside the clock
    // for it: the virtual device's thread, while the driver's thread sits in a Modbus call. Who
    // calls WaitUntil of a guest must know that such a resident is blocked for it.
    kGuest,
  };

  virtual ~Clock() = default;
  virtual Utime Now() const = 0;
  // Join a resident before its thread starts, in the thread that starts it: the order is then the
  // same in every run. `name` is for messages.
  virtual std::unique_ptr<Participant> Join(std::string name, Role role = Role::kResident) = 0;
  // How long a call that blocks outside the clock (libmodbus) is to wait in real time for what
  // should come within `timeout_us` of this clock. The virtual clock gives a busy machine more.
  virtual std::int64_t RealTimeout(std::int64_t timeout_us) const = 0;
};

// Wall clock at construction plus steady time since.
std::unique_ptr<Clock> MakeSystemClock();

// A clock of simulated time.
class VirtualClock : public Clock {
 public:
  // As fast as the machine allows.
  static constexpr double kUnpaced = 1e300;
  // Virtual seconds per real second while all wait: kUnpaced, 1 (real time), 0 (stands still until
  // a Notify). From any thread.
  virtual void SetPace(double pace) = 0;
};

// Starts at `start`, unpaced.
std::unique_ptr<VirtualClock> MakeVirtualClock(Utime start);

}  // namespace gyrobench

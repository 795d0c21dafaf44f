// The narrow interface of a driven axis of the stand.
#pragma once

#include <string>

#include "base/clock.h"

namespace gyrobench::drivers {

// What the drive says of itself. Table angle, not shaft angle.
struct AxisState {
  Utime utime = 0;  // host clock, when the drive took the request
  double commanded_deg =
      0.0;  // where the drive's pulse counter puts the table; knows nothing of lost steps
  bool enabled = false;
  bool moving = false;
  bool fault = false;
  int alarm = 0;  // the drive's alarm code, 0 = none
  // Its digital inputs that act now; false where the map does not say where they are read.
  bool emergency_stop = false;
  bool limit_plus = false, limit_minus = false;  // of the table's angle, as MoveBy counts it
};

// One stepper axis: shaft, worm, table. All calls throw DeviceError; none waits for a move to end.
// Calls belong to the thread of the bus that the device is on.
class Axis {
 public:
  virtual ~Axis() = default;
  virtual const std::string& name() const = 0;
  // Whether it moves. Asks for its status alone, before Open as well: of a drive that may have an
  // alarm, or not be what the map says in all else.
  virtual bool IsMoving() = 0;
  // Of the shaft, that the drive is set to. Before Open as well.
  virtual int PulsesPerTurn() = 0;
  // Checks that the drive is there, is what the map says, and is ready; enables it. Returns the
  // state in which it was found. One that moves is to be stopped before.
  virtual AxisState Open() = 0;
  virtual AxisState Read() = 0;
  // Starts one bounded relative move of the table [deg], right-handed about the axis, at
  // `rate_deg_s` > 0 with `acceleration_deg_s2` > 0. Returns the rate that the drive will really
  // use (it counts in whole rpm). Throws LimitError when the drive cannot express the move. Never
  // open-ended: a dead bus must not leave a table turning.
  virtual double MoveBy(double angle_deg, double rate_deg_s, double acceleration_deg_s2) = 0;
  // Quick stop along the drive's own deceleration. Safe in every state; tries more than once,
  // unless something urgent waits for the line.
  virtual void Stop() = 0;
  // Clears a latched alarm of the drive.
  virtual void ClearAlarm() = 0;
};

}  // namespace gyrobench::drivers

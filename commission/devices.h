// The devices of a stand as commissioning asks them: nothing of its stand file is taken for right but
// where they are and what registers they have.
#pragma once

#include <cstddef>
#include <vector>

#include "base/clock.h"
#include "base/geometry.h"
#include "commission/measurements.h"

namespace gyrobench::commission {

// The stand's devices, asked one at a time. Drives and encoders are counted as the stand file has
// its axes. All throw DeviceError; what ends the work (an abort) may be thrown by any of them.
class Devices {
 public:
  struct Rate {
    Utime utime = 0;          // at which the sensor felt it, its filter's delay taken off
    Vector3 rate_deg_s = {};  // nominal scale
  };
  struct Angle {
    Utime utime = 0;
    Words words = {};
  };

  virtual ~Devices() = default;
  // That the drive says. From then on it is moved by this number.
  virtual int PulsesPerTurn(std::size_t drive) = 0;
  virtual void StartMove(std::size_t drive, double angle_deg, double rate_deg_s,
                         double acceleration_deg_s2) = 0;
  virtual bool IsMoving(std::size_t drive) = 0;
  virtual Angle ReadEncoder(std::size_t encoder) = 0;
  // Appends what has come since the last call.
  virtual void ReadRates(std::vector<Rate>* rates) = 0;
  virtual void Wait(double duration_s) = 0;
  virtual Utime Now() = 0;
  virtual void Progress(double fraction) = 0;
};

}  // namespace gyrobench::commission

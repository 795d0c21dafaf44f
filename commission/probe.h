// Turns each drive of a stand a little, whatever its stand file says of it, and measures what
// moves.
#pragma once

#include <cstddef>
#include <vector>

#include "base/clock.h"
#include "base/geometry.h"
#include "commission/measurements.h"
#include "config/stand_config.h"

namespace gyrobench::commission {

// The stand's devices, asked one at a time. Drives and encoders are counted as the stand file has
// its axes. All throw DeviceError; what ends the work (an abort) may be thrown by any of them.
class Devices {
 public:
  struct Rate {
    Utime utime = 0;                // at which the sensor felt it, its filter's delay taken off
    Vector3 rate_deg_s = {};        // nominal scale
    Vector3 specific_force_g = {};  // the same
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
  // What is done of all, and the drive that turns now.
  virtual void Progress(double fraction, std::size_t drive) = 0;
};

// No table turns farther than this from where it stood, a drive whose ratio is 20 times off
// included.
inline constexpr double kFarthest_deg = 12.0;
// Of bench time, for a stand of three axes [s].
inline constexpr double kProbe_s = 150.0;

// The axes stand at their marks. First each drive is told small moves: what the gyro feels of them
// says how much of each further move is to be commanded. Then each turns twice one way; from there
// the others are turned a little, so that their directions tell which axis is outside which; and
// twice back. Throws LimitError where the soft limits of an axis leave too little room, DataError
// where the gyro feels nothing, or far too much, of a drive.
Measurements Probe(const std::vector<config::AxisConfig>& axes, Devices& devices);

}  // namespace gyrobench::commission

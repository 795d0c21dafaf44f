// A manoeuvre before it is made, as the recording that it would give without noise.
#pragma once

#include <string>
#include <vector>

#include "base/geometry.h"
#include "calibration/signal/collector.h"

namespace gyrobench::calibration {

// A turn of one of the stand's axes: ramps at both ends, constant rate between. Table angles [deg].
struct ForeseenMove {
  StandAxis axis = StandAxis::kInner;
  double begin_s = 0.0;  // since the manoeuvre's begin
  double from_deg = 0.0, to_deg = 0.0;
  double rate_deg_s = 0.0;
  double acceleration_deg_s2 = 0.0;
};

struct Manoeuvre {
  std::string name;
  double duration_s = 0.0;
  bool affordable =
      true;  // there is time for it; otherwise it says what could be known, and is not chosen
  Vector3 begin_deg = {};           // angles of the stand's axes
  std::vector<ForeseenMove> moves;  // in order of time, those of one axis one after the other
  // Change of the sensor's temperature by somebody's hand, a fan's say: first-order, 120 s.
  double warms_degC = 0.0;
};

// Angle of the table at a time since the move's begin [deg].
double AngleOf(const ForeseenMove& move, double t_s);

// The recording of the manoeuvre after what has been recorded: its time goes on, the temperature
// drifts on to where it was going. The reference reads at 10 Hz without error, the gyro has the
// sensitivity of `units_per_deg_s` and no bias.
Recording Foresee(const Manoeuvre& manoeuvre, const Recording& so_far,
                  const Vector3& units_per_deg_s);

}  // namespace gyrobench::calibration

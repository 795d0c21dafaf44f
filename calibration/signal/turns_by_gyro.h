// Whole turns of a reference whose angle begins again at 180 or 360 deg, by what the gyro turned.
#pragma once

#include "base/measurement.h"
#include "calibration/signal/columns.h"
#include "calibration/signal/intake.h"

namespace gyrobench::calibration {

// Where a defect `reference_wrapped` is of turns that the gyro told.
inline constexpr const char* kByTheGyro = "as the gyro turned";
// The defect of an angle that is wrapped, and of which nothing tells the turns.
inline constexpr const char* kTurnsUnknown = "reference_turns_unknown";

// An angle that is read often is unwrapped as it comes (reference_track.h). Where the table may
// have turned by half a turn and more from one reading to the next, the readings alone do not say
// which way; the gyro does, as soon as its sensitivity is known roughly, from the other intervals:
//   u . dz / dt = b + g u . dtheta / dt     u: the axis, in the sensor's frame
// or as it is declared. In an angle that never leaves one turn and steps by more than half of one,
// the whole turns that bring each interval nearest to that are added to all readings from there on,
// where they bring every one near enough. Else the columns stay as they are, with the defect
// kTurnsUnknown. `read_range_deg`: of each axis, the largest reading less the smallest, as read.
void AddTurnsByGyro(const MeasurementInfo& info, const Vector3& read_range_deg, Columns* columns,
                    DefectLog* defects);

}  // namespace gyrobench::calibration

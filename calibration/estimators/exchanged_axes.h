// What the channels of the gyro follow of what the reference turns: their own axis, or another's,
// in one unit or in two.
#pragma once

#include <optional>
#include <string>

#include "base/measurement.h"
#include "calibration/signal/columns.h"

namespace gyrobench::calibration {

// A sentence that names another channel of the gyro which follows what the reference turns about
// `axis` (of the sensor's frame), while that of `axis` itself does not: columns exchanged, or a
// mounting that is not declared. Compared are the channels alone, so that no sensitivity needs to
// be known. Empty where none does.
std::string FollowedByAnother(const Columns& columns, SensorAxis axis);

// A sentence that names a channel of the gyro which follows what the reference turns about an axis
// for which there is no channel: a column that is named for another axis, or a mounting that is not
// declared. Empty where none does, or where no sensitivity tells how much of it.
std::string FollowedByAnotherAlone(const MeasurementInfo& info, const Columns& columns);

// Output of the channel of `axis` per deg/s of the reference about that axis [output unit /
// (deg/s)], from the mean rates of all intervals; nullopt where its output follows something else
// as well, or did not turn. No estimate: for telling by which factor the two differ, the same for
// every command.
std::optional<double> FollowedSensitivity(const Columns& columns, SensorAxis axis);

// A sentence that says from when on, and by which factor, where the mean rates of every channel
// that was turned both before and after one moment follow the reference on two lines
//   dz/dt = b + g w   before,   b' + g' w   after
// with g' / g the same in all of them and further from 1 than a part may be from its data sheet.
// Empty where none does, or where nothing was turned on both sides. Linear in the nodes.
std::string UnitChangeWithin(const Columns& columns);

}  // namespace gyrobench::calibration

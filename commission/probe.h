// Turns each drive of a stand a little, whatever its stand file says of it, and measures what moves.
#pragma once

#include <vector>

#include "commission/devices.h"
#include "commission/measurements.h"
#include "config/stand_config.h"

namespace gyrobench::commission {

// No table turns farther than this from where it stood, a drive whose ratio is 20 times off included.
inline constexpr double kFarthest_deg = 12.0;
// Of bench time, for a stand of three axes [s].
inline constexpr double kProbe_s = 150.0;

// The axes stand at their marks. First each drive is told half a degree: what the gyro feels of it
// says how much of each further move is to be commanded. Then each turns twice one way; from there
// the others are turned a little, so that their directions tell which axis is outside which; and
// twice back. Throws LimitError where the soft limits of an axis leave too little room, DataError
// where the gyro feels nothing, or far too much, of a drive.
Measurements Probe(const std::vector<config::AxisConfig>& axes, Devices& devices);

}  // namespace gyrobench::commission

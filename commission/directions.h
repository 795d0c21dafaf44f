// Which drive turns which axis, which way round, and how the sensor sits on the table: from the
// directions in which the gyro feels each drive.
#pragma once

#include <cstddef>
#include <vector>

#include "base/geometry.h"
#include "commission/measurements.h"

namespace gyrobench::commission {

// One way in which a stand may be wired.
struct Assignment {
  std::vector<std::size_t> axis_of_drive;  // index of the axis that the drive turns
  std::vector<int> sense_of_drive;         // -1: its positive turns are negative ones of the axis
  StandGeometry geometry;                  // with the mounting that fits best
  double mounting_off_deg = 0.0;           // from the configured one
  double misfit_deg = 0.0;                 // root mean square angle between seen and expected
};

// What the sensor feels: moves that turned enough to have a direction, and of which way is up with
// the axes at their marks; 0 where that is not known.
struct Felt {
  std::vector<const Move*> moves;
  Vector3 up = {};
};

// All ways that fit nearly as well as the best. A mounting about the only direction that is felt
// stays as it was. `stand_axes`: of each axis of the stand file, its place among outer, middle,
// inner. The angle that a drive turned its table by is `scales[drive]` times what was commanded.
std::vector<Assignment> FittingAssignments(const StandGeometry& configured,
                                           const std::vector<std::size_t>& stand_axes,
                                           const Felt& felt, const std::vector<double>& scales);

}  // namespace gyrobench::commission

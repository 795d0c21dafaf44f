// Of the ways in which a stand may be wired, that with the fewest mistakes.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "commission/axis_seen.h"
#include "commission/directions.h"
#include "commission/measurements.h"
#include "config/stand_config.h"

namespace gyrobench::commission {

// A sensor is glued on, and a stand built, to a degree or two.
inline constexpr double kMountingKnown_deg = 5.0;

// The axis that an encoder follows, as wired; none where it stood still.
std::optional<std::size_t> AxisOfEncoder(const Seen& seen, const Assignment& wired,
                                         std::size_t encoder);
// Whether its counts go the other way than its sign says.
bool CountsBackwards(const config::StandConfig& stand, const Seen& seen, const Assignment& wired,
                     std::size_t encoder);
// One encoder on each axis, and none twice.
bool EachFollowsItsOwn(const Seen& seen, const Assignment& wired);

struct Choice {
  Assignment wired;
  std::vector<Assignment> rivals;  // that take as many mistakes
};

// Of the assignments that fit what the gyro felt, and the accelerometer where it felt gravity as
// the geometry has it. Throws DataError where none does.
Choice Choose(const config::StandConfig& stand, const Measurements& measured, const Seen& seen);

}  // namespace gyrobench::commission

// Where gyro and reference contradict each other.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/measurement.h"
#include "calibration/estimators/schedule.h"

namespace gyrobench::calibration {

// What is left out of the estimates of one channel, for one of the two is wrong there and nothing
// says which.
struct PartedWays {
  std::vector<std::size_t> rows;  // of those that were looked at
  std::vector<Defect> defects;    // turn_disagrees, turned_at_rest
  // So many turns contradict each other that none can be left out.
  bool too_many = false;
};

// Once each.
void AddDefects(const std::vector<Defect>& found, std::vector<Defect>* defects);
// What it means for the result, as a sentence.
std::string SaysOf(const Defect& defect, bool too_many);

// Of a channel's rows from stop to stop or of its rests alone. A turn by which the two differ by
// far more than in the others: a slip, lost steps, or a reference that stood for a time. A rest by
// the reference in which the gyro turns: a reference that stands still, or a table that is free.
// What parts differ by is in all turns: only what stands out by ten robust standard deviations, by
// 0.1 deg and by 0.3 % of the turn counts, the first two in longer turns by as much more as those
// take longer than most; of a rest by 5 deg/s from the rests before (after) it, which a zero-rate
// offset that follows the temperature does not leave.
// `gravity_g_s` (GravityOver): of a turn in which gravity was another than at rest before and after
// it, what g-sensitivity within its data sheet's bound may make of that is no contradiction.
PartedWays FindPartedWays(const std::vector<Row>& rows, std::size_t channel, double units_per_deg_s,
                          const std::vector<Vector3>& gravity_g_s = {});

}  // namespace gyrobench::calibration

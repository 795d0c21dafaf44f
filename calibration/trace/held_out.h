// A figure before and after, from the squares of its parts.
#pragma once

#include <cstdint>
#include <vector>

#include "calibration/trace/angle_windows.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

struct HeldOutFigures {
  HeldOut whitened_rms, angle_rms_deg;
};

// Sums over the rows that a model is tried on: squares of the whitened residual, one sum a block,
// and the angle errors.
struct TriedRows {
  double rows = 0.0;
  std::vector<double> squares;
  Windows windows;
};
// The reductions with their 95 % intervals: blocks and windows drawn anew, with replacement.
HeldOutFigures Compare(const TriedRows& before, const TriedRows& after, std::uint64_t seed);

}  // namespace gyrobench::calibration

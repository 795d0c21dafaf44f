// Curves of two knots: the best ramp from one edge of a quantity's cells to another.
#pragma once

#include <cstddef>

#include "calibration/gls/white_store.h"

namespace gyrobench::calibration {

struct RampPeak {
  std::size_t from = 0, to = 0;  // edges
  double gain = 0.0;             // of the residual's square
  double tried = 0.0;            // ramps
};

// `cells`: of ramps from 0 to 1 across each cell; a longer ramp is the mean of those it crosses.
RampPeak SearchRamps(const WhiteStore::Remainder& cells);

}  // namespace gyrobench::calibration

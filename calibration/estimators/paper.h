// The estimates of the paper this bench began with, as it has them (docs: the method, eq. (1) to
// (5)).
#pragma once

#include <cstddef>
#include <vector>

#include "base/measurement.h"
#include "calibration/estimators/schedule.h"
#include "calibration/gls/interval_gls.h"
#include "calibration/gls/polynomial.h"

namespace gyrobench::calibration {

struct PaperScale {
  double alpha = kMissing;            // mean over the turns [deg/s per output unit]
  double alpha_std_error = kMissing;  // from the scatter of the turns
  double first_rest_alpha = kMissing;
  std::size_t turns = 0;
};

// Eq. (4), (5) for each turn of at least 1 deg, between rests:
//   alpha = phi / (int xi dt - eps dt),   eps: mean output at the rest before the turn
// (beta(T) cancels within a turn and its rest); then the mean. Once more with the first rest only.
PaperScale EstimatePaperScale(const std::vector<Row>& stop_rows, std::size_t channel);

struct PaperBias {
  std::vector<double> coefficients;  // in powers of u
  double rms_error = kMissing;       // of the smoothed output about the curve
};

// Smooths the mean output of each row with a Kalman filter (local level: white noise N^2/dt, random
// walk K^2 dt; Rauch-Tung-Striebel), then fits a polynomial by ordinary least squares. Its order is
// the one of the least BIC for the means before smoothing. `output`, `u`: one of each a row.
PaperBias EstimatePaperBias(const IntervalSeries& rows, const NoiseModel& noise,
                            const std::vector<double>& output, const std::vector<double>& u,
                            std::size_t max_order);

}  // namespace gyrobench::calibration

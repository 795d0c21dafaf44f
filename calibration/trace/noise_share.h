// How much of a noise of some rows the data want beside the noises of gyro and reference.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "calibration/gls/interval_gls.h"
#include "calibration/gls/noise_model.h"
#include "calibration/gls/raw_columns.h"

namespace gyrobench::calibration {

// The rows with a share of that noise.
using RowsWithShare = std::function<std::vector<Interval>(double share)>;

struct NoiseShare {
  double share = 0.0;  // 0 where the data do not want it
  std::optional<NoiseModel> noise;
};

// From none up to the first least, by the restricted deviance, each with the noise that suits it
// best: a 64th at least, 64 where the data want more. `columns`: everything that may act. `from`: a
// noise to begin with. `least_gain`: of the deviance, to be wanted.
NoiseShare BestShare(const RowsWithShare& with, std::span<const RawColumns> columns,
                     const Eigen::VectorXd& output_deg, const std::optional<NoiseModel>& from,
                     double least_gain);

}  // namespace gyrobench::calibration

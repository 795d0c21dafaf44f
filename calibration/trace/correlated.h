// What columns explain where the residual is not white.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gyrobench::calibration {

// Gain of -2 log L by white `columns`, whose coefficients have errors that allow for residuals that
// correlate over up to `reach` rows of a run and differ in size (Wald's statistic, the covariance
// of Newey and West 1987); not more than the gain beside a white residual. `columns`: rows x
// columns, the rest of the model taken off; `output`: white, with what the columns explain;
// `residual`: without it; `run_begins`: the first row of each run, ascending from 0.
double GainWhereCorrelated(const Eigen::MatrixXd& columns, const Eigen::VectorXd& output,
                           const Eigen::VectorXd& residual,
                           const std::vector<Eigen::Index>& run_begins, Eigen::Index reach);

}  // namespace gyrobench::calibration

// What columns explain where the residual is not white.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gyrobench::calibration {

// Residuals are taken to correlate over up to so many blocks: those over which whiteness is tested.
inline constexpr Eigen::Index kCorrelatedBlocks = 10;

struct CorrelatedGain {
  double gain = 0.0;  // of -2 log L
  int rank = 0;       // of the columns
};

// Wald's statistic of white `columns`, for errors that allow for residuals that differ in size and
// correlate over up to kCorrelatedBlocks blocks of `block` rows:
//   g = y' X S^-1 X' y,   S = G_0 + sum_l (1 - l/L) (G_l + G_l'),   G_l = sum_b z_b z_(b+l)'
// with z_b the sum of x_i r_i over the rows of block b (Newey and West 1987). Not more than beside
// a white residual. `columns`: rows x columns, the rest of the model projected out, zero where
// nothing is left; `output`: white, the rest of the model projected out; `residual`: without what
// the columns explain as well; `run_begins`: the first row of each unbroken run, ascending from 0.
CorrelatedGain GainWhereCorrelated(const Eigen::MatrixXd& columns, const Eigen::VectorXd& output,
                                   const Eigen::VectorXd& residual,
                                   const std::vector<Eigen::Index>& run_begins, Eigen::Index block);

}  // namespace gyrobench::calibration

// What columns explain where the likelihood alone is not to be trusted: residuals that are not
// white, and a choice among many that may hang on a part of the data.
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

// The same for errors that the rows of one cluster may share: S = sum_c z_c z_c', with z_c the sum
// of x_i r_i over the rows of cluster c. `cluster`: of each row, counted from 0.
//
// The columns explain something in n = (sum_c s_c)^2 / sum_c s_c^2 clusters, s_c being what they
// explain in cluster c. With k columns n - k degrees of freedom are left to know S by, and the gain
// is that of an unknown variance, (n - k) log(1 + g / n). Where hardly two rows share a cluster, as
// of a step, or no more than one degree is left, it is the gain beside a white residual.
CorrelatedGain GainWhereClustered(const Eigen::MatrixXd& columns, const Eigen::VectorXd& output,
                                  const Eigen::VectorXd& residual,
                                  const std::vector<std::size_t>& cluster);

// Stability selection (Meinshausen and Buehlmann 2010): in most of many random halves of the data,
// taken in blocks, `chosen` explains the residual best among the columns, or nearly so. The columns
// are white and have the model taken off; zero columns are none.
bool StaysBest(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual,
               Eigen::Index chosen);

}  // namespace gyrobench::calibration

#include "calibration/trace/correlated.h"

#include <algorithm>

#include "calibration/trace/noise_search.h"
#include "calibration/trace/scaled_ldlt.h"

namespace gyrobench::calibration {

double GainWhereCorrelated(const Eigen::MatrixXd& columns, const Eigen::VectorXd& output,
                           const Eigen::VectorXd& residual,
                           const std::vector<Eigen::Index>& run_begins, Eigen::Index reach) {
  const Eigen::MatrixXd gram = columns.transpose() * columns;
  const std::vector<Eigen::Index> kept = IndependentColumns(gram);
  const Eigen::MatrixXd score = residual.asDiagonal() * columns(Eigen::all, kept);
  Eigen::MatrixXd spread = score.transpose() * score;
  for (std::size_t r = 0; r < run_begins.size(); ++r) {
    const Eigen::Index end = r + 1 < run_begins.size() ? run_begins[r + 1] : score.rows();
    const auto run = score.middleRows(run_begins[r], end - run_begins[r]);
    for (Eigen::Index lag = 1; lag < std::min(reach, run.rows()); ++lag) {
      const double weight = 1.0 - static_cast<double>(lag) / static_cast<double>(reach);
      const Eigen::MatrixXd shared =
          run.topRows(run.rows() - lag).transpose() * run.bottomRows(run.rows() - lag);
      spread += weight * (shared + shared.transpose());
    }
  }
  const Eigen::VectorXd right = columns(Eigen::all, kept).transpose() * output;
  return std::min(ScaledLdlt(spread).Square(right), ScaledLdlt(gram(kept, kept)).Square(right));
}

}  // namespace gyrobench::calibration

#include "calibration/gls/correlated.h"

#include <algorithm>

#include "calibration/gls/noise_search.h"
#include "calibration/gls/scaled_ldlt.h"

namespace gyrobench::calibration {
namespace {

// Sums over blocks of rows; the last block of a run may be shorter.
Eigen::MatrixXd BlockSums(const Eigen::Ref<const Eigen::MatrixXd>& rows, Eigen::Index block) {
  Eigen::MatrixXd out((rows.rows() + block - 1) / block, rows.cols());
  for (Eigen::Index b = 0; b < out.rows(); ++b) {
    const Eigen::Index begin = b * block;
    out.row(b) = rows.middleRows(begin, std::min(block, rows.rows() - begin)).colwise().sum();
  }
  return out;
}

}  // namespace

CorrelatedGain GainWhereCorrelated(const Eigen::MatrixXd& columns, const Eigen::VectorXd& output,
                                   const Eigen::VectorXd& residual,
                                   const std::vector<Eigen::Index>& run_begins,
                                   Eigen::Index block) {
  const Eigen::MatrixXd gram = columns.transpose() * columns;
  const std::vector<Eigen::Index> kept = IndependentColumns(gram);
  if (kept.empty()) return {};
  const Eigen::MatrixXd score = residual.asDiagonal() * columns(Eigen::all, kept);
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(score.cols(), score.cols());
  for (std::size_t r = 0; r < run_begins.size(); ++r) {
    const Eigen::Index end = r + 1 < run_begins.size() ? run_begins[r + 1] : score.rows();
    const Eigen::MatrixXd sums =
        BlockSums(score.middleRows(run_begins[r], end - run_begins[r]), block);
    spread += sums.transpose() * sums;
    for (Eigen::Index lag = 1; lag < std::min(kCorrelatedBlocks, sums.rows()); ++lag) {
      const double weight = 1.0 - static_cast<double>(lag) / kCorrelatedBlocks;
      const Eigen::MatrixXd shared =
          sums.topRows(sums.rows() - lag).transpose() * sums.bottomRows(sums.rows() - lag);
      spread += weight * (shared + shared.transpose());
    }
  }
  const Eigen::VectorXd right = columns(Eigen::all, kept).transpose() * output;
  return {std::min(ScaledLdlt(gram(kept, kept)).Square(right), ScaledLdlt(spread).Square(right)),
          static_cast<int>(kept.size())};
}

}  // namespace gyrobench::calibration

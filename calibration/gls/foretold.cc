#include "calibration/gls/foretold.h"

#include <algorithm>

#include "calibration/gls/scaled_ldlt.h"

namespace gyrobench::calibration {
namespace {

double LogDeterminantOf(const Eigen::MatrixXd& information, const std::vector<Eigen::Index>& some) {
  return some.empty() ? 0.0 : ScaledLdlt(information(some, some)).LogDeterminant();
}

}  // namespace

double LogForetold(const Eigen::MatrixXd& training, const HeldOutRows& rows,
                   const std::vector<Eigen::Index>& own) {
  if (training.rows() == 0) return -rows.square;
  std::vector<Eigen::Index> trained;
  for (Eigen::Index j = 0; j < training.rows(); ++j) {
    if (std::ranges::find(own, j) == own.end()) trained.push_back(j);
  }
  Eigen::MatrixXd whole = rows.products;
  whole(trained, trained) += training(trained, trained);
  const ScaledLdlt factor(whole);
  // Without the last one a column of their own would count for the more, the larger its unit is.
  return -rows.square + factor.Square(rows.scores) - factor.LogDeterminant() +
         LogDeterminantOf(training, trained) + LogDeterminantOf(rows.products, own);
}

}  // namespace gyrobench::calibration

#include "calibration/gls/independent_columns.h"

#include <cmath>

#include "calibration/gls/scaled_ldlt.h"

namespace gyrobench::calibration {

std::vector<Eigen::Index> IndependentColumns(const Eigen::MatrixXd& gram, double tolerance) {
  std::vector<Eigen::Index> out;
  // Gram-Schmidt on the products: what is left of each column after those before it.
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(gram.rows(), gram.rows());
  for (Eigen::Index j = 0; j < gram.rows(); ++j) {
    const auto kept = static_cast<Eigen::Index>(out.size());
    double left = gram(j, j);
    Eigen::VectorXd row(kept);
    for (Eigen::Index k = 0; k < kept; ++k) {
      const Eigen::Index column = out[static_cast<std::size_t>(k)];
      row(k) = (gram(j, column) - row.head(k).dot(lower.row(k).head(k))) / lower(k, k);
      left -= row(k) * row(k);
    }
    if (!(left > tolerance * gram(j, j)) || !(gram(j, j) > 0)) continue;
    lower.row(kept).head(kept) = row;
    lower(kept, kept) = std::sqrt(left);
    out.push_back(j);
  }
  return out;
}

Eigen::VectorXd SolveIndependent(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right) {
  const std::vector<Eigen::Index> kept = IndependentColumns(gram);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(gram.rows());
  out(kept) = ScaledLdlt(gram(kept, kept)).Solve(Eigen::VectorXd(right(kept)));
  return out;
}

}  // namespace gyrobench::calibration

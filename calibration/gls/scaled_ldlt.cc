#include "calibration/gls/scaled_ldlt.h"

#include <algorithm>

#include "calibration/gls/interval_gls.h"

namespace gyrobench::calibration {

ScaledLdlt WithoutOthers(const Eigen::MatrixXd& products, const std::vector<Eigen::Index>& some) {
  std::vector<Eigen::Index> others;
  for (Eigen::Index j = 0; j < products.cols(); ++j) {
    if (!std::ranges::binary_search(some, j)) others.push_back(j);
  }
  Eigen::MatrixXd left = products(some, some);
  if (!others.empty()) {
    left -=
        products(some, others) * ScaledLdlt(products(others, others)).Solve(products(others, some));
  }
  for (Eigen::Index k = 0; k < left.cols(); ++k) {
    const Eigen::Index j = some[static_cast<std::size_t>(k)];
    if (!(left(k, k) < kDependent * products(j, j))) continue;
    left.row(k).setZero();
    left.col(k).setZero();
    left(k, k) = products(j, j);
  }
  return ScaledLdlt(left);
}

}  // namespace gyrobench::calibration

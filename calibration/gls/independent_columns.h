// Columns that say something that those before them do not.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/gls/interval_gls.h"

namespace gyrobench::calibration {

// Those of the columns that are independent of the ones before them, `gram` being their products.
std::vector<Eigen::Index> IndependentColumns(const Eigen::MatrixXd& gram,
                                             double tolerance = kDependent);
// Least squares from products; columns that depend on others get 0.
Eigen::VectorXd SolveIndependent(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right);

}  // namespace gyrobench::calibration

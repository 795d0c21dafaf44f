// Whether a choice among many hangs on a part of the data.
#pragma once

#include <Eigen/Core>

namespace gyrobench::calibration {

// Stability selection (Meinshausen and Buehlmann 2010): in most of many random halves of the data,
// taken in blocks, `chosen` explains the residual best among the columns, or nearly so. The columns
// are white and have the model taken off; zero columns are none.
bool StaysBest(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual,
               Eigen::Index chosen);

}  // namespace gyrobench::calibration

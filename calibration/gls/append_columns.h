// Columns next to columns.
#pragma once

#include <Eigen/Core>

namespace gyrobench::calibration {

// Moves what is there: many at once are placed in a matrix of their final size instead.
inline void AppendColumns(Eigen::MatrixXd* to, const Eigen::MatrixXd& columns) {
  to->conservativeResize(columns.rows(), to->cols() + columns.cols());
  to->rightCols(columns.cols()) = columns;
}

}  // namespace gyrobench::calibration

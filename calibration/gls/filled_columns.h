// Products of tall matrices with columns that are 0 over long stretches of rows, as the offset of a
// power-on is in the rows of all others. Each stretch leaves out what is 0 in all of it, so that
// the time that an analysis takes grows with its rows, and not with its power-ons besides.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gyrobench::calibration {

constexpr Eigen::Index kStretchRows = 256;  // that stay in the cache

// A value that is not a number is not 0.
inline bool IsZero(const Eigen::Ref<const Eigen::VectorXd>& values) {
  // Nearly all that is not 0 begins or ends so: the sum over all of it is the exception.
  return values.size() == 0 ||
         (values(0) == 0.0 && values(values.size() - 1) == 0.0 && values.cwiseAbs().sum() == 0.0);
}
// Columns that are not 0 in all rows of a stretch, in rising order.
std::vector<Eigen::Index> FilledColumns(const Eigen::Ref<const Eigen::MatrixXd>& stretch);

// Those of which a filter remembers something besides, of its two states.
std::vector<Eigen::Index> WithRemembered(const std::vector<Eigen::Index>& filled,
                                         const Eigen::ArrayXd& bias,
                                         const Eigen::ArrayXd& reference);

// left' right, for as many rows of both.
Eigen::MatrixXd TransposeTimes(const Eigen::Ref<const Eigen::MatrixXd>& left,
                               const Eigen::Ref<const Eigen::MatrixXd>& right);
// columns' columns
Eigen::MatrixXd Gram(const Eigen::Ref<const Eigen::MatrixXd>& columns);
// from - model coefficients
void TakeOff(const Eigen::Ref<const Eigen::MatrixXd>& model, const Eigen::MatrixXd& coefficients,
             Eigen::MatrixXd* from);

}  // namespace gyrobench::calibration

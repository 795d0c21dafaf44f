// Products of tall matrices with columns that are 0 over long stretches of rows, as the offset of a
// power-on is in the rows of all others. Each stretch leaves out the columns that are 0 in all of
// it: a product then takes as long as its columns are filled, however many power-ons there are.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

namespace gyrobench::calibration {

// Rows of a stretch: so many of all columns stay in the processor's cache.
constexpr Eigen::Index kStretchRows = 256;

// A value that is not a number is not 0.
inline bool IsZero(const Eigen::Ref<const Eigen::VectorXd>& values) {
  // Nearly all that is not 0 begins or ends so: the sum over all of it is the exception.
  return values.size() == 0 ||
         (values(0) == 0.0 && values(values.size() - 1) == 0.0 && values.cwiseAbs().sum() == 0.0);
}
// Columns that are not 0 in at least one row of a stretch, in rising order.
std::vector<Eigen::Index> FilledColumns(const Eigen::Ref<const Eigen::MatrixXd>& stretch);

// `at(first row, rows, filled columns, these columns side by side)`, of each stretch in turn that
// has any.
template <typename At>
void ForEachStretch(const Eigen::Ref<const Eigen::MatrixXd>& columns, const At& at) {
  Eigen::MatrixXd some;
  for (Eigen::Index begin = 0; begin < columns.rows(); begin += kStretchRows) {
    const Eigen::Index rows = std::min(kStretchRows, columns.rows() - begin);
    const auto stretch = columns.middleRows(begin, rows);
    const std::vector<Eigen::Index> filled = FilledColumns(stretch);
    if (filled.empty()) continue;
    some = stretch(Eigen::all, filled);
    at(begin, rows, filled, some);
  }
}

// The filled columns, and those that the filter still remembers from other rows: one of its two
// states of the column is not 0.
std::vector<Eigen::Index> WithRemembered(const std::vector<Eigen::Index>& filled,
                                         const Eigen::ArrayXd& bias,
                                         const Eigen::ArrayXd& reference);

// left' right (rows x p and rows x q give p x q). A value of `right` that is not a number does not
// show where `left` is 0 in a stretch.
Eigen::MatrixXd TransposeTimes(const Eigen::Ref<const Eigen::MatrixXd>& left,
                               const Eigen::Ref<const Eigen::MatrixXd>& right);
// columns' columns (rows x p gives p x p).
Eigen::MatrixXd Gram(const Eigen::Ref<const Eigen::MatrixXd>& columns);
// Takes model * coefficients off `from` (rows x p, p x q, rows x q), which must be another matrix.
void TakeOff(const Eigen::Ref<const Eigen::MatrixXd>& model, const Eigen::MatrixXd& coefficients,
             Eigen::MatrixXd* from);

}  // namespace gyrobench::calibration

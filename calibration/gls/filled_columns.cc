#include "calibration/gls/filled_columns.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

namespace gyrobench::calibration {
namespace {

using Columns = Eigen::Ref<const Eigen::MatrixXd>;

}  // namespace

std::vector<Eigen::Index> FilledColumns(const Columns& stretch) {
  std::vector<Eigen::Index> out;
  for (Eigen::Index j = 0; j < stretch.cols(); ++j) {
    if (!IsZero(stretch.col(j))) out.push_back(j);
  }
  return out;
}

std::vector<Eigen::Index> WithRemembered(const std::vector<Eigen::Index>& filled,
                                         const Eigen::ArrayXd& bias,
                                         const Eigen::ArrayXd& reference) {
  std::vector<Eigen::Index> out;
  std::size_t next = 0;
  for (Eigen::Index j = 0; j < bias.size(); ++j) {
    const bool here = next < filled.size() && filled[next] == j;
    if (here) ++next;
    if (here || bias(j) != 0.0 || reference(j) != 0.0) out.push_back(j);
  }
  return out;
}

Eigen::MatrixXd TransposeTimes(const Columns& left, const Columns& right) {
  assert(left.rows() == right.rows());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(left.cols(), right.cols());
  ForEachStretch(left, [&](Eigen::Index begin, Eigen::Index rows, const auto& filled,
                           const Eigen::MatrixXd& some) {
    out(filled, Eigen::all) += some.transpose() * right.middleRows(begin, rows);
  });
  return out;
}

Eigen::MatrixXd Gram(const Columns& columns) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
  ForEachStretch(columns,
                 [&](Eigen::Index, Eigen::Index, const auto& filled, const Eigen::MatrixXd& some) {
                   out(filled, filled) += some.transpose() * some;
                 });
  return out;
}

void TakeOff(const Columns& model, const Eigen::MatrixXd& coefficients, Eigen::MatrixXd* from) {
  assert(model.rows() == from->rows());
  ForEachStretch(model, [&](Eigen::Index begin, Eigen::Index rows, const auto& filled,
                            const Eigen::MatrixXd& some) {
    from->middleRows(begin, rows).noalias() -= some * coefficients(filled, Eigen::all);
  });
}

}  // namespace gyrobench::calibration

// Raw columns of a problem or of a part of its rows. A part keeps no copy: it picks its rows out of
// the columns of the whole.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

namespace gyrobench::calibration {

using SharedRows = std::shared_ptr<const std::vector<Eigen::Index>>;

class RawColumns {
 public:
  RawColumns() = default;
  RawColumns(Eigen::MatrixXd columns)  // NOLINT(google-explicit-constructor): a matrix is columns
      : whole_(std::make_shared<const Eigen::MatrixXd>(std::move(columns))) {}
  // With coefficients that are hardly larger than this, as NoiseSearch takes them.
  RawColumns Limited(double largest) const {
    RawColumns out = *this;
    out.largest_ = largest;
    return out;
  }
  // Of columns that have all rows.
  RawColumns Part(SharedRows rows) const {
    RawColumns out = *this;
    out.picked_ = std::move(rows);
    return out;
  }

  Eigen::Index rows() const {
    return picked_ ? static_cast<Eigen::Index>(picked_->size()) : whole_->rows();
  }
  Eigen::Index cols() const { return whole_->cols(); }
  double operator()(Eigen::Index row, Eigen::Index column) const {
    return (*whole_)(picked_ ? (*picked_)[static_cast<std::size_t>(row)] : row, column);
  }
  // Of one column, the rows from `first` on that `out` has room for.
  void CopyRows(Eigen::Index column, Eigen::Index first, Eigen::Ref<Eigen::VectorXd> out) const {
    if (picked_) {
      for (Eigen::Index i = 0; i < out.size(); ++i) out(i) = (*this)(first + i, column);
    } else {
      out = whole_->col(column).segment(first, out.size());
    }
  }
  Eigen::MatrixXd Copy() const {
    return picked_ ? Eigen::MatrixXd((*whole_)(*picked_, Eigen::all)) : *whole_;
  }
  bool allFinite() const { return whole_->allFinite(); }
  // Of each coefficient; infinite: it may be anything.
  double largest() const { return largest_; }

 private:
  std::shared_ptr<const Eigen::MatrixXd> whole_;
  SharedRows picked_;  // nullptr: all
  double largest_ = std::numeric_limits<double>::infinity();
};

// Columns next to columns. Moves what is there: many at once are placed in a matrix of their final
// size instead.
inline void AppendColumns(Eigen::MatrixXd* to, const Eigen::MatrixXd& columns) {
  to->conservativeResize(columns.rows(), to->cols() + columns.cols());
  to->rightCols(columns.cols()) = columns;
}

}  // namespace gyrobench::calibration

// White columns of everything that is compared, and their products: every model among them is then
// a small linear problem. A product is worked out when it is first asked for, as most of them never
// are: not for use by two threads at once.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace gyrobench::calibration {

class WhiteStore {
 public:
  using Columns = std::vector<Eigen::Index>;

  // `output`: white. Room for `capacity` columns.
  WhiteStore(const Eigen::VectorXd& output, Eigen::Index capacity);

  // Adds white columns; returns the indices they got. Grows when it must.
  Columns Add(const Eigen::Ref<const Eigen::MatrixXd>& columns);
  // The same of columns that are made where they stay: places to fill, which Add(count) then adds.
  Eigen::Ref<Eigen::MatrixXd> Places(Eigen::Index count);
  Columns Add(Eigen::Index count);
  // Products that are asked for anyway, in one pass over the rows: of the output and the first
  // columns with all; of neighbouring columns with each other.
  void MultiplyFirst(Eigen::Index count);
  void MultiplyEachOther(const Columns& columns);
  // Takes columns away again, those from `first` on.
  void DropFrom(Eigen::Index first) { used_ = first; }
  Eigen::Index used() const { return used_; }
  Eigen::Index rows() const { return white_.rows(); }
  auto column(Eigen::Index j) const { return white_.col(j + 1); }
  auto output() const { return white_.col(0); }
  // Further white rows, which the output has and only some columns are not zero in.
  void SetMoreOfOutput(Eigen::VectorXd more);
  void SetMore(const Columns& columns, const Eigen::MatrixXd& more);
  // What the model leaves of the output there.
  Eigen::VectorXd MoreOfResidual(std::span<const Eigen::Index> model) const;
  const Eigen::VectorXd& more_of_output() const { return more_[0]; }
  // Of a column, all rows.
  double Square(Eigen::Index column) const { return Product(column + 1, column + 1); }
  Eigen::MatrixXd Take(std::span<const Eigen::Index> columns) const {
    return Take(columns, 0, rows());
  }
  // The same of `count` rows from `first` on.
  Eigen::MatrixXd Take(std::span<const Eigen::Index> columns, Eigen::Index first,
                       Eigen::Index count) const;
  // Of columns with each other.
  Eigen::MatrixXd Products(std::span<const Eigen::Index> columns) const;

  // Least squares of the output; dependent columns count once.
  struct Fit {
    double residual_square = 0.0;
    int rank = 0;
  };
  Fit FitTo(std::span<const Eigen::Index> columns) const;
  // Coefficients of the least squares; zero for a dependent column.
  Eigen::VectorXd Solve(std::span<const Eigen::Index> columns) const;
  // Of columns, after the model is taken off them and off the output.
  struct Remainder {
    Eigen::MatrixXd products;  // of the columns with each other
    Eigen::VectorXd with_output;
  };
  Remainder RemainderOf(const Columns& columns, std::span<const Eigen::Index> model) const;
  // Share of a column's square that is left when the model is taken off it, 0..1.
  double Left(Eigen::Index column, std::span<const Eigen::Index> model) const;

 private:
  class Elimination;
  using Known = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>;

  double ProductOfMore(Eigen::Index i, Eigen::Index j) const;
  // By places, of which the output has the first.
  void Multiply(Eigen::Index row, Eigen::Index row_end, Eigen::Index column,
                Eigen::Index column_end);
  double Product(Eigen::Index i, Eigen::Index j) const;
  Eigen::MatrixXd Products(const std::vector<Eigen::Index>& rows,
                           const std::vector<Eigen::Index>& columns) const;

  Eigen::MatrixXd white_;              // the output is column 0
  std::vector<Eigen::VectorXd> more_;  // of each place; empty: zero
  mutable Eigen::MatrixXd gram_;
  mutable Known known_;  // of `gram_`
  Eigen::Index used_ = 0;
};

}  // namespace gyrobench::calibration

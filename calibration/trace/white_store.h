// White columns of everything that is compared, and their products: every model among them is then
// a small linear problem.
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
  // Takes columns away again, those from `first` on.
  void DropFrom(Eigen::Index first) { used_ = first; }
  Eigen::Index used() const { return used_; }
  Eigen::Index rows() const { return white_.rows(); }
  auto column(Eigen::Index j) const { return white_.col(j + 1); }
  auto output() const { return white_.col(0); }
  Eigen::MatrixXd Take(std::span<const Eigen::Index> columns) const;

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
  Eigen::MatrixXd white_, gram_;  // the output is column 0
  Eigen::Index used_ = 0;
};

}  // namespace gyrobench::calibration

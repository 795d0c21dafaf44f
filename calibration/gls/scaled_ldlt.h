// Equations of products of columns whose units differ by many orders: solved in columns of
// length 1.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "calibration/gls/filled_columns.h"

namespace gyrobench::calibration {

class ScaledLdlt {
 public:
  ScaledLdlt() = default;
  explicit ScaledLdlt(const Eigen::MatrixXd& gram)
      : scale_(gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse()),
        factor_(Eigen::MatrixXd(scale_.asDiagonal() * gram * scale_.asDiagonal())) {}

  // gram^-1 right
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& right) const {
    if (right.size() == 0) return right;  // Eigen solves nothing of size 0
    return scale_.asDiagonal() * factor_.solve(scale_.asDiagonal() * right);
  }

  // right' gram^-1 right
  double Square(const Eigen::VectorXd& right) const {
    const Eigen::VectorXd scaled = scale_.cwiseProduct(right);
    return scaled.dot(factor_.solve(scaled));
  }
  // The same of each column.
  Eigen::VectorXd Squares(const Eigen::MatrixXd& right) const {
    Eigen::MatrixXd z = factor_.transpositionsP() * (scale_.asDiagonal() * right);
    factor_.matrixL().solveInPlace(z);
    // As a solution with the factor has it: a direction of which nothing at all is left has none.
    const Eigen::VectorXd d = factor_.vectorD().unaryExpr([](double value) {
      return std::fabs(value) > std::numeric_limits<double>::min() ? 1.0 / value : 0.0;
    });
    return d.transpose() * z.cwiseAbs2();
  }

  // A direction that rounding alone is left of counts as that much.
  double LogDeterminant() const {
    constexpr double kRounding = 1e-14;
    return factor_.vectorD().array().max(kRounding).log().sum() - 2.0 * scale_.array().log().sum();
  }

 private:
  Eigen::VectorXd scale_;
  Eigen::LDLT<Eigen::MatrixXd> factor_;
};

// Of the products of `some` columns, in rising order, after all other columns are taken off them:
// its inverse is the part of the inverse of all `products` that belongs to them. A column that the
// others leave nothing of counts as one that says nothing.
ScaledLdlt WithoutOthers(const Eigen::MatrixXd& products, const std::vector<Eigen::Index>& some);

// What a group of columns explains where their coefficients can be no larger than something, as of
// Earth's rotation, whose rate is known and whose direction is not.
struct LimitedGain {
  double gain = 0.0;  // of -2 log L
  int rank = 0;       // directions of the coefficients that the data know
};

// Most of 2 b'c - c'Gc for coefficients c with |c| <= longest, and none along eigenvectors of G
// whose eigenvalue is below `least`, which are not known: c = (G + l)^-1 b, with l = 0 where that
// is short enough, and otherwise with the l that gives it this length.
//
// gram: G, products of the columns; scores: b, their products with the output, both after the rest
// of the model is taken off. Units: of one standard deviation per unit of a coefficient, squared
// and alone. `least` and `longest` must be above 0.
//
// J. J. More, D. C. Sorensen, Computing a trust region step, SIAM J. Sci. Stat. Comput. 4 (1983).
LimitedGain GainOfLength(const Eigen::MatrixXd& gram, const Eigen::VectorXd& scores, double least,
                         double longest);

// Takes a model's columns off others, by least squares.
class Projection {
 public:
  explicit Projection(Eigen::MatrixXd model) : model_(std::move(model)), factor_(Gram(model_)) {}

  // `coefficients`: filled with those of the model, where given.
  Eigen::MatrixXd Off(const Eigen::MatrixXd& columns,
                      Eigen::MatrixXd* coefficients = nullptr) const {
    const Eigen::MatrixXd of_model = factor_.Solve(TransposeTimes(model_, columns));
    Eigen::MatrixXd left = columns;
    TakeOff(model_, of_model, &left);
    if (coefficients != nullptr) *coefficients = of_model;
    return left;
  }

 private:
  Eigen::MatrixXd model_;
  ScaledLdlt factor_;
};

}  // namespace gyrobench::calibration

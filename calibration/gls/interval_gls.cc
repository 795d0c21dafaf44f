#include "calibration/gls/interval_gls.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/gls/white_products.h"

namespace gyrobench::calibration {

void IntervalSeries::Reserve(std::size_t rows) {
  intervals_.reserve(rows);
  values_.reserve(rows * static_cast<std::size_t>(columns_));
}

double* IntervalSeries::Add(const Interval& interval) {
  intervals_.push_back(interval);
  values_.resize(values_.size() + static_cast<std::size_t>(columns_), 0.0);
  return row(rows() - 1);
}

WhiteGram Whiten(const IntervalSeries& series, const NoiseModel& noise) {
  WhiteProducts white = ProductsUnder(series.intervals(), ColumnsInChunks(series.values()), noise);
  return {series.rows(), std::move(white.products), white.log_det};
}

GlsSolution Solve(const WhiteGram& gram, std::span<const int> regressors, int output) {
  const auto p = static_cast<Eigen::Index>(regressors.size());
  GlsSolution out;
  Eigen::MatrixXd information(p, p);
  Eigen::VectorXd right(p), scale(p);
  for (Eigen::Index i = 0; i < p; ++i) {
    const int column = regressors[static_cast<std::size_t>(i)];
    const double square = gram.products(column, column);
    if (!(square > 0) || !std::isfinite(square)) return out;
    scale(i) = 1.0 / std::sqrt(square);
  }
  for (Eigen::Index i = 0; i < p; ++i) {
    const int row = regressors[static_cast<std::size_t>(i)];
    right(i) = scale(i) * gram.products(row, output);
    for (Eigen::Index j = 0; j < p; ++j) {
      information(i, j) =
          scale(i) * scale(j) * gram.products(row, regressors[static_cast<std::size_t>(j)]);
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(information);
  if (p > 0 && factor.info() != Eigen::Success) return out;
  const Eigen::VectorXd pivots = factor.matrixLLT().diagonal();
  if (p > 0 && pivots.array().square().minCoeff() < kLeastIndependentShare) return out;
  const Eigen::VectorXd theta = factor.solve(right);
  const Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(p, p));
  const double square = gram.products(output, output) - theta.dot(right);
  out.residual_square = std::max(square, 0.0);
  out.log_det_information = 2.0 * (pivots.array().log().sum() - scale.array().log().sum());
  out.coefficients.resize(regressors.size());
  out.covariance.resize(regressors.size() * regressors.size());
  for (Eigen::Index i = 0; i < p; ++i) {
    out.coefficients[static_cast<std::size_t>(i)] = theta(i) * scale(i);
    for (Eigen::Index j = 0; j < p; ++j) {
      out.covariance[static_cast<std::size_t>(i * p + j)] = inverse(i, j) * scale(i) * scale(j);
    }
  }
  out.solvable = true;
  return out;
}

double Deviance(const WhiteGram& gram, const GlsSolution& solution) {
  return gram.log_det + solution.residual_square;
}

double RestrictedDeviance(const WhiteGram& gram, const GlsSolution& solution) {
  return gram.log_det + solution.residual_square + solution.log_det_information;
}

void Detrend(IntervalSeries* series, std::span<const int> regressors,
             std::span<const double> coefficients, int output) {
  for (std::size_t i = 0; i < series->rows(); ++i) {
    double* const row = series->row(i);
    for (std::size_t j = 0; j < regressors.size(); ++j)
      row[output] -= coefficients[j] * row[regressors[j]];
  }
}

std::vector<double> SolveAngles(const IntervalSeries& series, std::span<const int> regressors,
                                int output) {
  const auto columns = static_cast<Eigen::Index>(series.columns());
  WhiteGram gram{series.rows(), Eigen::MatrixXd::Zero(columns, columns), 0.0};
  Eigen::VectorXd angle = Eigen::VectorXd::Zero(columns), sum = angle;
  Eigen::MatrixXd square = gram.products;
  double n = 0.0;
  // Adds the products about the mean of one stretch, and begins the next.
  auto close = [&] {
    if (n > 0) gram.products += square - sum * sum.transpose() / n;
    angle.setZero();
    sum.setZero();
    square.setZero();
    n = 0.0;
  };
  for (std::size_t i = 0; i < series.rows(); ++i) {
    const Interval& interval = series.interval(i);
    if (interval.new_reference || interval.gap_before_s > 0) close();
    angle += Eigen::Map<const Eigen::VectorXd>(series.row(i), columns);
    sum += angle;
    square += angle * angle.transpose();
    n += 1.0;
  }
  close();
  return Solve(gram, regressors, output).coefficients;
}

}  // namespace gyrobench::calibration

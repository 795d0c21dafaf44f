#include "calibration/gls/interval_gls.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "calibration/gls/interval_filter.h"

namespace gyrobench::calibration {
namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr std::size_t kBlockRows = 64;
// Pivots of the information matrix, scaled to a unit diagonal, below which columns count as
// dependent.
constexpr double kLeastPivot = 1e-13;

// The states of all columns and the innovation of one row: plain arrays, so that the compiler
// vectorises.
void PassColumns(const Step& step, const double* in, double* out, double* bias, double* reference,
                 double* integral, std::size_t columns) {
  for (std::size_t j = 0; j < columns; ++j) {
    const double walked = step.bias_factor * bias[j];
    const double innovation = in[j] - walked - step.reference_factor * reference[j];
    bias[j] += step.gain_bias * innovation;
    reference[j] = step.reference_transition * reference[j] + step.gain_reference * innovation;
    integral[j] += walked + step.gain_integral * innovation;
    out[j] = step.inverse_sigma * innovation;
  }
}

void AddProducts(const double* block, std::size_t rows, RowMatrix* products) {
  const auto p = products->cols();
  if (p > 12) {
    const Eigen::Map<const RowMatrix> b(block, static_cast<Eigen::Index>(rows), p);
    products->selfadjointView<Eigen::Lower>().rankUpdate(b.transpose());
    return;
  }
  const auto columns = static_cast<std::size_t>(p);
  double* out = products->data();
  for (std::size_t r = 0; r < rows; ++r) {
    const double* row = block + r * columns;
    for (std::size_t i = 0; i < columns; ++i) {
      for (std::size_t j = 0; j <= i; ++j) out[i * columns + j] += row[i] * row[j];
    }
  }
}

}  // namespace

void IntervalSeries::Reserve(std::size_t rows) {
  intervals_.reserve(rows);
  values_.reserve(rows * static_cast<std::size_t>(columns_));
}

double* IntervalSeries::Add(const Interval& interval) {
  intervals_.push_back(interval);
  values_.resize(values_.size() + static_cast<std::size_t>(columns_), 0.0);
  return row(rows() - 1);
}

WhiteGram Whiten(const IntervalSeries& series, const IntervalNoise& noise) {
  return Whiten(series, noise, nullptr);
}

WhiteGram Whiten(const IntervalSeries& series, const IntervalNoise& noise,
                 std::vector<double>* white) {
  const auto columns = static_cast<std::size_t>(series.columns());
  std::vector<double> states(3 * columns, 0.0), block(kBlockRows * columns);
  RowMatrix products = RowMatrix::Zero(series.columns(), series.columns());
  CovarianceFilter filter(noise, series.reference_gain());
  WhiteGram out;
  out.columns = series.columns();
  out.rows = series.rows();
  if (white != nullptr) white->resize(series.rows() * columns);
  for (std::size_t i = 0; i < series.rows(); ++i) {
    const Step step = filter.Advance(series.interval(i));
    out.log_det += std::log(filter.variance());
    out.duration_s += series.interval(i).duration_s;
    if (series.interval(i).new_run) std::fill_n(states.begin(), 2 * columns, 0.0);
    double* const row = block.data() + (i % kBlockRows) * columns;
    PassColumns(step, series.row(i), row, states.data(), states.data() + columns,
                states.data() + 2 * columns, columns);
    if (white != nullptr) std::copy_n(row, columns, white->data() + i * columns);
    const bool last = i + 1 == series.rows();
    if (last || i % kBlockRows == kBlockRows - 1)
      AddProducts(block.data(), i % kBlockRows + 1, &products);
  }
  products.triangularView<Eigen::StrictlyUpper>() = products.transpose();
  out.products.assign(products.data(), products.data() + products.size());
  out.walk_integral_s.assign(states.begin() + static_cast<std::ptrdiff_t>(2 * columns),
                             states.end());
  out.walk_integral_variance = filter.integral_variance();
  return out;
}

GlsSolution Solve(const WhiteGram& gram, std::span<const int> regressors, int output) {
  const auto p = static_cast<Eigen::Index>(regressors.size());
  GlsSolution out;
  Eigen::MatrixXd information(p, p);
  Eigen::VectorXd right(p), scale(p);
  for (Eigen::Index i = 0; i < p; ++i) {
    const int column = regressors[static_cast<std::size_t>(i)];
    const double square = gram.product(column, column);
    if (!(square > 0) || !std::isfinite(square)) return out;
    scale(i) = 1.0 / std::sqrt(square);
  }
  for (Eigen::Index i = 0; i < p; ++i) {
    const int row = regressors[static_cast<std::size_t>(i)];
    right(i) = scale(i) * gram.product(row, output);
    for (Eigen::Index j = 0; j < p; ++j) {
      information(i, j) =
          scale(i) * scale(j) * gram.product(row, regressors[static_cast<std::size_t>(j)]);
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(information);
  if (p > 0 && factor.info() != Eigen::Success) return out;
  const Eigen::VectorXd pivots = factor.matrixLLT().diagonal();
  if (p > 0 && pivots.array().square().minCoeff() < kLeastPivot) return out;
  const Eigen::VectorXd theta = factor.solve(right);
  const Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(p, p));
  const double square = gram.product(output, output) - theta.dot(right);
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
  WhiteGram gram;
  gram.columns = series.columns();
  gram.rows = series.rows();
  RowMatrix products = RowMatrix::Zero(columns, columns);
  Eigen::VectorXd angle = Eigen::VectorXd::Zero(columns), sum = angle;
  RowMatrix square = products;
  double n = 0.0;
  // Adds the products about the mean of one stretch, and begins the next.
  auto close = [&] {
    if (n > 0) products += square - sum * sum.transpose() / n;
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
  gram.products.assign(products.data(), products.data() + products.size());
  return Solve(gram, regressors, output).coefficients;
}

}  // namespace gyrobench::calibration

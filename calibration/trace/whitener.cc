#include "calibration/trace/whitener.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::calibration {
namespace {

// Several columns at once: each waits for its own innovation before the next row, together they
// fill the pipeline.
template <std::size_t kColumns>
void Pass(std::span<const Step> steps, double* const* column) {
  double bias[kColumns] = {}, reference[kColumns] = {};
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Step& step = steps[i];
    for (std::size_t j = 0; j < kColumns; ++j) {
      bias[j] *= step.bias_keep;
      const double innovation =
          column[j][i] - step.bias_factor * bias[j] - step.reference_factor * reference[j];
      bias[j] += step.gain_bias * innovation;
      reference[j] = step.reference_keep * reference[j] + step.gain_reference * innovation;
      column[j][i] = step.inverse_sigma * innovation;
    }
  }
}

// Columns that are 0 here (constants of other measurements) cost nothing.
void AddProducts(const Eigen::Ref<const RowMajor>& white, Eigen::MatrixXd* gram) {
  Eigen::ArrayXd largest = Eigen::ArrayXd::Zero(white.cols());
  for (Eigen::Index i = 0; i < white.rows(); ++i)
    largest = largest.max(white.row(i).transpose().array().abs());
  std::vector<Eigen::Index> some;
  for (Eigen::Index j = 0; j < white.cols(); ++j) {
    if (largest(j) > 0.0) some.push_back(j);
  }
  if (static_cast<Eigen::Index>(some.size()) == white.cols()) {
    gram->selfadjointView<Eigen::Lower>().rankUpdate(white.transpose());
    return;
  }
  const RowMajor part = white(Eigen::all, some);
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(part.cols(), part.cols());
  products.selfadjointView<Eigen::Lower>().rankUpdate(part.transpose());
  for (std::size_t i = 0; i < some.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j)
      (*gram)(some[i], some[j]) +=
          products(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  }
}

}  // namespace

Whitener::Whitener(std::span<const Interval> intervals, const IntervalNoise& noise) {
  CovarianceFilter filter(noise, 1.0);
  steps_.reserve(intervals.size());
  // A logarithm of a few variances at once.
  constexpr std::size_t kTogether = 4;
  double product = 1.0;
  for (const Interval& interval : intervals) {
    steps_.push_back(filter.Advance(interval));
    product *= filter.variance();
    if (steps_.size() % kTogether != 0) continue;
    log_det_ += std::log(product);
    product = 1.0;
  }
  log_det_ += std::log(product);
}

Eigen::MatrixXd Whitener::Products(const RowMajor& columns) const {
  constexpr Eigen::Index kChunk = 256;  // rows, that stay in the cache
  const Eigen::Index p = columns.cols();
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(p, p);
  Eigen::ArrayXd bias = Eigen::ArrayXd::Zero(p), reference = bias, innovation = bias;
  RowMajor white(kChunk, p);
  for (Eigen::Index begin = 0; begin < columns.rows(); begin += kChunk) {
    const Eigen::Index count = std::min(kChunk, columns.rows() - begin);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Step& step = steps_[static_cast<std::size_t>(begin + i)];
      bias *= step.bias_keep;
      innovation = columns.row(begin + i).transpose().array() - step.bias_factor * bias -
                   step.reference_factor * reference;
      bias += step.gain_bias * innovation;
      reference = step.reference_keep * reference + step.gain_reference * innovation;
      white.row(i) = (step.inverse_sigma * innovation).matrix().transpose();
    }
    AddProducts(white.topRows(count), &gram);
  }
  return gram.selfadjointView<Eigen::Lower>();
}

void Whitener::Apply(Eigen::Ref<Eigen::MatrixXd> columns, Eigen::Index first) const {
  const std::span<const Step> steps(&steps_[static_cast<std::size_t>(first)],
                                    static_cast<std::size_t>(columns.rows()));
  constexpr std::size_t kTogether = 8;
  constexpr auto kStep = static_cast<Eigen::Index>(kTogether);
  Eigen::Index j = 0;
  for (; j + kStep <= columns.cols(); j += kStep) {
    double* pointers[kTogether];
    for (std::size_t k = 0; k < kTogether; ++k)
      pointers[k] = columns.col(j + static_cast<Eigen::Index>(k)).data();
    Pass<kTogether>(steps, pointers);
  }
  for (; j < columns.cols(); ++j) {
    double* pointer = columns.col(j).data();
    Pass<1>(steps, &pointer);
  }
}

// Backwards: r is what the states before a row are worth for all rows from it on.
//   r_i-1 = Z_i' v_i / s_i^2 + L_i' r_i,   u_i = v_i / s_i^2 - K_i' r_i,   L = T - K Z
Whitener::Shocks Whitener::Scores(const Eigen::MatrixXd& white) const {
  const auto n = static_cast<Eigen::Index>(rows());
  const Eigen::Index p = white.cols();
  Shocks out;
  out.bias.resize(n, p);
  out.output.resize(n, p);
  out.bias_information.resize(n);
  out.output_information.resize(n);
  Eigen::RowVectorXd bias = Eigen::RowVectorXd::Zero(p), reference = bias;
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  for (Eigen::Index i = n; i-- > 0;) {
    const Step& step = steps_[static_cast<std::size_t>(i)];
    const Eigen::Vector2d z(step.bias_factor, step.reference_factor);
    const Eigen::Vector2d k(step.gain_bias, step.gain_reference);
    Eigen::Matrix2d l = -k * z.transpose();
    l(0, 0) += 1.0;
    l(1, 1) += step.reference_keep;
    const double weight = step.inverse_sigma * step.inverse_sigma;
    out.output.row(i) = white.row(i) * step.inverse_sigma - k(0) * bias - k(1) * reference;
    out.output_information(i) = weight + k.dot(information * k);
    const Eigen::RowVectorXd innovation = out.output.row(i);
    // L' r + Z' v / s^2 = T' r + Z' u
    bias = bias + z(0) * innovation;
    reference = step.reference_keep * reference + z(1) * innovation;
    information = z * z.transpose() * weight + l.transpose() * information * l;
    out.bias.row(i) = bias;
    out.bias_information(i) = information(0, 0);
    // What comes before is nothing to a measurement that begins here.
    if (step.bias_keep == 0.0) {
      bias.setZero();
      reference.setZero();
      information.setZero();
    }
  }
  return out;
}

}  // namespace gyrobench::calibration

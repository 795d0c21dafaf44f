#include "calibration/gls/whitener.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace gyrobench::calibration {
namespace {

// What the filter remembers of one column between two of its rows.
struct ColumnState {
  double bias = 0.0, reference = 0.0;
};

// Several columns at once: each waits for its own innovation before the next row, together they
// fill the pipeline.
template <std::size_t kColumns>
void Pass(std::span<const Step> steps, double* const* column, ColumnState* states) {
  double bias[kColumns], reference[kColumns];
  for (std::size_t j = 0; j < kColumns; ++j) {
    bias[j] = states[j].bias;
    reference[j] = states[j].reference;
  }
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Step& step = steps[i];
    for (std::size_t j = 0; j < kColumns; ++j) {
      bias[j] *= step.bias_transition;
      const double innovation =
          column[j][i] - step.bias_factor * bias[j] - step.reference_factor * reference[j];
      bias[j] += step.gain_bias * innovation;
      reference[j] = step.reference_transition * reference[j] + step.gain_reference * innovation;
      column[j][i] = step.inverse_sigma * innovation;
    }
  }
  for (std::size_t j = 0; j < kColumns; ++j) states[j] = {bias[j], reference[j]};
}

// Rows and steps of a piece stay in the cache while all columns pass it.
constexpr Eigen::Index kPieceRows = 1024;

// `fill(column, first row, rows)` puts a column's raw values where they become white.
template <typename Fill>
void PassColumns(std::span<const Step> steps, Eigen::Ref<Eigen::MatrixXd>& columns,
                 const Fill& fill) {
  constexpr std::size_t kTogether = 8;
  constexpr auto kStep = static_cast<Eigen::Index>(kTogether);
  std::vector<ColumnState> states(static_cast<std::size_t>(columns.cols()));
  for (Eigen::Index begin = 0; begin < columns.rows(); begin += kPieceRows) {
    const Eigen::Index count = std::min(kPieceRows, columns.rows() - begin);
    const auto piece =
        steps.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(count));
    Eigen::Index j = 0;
    double* pointers[kTogether];
    auto take = [&](Eigen::Index column) {
      fill(column, begin, count);
      return &columns(begin, column);
    };
    for (; j + kStep <= columns.cols(); j += kStep) {
      for (std::size_t k = 0; k < kTogether; ++k)
        pointers[k] = take(j + static_cast<Eigen::Index>(k));
      Pass<kTogether>(piece, pointers, &states[static_cast<std::size_t>(j)]);
    }
    for (; j < columns.cols(); ++j) {
      pointers[0] = take(j);
      Pass<1>(piece, pointers, &states[static_cast<std::size_t>(j)]);
    }
  }
}

}  // namespace

Whitener::Whitener(std::span<const Interval> intervals, const NoiseModel& noise) {
  const double n = noise.angle_random_walk_deg_sqrt_s, k = noise.bias_random_walk_deg_s_sqrt_s,
               s = noise.reference_deg;
  FilterOf<double> filter(n * n, k * k, s * s);
  LogDeterminant log_det;
  steps_.reserve(intervals.size());
  for (const Interval& interval : intervals) {
    filter.Advance(interval);
    log_det.Add(filter.variance());
    steps_.push_back(filter.StepOf(interval, [](double value) { return value; }));
  }
  log_det_ = log_det.value();
  walk_integral_variance_ = filter.integral_variance();
}

Eigen::VectorXd Whitener::WalkIntegrals(const Eigen::Ref<const RowMajor>& columns) const {
  Eigen::RowVectorXd bias = Eigen::RowVectorXd::Zero(columns.cols());
  Eigen::RowVectorXd reference = bias, integral = bias, innovation = bias;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const Step& step = steps_[i];
    bias *= step.bias_transition;
    innovation = columns.row(static_cast<Eigen::Index>(i)) - step.bias_factor * bias -
                 step.reference_factor * reference;
    integral += step.bias_factor * bias + step.gain_integral * innovation;
    bias += step.gain_bias * innovation;
    reference = step.reference_transition * reference + step.gain_reference * innovation;
  }
  return integral.transpose();
}

void Whitener::Apply(Eigen::Ref<Eigen::MatrixXd> columns, Eigen::Index first) const {
  const std::span<const Step> all = steps_;
  PassColumns(
      all.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(columns.rows())),
      columns, [](Eigen::Index, Eigen::Index, Eigen::Index) {});
}

void Whitener::Whiten(std::span<const RawColumns> raw, Eigen::Ref<Eigen::MatrixXd> white) const {
  std::vector<std::pair<const RawColumns*, Eigen::Index>> from;
  for (const RawColumns& some : raw) {
    assert(some.rows() == white.rows());
    for (Eigen::Index j = 0; j < some.cols(); ++j) from.emplace_back(&some, j);
  }
  assert(white.rows() == static_cast<Eigen::Index>(rows()));
  assert(white.cols() == static_cast<Eigen::Index>(from.size()));
  PassColumns(steps_, white, [&](Eigen::Index column, Eigen::Index first, Eigen::Index count) {
    const auto& [some, place] = from[static_cast<std::size_t>(column)];
    some->CopyRows(place, first, white.col(column).segment(first, count));
  });
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
    l(1, 1) += step.reference_transition;
    const double weight = step.inverse_sigma * step.inverse_sigma;
    out.output.row(i) = white.row(i) * step.inverse_sigma - k(0) * bias - k(1) * reference;
    out.output_information(i) = weight + k.dot(information * k);
    const Eigen::RowVectorXd innovation = out.output.row(i);
    // L' r + Z' v / s^2 = T' r + Z' u
    bias = bias + z(0) * innovation;
    reference = step.reference_transition * reference + z(1) * innovation;
    information = z * z.transpose() * weight + l.transpose() * information * l;
    out.bias.row(i) = bias;
    out.bias_information(i) = information(0, 0);
    // What comes before is nothing to a measurement that begins here.
    if (step.bias_transition == 0.0) {
      bias.setZero();
      reference.setZero();
      information.setZero();
    }
  }
  return out;
}

}  // namespace gyrobench::calibration

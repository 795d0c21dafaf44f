#include "calibration/gls/whitener.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "calibration/gls/filled_columns.h"

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

// As many columns at once, from the `first` of `active` on; returns the first that is left.
template <std::size_t kColumns>
std::size_t PassTogether(std::span<const Step> piece, const std::vector<Eigen::Index>& active,
                         std::size_t first, Eigen::Ref<Eigen::MatrixXd> rows,
                         std::vector<ColumnState>* states) {
  for (; first + kColumns <= active.size(); first += kColumns) {
    double* pointers[kColumns];
    ColumnState some[kColumns];
    for (std::size_t k = 0; k < kColumns; ++k) {
      pointers[k] = &rows(0, active[first + k]);
      some[k] = (*states)[static_cast<std::size_t>(active[first + k])];
    }
    Pass<kColumns>(piece, pointers, some);
    for (std::size_t k = 0; k < kColumns; ++k)
      (*states)[static_cast<std::size_t>(active[first + k])] = some[k];
  }
  return first;
}

// `fill(column, first row, rows)` puts a column's raw values where they become white. What is 0 in
// all of a piece stays so, as long as the filter remembers nothing of it.
template <typename Fill>
void PassColumns(std::span<const Step> steps, Eigen::Ref<Eigen::MatrixXd>& columns,
                 const Fill& fill) {
  std::vector<ColumnState> states(static_cast<std::size_t>(columns.cols()));
  std::vector<Eigen::Index> active;
  for (Eigen::Index begin = 0; begin < columns.rows(); begin += kPieceRows) {
    const Eigen::Index count = std::min(kPieceRows, columns.rows() - begin);
    const auto piece =
        steps.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(count));
    active.clear();
    for (Eigen::Index j = 0; j < columns.cols(); ++j) {
      fill(j, begin, count);
      const ColumnState& state = states[static_cast<std::size_t>(j)];
      const bool remembered = state.bias != 0.0 || state.reference != 0.0;
      if (remembered || !IsZero(columns.col(j).segment(begin, count))) active.push_back(j);
    }
    const Eigen::Ref<Eigen::MatrixXd> rows = columns.middleRows(begin, count);
    const std::size_t first = PassTogether<8>(piece, active, 0, rows, &states);
    PassTogether<1>(piece, active, first, rows, &states);
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

// What the smoother remembers of some columns and of a shock, from the rows after.
struct Whitener::Smoother {
  Eigen::RowVectorXd bias, reference;
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
};

// Backwards: r is what the states before a row are worth for all rows from it on.
//   r_i-1 = Z_i' v_i / s_i^2 + L_i' r_i,   u_i = v_i / s_i^2 - K_i' r_i,   L = T - K Z
// `rows`: white, from `begin` on; they become the scores of the output, `bias` those of the bias.
void Whitener::Smooth(Eigen::Index begin, Smoother* smoother, RowMajor* rows, RowMajor* bias,
                      Shocks* out) const {
  Eigen::RowVectorXd& b = smoother->bias;
  Eigen::RowVectorXd& r = smoother->reference;
  Eigen::Matrix2d& information = smoother->information;
  for (Eigen::Index place = rows->rows(); place-- > 0;) {
    const Eigen::Index i = begin + place;
    const Step& step = steps_[static_cast<std::size_t>(i)];
    const Eigen::Vector2d z(step.bias_factor, step.reference_factor);
    const Eigen::Vector2d k(step.gain_bias, step.gain_reference);
    Eigen::Matrix2d l = -k * z.transpose();
    l(0, 0) += 1.0;
    l(1, 1) += step.reference_transition;
    const double weight = step.inverse_sigma * step.inverse_sigma;
    auto output = rows->row(place);
    output = output * step.inverse_sigma - k(0) * b - k(1) * r;
    out->output_information(i) = weight + k.dot(information * k);
    // L' r + Z' v / s^2 = T' r + Z' u
    b += z(0) * output;
    r = step.reference_transition * r + z(1) * output;
    information = z * z.transpose() * weight + l.transpose() * information * l;
    bias->row(place) = b;
    out->bias_information(i) = information(0, 0);
    // What comes before is nothing to a measurement that begins here.
    if (step.bias_transition == 0.0) {
      b.setZero();
      r.setZero();
      information.setZero();
    }
  }
}

Whitener::Shocks Whitener::Scores(const Eigen::MatrixXd& white) const {
  const auto n = static_cast<Eigen::Index>(rows());
  const Eigen::Index p = white.cols();
  Shocks out;
  out.bias = out.output = Eigen::MatrixXd::Zero(n, p);
  out.bias_information.resize(n);
  out.output_information.resize(n);
  Eigen::ArrayXd bias = Eigen::ArrayXd::Zero(p), reference = bias;
  Smoother smoother;
  RowMajor some, some_bias;
  const Eigen::Index stretches = (n + kStretchRows - 1) / kStretchRows;
  for (Eigen::Index stretch = stretches; stretch-- > 0;) {
    const Eigen::Index begin = stretch * kStretchRows, count = std::min(kStretchRows, n - begin);
    const auto rows_here = Eigen::seqN(begin, count);
    const std::vector<Eigen::Index> active =
        WithRemembered(FilledColumns(white.middleRows(begin, count)), bias, reference);
    some = white(rows_here, active);
    some_bias.resize(some.rows(), some.cols());
    smoother.bias = bias(active).transpose();
    smoother.reference = reference(active).transpose();
    Smooth(begin, &smoother, &some, &some_bias, &out);
    bias(active) = smoother.bias.transpose();
    reference(active) = smoother.reference.transpose();
    out.output(rows_here, active) = some;
    out.bias(rows_here, active) = some_bias;
  }
  return out;
}

}  // namespace gyrobench::calibration

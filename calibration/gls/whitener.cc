#include "calibration/gls/whitener.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace gyrobench::calibration {
namespace {

using RawRows = Eigen::Ref<const RowMajor>;

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

// The same of rows that lie one after the other, of a few neighbouring columns from `first` on.
// `bias`, `reference`: the states of all columns.
template <int kColumns>
void PassRows(std::span<const Step> steps, Eigen::Index first, RowMajor* rows, Eigen::ArrayXd* bias,
              Eigen::ArrayXd* reference) {
  using Some = Eigen::Array<double, kColumns, 1>;
  Some b = bias->segment<kColumns>(first), r = reference->segment<kColumns>(first);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Step& step = steps[i];
    Eigen::Map<Some> row(&(*rows)(static_cast<Eigen::Index>(i), first));
    b *= step.bias_transition;
    const Some innovation = row - step.bias_factor * b - step.reference_factor * r;
    b += step.gain_bias * innovation;
    r = step.reference_transition * r + step.gain_reference * innovation;
    row = step.inverse_sigma * innovation;
  }
  bias->segment<kColumns>(first) = b;
  reference->segment<kColumns>(first) = r;
}

// Some columns of raw rows, in rising order, side by side: as neighbours they pass together.
void Gather(const RawRows& raw, const std::vector<Eigen::Index>& columns, RowMajor* out) {
  out->resize(raw.rows(), static_cast<Eigen::Index>(columns.size()));
  for (Eigen::Index i = 0; i < raw.rows(); ++i) {
    const double* from = raw.data() + i * raw.outerStride();
    double* to = out->data() + i * out->cols();
    for (const Eigen::Index column : columns) *to++ = from[column];
  }
}

// All that are so many at once, from `first` on; returns the first that is left.
template <int kTogether>
Eigen::Index PassTogether(std::span<const Step> steps, Eigen::Index first, RowMajor* rows,
                          Eigen::ArrayXd* bias, Eigen::ArrayXd* reference) {
  for (; first + kTogether <= rows->cols(); first += kTogether)
    PassRows<kTogether>(steps, first, rows, bias, reference);
  return first;
}

void PassAllRows(std::span<const Step> steps, RowMajor* rows, Eigen::ArrayXd* bias,
                 Eigen::ArrayXd* reference) {
  Eigen::Index first = PassTogether<8>(steps, 0, rows, bias, reference);
  first = PassTogether<4>(steps, first, rows, bias, reference);
  first = PassTogether<2>(steps, first, rows, bias, reference);
  PassTogether<1>(steps, first, rows, bias, reference);
}

// Columns that are not 0 in some rows, or of which the filter remembers something.
std::vector<Eigen::Index> Active(const std::vector<Eigen::Index>& not_zero,
                                 const Eigen::ArrayXd& bias, const Eigen::ArrayXd& reference) {
  std::vector<Eigen::Index> out;
  std::size_t next = 0;
  for (Eigen::Index j = 0; j < bias.size(); ++j) {
    const bool here = next < not_zero.size() && not_zero[next] == j;
    if (here) ++next;
    if (here || bias(j) != 0.0 || reference(j) != 0.0) out.push_back(j);
  }
  return out;
}

void AddProducts(const RowMajor& white, const std::vector<Eigen::Index>& places,
                 Eigen::MatrixXd* gram) {
  if (white.cols() == gram->cols()) {
    gram->selfadjointView<Eigen::Lower>().rankUpdate(white.transpose());
    return;
  }
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(white.cols(), white.cols());
  products.selfadjointView<Eigen::Lower>().rankUpdate(white.transpose());
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j)
      (*gram)(places[i], places[j]) +=
          products(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  }
}

}  // namespace

Whitener::Whitener(std::span<const Interval> intervals, const NoiseModel& noise) {
  CovarianceFilter filter(noise);
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
  walk_integral_variance_ = filter.integral_variance();
}

ColumnsInChunks::ColumnsInChunks(RowMajor columns) : columns_(std::move(columns)) {
  for (Eigen::Index begin = 0; begin < columns_.rows(); begin += kChunk) {
    const Eigen::Index end = std::min(begin + kChunk, columns_.rows());
    // Sums, in which a value that is not a number stays one.
    Eigen::ArrayXd size = Eigen::ArrayXd::Zero(columns_.cols());
    for (Eigen::Index i = begin; i < end; ++i) size += columns_.row(i).transpose().array().abs();
    not_zero_.emplace_back();
    for (Eigen::Index j = 0; j < columns_.cols(); ++j) {
      if (!(size(j) == 0.0)) not_zero_.back().push_back(j);
    }
  }
}

Eigen::MatrixXd Whitener::Products(const ColumnsInChunks& columns) const {
  const Eigen::Index p = columns.all().cols();
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(p, p);
  Eigen::ArrayXd bias = Eigen::ArrayXd::Zero(p), reference = bias;
  const std::span<const Step> steps = steps_;
  RowMajor white;
  for (std::size_t chunk = 0; chunk < columns.chunks(); ++chunk) {
    const std::vector<Eigen::Index> active = Active(columns.not_zero(chunk), bias, reference);
    const RawRows raw = columns.rows(chunk);
    Gather(raw, active, &white);
    Eigen::ArrayXd some_bias = bias(active), some_reference = reference(active);
    PassAllRows(
        steps.subspan(chunk * ColumnsInChunks::kChunk, static_cast<std::size_t>(raw.rows())),
        &white, &some_bias, &some_reference);
    bias(active) = some_bias;
    reference(active) = some_reference;
    AddProducts(white, active, &gram);
  }
  return gram.selfadjointView<Eigen::Lower>();
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

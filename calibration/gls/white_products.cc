#include "calibration/gls/white_products.h"

#include <cassert>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>

#include "calibration/gls/interval_filter.h"

namespace gyrobench::calibration {
namespace {

using RawRows = Eigen::Ref<const RowMajor>;

// Rows that lie one after the other, of a few neighbouring columns from `first` on, become white.
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

// One noise of those that pass side by side: the steps of a chunk, and what comes of all so far.
struct NoisePass {
  std::vector<Step> steps;
  Eigen::ArrayXd bias, reference;  // what the filter remembers of each column
  Eigen::MatrixXd products;        // the lower half
  LogDeterminant log_det;
};

void AddChunk(const RawRows& raw, const std::vector<Eigen::Index>& not_zero, NoisePass* pass,
              RowMajor* white) {
  const std::vector<Eigen::Index> active = WithRemembered(not_zero, pass->bias, pass->reference);
  Gather(raw, active, white);
  Eigen::ArrayXd bias = pass->bias(active), reference = pass->reference(active);
  PassAllRows(pass->steps, white, &bias, &reference);
  pass->bias(active) = bias;
  pass->reference(active) = reference;
  AddProducts(*white, active, &pass->products);
}

// `Real`: of as many noises as there are passes; `of(value, k)`: of the k-th of them.
template <typename Real, typename Of>
std::vector<WhiteProducts> SideBySide(std::span<const Interval> intervals,
                                      const ColumnsInChunks& columns, FilterOf<Real> filter,
                                      std::size_t count, const Of& of) {
  const Eigen::Index p = columns.all().cols();
  std::vector<NoisePass> passes(count);
  for (NoisePass& pass : passes) {
    pass.bias = pass.reference = Eigen::ArrayXd::Zero(p);
    pass.products = Eigen::MatrixXd::Zero(p, p);
  }
  RowMajor white;
  for (std::size_t chunk = 0; chunk < columns.chunks(); ++chunk) {
    const RawRows raw = columns.rows(chunk);
    const auto here = intervals.subspan(chunk * kStretchRows, static_cast<std::size_t>(raw.rows()));
    for (NoisePass& pass : passes) pass.steps.resize(here.size());
    for (std::size_t i = 0; i < here.size(); ++i) {
      filter.Advance(here[i]);
      for (std::size_t k = 0; k < count; ++k) {
        const auto mine = [&](const Real& all) { return of(all, k); };
        passes[k].log_det.Add(mine(filter.variance()));
        passes[k].steps[i] = filter.StepOf(here[i], mine);
      }
    }
    for (NoisePass& pass : passes) AddChunk(raw, columns.not_zero(chunk), &pass, &white);
  }
  std::vector<WhiteProducts> out;
  for (const NoisePass& pass : passes)
    out.push_back({pass.products.selfadjointView<Eigen::Lower>(), pass.log_det.value()});
  return out;
}

}  // namespace

ColumnsInChunks::ColumnsInChunks(RowMajor columns) : columns_(std::move(columns)) {
  for (Eigen::Index begin = 0; begin < columns_.rows(); begin += kStretchRows) {
    const Eigen::Index end = std::min(begin + kStretchRows, columns_.rows());
    // Sums, in which a value that is not a number stays one.
    Eigen::ArrayXd size = Eigen::ArrayXd::Zero(columns_.cols());
    for (Eigen::Index i = begin; i < end; ++i) size += columns_.row(i).transpose().array().abs();
    not_zero_.emplace_back();
    for (Eigen::Index j = 0; j < columns_.cols(); ++j) {
      if (!(size(j) == 0.0)) not_zero_.back().push_back(j);
    }
  }
}

WhiteProducts ProductsUnder(std::span<const Interval> intervals, const ColumnsInChunks& columns,
                            const NoiseModel& noise) {
  std::vector<WhiteProducts> one = ProductsUnder(intervals, columns, std::span(&noise, 1));
  return {std::move(one.front().products), one.front().log_det};
}

std::vector<WhiteProducts> ProductsUnder(std::span<const Interval> intervals,
                                         const ColumnsInChunks& columns,
                                         std::span<const NoiseModel> noises) {
  constexpr std::size_t kLanes = 4;
  using Lanes = Eigen::Array<double, kLanes, 1>;
  assert(static_cast<Eigen::Index>(intervals.size()) == columns.all().rows());
  std::vector<WhiteProducts> out;
  for (; noises.size() > 1; noises = noises.subspan(std::min(noises.size(), kLanes))) {
    // Lanes that are left over repeat the last noise.
    const std::size_t count = std::min(noises.size(), kLanes);
    Lanes n, k, s;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const NoiseModel& noise = noises[std::min(lane, count - 1)];
      const auto place = static_cast<Eigen::Index>(lane);
      n(place) = noise.angle_random_walk_deg_sqrt_s;
      k(place) = noise.bias_random_walk_deg_s_sqrt_s;
      s(place) = noise.reference_deg;
    }
    std::vector<WhiteProducts> some = SideBySide(
        intervals, columns, FilterOf<Lanes>(n * n, k * k, s * s), count,
        [](const Lanes& of, std::size_t lane) { return of(static_cast<Eigen::Index>(lane)); });
    std::ranges::move(some, std::back_inserter(out));
  }
  for (const NoiseModel& noise : noises) {
    const double n = noise.angle_random_walk_deg_sqrt_s, k = noise.bias_random_walk_deg_s_sqrt_s,
                 s = noise.reference_deg;
    std::vector<WhiteProducts> one =
        SideBySide(intervals, columns, FilterOf<double>(n * n, k * k, s * s), 1,
                   [](double of, std::size_t) { return of; });
    out.push_back(std::move(one.front()));
  }
  return out;
}

}  // namespace gyrobench::calibration

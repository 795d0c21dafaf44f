#include "calibration/gls/white_products.h"

#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>

#include "calibration/gls/interval_filter.h"

namespace gyrobench::calibration {
namespace {

using RawRows = Eigen::Ref<const RowMajor>;

// Some neighbouring columns of rows that lie one after the other.
template <typename Value>
struct Neighbours {
  Value* first;         // of the first row
  Eigen::Index stride;  // from row to row
};

// kColumns of them become white. `bias`, `reference`: their states.
template <int kColumns>
void PassRows(std::span<const Step> steps, Neighbours<const double> raw, Neighbours<double> white,
              double* bias, double* reference) {
  using Some = Eigen::Array<double, kColumns, 1>;
  Eigen::Map<Some> bias_state(bias), reference_state(reference);
  Some b = bias_state, r = reference_state;
  for (const Step& step : steps) {
    b *= step.bias_transition;
    const Some innovation =
        Eigen::Map<const Some>(raw.first) - step.bias_factor * b - step.reference_factor * r;
    b += step.gain_bias * innovation;
    r = step.reference_transition * r + step.gain_reference * innovation;
    Eigen::Map<Some>(white.first) = step.inverse_sigma * innovation;
    raw.first += raw.stride;
    white.first += white.stride;
  }
  bias_state = b;
  reference_state = r;
}

// Columns of a chunk, in rising order, on their way to being white and side by side.
struct ChunkPass {
  const RawRows& raw;
  const std::vector<Eigen::Index>& columns;
  std::span<const Step> steps;
  RowMajor* white;
  Eigen::ArrayXd bias, reference;  // of these columns

  // All that are so many at once, from the `first` of them on; returns the first that is left.
  template <int kTogether>
  Eigen::Index PassTogether(Eigen::Index first) {
    for (; first + kTogether <= white->cols(); first += kTogether) {
      std::array<double, static_cast<std::size_t>(kTogether * kStretchRows)> copy;
      PassRows<kTogether>(steps, Take<kTogether>(first, copy.data()),
                          {white->data() + first, white->cols()}, bias.data() + first,
                          reference.data() + first);
    }
    return first;
  }

 private:
  // As they are where they lie side by side, otherwise copied to there.
  template <int kTogether>
  Neighbours<const double> Take(Eigen::Index first, double* copy) const {
    const Eigen::Index* some = columns.data() + first;
    if (some[kTogether - 1] - some[0] == kTogether - 1)
      return {raw.data() + some[0], raw.outerStride()};
    for (Eigen::Index i = 0; i < raw.rows(); ++i) {
      const double* from = raw.data() + i * raw.outerStride();
      for (int j = 0; j < kTogether; ++j) copy[i * kTogether + j] = from[some[j]];
    }
    return {copy, kTogether};
  }
};

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
  white->resize(raw.rows(), static_cast<Eigen::Index>(active.size()));
  ChunkPass chunk{raw, active, pass->steps, white, pass->bias(active), pass->reference(active)};
  Eigen::Index first = chunk.PassTogether<8>(0);
  first = chunk.PassTogether<4>(first);
  first = chunk.PassTogether<2>(first);
  chunk.PassTogether<1>(first);
  pass->bias(active) = chunk.bias;
  pass->reference(active) = chunk.reference;
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

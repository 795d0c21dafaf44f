#include "calibration/gls/white_products.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <iterator>
#include <utility>

#include "calibration/gls/interval_filter.h"

namespace gyrobench::calibration {
namespace {

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

// Columns of a chunk on their way to being white.
struct ChunkPass {
  const RowMajor& raw;
  std::span<const Step> steps;
  RowMajor* white;
  Eigen::ArrayXd bias, reference;  // of these columns

  // All that are so many at once, from the `first` of them on; returns the first that is left.
  template <int kTogether>
  Eigen::Index PassTogether(Eigen::Index first) {
    for (; first + kTogether <= raw.cols(); first += kTogether) {
      PassRows<kTogether>(steps, {raw.data() + first, raw.cols()},
                          {white->data() + first, raw.cols()}, bias.data() + first,
                          reference.data() + first);
    }
    return first;
  }
};

// The columns `active`, in rising order, of which the chunk holds some; the others are 0.
const RowMajor& ActiveIn(const ColumnsInChunks::Chunk& chunk,
                         const std::vector<Eigen::Index>& active, RowMajor* copy) {
  if (active.size() == chunk.not_zero.size()) return chunk.values;
  std::vector<Eigen::Index> places;  // in `active`, of those that the chunk holds
  std::size_t place = 0;
  for (const Eigen::Index column : chunk.not_zero) {
    while (active[place] != column) ++place;
    places.push_back(static_cast<Eigen::Index>(place));
  }
  copy->setZero(chunk.values.rows(), static_cast<Eigen::Index>(active.size()));
  for (Eigen::Index i = 0; i < copy->rows(); ++i) {
    for (std::size_t k = 0; k < places.size(); ++k)
      (*copy)(i, places[k]) = chunk.values(i, static_cast<Eigen::Index>(k));
  }
  return *copy;
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

// What chunks are worked on in: one after the other in the same memory.
struct Workspace {
  RowMajor active, white;
};

void AddChunk(const ColumnsInChunks::Chunk& columns, NoisePass* pass, Workspace* work) {
  const std::vector<Eigen::Index> active =
      WithRemembered(columns.not_zero, pass->bias, pass->reference);
  const RowMajor& raw = ActiveIn(columns, active, &work->active);
  work->white.resize(raw.rows(), raw.cols());
  ChunkPass chunk{raw, pass->steps, &work->white, pass->bias(active), pass->reference(active)};
  Eigen::Index first = chunk.PassTogether<8>(0);
  first = chunk.PassTogether<4>(first);
  first = chunk.PassTogether<2>(first);
  chunk.PassTogether<1>(first);
  pass->bias(active) = chunk.bias;
  pass->reference(active) = chunk.reference;
  AddProducts(work->white, active, &pass->products);
}

// `Real`: of as many noises as there are passes; `of(value, k)`: of the k-th of them.
template <typename Real, typename Of>
std::vector<WhiteProducts> SideBySide(std::span<const Interval> intervals,
                                      const ColumnsInChunks& columns, FilterOf<Real> filter,
                                      std::size_t count, const Of& of) {
  const Eigen::Index p = columns.cols();
  std::vector<NoisePass> passes(count);
  for (NoisePass& pass : passes) {
    pass.bias = pass.reference = Eigen::ArrayXd::Zero(p);
    pass.products = Eigen::MatrixXd::Zero(p, p);
  }
  Workspace work;
  for (const ColumnsInChunks::Chunk& chunk : columns.chunks()) {
    const std::span<const Interval> here =
        intervals.first(static_cast<std::size_t>(chunk.values.rows()));
    intervals = intervals.subspan(here.size());
    for (NoisePass& pass : passes) pass.steps.resize(here.size());
    for (std::size_t i = 0; i < here.size(); ++i) {
      filter.Advance(here[i]);
      for (std::size_t k = 0; k < count; ++k) {
        const auto mine = [&](const Real& all) { return of(all, k); };
        passes[k].log_det.Add(mine(filter.variance()));
        passes[k].steps[i] = filter.StepOf(here[i], mine);
      }
    }
    for (NoisePass& pass : passes) AddChunk(chunk, &pass, &work);
  }
  std::vector<WhiteProducts> out;
  for (const NoisePass& pass : passes)
    out.push_back({pass.products.selfadjointView<Eigen::Lower>(), pass.log_det.value()});
  return out;
}

}  // namespace

ColumnsInChunks::ColumnsInChunks(const Eigen::Ref<const RowMajor>& columns)
    : rows_(columns.rows()), cols_(columns.cols()) {
  for (Eigen::Index begin = 0; begin < rows_; begin += kStretchRows) {
    const auto here = columns.middleRows(begin, std::min(kStretchRows, rows_ - begin));
    // Sums, in which a value that is not a number stays one.
    const Eigen::ArrayXd size = here.cwiseAbs().colwise().sum().transpose();
    Chunk chunk;
    for (Eigen::Index j = 0; j < cols_; ++j) {
      if (!(size(j) == 0.0)) chunk.not_zero.push_back(j);
    }
    chunk.values = here(Eigen::all, chunk.not_zero);
    chunks_.push_back(std::move(chunk));
  }
}

ColumnsInChunks ColumnsInChunks::WithLastPlus(const Eigen::VectorXd& times,
                                              const std::vector<Eigen::Index>& stay) const {
  const Eigen::Index last = cols_ - 1;
  assert(times.size() == last);
  // Where each column goes to; nowhere.
  std::vector<Eigen::Index> place(static_cast<std::size_t>(cols_), -1);
  for (std::size_t j = 0; j < stay.size(); ++j)
    place[static_cast<std::size_t>(stay[j])] = static_cast<Eigen::Index>(j);
  ColumnsInChunks out;
  out.rows_ = rows_;
  out.cols_ = static_cast<Eigen::Index>(stay.size()) + 1;
  for (const Chunk& chunk : chunks_) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(chunk.values.rows());
    std::vector<Eigen::Index> kept;  // of those that the chunk holds
    Chunk left;
    for (std::size_t k = 0; k < chunk.not_zero.size(); ++k) {
      const Eigen::Index column = chunk.not_zero[k], held = static_cast<Eigen::Index>(k);
      sum += (column == last ? 1.0 : times(column)) * chunk.values.col(held);
      const Eigen::Index goes_to = place[static_cast<std::size_t>(column)];
      if (goes_to < 0) continue;
      kept.push_back(held);
      left.not_zero.push_back(goes_to);
    }
    left.not_zero.push_back(out.cols_ - 1);
    left.values.resize(chunk.values.rows(), static_cast<Eigen::Index>(kept.size()) + 1);
    left.values << chunk.values(Eigen::all, kept), sum;
    out.chunks_.push_back(std::move(left));
  }
  return out;
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
  assert(static_cast<Eigen::Index>(intervals.size()) == columns.rows());
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

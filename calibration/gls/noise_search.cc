#include "calibration/gls/noise_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "calibration/gls/filled_columns.h"
#include "calibration/gls/independent_columns.h"
#include "calibration/gls/minimize.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/gls/white_products.h"

namespace gyrobench::calibration {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Natural logarithms of K/N [1/s] and s/N [sqrt(s)].
constexpr double kLowestWalk = -14.0, kHighestWalk = 3.0, kLowestReference = -7.0,
                 kHighestReference = 12.0;

std::vector<double> Low(bool moving) {
  return moving ? std::vector{kLowestWalk, kLowestReference} : std::vector{kLowestWalk};
}
std::vector<double> High(bool moving) {
  return moving ? std::vector{kHighestWalk, kHighestReference} : std::vector{kHighestWalk};
}

// Where a search begins of which nothing is known.
std::vector<std::vector<double>> Grid(bool moving) {
  if (!moving) return {{-7.0}, {-3.5}};
  return {{-7.0, 0.5}, {-7.0, 3.0}, {-3.5, 0.5}, {-3.5, 3.0}};
}

}  // namespace

// Of the columns, and the output last, each scaled to a square of 1. What was taken off the output
// in the columns' name before, and 1 over the largest coefficient of each column.
struct NoiseSearch::Products {
  Eigen::MatrixXd scaled;
  Eigen::VectorXd log_scale;  // of the scales that did it
  double log_det = 0.0;       // of the covariance
  Eigen::VectorXd bulk, per_largest;

  Eigen::Index columns() const { return scaled.cols() - 1; }
  bool limited() const { return per_largest.size() > 0 && per_largest.maxCoeff() > 0.0; }
  double output_scale() const { return std::exp(log_scale(columns())); }
};

// Least squares of such products under an N, each limited coefficient being one more row: N times
// it over its largest size is 0.
struct NoiseSearch::Solved {
  Eigen::LLT<Eigen::MatrixXd> factor;  // of the products and these rows
  Eigen::VectorXd coefficients;        // of what is left of the output, scaled
  double square = 0.0;                 // that is left of the rows of the data
  double penalty = 0.0;                // of the others, in standard deviations
  double held = 0.0;                   // of how many coefficients they say what the data do not
  double information = 0.0;            // half the logarithm of its determinant
};

struct NoiseSearch::Deviances {
  double with = kInfinity, without = kInfinity;
};

NoiseSearch::NoiseSearch(std::span<const Interval> intervals, std::span<const RawColumns> columns,
                         const Eigen::VectorXd& output, double tolerance, double piece_s) {
  tolerance_ = tolerance;
  for (const Interval& interval : intervals) moving_ = moving_ || !interval.still;
  const std::vector<Eigen::Index> piece = InPieces(intervals, piece_s, &intervals_);
  Eigen::Index p = 0;
  for (const RawColumns& some : columns) p += some.cols();
  Eigen::VectorXd per_largest(p);
  Eigen::Index first = 0;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    per_largest.segment(first, columns[k].cols()).setConstant(1.0 / columns[k].largest());
    first += columns[k].cols();
    came_with_.resize(static_cast<std::size_t>(first), k);
  }
  RowMajor merged = RowMajor::Zero(static_cast<Eigen::Index>(intervals_.size()), p + 1);
  // A stretch at a time, while every column fills its place in it.
  const auto rows = static_cast<Eigen::Index>(intervals.size());
  Eigen::VectorXd here(kStretchRows);
  for (Eigen::Index begin = 0; begin < rows; begin += kStretchRows) {
    const Eigen::Index end = std::min(begin + kStretchRows, rows);
    Eigen::Index place = 0;
    for (const RawColumns& some : columns) {
      for (Eigen::Index j = 0; j < some.cols(); ++j, ++place) {
        some.CopyRows(j, begin, here.head(end - begin));
        if (IsZero(here.head(end - begin))) continue;  // as what is of another power-on
        for (Eigen::Index i = begin; i < end; ++i)
          merged(piece[static_cast<std::size_t>(i)], place) += here(i - begin);
      }
    }
    for (Eigen::Index i = begin; i < end; ++i)
      merged(piece[static_cast<std::size_t>(i)], p) += output(i);
  }
  Prepare(ColumnsInChunks(merged), per_largest, tolerance);
}

// Keeps only independent columns; takes the bulk off the output so that products keep digits.
void NoiseSearch::Prepare(ColumnsInChunks columns, const Eigen::VectorXd& per_largest,
                          double tolerance) {
  const Eigen::Index p = columns.cols() - 1;
  columns_ = std::move(columns);
  const Eigen::MatrixXd gram =
      ProductsUnder(intervals_, columns_, {1.0, 0.01, moving_ ? 1.0 : 0.0}).products;
  kept_ = IndependentColumns(gram.topLeftCorner(p, p), tolerance);
  const auto kept = static_cast<Eigen::Index>(kept_.size());
  per_largest_ = per_largest(kept_);
  for (std::size_t j = 0; j < kept_.size(); ++j)
    came_with_[j] = came_with_[static_cast<std::size_t>(kept_[j])];
  came_with_.resize(kept_.size());
  // Values that are no numbers have no likelihood.
  solvable_ = gram.allFinite() && columns_.rows() > kept;
  if (!solvable_) return;
  const Eigen::VectorXd right = gram.col(p)(kept_);
  Eigen::MatrixXd chosen = gram(kept_, kept_);
  bulk_ = ScaledLdlt(chosen).Solve(right);
  // Within the limits: what is far beyond them would cost the products' digits again.
  const double left_square = std::max(gram(p, p) - right.dot(bulk_), 0.0);
  chosen.diagonal().array() +=
      left_square / static_cast<double>(columns_.rows() - kept) * per_largest_.array().square();
  bulk_ = ScaledLdlt(chosen).Solve(right);
  Eigen::VectorXd taken_off = Eigen::VectorXd::Zero(p);
  taken_off(kept_) = -bulk_;
  columns_ = columns_.WithLastPlus(taken_off, kept_);
}

NoiseSearch::Products NoiseSearch::At(double walk, double reference) const {
  return Scaled(ProductsUnder(intervals_, columns_, {1.0, walk, reference}));
}

NoiseSearch::Products NoiseSearch::Scaled(const WhiteProducts& white) const {
  const Eigen::MatrixXd& full = white.products;
  const Eigen::VectorXd scale = full.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  return {scale.asDiagonal() * full * scale.asDiagonal(), scale.array().log(), white.log_det, bulk_,
          per_largest_};
}

std::optional<NoiseSearch::Solved> NoiseSearch::Solve(const Products& products, double n) {
  const Eigen::Index p = products.columns();
  const Eigen::ArrayXd scale = products.log_scale.head(p).array().exp();
  const double unit = products.output_scale();
  const Eigen::ArrayXd weight = (n * products.per_largest.array() * scale).square();
  const Eigen::ArrayXd taken = products.bulk.array() * unit / scale;
  Eigen::MatrixXd gram = products.scaled.topLeftCorner(p, p);
  gram.diagonal().array() += weight;
  const Eigen::VectorXd right = products.scaled.col(p).head(p).array() - weight * taken;
  Solved out;
  out.factor.compute(gram);
  if (out.factor.info() != Eigen::Success) return std::nullopt;
  const Eigen::VectorXd projected = out.factor.matrixL().solve(right);
  out.coefficients = out.factor.matrixU().solve(projected);
  const double of_limits = (weight * (out.coefficients.array() + taken).square()).sum();
  const double all =
      products.scaled(p, p) + (weight * taken.square()).sum() - projected.squaredNorm();
  out.square = std::max(all - of_limits, 0.0) / (unit * unit);
  out.penalty = of_limits > 0.0 ? of_limits / (unit * unit * n * n) : 0.0;
  out.information =
      out.factor.matrixLLT().diagonal().array().log().sum() - products.log_scale.head(p).sum();
  if (products.limited()) {
    const Eigen::MatrixXd inverse = out.factor.solve(Eigen::MatrixXd::Identity(p, p));
    out.held = (weight * inverse.diagonal().array()).sum();
  }
  return out;
}

double NoiseSearch::DevianceOf(const Products& products, const Solved& model,
                               const Solved& restricted, double n) const {
  const auto freedom = static_cast<double>(columns_.rows() - restricted.coefficients.size());
  return products.log_det + 2.0 * (restricted.information + freedom * std::log(n)) +
         model.square / (n * n) + model.penalty;
}

// N of a model without the limited columns; 0 where there are none, or it cannot be solved.
double NoiseSearch::WithoutLimited(const Products& products) const {
  if (!products.limited()) return 0.0;
  std::vector<Eigen::Index> limited;
  for (Eigen::Index j = 0; j < products.columns(); ++j) {
    if (products.per_largest(j) > 0.0) limited.push_back(j);
  }
  const Products free = Without(products, limited);
  const std::optional<Solved> solved = Solve(free, 0.0);
  if (!solved) return 0.0;
  return std::sqrt(solved->square / static_cast<double>(columns_.rows() - free.columns()));
}

// At the ratios of the products, with the N that suits them best: where the derivative is none,
//   N^2 = square / (rows - columns + held).
// A larger N leaves limited coefficients less; it is come to from above, since a column that may
// take the noise away would be free to under the small N that it makes.
NoiseSearch::Likeliest NoiseSearch::Profile(const Products& model,
                                            const Products& restricted) const {
  constexpr int kMostSteps = 30;
  constexpr double kSame = 1e-7;
  const bool one = &model == &restricted;
  const auto freedom = static_cast<double>(columns_.rows() - restricted.columns());
  double n = WithoutLimited(model);
  std::optional<Solved> solved, beside;
  for (int step = 0; step < kMostSteps; ++step) {
    solved = Solve(model, n);
    if (!one) beside = Solve(restricted, n);
    if (!solved || (!one && !beside)) return {};
    const double held = one ? solved->held : beside->held;
    const double next =
        std::max(std::sqrt(solved->square / (freedom + held)), kLeastAngleRandomWalk);
    const bool same = std::fabs(next - n) < kSame * n;
    n = next;
    if (same || !(model.limited() || restricted.limited())) break;
  }
  return {n, DevianceOf(model, *solved, one ? *solved : *beside, n)};
}

// Without a group's columns, whose part of the output it has again.
NoiseSearch::Products NoiseSearch::Without(const Products& products,
                                           const std::vector<Eigen::Index>& group) {
  const Eigen::Index p = products.columns();
  std::vector<Eigen::Index> others;
  for (Eigen::Index j = 0; j < p; ++j) {
    if (std::find(group.begin(), group.end(), j) == group.end()) others.push_back(j);
  }
  Eigen::VectorXd back = Eigen::VectorXd::Zero(p + 1);
  for (const Eigen::Index j : group)
    back(j) = products.bulk(j) * std::exp(products.log_scale(p) - products.log_scale(j));
  back(p) = 1.0;
  const Eigen::VectorXd output = products.scaled * back;
  Products out;
  out.log_det = products.log_det;
  out.bulk = products.bulk(others);
  out.per_largest = products.per_largest(others);
  others.push_back(p);
  out.scaled = products.scaled(others, others);
  out.log_scale = products.log_scale(others);
  const Eigen::Index q = out.columns();
  out.scaled.col(q) = output(others);
  out.scaled.row(q) = out.scaled.col(q).transpose();
  out.scaled(q, q) = back.dot(output);
  return out;
}

NoiseSearch::Deviances NoiseSearch::Contest(const Products& products,
                                            const std::vector<Eigen::Index>& group) const {
  const Products others = Without(products, group);
  return {Profile(products, others).deviance, Profile(others, others).deviance};
}

CoefficientEstimate NoiseSearch::FirstCoefficient(const NoiseModel& noise) const {
  if (!solvable_ || kept_.empty() || kept_.front() != 0) return {};
  const double n = noise.angle_random_walk_deg_sqrt_s;
  const Products products = At(noise.bias_random_walk_deg_s_sqrt_s / n, noise.reference_deg / n);
  const std::optional<Solved> solved = Solve(products, n);
  if (!solved) return {};
  const Eigen::VectorXd row = solved->factor.solve(Eigen::VectorXd::Unit(products.columns(), 0));
  const double scale = std::exp(products.log_scale(0));
  return {bulk_(0) + solved->coefficients(0) * scale / products.output_scale(),
          n * scale * std::sqrt(row(0))};
}

double NoiseSearch::Deviance(const NoiseModel& noise) const {
  if (!solvable_) return kInfinity;
  const double n = noise.angle_random_walk_deg_sqrt_s;
  const Products products = At(noise.bias_random_walk_deg_s_sqrt_s / n, noise.reference_deg / n);
  const std::optional<Solved> solved = Solve(products, n);
  return solved ? DevianceOf(products, *solved, *solved, n) : kInfinity;
}

// Logarithms of the ratios.
std::vector<double> NoiseSearch::Start(const NoiseModel& noise) const {
  const double unit = noise.angle_random_walk_deg_sqrt_s;
  std::vector<double> u = {
      std::clamp(std::log(noise.bias_random_walk_deg_s_sqrt_s / unit), kLowestWalk, kHighestWalk)};
  if (moving_)
    u.push_back(
        std::clamp(std::log(noise.reference_deg / unit), kLowestReference, kHighestReference));
  return u;
}

std::optional<NoiseEstimate> NoiseSearch::Best(const std::optional<NoiseModel>& start,
                                               double tolerance) const {
  if (!solvable_) return std::nullopt;
  // A place is come back to: from the grid, and from the simplex's best at the end.
  std::map<std::vector<double>, Likeliest> known;
  auto value_at = [&](const std::vector<double>& u) {
    const auto [place, is_new] = known.try_emplace(u);
    if (is_new) place->second = Profile(At(std::exp(u[0]), moving_ ? std::exp(u[1]) : 0.0));
    return place->second;
  };
  std::vector<double> best;
  double step = 1.0;
  if (start) {
    best = Start(*start);
    step = 0.3;
  } else {
    double least = kInfinity;
    for (const std::vector<double>& u : Grid(moving_)) {
      const double value = value_at(u).deviance;
      if (value < least) {
        least = value;
        best = u;
      }
    }
    if (best.empty()) return std::nullopt;
  }
  const auto deviance_at = [&](const std::vector<double>& u) { return value_at(u).deviance; };
  const Minimum minimum =
      Minimize(deviance_at, best, step, Low(moving_), High(moving_), tolerance, 60);
  const auto [n, deviance] = value_at(minimum.at);
  if (!std::isfinite(deviance)) return std::nullopt;
  return NoiseEstimate{
      {n, n * std::exp(minimum.at[0]), moving_ ? n * std::exp(minimum.at[1]) : 0.0}, deviance};
}

std::optional<NoiseEstimate> NoiseSearch::BestPlausible(const std::optional<NoiseModel>& start,
                                                        double tolerance) {
  std::optional<NoiseEstimate> best = Best(start, tolerance);
  // What the noise was with such columns says nothing of what it is without.
  while (best && LeaveOutImplausible(best->noise)) best = Best({}, tolerance);
  return best;
}

// Whether there were any.
bool NoiseSearch::LeaveOutImplausible(const NoiseModel& noise) {
  constexpr double kImplausible = 3.0;  // largest coefficients
  const double n = noise.angle_random_walk_deg_sqrt_s;
  const Products products = At(noise.bias_random_walk_deg_s_sqrt_s / n, noise.reference_deg / n);
  const std::optional<Solved> solved = Solve(products, n);
  if (!solved) return false;
  std::set<std::size_t> out;
  for (Eigen::Index j = 0; j < products.columns(); ++j) {
    const double value = bulk_(j) + solved->coefficients(j) * std::exp(products.log_scale(j)) /
                                        products.output_scale();
    if (std::fabs(value) * per_largest_(j) > kImplausible)
      out.insert(came_with_[static_cast<std::size_t>(j)]);
  }
  if (!out.empty()) LeaveOut(out);
  return !out.empty();
}

// Those that came with these. What was taken off the output is put back and taken off anew by
// those that stay.
void NoiseSearch::LeaveOut(const std::set<std::size_t>& given) {
  const auto columns = static_cast<Eigen::Index>(kept_.size());
  std::vector<Eigen::Index> stay, index;
  std::vector<std::size_t> came_with;
  for (Eigen::Index j = 0; j < columns; ++j) {
    const auto at = static_cast<std::size_t>(j);
    if (given.contains(came_with_[at])) continue;
    stay.push_back(j);
    index.push_back(kept_[at]);
    came_with.push_back(came_with_[at]);
  }
  came_with_ = std::move(came_with);
  Prepare(columns_.WithLastPlus(bulk_, stay), Eigen::VectorXd(per_largest_(stay)), tolerance_);
  for (Eigen::Index& kept : kept_) kept = index[static_cast<std::size_t>(kept)];
}

NoiseEstimate NoiseSearch::WithoutUnseen(const NoiseEstimate& best) const {
  constexpr double kNoGain = 1e-3;  // of the deviance
  NoiseEstimate out = best;
  const auto try_without = [&](double NoiseModel::*unseen) {
    NoiseModel ratios = out.noise;
    ratios.*unseen = 0.0;
    const double unit = ratios.angle_random_walk_deg_sqrt_s;
    const double walk = ratios.bias_random_walk_deg_s_sqrt_s / unit;
    const double reference = ratios.reference_deg / unit;
    const auto [n, deviance] = Profile(At(walk, reference));
    if (deviance <= out.deviance + kNoGain) out = {{n, n * walk, n * reference}, deviance};
  };
  try_without(&NoiseModel::bias_random_walk_deg_s_sqrt_s);
  if (moving_) try_without(&NoiseModel::reference_deg);
  return out;
}

NoiseEstimate NoiseSearch::WithMeanWalk(const NoiseEstimate& best) const {
  constexpr double kStep = 0.4, kHardlyAny = -8.0;  // of the logarithm of K/N
  constexpr double kUnlikely = 12.0;                // of the deviance
  constexpr int kMost = 24;
  const std::vector<double> start = Start(best.noise);
  const double reference = moving_ ? std::exp(start[1]) : 0.0;
  const double middle = std::max(start[0], kHardlyAny);
  double sum = 0.0, moment = 0.0;
  // Whether there may be more that counts beyond.
  auto add = [&](double u) {
    const double over = Profile(At(std::exp(u), reference)).deviance - best.deviance;
    const double weight = std::exp(u - 0.5 * over);  // even in K: du times K
    sum += weight;
    moment += weight * std::exp(u);
    return over < kUnlikely;
  };
  for (int i = 0; i < kMost && add(middle + i * kStep);) ++i;
  for (int i = 1; i < kMost / 3 && add(middle - i * kStep);) ++i;
  if (!(sum > 0.0) || !std::isfinite(moment)) return best;
  const double walk = moment / sum;
  const auto [n, deviance] = Profile(At(walk, reference));
  return {{n, n * walk, n * reference}, deviance};
}

std::vector<double> NoiseSearch::GainsOverNoise(
    const std::vector<std::vector<Eigen::Index>>& groups, const NoiseModel& start) const {
  // Any bias random walk, as a missing effect may ask for, closely where it usually is; more noise
  // of the reference. Logarithms of the ratios, the second relative to the start.
  constexpr std::array<double, 10> kWalk = {-6.5, -5.5, -4.7, -4.1, -3.5,
                                            -2.9, -2.3, -1.5, -0.5, 1.0};
  constexpr std::array<double, 3> kReference = {0.0, 0.3, 0.8};
  std::vector<std::vector<Eigen::Index>> mine(groups.size());
  for (std::size_t g = 0; g < groups.size(); ++g) {
    for (const Eigen::Index column : groups[g]) {
      const auto at = std::find(kept_.begin(), kept_.end(), column);
      if (at != kept_.end()) mine[g].push_back(at - kept_.begin());
    }
  }
  std::vector<double> out(groups.size(), 0.0);
  if (!solvable_) return out;
  const std::vector<double> low = Low(moving_), high = High(moving_), first = Start(start);
  std::vector<double> walks(kWalk.begin(), kWalk.end());
  walks.push_back(first[0]);
  std::vector<NoiseModel> noises;
  for (const double u : walks) {
    if (!moving_) {
      noises.push_back({1.0, std::exp(u), 0.0});
      continue;
    }
    for (const double reference : kReference)
      noises.push_back(
          {1.0, std::exp(u), std::exp(std::clamp(first[1] + reference, low[1], high[1]))});
  }
  std::vector<Deviances> least(groups.size());
  for (const WhiteProducts& white : ProductsUnder(intervals_, columns_, noises)) {
    const Products products = Scaled(white);
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const Deviances here = Contest(products, mine[g]);
      least[g].with = std::min(least[g].with, here.with);
      least[g].without = std::min(least[g].without, here.without);
    }
  }
  for (std::size_t g = 0; g < groups.size(); ++g)
    out[g] = std::max(least[g].without - least[g].with, 0.0);
  return out;
}

}  // namespace gyrobench::calibration

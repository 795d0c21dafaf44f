#include "calibration/gls/noise_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "calibration/gls/filled_columns.h"
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

// Index of the piece that each interval becomes a part of.
std::vector<Eigen::Index> Merge(std::span<const Interval> intervals, double piece_s,
                                std::vector<Interval>* merged) {
  std::vector<Eigen::Index> piece(intervals.size());
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const Interval& interval = intervals[i];
    const bool joins = interval.still && interval.GoesOn() && !merged->empty() &&
                       merged->back().still &&
                       merged->back().duration_s + interval.duration_s <= piece_s + 1e-6;
    if (joins) {
      merged->back().duration_s += interval.duration_s;
      merged->back().more_walk_s += interval.more_walk_s;
    } else {
      merged->push_back(interval);
    }
    piece[i] = static_cast<Eigen::Index>(merged->size()) - 1;
  }
  return piece;
}

// Square of the output that the columns leave [of its own], by a factor of their products.
double LeftBy(const Eigen::LLT<Eigen::MatrixXd>& factor, const Eigen::MatrixXd& scaled) {
  const Eigen::Index p = scaled.cols() - 1;
  const double taken = factor.matrixL().solve(scaled.col(p).head(p)).squaredNorm();
  return std::max(scaled(p, p) - taken, 0.0);
}

}  // namespace

// Of the columns, and the output last, each scaled to a square of 1.
struct NoiseSearch::Products {
  Eigen::MatrixXd scaled;
  Eigen::VectorXd log_scale;   // of the scales that did it
  double output_square = 0.0;  // of the output before
  double log_det = 0.0;        // of the covariance
};

struct NoiseSearch::Deviances {
  double with = kInfinity, without = kInfinity;
};

NoiseSearch::NoiseSearch(std::span<const Interval> intervals, std::span<const RawColumns> columns,
                         const Eigen::VectorXd& output, double tolerance, double piece_s) {
  for (const Interval& interval : intervals) moving_ = moving_ || !interval.still;
  const std::vector<Eigen::Index> piece = Merge(intervals, piece_s, &intervals_);
  Eigen::Index p = 0;
  for (const RawColumns& some : columns) p += some.cols();
  Eigen::VectorXd per_largest(p);
  Eigen::Index limited = 0;
  for (const RawColumns& some : columns) {
    per_largest.segment(limited, some.cols()).setConstant(1.0 / some.largest());
    limited += some.cols();
  }
  RowMajor merged = RowMajor::Zero(static_cast<Eigen::Index>(intervals_.size()), p + 1);
  // A stretch at a time, while every column fills its place in it.
  const auto rows = static_cast<Eigen::Index>(intervals.size());
  for (Eigen::Index begin = 0; begin < rows; begin += kStretchRows) {
    const Eigen::Index end = std::min(begin + kStretchRows, rows);
    Eigen::Index place = 0;
    for (const RawColumns& some : columns) {
      for (Eigen::Index j = 0; j < some.cols(); ++j, ++place) {
        for (Eigen::Index i = begin; i < end; ++i)
          merged(piece[static_cast<std::size_t>(i)], place) += some(i, j);
      }
    }
    for (Eigen::Index i = begin; i < end; ++i)
      merged(piece[static_cast<std::size_t>(i)], p) += output(i);
  }
  Prepare(std::move(merged), per_largest, tolerance);
}

// Keeps only independent columns; takes the bulk off the output so that products keep digits.
void NoiseSearch::Prepare(RowMajor columns, const Eigen::VectorXd& per_largest, double tolerance) {
  const Eigen::Index p = columns.cols() - 1;
  columns_ = ColumnsInChunks(std::move(columns));
  const Eigen::MatrixXd gram =
      ProductsUnder(intervals_, columns_, {1.0, 0.01, moving_ ? 1.0 : 0.0}).products;
  kept_ = IndependentColumns(gram.topLeftCorner(p, p), tolerance);
  const auto kept = static_cast<Eigen::Index>(kept_.size());
  per_largest_ = per_largest(kept_);
  // Values that are no numbers have no likelihood.
  solvable_ = gram.allFinite() && columns_.all().rows() > kept;
  if (!solvable_) return;
  const Eigen::VectorXd right = gram.col(p)(kept_);
  Eigen::MatrixXd chosen = gram(kept_, kept_);
  bulk_ = ScaledLdlt(chosen).Solve(right);
  // Within the limits: what is far beyond them would cost the products' digits again.
  const double left_square = std::max(gram(p, p) - right.dot(bulk_), 0.0);
  chosen.diagonal().array() += left_square / static_cast<double>(columns_.all().rows() - kept) *
                               per_largest_.array().square();
  bulk_ = ScaledLdlt(chosen).Solve(right);
  RowMajor left(columns_.all().rows(), kept + 1);
  left << columns_.all()(Eigen::all, kept_), columns_.all().col(p);
  left.rightCols(1) -= left.leftCols(kept) * bulk_;
  columns_ = ColumnsInChunks(std::move(left));
}

NoiseSearch::Products NoiseSearch::At(double walk, double reference) const {
  return Limited(Scaled(ProductsUnder(intervals_, columns_, {1.0, walk, reference})));
}

NoiseSearch::Products NoiseSearch::Scaled(const WhiteProducts& white) {
  const Eigen::MatrixXd& full = white.products;
  const Eigen::VectorXd scale = full.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  return {scale.asDiagonal() * full * scale.asDiagonal(), scale.array().log(),
          full(full.rows() - 1, full.rows() - 1), white.log_det};
}

// Each limited coefficient is one more row: 0 is what N times it over its largest size is. N is
// what the rows of the data alone say.
NoiseSearch::Products NoiseSearch::Limited(const Products& products) const {
  if (!(per_largest_.size() > 0 && per_largest_.maxCoeff() > 0.0)) return products;
  const Eigen::Index p = products.scaled.cols() - 1;
  const Eigen::LLT<Eigen::MatrixXd> factor(products.scaled.topLeftCorner(p, p));
  if (factor.info() != Eigen::Success) return products;
  const double square = LeftBy(factor, products.scaled) * products.output_square;
  const double n = std::sqrt(square / static_cast<double>(columns_.all().rows() - p));
  const Eigen::ArrayXd scale = products.log_scale.array().exp();
  const Eigen::ArrayXd column = n * per_largest_.array() * scale.head(p);
  const Eigen::ArrayXd output = n * per_largest_.array() * bulk_.array() * scale(p);
  Products out = products;
  out.scaled.diagonal().head(p).array() += column.square();
  out.scaled.col(p).head(p).array() -= column * output;
  out.scaled.row(p) = out.scaled.col(p).transpose();
  out.scaled(p, p) += output.square().sum();
  return out;
}

// Deviance at the ratios of the products, with the N that suits them best.
double NoiseSearch::Profile(const Products& products, double* n) const {
  const Eigen::Index p = products.scaled.cols() - 1;
  const Eigen::LLT<Eigen::MatrixXd> factor(products.scaled.topLeftCorner(p, p));
  if (factor.info() != Eigen::Success) return kInfinity;
  const double square = LeftBy(factor, products.scaled) * products.output_square;
  const auto freedom = static_cast<double>(columns_.all().rows() - p);
  *n = std::max(std::sqrt(square / freedom), kLeastAngleRandomWalk);
  const double information =
      factor.matrixLLT().diagonal().array().log().sum() - products.log_scale.head(p).sum();
  return products.log_det + 2.0 * information + freedom * (2.0 * std::log(*n) + 1.0);
}

// The group's columns moved behind the others: one factor serves both models.
NoiseSearch::Deviances NoiseSearch::Contest(const Products& products,
                                            const std::vector<Eigen::Index>& group) const {
  const Eigen::Index p = products.scaled.cols() - 1;
  std::vector<Eigen::Index> order;
  for (Eigen::Index j = 0; j < p; ++j) {
    if (std::find(group.begin(), group.end(), j) == group.end()) order.push_back(j);
  }
  const auto others = static_cast<Eigen::Index>(order.size());
  order.insert(order.end(), group.begin(), group.end());
  const Eigen::LLT<Eigen::MatrixXd> factor(products.scaled(order, order));
  if (factor.info() != Eigen::Success) return {};
  const Eigen::VectorXd scales = products.log_scale(order);
  const double information =
      factor.matrixLLT().diagonal().head(others).array().log().sum() - scales.head(others).sum();
  const auto freedom = static_cast<double>(columns_.all().rows() - others);
  auto deviance = [&](double share) {
    const double n2 = std::max(share * products.output_square / freedom,
                               kLeastAngleRandomWalk * kLeastAngleRandomWalk);
    return products.log_det + 2.0 * information + freedom * (std::log(n2) + 1.0);
  };
  const Eigen::VectorXd right = products.scaled.col(p)(order);
  const Eigen::VectorXd projected = factor.matrixL().solve(right);
  const double left = std::max(products.scaled(p, p) - projected.squaredNorm(), 0.0);
  // What was taken off the output in the group's name belongs to it again.
  Eigen::VectorXd group_part = Eigen::VectorXd::Zero(p);
  for (const Eigen::Index j : group)
    group_part(j) = bulk_(j) * std::exp(products.log_scale(p) - products.log_scale(j));
  const Eigen::VectorXd own =
      projected + factor.matrixL().transpose() * Eigen::VectorXd(group_part(order));
  return {deviance(left), deviance(left + own.tail(p - others).squaredNorm())};
}

CoefficientEstimate NoiseSearch::FirstCoefficient(const NoiseModel& noise) const {
  if (!solvable_ || kept_.empty() || kept_.front() != 0) return {};
  const double n = noise.angle_random_walk_deg_sqrt_s;
  const Products products = At(noise.bias_random_walk_deg_s_sqrt_s / n, noise.reference_deg / n);
  const Eigen::Index p = products.scaled.cols() - 1;
  const Eigen::LLT<Eigen::MatrixXd> factor(products.scaled.topLeftCorner(p, p));
  if (factor.info() != Eigen::Success) return {};
  const Eigen::VectorXd row = factor.solve(Eigen::VectorXd::Unit(p, 0));  // of the inverse
  const double scale = std::exp(products.log_scale(0));
  const double left = row.dot(products.scaled.col(p).head(p));
  return {bulk_(0) + left * scale * std::exp(-products.log_scale(p)),
          n * scale * std::sqrt(row(0))};
}

double NoiseSearch::Deviance(const NoiseModel& noise) const {
  if (!solvable_) return kInfinity;
  const double n = noise.angle_random_walk_deg_sqrt_s;
  const Products products = At(noise.bias_random_walk_deg_s_sqrt_s / n, noise.reference_deg / n);
  double best_n = 0.0;
  const double best = Profile(products, &best_n);
  const auto freedom = static_cast<double>(columns_.all().rows() - products.scaled.cols() + 1);
  const double ratio = best_n * best_n / (n * n);
  return best + freedom * (ratio - 1.0 - std::log(ratio));
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
  struct Value {
    double deviance = kInfinity, n = 0.0;
  };
  // A place is come back to: from the grid, and from the simplex's best at the end.
  std::map<std::vector<double>, Value> known;
  auto value_at = [&](const std::vector<double>& u) {
    const auto [place, is_new] = known.try_emplace(u);
    Value& value = place->second;
    if (is_new)
      value.deviance = Profile(At(std::exp(u[0]), moving_ ? std::exp(u[1]) : 0.0), &value.n);
    return value;
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
  const auto [deviance, n] = value_at(minimum.at);
  if (!std::isfinite(deviance)) return std::nullopt;
  return NoiseEstimate{
      {n, n * std::exp(minimum.at[0]), moving_ ? n * std::exp(minimum.at[1]) : 0.0}, deviance};
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
    double n = 0.0;
    const double deviance = Profile(At(walk, reference), &n);
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
    double n = 0.0;
    const double over = Profile(At(std::exp(u), reference), &n) - best.deviance;
    const double weight = std::exp(u - 0.5 * over);  // even in K: du times K
    sum += weight;
    moment += weight * std::exp(u);
    return over < kUnlikely;
  };
  for (int i = 0; i < kMost && add(middle + i * kStep);) ++i;
  for (int i = 1; i < kMost / 3 && add(middle - i * kStep);) ++i;
  if (!(sum > 0.0) || !std::isfinite(moment)) return best;
  double n = 0.0;
  const double walk = moment / sum;
  const double deviance = Profile(At(walk, reference), &n);
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
    const Products products = Limited(Scaled(white));
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

std::vector<Eigen::Index> IndependentColumns(const Eigen::MatrixXd& gram, double tolerance) {
  std::vector<Eigen::Index> out;
  // Gram-Schmidt on the products: what is left of each column after those before it.
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(gram.rows(), gram.rows());
  for (Eigen::Index j = 0; j < gram.rows(); ++j) {
    const auto kept = static_cast<Eigen::Index>(out.size());
    double left = gram(j, j);
    Eigen::VectorXd row(kept);
    for (Eigen::Index k = 0; k < kept; ++k) {
      const Eigen::Index column = out[static_cast<std::size_t>(k)];
      row(k) = (gram(j, column) - row.head(k).dot(lower.row(k).head(k))) / lower(k, k);
      left -= row(k) * row(k);
    }
    if (!(left > tolerance * gram(j, j)) || !(gram(j, j) > 0)) continue;
    lower.row(kept).head(kept) = row;
    lower(kept, kept) = std::sqrt(left);
    out.push_back(j);
  }
  return out;
}

Eigen::VectorXd SolveIndependent(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right) {
  const std::vector<Eigen::Index> kept = IndependentColumns(gram);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(gram.rows());
  out(kept) = ScaledLdlt(gram(kept, kept)).Solve(Eigen::VectorXd(right(kept)));
  return out;
}

}  // namespace gyrobench::calibration

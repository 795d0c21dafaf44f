#include "calibration/trace/noise_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/minimize.h"
#include "calibration/trace/whitener.h"

namespace gyrobench::calibration {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLeastN = 1e-12;
// Natural logarithms of K/N [1/s] and s/N [sqrt(s)].
constexpr double kLowWalk = -14.0, kHighWalk = 3.0, kLowReference = -7.0, kHighReference = 12.0;

// Index of the piece that each interval becomes a part of.
std::vector<Eigen::Index> Merge(std::span<const Interval> intervals, double piece_s,
                                std::vector<Interval>* merged) {
  std::vector<Eigen::Index> piece(intervals.size());
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const Interval& interval = intervals[i];
    const bool joins = interval.still && interval.gap_before_s == 0.0 && !interval.new_reference &&
                       !merged->empty() && merged->back().still &&
                       merged->back().duration_s + interval.duration_s <= piece_s + 1e-6;
    if (joins) {
      merged->back().duration_s += interval.duration_s;
    } else {
      merged->push_back(interval);
    }
    piece[i] = static_cast<Eigen::Index>(merged->size()) - 1;
  }
  return piece;
}

}  // namespace

struct NoiseSearch::Products {
  double residual_square = kInfinity;
  double log_det = 0.0;  // of the covariance, and of the information of what restricts
};

NoiseSearch::NoiseSearch(std::span<const Interval> intervals, const Eigen::MatrixXd& columns,
                         const Eigen::VectorXd& output, double piece_s)
    : NoiseSearch(intervals, columns, Eigen::MatrixXd(columns.rows(), 0), output, piece_s) {}

NoiseSearch::NoiseSearch(std::span<const Interval> intervals, const Eigen::MatrixXd& columns,
                         const Eigen::MatrixXd& tested, const Eigen::VectorXd& output,
                         double piece_s)
    : restricting_(columns.cols()) {
  for (const Interval& interval : intervals) moving_ = moving_ || !interval.still;
  const std::vector<Eigen::Index> piece = Merge(intervals, piece_s, &intervals_);
  const Eigen::Index p = columns.cols(), q = tested.cols();
  columns_ = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(intervals_.size()), p + q + 1);
  for (Eigen::Index j = 0; j <= p + q; ++j) {
    const double* in = j < p       ? columns.col(j).data()
                       : j < p + q ? tested.col(j - p).data()
                                   : output.data();
    for (std::size_t i = 0; i < intervals.size(); ++i) columns_(piece[i], j) += in[i];
  }
  Prepare();
}

// Keeps only independent columns; takes the bulk off the output so that products keep digits.
void NoiseSearch::Prepare() {
  Eigen::MatrixXd white = columns_;
  Whitener(intervals_, {1.0, 0.01, moving_ ? 1.0 : 0.0}).Apply(white);
  const Eigen::Index p = white.cols() - 1;
  const Eigen::MatrixXd gram = white.leftCols(p).transpose() * white.leftCols(p);
  const std::vector<Eigen::Index> keep = IndependentColumns(gram);
  const auto kept = static_cast<Eigen::Index>(keep.size());
  solvable_ = columns_.rows() >= kept + 2;
  if (!solvable_) return;
  const Eigen::MatrixXd chosen = white(Eigen::all, keep);
  const Eigen::VectorXd bulk =
      (chosen.transpose() * chosen).ldlt().solve(chosen.transpose() * white.col(p));
  Eigen::MatrixXd left(columns_.rows(), kept + 1);
  left << columns_(Eigen::all, keep), columns_.col(p);
  left.rightCols(1) -= left.leftCols(kept) * bulk;
  columns_ = std::move(left);
  restricting_ = std::count_if(keep.begin(), keep.end(),
                               [this](Eigen::Index column) { return column < restricting_; });
}

NoiseSearch::Products NoiseSearch::At(const IntervalNoise& noise) const {
  Products out;
  Eigen::MatrixXd white = columns_;
  const Whitener whitener(intervals_, noise);
  whitener.Apply(white);
  const Eigen::Index p = white.cols() - 1;
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(p + 1, p + 1);
  gram.selfadjointView<Eigen::Lower>().rankUpdate(white.transpose());
  const Eigen::VectorXd scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd full = gram.selfadjointView<Eigen::Lower>();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * full * scale.asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> factor(scaled.topLeftCorner(p, p));
  if (factor.info() != Eigen::Success) return out;
  const Eigen::VectorXd projected = factor.matrixL().solve(scaled.col(p).head(p));
  out.residual_square = std::max((1.0 - projected.squaredNorm()) * gram(p, p), 0.0);
  out.log_det = whitener.log_det() +
                2.0 * (factor.matrixLLT().diagonal().head(restricting_).array().log().sum() -
                       scale.head(restricting_).array().log().sum());
  return out;
}

double NoiseSearch::Deviance(const IntervalNoise& noise) const {
  if (!solvable_) return kInfinity;
  const Products products = At(noise);
  return products.log_det + products.residual_square;
}

// The same at given ratios, with the N that suits them best.
double NoiseSearch::Profile(double walk, double reference, double* n) const {
  const Products products = At({1.0, walk, reference});
  if (!std::isfinite(products.residual_square)) return kInfinity;
  const auto freedom = static_cast<double>(columns_.rows() - restricting_);
  *n = std::max(std::sqrt(products.residual_square / freedom), kLeastN);
  return products.log_det + freedom * (2.0 * std::log(*n) + 1.0);
}

std::optional<NoiseEstimate> NoiseSearch::Best(const std::optional<IntervalNoise>& start) const {
  if (!solvable_) return std::nullopt;
  double n = 0.0;
  auto at = [&](const std::vector<double>& u) {
    return Profile(std::exp(u[0]), moving_ ? std::exp(u[1]) : 0.0, &n);
  };
  std::vector<double> best;
  double step = 1.0;
  if (start && start->bias_random_walk_deg_s_sqrt_s > 0) {
    const double unit = start->angle_random_walk_deg_sqrt_s;
    best = {std::log(start->bias_random_walk_deg_s_sqrt_s / unit)};
    if (moving_) best.push_back(std::log(std::max(start->reference_deg / unit, 1e-3)));
    step = 0.3;
  } else {
    double least = kInfinity;
    for (const double walk : {-7.0, -3.5}) {
      for (const double reference : {0.5, 3.0}) {
        std::vector<double> u = {walk};
        if (moving_) u.push_back(reference);
        const double value = at(u);
        if (value < least) {
          least = value;
          best = u;
        }
        if (!moving_) break;
      }
    }
    if (best.empty()) return std::nullopt;
  }
  std::vector<double> low = {kLowWalk}, high = {kHighWalk};
  if (moving_) {
    low.push_back(kLowReference);
    high.push_back(kHighReference);
  }
  const Minimum minimum = Minimize(at, best, step, low, high, 0.02, 60);
  const double deviance = at(minimum.at);
  if (!std::isfinite(deviance)) return std::nullopt;
  return NoiseEstimate{
      {n, n * std::exp(minimum.at[0]), moving_ ? n * std::exp(minimum.at[1]) : 0.0}, deviance};
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

}  // namespace gyrobench::calibration

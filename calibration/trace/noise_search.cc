#include "calibration/trace/noise_search.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "calibration/minimize.h"
#include "calibration/trace/whitener.h"

namespace gyrobench::calibration {
namespace {

constexpr double kPiece_s = 1.0;
constexpr double kLeastN = 1e-12;
// Natural logarithms of K/N [1/s] and s/N [sqrt(s)].
constexpr double kLowWalk = -14.0, kHighWalk = 3.0, kLowReference = -7.0, kHighReference = 12.0;

struct Merged {
  std::vector<Interval> intervals;
  Eigen::MatrixXd columns;  // the output last
};

Merged Merge(std::span<const Interval> intervals, const Eigen::MatrixXd& columns,
             const Eigen::VectorXd& output) {
  Merged out;
  std::vector<Eigen::Index> piece(intervals.size());
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const Interval& interval = intervals[i];
    const bool joins = interval.still && interval.gap_before_s == 0.0 && !interval.new_reference &&
                       !out.intervals.empty() && out.intervals.back().still &&
                       out.intervals.back().duration_s + interval.duration_s <= kPiece_s + 1e-6;
    if (joins) {
      out.intervals.back().duration_s += interval.duration_s;
    } else {
      out.intervals.push_back(interval);
    }
    piece[i] = static_cast<Eigen::Index>(out.intervals.size()) - 1;
  }
  out.columns =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(out.intervals.size()), columns.cols() + 1);
  for (Eigen::Index j = 0; j <= columns.cols(); ++j) {
    const double* in = j < columns.cols() ? columns.col(j).data() : output.data();
    for (std::size_t i = 0; i < intervals.size(); ++i) out.columns(piece[i], j) += in[i];
  }
  return out;
}

class Profile {
 public:
  explicit Profile(Merged merged) : merged_(std::move(merged)) {}

  // Deviance of the restricted likelihood at the ratios, N in closed form (and kept).
  double At(double walk, double reference) {
    Eigen::MatrixXd white = merged_.columns;
    const Whitener whitener(merged_.intervals, {1.0, walk, reference});
    whitener.Apply(white);
    const Eigen::Index p = white.cols() - 1;
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(p + 1, p + 1);
    gram.selfadjointView<Eigen::Lower>().rankUpdate(white.transpose());
    const Eigen::VectorXd scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd full = gram.selfadjointView<Eigen::Lower>();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * full * scale.asDiagonal();
    const Eigen::LLT<Eigen::MatrixXd> factor(scaled.topLeftCorner(p, p));
    const auto freedom = static_cast<double>(white.rows() - p);
    if (factor.info() != Eigen::Success || freedom < 2) {
      return std::numeric_limits<double>::infinity();
    }
    const Eigen::VectorXd projected = factor.matrixL().solve(scaled.col(p).head(p));
    const double rest = std::max((1.0 - projected.squaredNorm()) * gram(p, p), 0.0);
    n_ = std::max(std::sqrt(rest / freedom), kLeastN);
    const double log_det = 2.0 * (factor.matrixLLT().diagonal().array().log().sum() -
                                  scale.head(p).array().log().sum());
    return whitener.log_det() + log_det + 2.0 * freedom * std::log(n_);
  }
  double n() const { return n_; }
  // Keeps only independent columns; takes the bulk off the output so that products keep digits.
  bool Prepare(bool moving) {
    Eigen::MatrixXd white = merged_.columns;
    Whitener(merged_.intervals, {1.0, 0.01, moving ? 1.0 : 0.0}).Apply(white);
    const Eigen::Index p = white.cols() - 1;
    const Eigen::MatrixXd gram = white.leftCols(p).transpose() * white.leftCols(p);
    const std::vector<Eigen::Index> keep = IndependentColumns(gram);
    if (merged_.columns.rows() < static_cast<Eigen::Index>(keep.size()) + 2) return false;
    Eigen::MatrixXd kept(merged_.columns.rows(), static_cast<Eigen::Index>(keep.size()) + 1);
    for (std::size_t j = 0; j < keep.size(); ++j)
      kept.col(static_cast<Eigen::Index>(j)) = merged_.columns.col(keep[j]);
    kept.rightCols(1) = merged_.columns.rightCols(1);
    Eigen::MatrixXd sub(gram.rows(), gram.cols());
    const Eigen::MatrixXd chosen = white(Eigen::all, keep);
    const Eigen::VectorXd bulk =
        (chosen.transpose() * chosen).ldlt().solve(chosen.transpose() * white.col(p));
    kept.rightCols(1) -= kept.leftCols(kept.cols() - 1) * bulk;
    merged_.columns = std::move(kept);
    return true;
  }

 private:
  Merged merged_;
  double n_ = 0.0;
};

}  // namespace

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

std::optional<IntervalNoise> SearchNoise(std::span<const Interval> intervals,
                                         const Eigen::MatrixXd& columns,
                                         const Eigen::VectorXd& output,
                                         const std::optional<IntervalNoise>& start) {
  bool moving = false;
  for (const Interval& interval : intervals) moving = moving || !interval.still;
  Profile profile(Merge(intervals, columns, output));
  if (!profile.Prepare(moving)) return std::nullopt;
  auto at = [&](const std::vector<double>& u) {
    return profile.At(std::exp(u[0]), moving ? std::exp(u[1]) : 0.0);
  };
  std::vector<double> best;
  double step = 1.0;
  if (start && start->bias_random_walk_deg_s_sqrt_s > 0) {
    best = {std::log(start->bias_random_walk_deg_s_sqrt_s / start->angle_random_walk_deg_sqrt_s)};
    if (moving)
      best.push_back(
          std::log(std::max(start->reference_deg, 1e-3 * start->angle_random_walk_deg_sqrt_s) /
                   start->angle_random_walk_deg_sqrt_s));
    step = 0.3;
  } else {
    double least = std::numeric_limits<double>::infinity();
    for (const double walk : {-7.0, -3.5}) {
      for (const double reference : {0.5, 3.0}) {
        std::vector<double> u = {walk};
        if (moving) u.push_back(reference);
        const double value = at(u);
        if (value < least) {
          least = value;
          best = u;
        }
        if (!moving) break;
      }
    }
    if (best.empty()) return std::nullopt;
  }
  std::vector<double> low = {kLowWalk}, high = {kHighWalk};
  if (moving) {
    low.push_back(kLowReference);
    high.push_back(kHighReference);
  }
  const Minimum minimum = Minimize(at, best, step, low, high, 0.02, 60);
  if (!std::isfinite(at(minimum.at))) return std::nullopt;
  const double n = profile.n();
  return IntervalNoise{n, n * std::exp(minimum.at[0]), moving ? n * std::exp(minimum.at[1]) : 0.0};
}

}  // namespace gyrobench::calibration

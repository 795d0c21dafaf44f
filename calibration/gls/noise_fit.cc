#include "calibration/gls/noise_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "calibration/gls/noise_search.h"
#include "calibration/gls/statistics.h"
#include "calibration/gls/white_products.h"
#include "calibration/gls/whitener.h"

namespace gyrobench::calibration {
namespace {

// Of the logarithms of K/N and s/N.
constexpr double kRatioTolerance = 3e-3;

IntervalSeries StillOnly(const IntervalSeries& series) {
  IntervalSeries out(series.columns());
  double passed_s = 0.0;
  for (std::size_t i = 0; i < series.rows(); ++i) {
    Interval interval = series.interval(i);
    if (!interval.still) {
      passed_s += interval.gap_before_s + interval.duration_s;
      continue;
    }
    interval.gap_before_s += passed_s;
    passed_s = 0.0;
    std::copy_n(series.row(i), series.columns(), out.Add(interval));
  }
  return out;
}

bool HasMoving(const IntervalSeries& series) {
  for (std::size_t i = 0; i < series.rows(); ++i) {
    if (!series.interval(i).still) return true;
  }
  return false;
}

}  // namespace

std::optional<NoiseModel> FitNoise(const IntervalSeries& series, const FitOptions& options) {
  const bool moving = HasMoving(series);
  if (moving && options.known_reference_deg) {
    FitOptions rest = options;
    rest.regressors = options.rest_regressors;
    rest.known_reference_deg.reset();
    std::optional<NoiseModel> out = FitNoise(StillOnly(series), rest);
    if (out) out->reference_deg = *options.known_reference_deg;
    return out;
  }
  // In the pieces that the series is made of.
  constexpr double kNoLongerPieces_s = 0.0;
  const Eigen::Map<const RowMajor> values = series.values();
  const NoiseSearch search(series.intervals(),
                           Eigen::MatrixXd(values(Eigen::all, options.regressors)),
                           values.col(options.output), kLeastIndependentShare, kNoLongerPieces_s);
  if (search.independent() < options.regressors.size()) return std::nullopt;
  const std::optional<NoiseEstimate> best = search.Best({}, kRatioTolerance);
  if (!best) return std::nullopt;
  return search.WithoutUnseen(*best).noise;
}

namespace {

// The restricted deviance and the log variances of the coefficients, as functions of shifts of the
// logarithms of those noises that were estimated and are not zero.
class NearOptimum {
 public:
  NearOptimum(const IntervalSeries& series, const FitOptions& options, const NoiseModel& noise)
      : intervals_(series.intervals()),
        columns_(series.values()),
        options_(options),
        noise_(noise) {
    if (noise.bias_random_walk_deg_s_sqrt_s > 0.0) free_.push_back(1);
    if (noise.reference_deg > 0.0 && !options.known_reference_deg) free_.push_back(2);
  }

  Eigen::Index size() const { return static_cast<Eigen::Index>(free_.size()); }
  // NaN where it cannot be solved.
  double At(Eigen::Index a, double shift_a, Eigen::Index b = 0, double shift_b = 0.0) {
    std::array<double, 3> shift = {};
    shift[free_[static_cast<std::size_t>(a)]] += shift_a;
    shift[free_[static_cast<std::size_t>(b)]] += shift_b;
    const NoiseModel noise = {noise_.angle_random_walk_deg_sqrt_s * std::exp(shift[0]),
                              noise_.bias_random_walk_deg_s_sqrt_s * std::exp(shift[1]),
                              noise_.reference_deg * std::exp(shift[2])};
    WhiteProducts white = ProductsUnder(intervals_, columns_, noise);
    const WhiteGram gram{intervals_.size(), std::move(white.products), white.log_det};
    const GlsSolution solution = Solve(gram, options_.regressors, options_.output);
    if (!solution.solvable) return std::numeric_limits<double>::quiet_NaN();
    const auto p = static_cast<Eigen::Index>(options_.regressors.size());
    log_variance_.resize(p);
    for (Eigen::Index i = 0; i < p; ++i) {
      log_variance_(i) = std::log(solution.variance(static_cast<std::size_t>(i)));
    }
    return RestrictedDeviance(gram, solution);
  }
  // Of the coefficients, at the last point asked for.
  const Eigen::VectorXd& log_variance() const { return log_variance_; }

 private:
  std::span<const Interval> intervals_;
  ColumnsInChunks columns_;
  const FitOptions& options_;
  NoiseModel noise_;
  std::vector<std::size_t> free_ = {0};  // indices of N, K, s
  Eigen::VectorXd log_variance_;
};

// Degrees of freedom of each coefficient's variance (Satterthwaite): with phi the logarithms of the
// estimated noises and A their covariance (inverse Hessian of the restricted likelihood),
//   nu = 2 / (g' A g),   g = d log variance / d phi
std::vector<double> Inflation(const IntervalSeries& series, const FitOptions& options,
                              const NoiseModel& noise) {
  const auto p = static_cast<Eigen::Index>(options.regressors.size());
  std::vector<double> out(options.regressors.size(), 1.0);
  NearOptimum near(series, options, noise);
  const Eigen::Index m = near.size();
  constexpr double kStep = 0.15;
  const double centre = near.At(0, 0.0);
  Eigen::MatrixXd hessian(m, m), gradient(p, m);
  for (Eigen::Index a = 0; a < m; ++a) {
    const double above = near.At(a, kStep);
    if (!std::isfinite(above)) return out;
    gradient.col(a) = near.log_variance();
    const double below = near.At(a, -kStep);
    if (!std::isfinite(below)) return out;
    gradient.col(a) = (gradient.col(a) - near.log_variance()) / (2.0 * kStep);
    hessian(a, a) = (above - 2.0 * centre + below) / (kStep * kStep);
    for (Eigen::Index b = 0; b < a; ++b) {
      const double mixed = near.At(a, kStep, b, kStep) - near.At(a, kStep, b, -kStep) -
                           near.At(a, -kStep, b, kStep) + near.At(a, -kStep, b, -kStep);
      hessian(a, b) = hessian(b, a) = mixed / (4.0 * kStep * kStep);
    }
  }
  if (!hessian.allFinite()) return out;
  // A noise that the data hardly see has a flat likelihood: at least a hundredth of one
  // observation.
  hessian.diagonal() = hessian.diagonal().cwiseMax(0.02);
  const Eigen::LDLT<Eigen::MatrixXd> factor(hessian);
  if (factor.info() != Eigen::Success || !factor.isPositive()) return out;
  for (Eigen::Index i = 0; i < p; ++i) {
    const Eigen::VectorXd g = gradient.row(i).transpose();
    // The covariance of phi is twice the inverse Hessian of the deviance (-2 log likelihood).
    const double spread = 2.0 * g.dot(factor.solve(g));
    if (spread > 0)
      out[static_cast<std::size_t>(i)] = StudentInflation(std::max(2.0 / spread, 2.0));
  }
  return out;
}

// White noise, least squares: good enough to take the bulk off.
std::vector<double> Pilot(const IntervalSeries& series, const FitOptions& options) {
  const GlsSolution solution =
      Solve(Whiten(series, NoiseModel{1.0, 0.0, 0.0}), options.regressors, options.output);
  return solution.coefficients;
}

}  // namespace

GlsFit FitIntervals(IntervalSeries series, const FitOptions& options) {
  GlsFit fit;
  const std::vector<double> pilot = Pilot(series, options);
  if (pilot.size() != options.regressors.size()) return fit;
  Detrend(&series, options.regressors, pilot, options.output);
  const std::optional<NoiseModel> noise = FitNoise(series, options);
  if (!noise) return fit;
  fit.noise = *noise;
  const Whitener whitener(series.intervals(), fit.noise);
  Eigen::MatrixXd white = series.values();
  whitener.Apply(white);
  const WhiteGram gram{series.rows(), white.transpose() * white, whitener.log_det()};
  fit.solution = Solve(gram, options.regressors, options.output);
  if (!fit.solution.solvable) return fit;
  fit.inflation = Inflation(series, options, fit.noise);
  fit.white_regressors = white(Eigen::all, options.regressors);
  const auto p = static_cast<Eigen::Index>(pilot.size());
  fit.white_residuals =
      white.col(options.output) -
      fit.white_regressors * Eigen::Map<Eigen::VectorXd>(fit.solution.coefficients.data(), p);
  fit.walk = IntegrateWalk(series, whitener);
  for (std::size_t j = 0; j < pilot.size(); ++j) {
    fit.solution.coefficients[j] += pilot[j];
    // The walk's integral of the output as given: the pilot's part put back.
    fit.walk.of_columns(options.output) += pilot[j] * fit.walk.of_columns(options.regressors[j]);
  }
  fit.solvable = true;
  return fit;
}

WalkIntegral IntegrateWalk(const IntervalSeries& series, const Whitener& whitener) {
  WalkIntegral out{whitener.WalkIntegrals(series.values()), whitener.walk_integral_variance(), 0.0};
  for (const Interval& interval : series.intervals()) out.duration_s += interval.duration_s;
  return out;
}

std::size_t OrderOfLeastBic(const WhiteGram& gram, std::size_t longest,
                            const std::function<FitOptions(std::size_t)>& options_of) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t order = 0; order <= longest; ++order) {
    const FitOptions options = options_of(order);
    const GlsSolution solution = Solve(gram, options.regressors, options.output);
    if (!solution.solvable) continue;
    const double bic = solution.residual_square +
                       static_cast<double>(order) * std::log(static_cast<double>(gram.rows));
    if (bic < least) {
      least = bic;
      best = order;
    }
  }
  return best;
}

// A = theta_i + (c_y - sum_j theta_j c_j) / T, with c the walk's integral as the filter ends with
// it.
MeanBias AverageBias(const GlsFit& fit, const FitOptions& options, std::size_t index) {
  const std::size_t p = options.regressors.size();
  std::vector<double> direction(p);
  MeanBias out;
  const double duration_s = fit.walk.duration_s;
  out.value = fit.walk.of_columns(options.output) / duration_s;
  for (std::size_t j = 0; j < p; ++j) {
    direction[j] =
        (j == index ? 1.0 : 0.0) - fit.walk.of_columns(options.regressors[j]) / duration_s;
    out.value += direction[j] * fit.solution.coefficients[j];
  }
  out.covariance.assign(p, 0.0);
  for (std::size_t i = 0; i < p; ++i) {
    for (std::size_t j = 0; j < p; ++j) {
      out.covariance[i] += fit.solution.covariance[i * p + j] * direction[j];
    }
  }
  out.variance = fit.walk.variance / (duration_s * duration_s);
  for (std::size_t i = 0; i < p; ++i) out.variance += direction[i] * out.covariance[i];
  return out;
}

double SandwichVariance(const GlsFit& fit, std::size_t index) {
  const std::size_t p = fit.solution.coefficients.size(),
                    n = static_cast<std::size_t>(fit.white_residuals.size());
  const std::size_t blocks = std::min<std::size_t>(n / 20, 30);
  if (blocks < 8) return std::numeric_limits<double>::quiet_NaN();
  const auto cols = static_cast<Eigen::Index>(p);
  const Eigen::Map<const RowMajor> covariance(fit.solution.covariance.data(), cols, cols);
  double sum = 0.0;
  for (std::size_t b = 0; b < blocks; ++b) {
    const auto begin = static_cast<Eigen::Index>(b * n / blocks);
    const auto size = static_cast<Eigen::Index>((b + 1) * n / blocks) - begin;
    const Eigen::VectorXd score = fit.white_regressors.middleRows(begin, size).transpose() *
                                  fit.white_residuals.segment(begin, size);
    sum += std::pow(covariance.row(static_cast<Eigen::Index>(index)).dot(score), 2);
  }
  const auto count = static_cast<double>(blocks);
  const double freedom = std::max(count - static_cast<double>(p), 1.0);
  return sum * count / freedom * std::pow(StudentInflation(freedom), 2);
}

}  // namespace gyrobench::calibration

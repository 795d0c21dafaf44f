#include "calibration/gls/noise_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "calibration/gls/minimize.h"
#include "calibration/gls/statistics.h"

namespace gyrobench::calibration {
namespace {

// Bounds of the ratios, natural logarithms: K/N [1/s], s/N [sqrt(s)]. Below the lower one it is as
// good as 0.
constexpr double kLowWalk = -16.0, kHighWalk = 4.0;
constexpr double kLowReference = -9.0, kHighReference = 14.0;
// A noise that gains less deviance than this is none.
constexpr double kNoGain = 1e-3;

struct Profile {
  double deviance = std::numeric_limits<double>::infinity();
  double n = 0.0;
};

// The restricted deviance with N in closed form, for the ratios k = K/N and s = s/N:
//   N^2 = RSS(1, k, s) / (n - p),   deviance = log det V(1, k, s) + log det X'V^-1X + (n - p) log
//   N^2
Profile ProfileAt(const IntervalSeries& series, const FitOptions& options, double k, double s) {
  Profile out;
  const WhiteGram gram = Whiten(series, IntervalNoise{1.0, k, s});
  const GlsSolution solution = Solve(gram, options.regressors, options.output);
  const double freedom =
      static_cast<double>(gram.rows) - static_cast<double>(options.regressors.size());
  if (!solution.solvable || freedom < 1.0) return out;
  out.n = std::max(std::sqrt(solution.residual_square / freedom), kLeastAngleRandomWalk);
  out.deviance = gram.log_det + solution.log_det_information + 2.0 * freedom * std::log(out.n);
  return out;
}

struct Ratios {
  double k = 0.0, s = 0.0;
};

Ratios SearchRatios(const IntervalSeries& series, const FitOptions& options, bool with_reference) {
  auto at = [&](const std::vector<double>& u) {
    return ProfileAt(series, options, std::exp(u[0]), u.size() > 1 ? std::exp(u[1]) : 0.0).deviance;
  };
  std::vector<double> best;
  double best_value = std::numeric_limits<double>::infinity();
  for (const double k : {-9.0, -5.5, -3.0}) {
    const std::vector<double> references =
        with_reference ? std::vector<double>{-1.0, 1.5, 4.0} : std::vector<double>{0.0};
    for (const double s : references) {
      std::vector<double> u = {k};
      if (with_reference) u.push_back(s);
      const double value = at(u);
      if (value < best_value) {
        best_value = value;
        best = u;
      }
    }
  }
  if (best.empty()) return {};
  std::vector<double> low = {kLowWalk}, high = {kHighWalk};
  if (with_reference) {
    low.push_back(kLowReference);
    high.push_back(kHighReference);
  }
  const Minimum minimum = Minimize(at, best, 1.0, low, high, 3e-3, 120);
  Ratios out{std::exp(minimum.at[0]), with_reference ? std::exp(minimum.at[1]) : 0.0};
  double value = minimum.value;
  const double without_walk = ProfileAt(series, options, 0.0, out.s).deviance;
  if (without_walk <= value + kNoGain) {
    out.k = 0.0;
    value = without_walk;
  }
  if (with_reference && ProfileAt(series, options, out.k, 0.0).deviance <= value + kNoGain)
    out.s = 0.0;
  return out;
}

IntervalSeries StillOnly(const IntervalSeries& series) {
  IntervalSeries out(series.columns(), series.reference_gain());
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

NoiseFit FitNoise(const IntervalSeries& series, const FitOptions& options) {
  NoiseFit out;
  const bool moving = HasMoving(series);
  if (moving && options.known_reference_deg) {
    FitOptions rest = options;
    rest.regressors = options.rest_regressors;
    rest.known_reference_deg.reset();
    out = FitNoise(StillOnly(series), rest);
    out.noise.reference_deg = *options.known_reference_deg;
    return out;
  }
  const Ratios ratios = SearchRatios(series, options, moving);
  const Profile profile = ProfileAt(series, options, ratios.k, ratios.s);
  if (!std::isfinite(profile.deviance)) return out;
  out.solvable = true;
  out.noise = {profile.n, ratios.k * profile.n, ratios.s * profile.n};
  out.angle_estimated = true;
  out.bias_estimated = ratios.k > 0;
  out.reference_estimated = ratios.s > 0;
  return out;
}

namespace {

// The restricted deviance and the log variances of the coefficients, as functions of shifts of the
// logarithms of those noises that were estimated and are not zero.
class NearOptimum {
 public:
  NearOptimum(const IntervalSeries& series, const FitOptions& options, const NoiseFit& fit)
      : series_(series), options_(options), noise_(fit.noise) {
    if (fit.angle_estimated) free_.push_back(0);
    if (fit.bias_estimated) free_.push_back(1);
    if (fit.reference_estimated) free_.push_back(2);
  }

  Eigen::Index size() const { return static_cast<Eigen::Index>(free_.size()); }
  // NaN where it cannot be solved.
  double At(Eigen::Index a, double shift_a, Eigen::Index b = 0, double shift_b = 0.0) {
    std::array<double, 3> shift = {};
    shift[free_[static_cast<std::size_t>(a)]] += shift_a;
    shift[free_[static_cast<std::size_t>(b)]] += shift_b;
    const IntervalNoise noise = {noise_.angle_random_walk_deg_sqrt_s * std::exp(shift[0]),
                                 noise_.bias_random_walk_deg_s_sqrt_s * std::exp(shift[1]),
                                 noise_.reference_deg * std::exp(shift[2])};
    const WhiteGram gram = Whiten(series_, noise);
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
  const IntervalSeries& series_;
  const FitOptions& options_;
  IntervalNoise noise_;
  std::vector<std::size_t> free_;
  Eigen::VectorXd log_variance_;
};

// Degrees of freedom of each coefficient's variance (Satterthwaite): with phi the logarithms of the
// estimated noises and A their covariance (inverse Hessian of the restricted likelihood),
//   nu = 2 / (g' A g),   g = d log variance / d phi
std::vector<double> Inflation(const IntervalSeries& series, const FitOptions& options,
                              const NoiseFit& noise) {
  const auto p = static_cast<Eigen::Index>(options.regressors.size());
  std::vector<double> out(options.regressors.size(), 1.0);
  NearOptimum near(series, options, noise);
  const Eigen::Index m = near.size();
  if (m == 0) return out;
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
      Solve(Whiten(series, IntervalNoise{1.0, 0.0, 0.0}), options.regressors, options.output);
  return solution.coefficients;
}

}  // namespace

GlsFit FitIntervals(IntervalSeries series, const FitOptions& options) {
  GlsFit fit;
  const std::vector<double> pilot = Pilot(series, options);
  if (pilot.size() != options.regressors.size()) return fit;
  Detrend(&series, options.regressors, pilot, options.output);
  fit.noise = FitNoise(series, options);
  if (!fit.noise.solvable) return fit;
  std::vector<double> white;
  fit.gram = Whiten(series, fit.noise.noise, &white);
  fit.solution = Solve(fit.gram, options.regressors, options.output);
  if (!fit.solution.solvable) return fit;
  fit.inflation = Inflation(series, options, fit.noise);
  const auto columns = static_cast<std::size_t>(series.columns());
  const std::size_t p = options.regressors.size();
  fit.residuals.resize(series.rows());
  fit.white_regressors.resize(series.rows() * p);
  for (std::size_t i = 0; i < series.rows(); ++i) {
    const double* row = white.data() + i * columns;
    double residual = row[options.output];
    for (std::size_t j = 0; j < p; ++j) {
      fit.white_regressors[i * p + j] = row[options.regressors[j]];
      residual -= fit.solution.coefficients[j] * row[options.regressors[j]];
    }
    fit.residuals[i] = residual;
  }
  for (std::size_t j = 0; j < p; ++j) fit.solution.coefficients[j] += pilot[j];
  // The walk's integral of the output as given: the pilot's part put back.
  for (std::size_t j = 0; j < p; ++j) {
    fit.gram.walk_integral_s[static_cast<std::size_t>(options.output)] +=
        pilot[j] * fit.gram.walk_integral_s[static_cast<std::size_t>(options.regressors[j])];
  }
  fit.solvable = true;
  return fit;
}

// A = theta_i + (c_y - sum_j theta_j c_j) / T, with c the walk's integral as the filter ends with
// it.
MeanBias AverageBias(const GlsFit& fit, const FitOptions& options, std::size_t index) {
  const std::size_t p = options.regressors.size();
  std::vector<double> direction(p);
  MeanBias out;
  const double duration_s = fit.gram.duration_s;
  out.value = fit.gram.walk_integral_s[static_cast<std::size_t>(options.output)] / duration_s;
  for (std::size_t j = 0; j < p; ++j) {
    direction[j] =
        (j == index ? 1.0 : 0.0) -
        fit.gram.walk_integral_s[static_cast<std::size_t>(options.regressors[j])] / duration_s;
    out.value += direction[j] * fit.solution.coefficients[j];
  }
  out.covariance.assign(p, 0.0);
  for (std::size_t i = 0; i < p; ++i) {
    for (std::size_t j = 0; j < p; ++j) {
      out.covariance[i] += fit.solution.covariance[i * p + j] * direction[j];
    }
  }
  out.variance = fit.gram.walk_integral_variance / (duration_s * duration_s);
  for (std::size_t i = 0; i < p; ++i) out.variance += direction[i] * out.covariance[i];
  return out;
}

double SandwichVariance(const GlsFit& fit, std::size_t index) {
  const std::size_t p = fit.solution.coefficients.size(), n = fit.residuals.size();
  const std::size_t blocks = std::min<std::size_t>(n / 20, 30);
  if (blocks < 8) return std::numeric_limits<double>::quiet_NaN();
  using Map =
      Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  const auto cols = static_cast<Eigen::Index>(p);
  const Map x(fit.white_regressors.data(), static_cast<Eigen::Index>(n), cols);
  const Map covariance(fit.solution.covariance.data(), cols, cols);
  const Eigen::Map<const Eigen::VectorXd> v(fit.residuals.data(), static_cast<Eigen::Index>(n));
  double sum = 0.0;
  for (std::size_t b = 0; b < blocks; ++b) {
    const auto begin = static_cast<Eigen::Index>(b * n / blocks);
    const auto size = static_cast<Eigen::Index>((b + 1) * n / blocks) - begin;
    const Eigen::VectorXd score = x.middleRows(begin, size).transpose() * v.segment(begin, size);
    sum += std::pow(covariance.row(static_cast<Eigen::Index>(index)).dot(score), 2);
  }
  const auto count = static_cast<double>(blocks);
  const double freedom = std::max(count - static_cast<double>(p), 1.0);
  return sum * count / freedom * std::pow(StudentInflation(freedom), 2);
}

}  // namespace gyrobench::calibration

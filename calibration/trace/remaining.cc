#include "calibration/trace/remaining.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "base/geometry.h"
#include "calibration/gls/robust_gain.h"
#include "calibration/gls/statistics.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

constexpr double kLevel = 0.01;
constexpr int kLevels = 12;
constexpr Eigen::Index kLags = kCorrelatedBlocks;
constexpr Eigen::Index kLeastTestedRows = 200;

// What explains less of the residual's square than this is no matter for a user, however
// significant: with many samples the last imperfection of sampling shows.
constexpr double kLeastShare = 0.005;
constexpr double kLeastVarianceRatio = 1.5;
// Bins of the rate so wide that its noise does not sort the rows of one speed into them.
constexpr double kRateSigmas = 8.0;

// Of the rate between two nodes, by the readings' errors [deg/s].
double RateError(const ChannelProblem& problem) {
  double error_deg = 0.0, time_s = 0.0;
  for (const StateHistory& history : problem.histories())
    error_deg = std::max(error_deg, history.angle_error_deg);
  for (const Interval& interval : problem.intervals()) time_s += interval.duration_s;
  return std::sqrt(2.0) * error_deg * static_cast<double>(problem.rows()) / time_s;
}

struct Test {
  Finding finding;
  double log_p = 0.0;
  // Met at evenly spaced angles, the rounding of a coarse encoder does the same: it beats from
  // interval to interval while the table turns evenly, and not while it accelerates.
  bool rounding_does_it = false;
};

// 0 (no evidence) for what is too small to matter.
double LogPOf(double q, double degrees, double n) {
  return q - degrees > kLeastShare * n ? LogChiSquareTail(q, degrees) : 0.0;
}

// Over so many rows each, less their mean.
Eigen::VectorXd SumsOver(Eigen::Index pool, const Eigen::VectorXd& values) {
  Eigen::VectorXd out(values.size() / pool);
  for (Eigen::Index i = 0; i < out.size(); ++i) out(i) = values.segment(i * pool, pool).sum();
  out.array() -= out.mean();
  return out;
}

// Portmanteau statistic of the serial correlations of sums over `pool` rows, Ljung and Box.
// `residual_deg`: before whitening. However many rows a sum has, only the readings at its two ends
// misread it: by less than `rounding_deg`, half a step, in the root mean square.
Test Whiteness(const Eigen::VectorXd& residual, const Eigen::VectorXd& residual_deg,
               double rounding_deg, Eigen::Index pool) {
  const Eigen::VectorXd v = SumsOver(pool, residual);
  const Eigen::Index n = v.size();
  const double square = v.squaredNorm();
  double q = 0.0;
  Eigen::Index strongest = 1;
  double largest = 0.0;
  for (Eigen::Index lag = 1; lag <= kLags; ++lag) {
    const double r = v.head(n - lag).dot(v.tail(n - lag)) / square;
    q += r * r / static_cast<double>(n - lag);
    if (std::fabs(r) > std::fabs(largest)) {
      largest = r;
      strongest = lag;
    }
  }
  const auto count = static_cast<double>(n);
  Test test;
  test.log_p = LogPOf(count * (count + 2.0) * q, static_cast<double>(kLags), count);
  test.finding.test = "whiteness";
  const double alike_deg =
      std::sqrt(std::fabs(largest) * SumsOver(pool, residual_deg).squaredNorm() / count);
  test.rounding_does_it = pool == 1 || alike_deg < rounding_deg;
  test.finding.says =
      pool == 1 ? fmt::format(
                      "residuals of neighbouring intervals correlate, {:+.3f} at a distance of {}",
                      largest, strongest)
                : fmt::format(
                      "sums of residuals over {} intervals correlate, {:+.3f} at a distance of {}",
                      pool, largest, strongest);
  return test;
}

// Over a stretch of rows that are in one bin, however many, only the readings at its two ends err.
// Whether what the stretches of the bins turn by too much, each bin's in the mean, is no more than
// the half steps `rounding_deg` of those two, and no more than one of them from bin to bin.
bool MayBeOfTwoReadings(const Eigen::MatrixXd& bins, const Eigen::VectorXd& residual_deg,
                        double rounding_deg) {
  double square_deg2 = 0.0, most_deg = 0.0;
  for (const auto& bin : bins.colwise()) {
    double stretches = bin(0);
    for (Eigen::Index i = 1; i < bin.size(); ++i) stretches += std::max(0.0, bin(i) - bin(i - 1));
    const double mean_deg = bin.dot(residual_deg) / std::max(1.0, stretches);
    square_deg2 += mean_deg * mean_deg;
    most_deg = std::max(most_deg, std::fabs(mean_deg));
  }
  return most_deg < 2.0 * rounding_deg &&
         std::sqrt(square_deg2 / static_cast<double>(bins.cols())) < rounding_deg;
}

// A table at rest, or turned about the vertical: what is left of a change is the error of its tilt.
constexpr double kLeastTestedGravity_g = 0.02;

// What the residual may depend on.
struct Quantity {
  std::string name;
  std::function<double(Eigen::Index)> value;  // of each row; NaN: it is not looked at
  bool of_angle = false;                      // goes by the table's angle, as rounding does
};

// `problem` must outlive them.
std::vector<Quantity> QuantitiesOf(const ChannelProblem& problem,
                                   const std::vector<std::string>& covariates) {
  std::vector<Quantity> out = {
      {"time [s]", [&](Eigen::Index i) { return problem.begin_s(i); }},
      {"temperature [degC]", [&](Eigen::Index i) { return problem.half(i, 0).temperature_degC; }}};
  const auto in_motion = [&problem](Eigen::Index i, double value) {
    return problem.half(i, 0).still ? kMissing : value;
  };
  // In steps: the rate is known through the same noise as the residual, and within one speed the
  // order of rates is the order of that noise.
  const double step =
      std::max({problem.max_rate_deg_s() / 40.0, kRateSigmas * RateError(problem), 1e-6});
  out.push_back({"rate [deg/s]",
                 [&problem, in_motion, step](Eigen::Index i) {
                   const double rate_deg_s = problem.half(i, 0).rate_deg_s[problem.channel()];
                   return in_motion(i, step * std::round(rate_deg_s / step));
                 },
                 true});
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(problem.gravity_range_g()[a] > kLeastTestedGravity_g)) continue;
    out.push_back({fmt::format("gravity along {} [g]", "xyz"[a]),
                   [&problem, a](Eigen::Index i) { return problem.half(i, 0).gravity_g[a]; }});
  }
  for (const std::size_t a : problem.table_axes()) {
    out.push_back({"table angle [deg]",
                   [&problem, in_motion, a](Eigen::Index i) {
                     const double turns = problem.half(i, 0).table_deg[a] / kFullTurn_deg;
                     return in_motion(i, kFullTurn_deg * (turns - std::floor(turns)));
                   },
                   true});
  }
  for (std::size_t j = 0; j < covariates.size(); ++j) {
    out.push_back({covariates[j],
                   [&problem, j](Eigen::Index i) { return problem.half(i, 0).covariates[j]; }});
  }
  return out;
}

// Means of the residual in bins of a quantity: together, against the model's fit. `gram`: products
// of its white columns.
Test Dependence(const ChannelProblem& problem, const ChannelFit& fit, const Eigen::MatrixXd& gram,
                const Eigen::VectorXd& residual, const Eigen::VectorXd& residual_deg,
                const Quantity& quantity) {
  Test test;
  test.finding.test = "covariate";
  test.finding.covariate = quantity.name;
  std::vector<std::pair<double, Eigen::Index>> order;
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const double x = quantity.value(i);
    if (std::isfinite(x)) order.emplace_back(x, i);
  }
  if (order.size() < 20 * kLevels) return test;
  std::sort(order.begin(), order.end());
  Eigen::MatrixXd bins = Eigen::MatrixXd::Zero(problem.rows(), kLevels);
  for (std::size_t k = 0; k < order.size(); ++k)
    bins(order[k].second, static_cast<Eigen::Index>(k * kLevels / order.size())) = 1.0;
  // The columns that were fitted can hide a part of it.
  const Eigen::MatrixXd shared = fit.white.transpose() * bins;
  const Eigen::VectorXd scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled_shared = scale.asDiagonal() * shared;
  const Eigen::LDLT<Eigen::MatrixXd> factor(
      Eigen::MatrixXd(scale.asDiagonal() * gram * scale.asDiagonal()) +
      1e-10 * Eigen::MatrixXd::Identity(gram.rows(), gram.cols()));
  Eigen::MatrixXd information = Eigen::MatrixXd(bins.transpose() * bins) -
                                scaled_shared.transpose() * factor.solve(scaled_shared);
  information.diagonal().array() += 1e-6 * information.diagonal().array().abs() + 1e-6;
  const Eigen::VectorXd score = bins.transpose() * residual;
  const double q = score.dot(information.ldlt().solve(score));
  test.log_p = LogPOf(q, kLevels, static_cast<double>(problem.rows()));
  Eigen::Index bin = 0;
  const Eigen::VectorXd z = score.cwiseQuotient(information.diagonal().cwiseMax(1e-3).cwiseSqrt());
  z.cwiseAbs().maxCoeff(&bin);
  const auto middle = static_cast<std::size_t>(
      (2 * bin + 1) * static_cast<Eigen::Index>(order.size()) / (2 * kLevels));
  test.finding.says = fmt::format("the residual depends on {}, most around {:.4g}", quantity.name,
                                  order[middle].first);
  test.rounding_does_it =
      quantity.of_angle && MayBeOfTwoReadings(bins, residual_deg, problem.rounding_deg());
  return test;
}

// Whether the size of the residual follows the angular acceleration.
Test Variance(const ChannelProblem& problem, const Eigen::VectorXd& residual) {
  Test test;
  test.finding.test = "variance";
  test.finding.covariate = "angular acceleration";
  test.rounding_does_it = true;
  double x = 0, y = 0, xx = 0, xy = 0, yy = 0, n = 0;
  const double much = 0.05 * problem.max_rate_deg_s();
  for (Eigen::Index i = 2; i + 2 < problem.rows(); ++i) {
    if (problem.half(i, 0).still) continue;
    // Of the neighbours: its own rate shares the noise of the residual.
    const double change = problem.half(i + 2, 0).rate_deg_s[problem.channel()] -
                          problem.half(i - 2, 0).rate_deg_s[problem.channel()];
    const double a = std::fabs(change) > much ? 1.0 : 0.0;
    const double square = std::min(residual(i) * residual(i), 16.0);
    x += a;
    y += square;
    xx += a * a;
    xy += a * square;
    yy += square * square;
    n += 1;
  }
  const double sxx = xx - x * x / n, sxy = xy - x * y / n, syy = yy - y * y / n;
  if (!(sxx > 1e-6 * n) || !(syy > 0)) return test;
  const double r = sxy / std::sqrt(sxx * syy);
  const double there = xy / x, elsewhere = (y - xy) / (n - x);
  if (there < kLeastVarianceRatio * elsewhere) return test;
  test.log_p = LogChiSquareTail(n * r * r, 1.0);
  test.finding.says =
      fmt::format("the residual is {} where the table accelerates", r > 0 ? "larger" : "smaller");
  return test;
}

}  // namespace

bool WhitenessIsTested(const ChannelProblem& problem, Eigen::Index block) {
  // At rest alone the filter of the sensor shows from interval to interval: that is its noise.
  if (block == 1 && (problem.observables() & kNeedsRate) == 0) return false;
  return problem.rows() / block > 10 * kLags;
}

ChannelTrace::Remaining WhatRemains(const ChannelProblem& problem, const ChannelFit& fit,
                                    const std::vector<std::string>& covariates) {
  ChannelTrace::Remaining out;
  if (problem.rows() < kLeastTestedRows) return out;
  const Eigen::VectorXd residual = fit.WhiteResidual();
  const Eigen::VectorXd residual_deg = problem.output_deg() - fit.raw * fit.linear;
  const double rounding_deg = problem.rounding_deg();
  std::vector<Test> tests;
  for (const Eigen::Index block : kWhitenessBlocks) {
    if (WhitenessIsTested(problem, block))
      tests.push_back(Whiteness(residual, residual_deg, rounding_deg, block));
  }
  const Eigen::Index linear = fit.white.cols();
  const Eigen::MatrixXd gram =
      fit.white.transpose() * fit.white + fit.more_products.topLeftCorner(linear, linear);
  for (const Quantity& quantity : QuantitiesOf(problem, covariates))
    tests.push_back(Dependence(problem, fit, gram, residual, residual_deg, quantity));
  tests.push_back(Variance(problem, residual));
  std::sort(tests.begin(), tests.end(),
            [](const Test& a, const Test& b) { return a.log_p < b.log_p; });
  for (std::size_t k = 0; k < tests.size(); ++k) {
    const auto left = static_cast<double>(tests.size() - k);
    if (tests[k].log_p > std::log(kLevel / left)) break;
    tests[k].finding.p_value = std::min(1.0, std::exp(tests[k].log_p) * left);
    out.white = out.white && tests[k].finding.test != "whiteness";
    if (rounding_deg > 0.0 && tests[k].rounding_does_it) {
      out.white = false;
      continue;
    }
    out.findings.push_back(tests[k].finding);
  }
  return out;
}

}  // namespace gyrobench::calibration

#include "calibration/estimators/paper.h"

#include <cmath>
#include <limits>

#include "calibration/gls/statistics.h"

namespace gyrobench::calibration {
namespace {

constexpr double kLeastRotation_deg = 1.0;
constexpr double kRounding = 1e-12;

struct RestMean {
  double z = 0.0, time_s = 0.0;
  bool known() const { return time_s > 0; }
  double output() const { return z / time_s; }
};

double AlphaOf(const Row& turn, std::size_t channel, const RestMean& rest) {
  return turn.rotation_deg[channel] / (turn.z[channel] - rest.output() * turn.duration_s());
}

}  // namespace

PaperScale EstimatePaperScale(const std::vector<Row>& rows, std::size_t channel) {
  std::vector<RestMean> rests;
  for (const Row& row : rows) {
    if (row.rest >= rests.size()) rests.resize(row.rest + 1);
    if (!row.still || !row.usable[channel]) continue;
    rests[row.rest].z += row.z[channel];
    rests[row.rest].time_s += row.duration_s();
  }
  std::vector<double> by_rest_before, by_first_rest;
  for (const Row& row : rows) {
    const bool turn = !row.still && row.usable[channel] &&
                      std::fabs(row.rotation_deg[channel]) >= kLeastRotation_deg;
    if (!turn || !rests[row.rest].known()) continue;
    const double alpha = AlphaOf(row, channel, rests[row.rest]);
    if (!std::isfinite(alpha)) continue;
    by_rest_before.push_back(alpha);
    if (rests.front().known()) by_first_rest.push_back(AlphaOf(row, channel, rests.front()));
  }
  PaperScale out;
  out.turns = by_rest_before.size();
  if (by_rest_before.empty()) return out;
  out.alpha = Mean(by_rest_before);
  out.alpha_std_error = MeanStdError(by_rest_before);
  if (!by_first_rest.empty()) out.first_rest_alpha = Mean(by_first_rest);
  return out;
}

namespace {

// Filtered forward, smoothed backward.
std::vector<double> Smoothed(const IntervalSeries& rows, const NoiseModel& noise,
                             const std::vector<double>& output) {
  const std::size_t n = output.size();
  std::vector<double> level(n), variance(n), predicted_variance(n);
  const double n2 = std::pow(noise.angle_random_walk_deg_sqrt_s, 2);
  const double k2 = std::pow(noise.bias_random_walk_deg_s_sqrt_s, 2);
  for (std::size_t i = 0; i < n; ++i) {
    const Interval& interval = rows.interval(i);
    const double measured = n2 / interval.duration_s;
    if (i == 0) {
      level[0] = output[0];
      variance[0] = predicted_variance[0] = measured;
      continue;
    }
    // From middle to middle.
    const double apart_s =
        0.5 * (rows.interval(i - 1).duration_s + interval.duration_s) + interval.gap_before_s;
    predicted_variance[i] = variance[i - 1] + k2 * apart_s;
    const double gain = predicted_variance[i] / (predicted_variance[i] + measured);
    level[i] = level[i - 1] + gain * (output[i] - level[i - 1]);
    variance[i] = (1.0 - gain) * predicted_variance[i];
  }
  for (std::size_t i = n - 1; i-- > 0;) {
    const double gain =
        predicted_variance[i + 1] > 0 ? variance[i] / predicted_variance[i + 1] : 1.0;
    level[i] += gain * (level[i + 1] - level[i]);
  }
  return level;
}

}  // namespace

PaperBias EstimatePaperBias(const IntervalSeries& rows, const NoiseModel& noise,
                            const std::vector<double>& output, const std::vector<double>& u,
                            std::size_t max_order) {
  const auto n = static_cast<double>(output.size());
  std::size_t order = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t candidate = 0; candidate <= max_order && candidate + 2 < output.size();
       ++candidate) {
    const double square = FitPolynomial(u, output, candidate).residual_square;
    const double bic = n * std::log(square / n) + static_cast<double>(candidate + 1) * std::log(n);
    if (bic < least) {
      least = bic;
      order = candidate;
    }
  }
  const std::vector<double> smoothed = Smoothed(rows, noise, output);
  const PolynomialFit fit = FitPolynomial(u, smoothed, order);
  // Without a random walk the smoothed output is a constant, and what is left of it is rounding.
  double largest = 0.0;
  for (const double value : smoothed) largest = std::fmax(largest, std::fabs(value));
  const double rms = std::sqrt(fit.residual_square / n);
  return {fit.coefficients, rms <= kRounding * largest ? 0.0 : rms};
}

}  // namespace gyrobench::calibration

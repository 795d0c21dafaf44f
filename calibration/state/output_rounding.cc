// What the rounding of the gyro's output to its last digit leaves in a mean.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calibration/state/trail_parts.h"

namespace gyrobench::calibration {
namespace {

// Of pairs of neighbouring intervals at rest.
constexpr double kLeastPairs = 20.0;
// Of an undithered output: half a digit either way.
constexpr double kMostError = 0.5;
// Of a digit: less is nothing.
constexpr double kLeastError = 0.01;

// Variance of one sample at rest, rounding included: from the differences of the means over
// neighbouring intervals, of so many samples each, so that the zero-rate offset may move. The noise
// of a filter that is narrower than the samples are apart counts as larger, which makes the
// rounding's error smaller. NaN with too little rest.
double SampleVariance(const Trail& trail, std::size_t channel) {
  const double sample_s = trail.recording->median_interval_s;
  const auto rate = [&](std::size_t i) {
    const IntegralMark &from = trail.epochs[i].at, &to = trail.epochs[i + 1].at;
    return (to.z[channel] - from.z[channel]) / (to.t_s - from.t_s);
  };
  double sum = 0.0, pairs = 0.0;
  for (std::size_t i = 1; i < trail.still.size(); ++i) {
    const bool used = trail.still[i - 1] && trail.still[i] && trail.usable[i - 1][channel] &&
                      trail.usable[i][channel];
    if (!used) continue;
    const double length_s = trail.epochs[i + 1].at.t_s - trail.epochs[i].at.t_s;
    sum += 0.5 * std::pow(rate(i) - rate(i - 1), 2) * std::max(1.0, length_s / sample_s);
    pairs += 1.0;
  }
  return pairs < kLeastPairs ? kMissing : sum / pairs;
}

}  // namespace

// The mean of a value x with Gaussian noise of sigma, rounded to steps of q, is off by up to
// q / pi exp(-2 pi^2 sigma^2 / q^2) (Widrow and Kollar, Quantization Noise, 2008, first harmonic of
// the sawtooth); without noise by q / 2. Rounding adds q^2 / 12 to the variance.
void FillOutputRounding(const Recording& recording, Trail* trail) {
  const double step = recording.output_step;
  if (!(step > 0.0) || !(recording.median_interval_s > 0.0)) return;
  for (std::size_t c = 0; c < 3; ++c) {
    const double variance = SampleVariance(*trail, c);
    if (std::isnan(variance)) continue;
    const double dither = std::max(0.0, variance / (step * step) - 1.0 / 12.0);
    const double pi = std::numbers::pi;
    const double error = kMostError * std::exp(-2.0 * pi * pi * dither);
    if (error > kLeastError) trail->output_rounding[c] = error * step;
  }
}

}  // namespace gyrobench::calibration

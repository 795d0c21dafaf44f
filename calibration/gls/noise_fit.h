// Parameters and noise of an interval series, together.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "calibration/gls/interval_gls.h"

namespace gyrobench::calibration {

struct FitOptions {
  std::vector<int> regressors;
  // Of these, the ones that are not zero at rest: where the reference's error is known, N and K
  // come from the still intervals alone.
  std::vector<int> rest_regressors;
  int output = 0;
  // Known error of one reference angle, in the output's deg: too few turns to see it in the data.
  std::optional<double> known_reference_deg;
};

// Noise by restricted maximum likelihood (REML) over (N, K, s): N in closed form, the ratios K/N
// and s/N by search on their logarithms; zero where the likelihood does not want them.
struct NoiseFit {
  bool solvable = false;
  IntervalNoise noise;
  // Which of N, K, s were estimated from the data and are not zero.
  bool angle_estimated = false, bias_estimated = false, reference_estimated = false;
};

// `series`: the output should be without its bulk (Detrend), so that products keep their digits.
NoiseFit FitNoise(const IntervalSeries& series, const FitOptions& options);

// A whole fit: pilot, noise, parameters, degrees of freedom.
struct GlsFit {
  bool solvable = false;
  NoiseFit noise;
  WhiteGram gram;  // under this noise; the output's products without what a first fit took off
  GlsSolution solution;  // coefficients of the output as given
  // For each coefficient, the factor by which its standard error grows because the noise was
  // estimated (Satterthwaite's degrees of freedom, Student's t).
  std::vector<double> inflation;
  // Whitened residuals, one a row, and whitened regressors, rows x p.
  std::vector<double> residuals;
  std::vector<double> white_regressors;
};

GlsFit FitIntervals(IntervalSeries series, const FitOptions& options);

// Mean over all intervals of coefficient `index` (the one whose column is the duration) plus the
// random walk: what the bias was on average. Covariance with the coefficients as they are.
struct MeanBias {
  double value = 0.0;
  double variance = 0.0;
  std::vector<double> covariance;
};
MeanBias AverageBias(const GlsFit& fit, const FitOptions& options, std::size_t index);

// Variance of coefficient `index` by a block sandwich: scores summed over blocks, longer than any
// correlation that is left in the residuals. NaN with too few rows.
double SandwichVariance(const GlsFit& fit, std::size_t index);

}  // namespace gyrobench::calibration

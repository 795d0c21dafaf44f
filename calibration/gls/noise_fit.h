// Parameters and noise of an interval series, together.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "calibration/gls/interval_gls.h"

namespace gyrobench::calibration {

class Whitener;

struct FitOptions {
  std::vector<int> regressors;
  // Of these, the ones that are not zero at rest: where the reference's error is known, N and K
  // come from the still intervals alone.
  std::vector<int> rest_regressors;
  int output = 0;
  // Known error of one reference angle, in the output's deg: too few turns to see it in the data.
  std::optional<double> known_reference_deg;
};

// Noise by restricted maximum likelihood (NoiseSearch), 0 where the likelihood does not want it.
// nullopt where it cannot be solved. `series`: the output should be without its bulk (Detrend), so
// that products keep their digits.
std::optional<NoiseModel> FitNoise(const IntervalSeries& series, const FitOptions& options);

// The integral of the bias deviation over all intervals, as the filter sees it at the end.
struct WalkIntegral {
  Eigen::VectorXd of_columns;  // its estimate is linear in them
  double variance = 0.0;
  double duration_s = 0.0;  // of all intervals
};
WalkIntegral IntegrateWalk(const IntervalSeries& series, const Whitener& whitener);

// A whole fit: pilot, noise, parameters, degrees of freedom.
struct GlsFit {
  bool solvable = false;
  NoiseModel noise;
  WalkIntegral walk;     // under this noise
  GlsSolution solution;  // coefficients of the output as given
  // For each coefficient, the factor by which its standard error grows because the noise was
  // estimated (Satterthwaite's degrees of freedom, Student's t).
  std::vector<double> inflation;
  Eigen::VectorXd white_residuals;
  Eigen::MatrixXd white_regressors;  // rows x p
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

// The order of a polynomial, 0 to `longest`, of the least Bayesian information criterion (Schwarz
// 1978). Of one noise, that of the longest: a curve too short must not pass as noise.
std::size_t OrderOfLeastBic(const WhiteGram& gram, std::size_t longest,
                            const std::function<FitOptions(std::size_t)>& options_of);

// Variance of coefficient `index` by a block sandwich: scores summed over blocks, longer than any
// correlation that is left in the residuals. NaN with too few rows.
double SandwichVariance(const GlsFit& fit, std::size_t index);

}  // namespace gyrobench::calibration

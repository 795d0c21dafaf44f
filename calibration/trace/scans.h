// Scans for what has no grid: steps in bias and angle at every time, tones at every frequency,
// ripple at every number of periods a turn. Each in about O(n log n).
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "calibration/gls/whitener.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/within_nodes.h"

namespace gyrobench::calibration {

struct ScanPeak {
  const Effect* effect = nullptr;
  std::size_t table_axis = 2;
  double nonlinear = 0.0;  // t0 [s], f [Hz], k [periods per turn]
  Eigen::Index row = 0;    // where it is, for steps and tones
  double gain = 0.0;       // about what the peak takes off the residual's square
  // By which the chance of a false discovery is divided at this place: independent places that were
  // looked at or, where places have unequal shares of the chance, one over the share.
  double tried = 1.0;
  // What a single row decides is as likely as the tails of all rows say: degrees of freedom of
  // their Student's distribution.
  double tail_freedom = std::numeric_limits<double>::infinity();
  // Whether it stands behind all others that do not explain far less: a tone of few rests, which
  // many a residual seems to have that is not understood yet.
  bool last_resort = false;

  // Whether it is worth to be worked out against a level (logarithm of a chance): the scan's own
  // figure is rough.
  bool ComesNear(double log_level) const;
};

// What single readings say beyond the nodes' means, and what is left of it.
struct SingleReadings {
  const WithinNodes& within;
  Eigen::VectorXd residual;
};

// The highest peak of each kind in the white residual; of tones and ripples those that may be it.
// `model`: white columns that were fitted (their share of a shock is taken off).
std::vector<ScanPeak> Scan(const ChannelProblem& problem, const Whitener& whitener,
                           const Eigen::MatrixXd& model, const Eigen::VectorXd& residual,
                           const SingleReadings& readings);
// The same of what makes the noise look larger than it is: a step or a tone of the bias, a step or
// a ripple of the angle.
std::vector<ScanPeak> ScanForNoise(const ChannelProblem& problem, const Whitener& whitener,
                                   const Eigen::MatrixXd& model, const Eigen::VectorXd& residual);

// Part of Scan: the highest peaks of a ripple of one axis of the table, the highest first. A
// ripple is not always at the highest: the scan goes by the angle at the nodes, and not by the mean
// over the readings of each. `output_score`: of each row's output, of the white residual.
// `readings`: null where the nodes' means alone are to be looked at.
std::vector<ScanPeak> ScanRipple(const ChannelProblem& problem, const Eigen::VectorXd& output_score,
                                 const SingleReadings* readings, std::size_t axis,
                                 std::size_t most_peaks);

// Part of Scan: the tone that the rests of the longest power-on show most clearly, and those of
// which it may be the alias. None where too little is at rest.
std::vector<ScanPeak> ScanTones(const ChannelProblem& problem, const Eigen::VectorXd& residual,
                                std::size_t most_peaks);

// From the least to the largest angle of an axis of the table [turns].
double TurnsSpanned(const ChannelProblem& problem, std::size_t axis);

}  // namespace gyrobench::calibration

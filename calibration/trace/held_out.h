// What a chosen model is worth on data that the coefficients which all measurements share did not
// see: the angle error that matters to a user, in short windows, each one's mean removed; a figure
// before and after, from the squares of its parts; and the model tried on what is held out.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

struct ChannelFit;
class ChannelProblem;

// Root mean square of the angle error in windows of 10 s, the mean of each taken off, of residual
// increments [deg]; one square sum and count a window.
struct Windows {
  std::vector<double> square, count;
  double rms() const;
  void Append(const Windows& others);
};
Windows AngleWindows(const ChannelProblem& problem, const Eigen::VectorXd& residual_deg,
                     Eigen::Index begin, Eigen::Index end);
// The angle error [deg] at the end of every row, in the same windows.
Eigen::VectorXd AngleErrors(const ChannelProblem& problem, const Eigen::VectorXd& residual_deg);

struct HeldOutFigures {
  HeldOut whitened_rms, angle_rms_deg;
  // Of twice the logarithm of the probability density of the held-out rows, as the model foretells
  // them: what the coefficients of the other rows leave open there is a part of the forecast. After
  // less before; NaN where there is nothing to hold out.
  double foretold_better = kMissing;
};

// Sums over the rows that a model is tried on: squares of the whitened residual, one sum a block,
// and the angle errors.
struct TriedRows {
  double rows = 0.0;
  std::vector<double> squares;
  Windows windows;
  double log_density = 0.0;  // twice the logarithm, as the model foretells them
};
// The reductions with their 95 % intervals: blocks and windows drawn anew, with replacement.
HeldOutFigures Compare(const TriedRows& before, const TriedRows& after, std::uint64_t seed);

// Whitened RMS and angle error on data that the coefficients did not see: by whole measurements
// where there are three and more, and none of them alone knows what a column does; else ten times a
// tenth of short blocks in time, which cover what the rest of the blocks do. Blocks that know more
// of a column than the rest, as of a resonance that is passed once, have a tenth of their weight in
// the coefficients. What acts in the held-out rows alone, as a step of the angle, a delay of one
// run or the constant of one power-on, no other row knows: its size is what these rows say of it,
// so that of such an effect the figures say how well it describes them, and foretell nothing.
// `without`: columns of `fit.raw` that the model before leaves out; the model
// after has all. NaN where the data are too short to be divided. Which effects there are, where a
// step, a tone or a curve's bend is, and the noise, was chosen on all data: only sizes, shapes and
// constants are trained anew. PartTrial has the choice on a part as well.
HeldOutFigures HoldOut(const ChannelProblem& problem, const ChannelFit& fit,
                       const std::vector<Eigen::Index>& without, std::uint64_t seed);

}  // namespace gyrobench::calibration

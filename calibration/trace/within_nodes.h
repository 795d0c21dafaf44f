// What single readings of the reference say beyond the means of the nodes that they belong to.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "calibration/effects/effect.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {

// A node where the table moves is the mean of its readings. Of an error of the angle that changes
// within it, as a wave of many periods a turn or a step, the rest is in how the readings lie about
// that mean: of reading r, less the mean over the node,
//   z_r / s0 - M rotation_r - b (t_r - t)  =  felt * f(angle_r, t_r) - M error_r
// with the baseline as fitted to the nodes, b with what the nodes about this one say of the rate.
// The errors are independent of each other and of their mean; the gyro's angle random walk within
// the node, which is no larger, is whitened with them. Each reading is a further row of the least
// squares. How large the errors are the readings themselves show.
class WithinNodes {
 public:
  WithinNodes() = default;
  // Of nodes at a steady speed. `fit`: coefficients of the baseline. `problem` must outlive this.
  // There are no rows of measurements whose readings are rounded to steps coarser than their noise,
  // as those errors go by the angle, nor of those in which the gyro's walk over a node is larger
  // than the errors.
  WithinNodes(const ChannelProblem& problem, const Baseline& baseline, const Eigen::VectorXd& fit,
              double walk_deg_sqrt_s);

  bool empty() const { return output_.size() == 0; }
  // White, one a reading.
  const Eigen::VectorXd& output() const { return output_; }
  // Columns of an effect of which each reading shows the value at its own time and angle
  // (Effect::of_each_reading): readings x terms.
  Eigen::MatrixXd Columns(const Effect& effect, const BasisContext& context,
                          std::optional<std::size_t> power_on) const;
  // Of each reading of the axis of the table: its angle [turns], and what the white residual says of
  // an error of the angle there [1/deg].
  void ForEachReading(std::size_t axis, const Eigen::VectorXd& residual,
                      const std::function<void(double angle_turns, double score)>& visit) const;
  // By periods a turn, from 0: sum of squares of a sine's and a cosine's columns.
  const std::vector<double>& SquaresOfWaves(std::size_t axis, std::size_t most_periods) const;

 private:
  struct MovingNode {
    Eigen::Index row = 0;  // of the problem: it ends at the node
    Eigen::Index begin = 0, count = 0;
    std::size_t white = 0;  // of whitening_
  };

  void Collect(const Baseline& baseline, const Eigen::VectorXd& fit, std::vector<double>* output);
  // Measurement, octave of the rate, octave of how much of a turn is felt.
  using Alike = std::tuple<std::size_t, int, int>;
  Alike AlikeOf(const MovingNode& node) const;
  // 0 where nothing is to be had of them.
  std::map<Alike, double> ErrorsOfReadings(const std::vector<double>& output) const;
  double SpanOf(const MovingNode& node) const;
  bool GoesByTheAngle(std::size_t run, double sigma_deg) const;
  std::size_t WhiteningOf(Eigen::Index readings, double step_s, double sigma_deg);
  const Eigen::MatrixXd& White(const MovingNode& node) const { return whitening_[node.white]; }
  bool Contains(const MovingNode& node, double t_s) const;
  Eigen::MatrixXd SlowRatesOf(const Eigen::MatrixXd& columns) const;
  double OffMean_deg(const MovingNode& node, std::size_t axis, Eigen::Index reading) const;
  const SensorState& StateAt(const MovingNode& node) const { return problem_->end_node(node.row); }

  const ChannelProblem* problem_ = nullptr;
  double walk_deg_sqrt_s_ = 0.0;
  std::vector<bool> steady_;  // of each row
  std::vector<MovingNode> nodes_;
  std::vector<double> after_s_;  // of each reading
  Eigen::VectorXd output_;
  std::vector<Eigen::MatrixXd> whitening_;
  // By number of readings, their distance and their error: which of them.
  std::map<std::tuple<Eigen::Index, long, double>, std::size_t> known_whitening_;
  mutable std::array<std::vector<double>, 3> squares_;
};

}  // namespace gyrobench::calibration

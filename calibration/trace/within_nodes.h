// What single readings of the reference say beyond the means of the nodes that they belong to.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "calibration/effects/effect.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {

// A node where the table moves is the mean of its readings. Of an error of the angle that changes
// within it, as a wave of many periods a turn or a step, the rest is in how the readings lie about
// that mean: of reading r, less the mean over the node,
//   z_r / s0 - M rotation_r - b (t_r - t)  =  felt * f(angle_r, t_r) - M error_r
// with the baseline as fitted to the nodes. The gyro's own noise is next to none over so short a
// time, the errors are white, and independent of their mean. Each reading is a further row of the
// least squares, divided by their standard deviation, which the rows of each measurement show.
class WithinNodes {
 public:
  WithinNodes() = default;
  // `fit`: coefficients of the baseline. `problem` must outlive this. Measurements whose readings
  // are rounded to steps coarser than their noise, whose errors are not independent, have no rows.
  WithinNodes(const ChannelProblem& problem, const Baseline& baseline, const Eigen::VectorXd& fit);

  bool empty() const { return output_.size() == 0; }
  // White, one a reading.
  const Eigen::VectorXd& output() const { return output_; }
  // Columns of an effect of which each reading shows the value at its own time and angle
  // (Effect::of_each_reading): readings x terms.
  Eigen::MatrixXd Columns(const Effect& effect, const BasisContext& context,
                          std::optional<std::size_t> power_on) const;
  // Of each reading that feels the axis of the table: its angle [turns], and what a unit of its row
  // there is.
  void ForEachReading(std::size_t axis,
                      const std::function<void(Eigen::Index reading, double angle_turns,
                                               double felt_per_sigma)>& visit) const;
  // By periods a turn, from 0: sum of squares of a sine's and a cosine's columns.
  const std::vector<double>& SquaresOfWaves(std::size_t axis, std::size_t most_periods) const;

 private:
  struct MovingNode {
    Eigen::Index row = 0;  // of the problem: it ends at the node
    Eigen::Index begin = 0, count = 0;
  };

  void Collect(const Baseline& baseline, const Eigen::VectorXd& fit);
  void Weigh();
  bool Contains(const MovingNode& node, double t_s) const;
  double OffMean_deg(const MovingNode& node, std::size_t axis, Eigen::Index reading) const;
  const SensorState& StateAt(const MovingNode& node) const { return problem_->end_node(node.row); }

  const ChannelProblem* problem_ = nullptr;
  std::vector<MovingNode> nodes_;
  std::vector<double> after_s_, per_sigma_;  // of each reading; sqrt(readings) / sigma [1/deg]
  Eigen::VectorXd output_;
  mutable std::array<std::vector<double>, 3> squares_;
};

}  // namespace gyrobench::calibration

// Where the motion bends between two samples of a gyro, and what its output lacks there.
#pragma once

#include <Eigen/Core>

namespace gyrobench::calibration {

class ChannelProblem;

// What the output lacks between samples, by what the samples may be.
struct Corners {
  // Of each row, over N^2 [s]: what the variance of the output is larger by where the motion bends
  // more than noise, or a rate that bends all along, makes of it. Of samples that are rates of
  // single moments.
  Eigen::VectorXd open_s;
  // What the output of such samples lacks [deg] where the rate goes straight on either side of a
  // corner.
  Eigen::VectorXd bends_deg;
  // What it lacks [deg] where samples are means from half way to half way: AsMeans of the nodes at
  // which the rate changes. At others it would be the noise of the output again.
  Eigen::VectorXd means_deg;
  // The same of means over the interval before their times, beside that they are late.
  Eigen::VectorXd means_before_deg;
  // Whether `open_s` is more than little beside the angle random walk.
  bool open = false;
  // The square of the standard deviations by which `means_deg` would show, were nothing else unknown;
  // its own noise counts in it.
  double squared_sigmas = 0.0;
};

// Square of the angle random walk [deg^2/s], from second differences of the rate where nothing
// moves, or of all where too little rests; NaN where there is too little of anything.
double RoughWalk_deg2_s(const ChannelProblem& problem);

// All zero where the noise cannot be told.
Corners CornersOf(const ChannelProblem& problem);

}  // namespace gyrobench::calibration

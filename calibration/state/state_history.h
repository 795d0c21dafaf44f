// One measurement as the tracer sees it: the state of sensor and bench at the nodes and between.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "calibration/signal/collector.h"
#include "calibration/state/rounding_wave.h"
#include "calibration/state/sensor_state.h"
#include "kinematics/stand_frame.h"

namespace gyrobench::calibration {

// Not copied: its nodes point into its vectors.
struct StateHistory {
  StateHistory() = default;
  StateHistory(const StateHistory&) = delete;
  StateHistory& operator=(const StateHistory&) = delete;
  StateHistory(StateHistory&&) = default;
  StateHistory& operator=(StateHistory&&) = default;
  ~StateHistory() = default;

  const Recording* recording = nullptr;
  kinematics::StandFrame stand;  // that the recording was made on
  std::string name;
  std::size_t number = 1;  // of the measurement, as they were given
  bool new_power_on = true;
  bool earth_rate_known = false;  // Earth's rotation is in the rotations
  // The recording's nodes as they are used: where the table moves at the mean of their readings
  // (times, rotations, integrals of the output), at rest as they are.
  std::vector<Node> epochs;
  // One point a node; two a interval (i from node i to i + 1), in the middle of its halves:
  // midpoints[2 i], midpoints[2 i + 1]. Rates there are means over the half.
  std::vector<SensorState> nodes, midpoints;
  // Of interval i: the reference stood still; may be used, channel by channel.
  std::vector<bool> still;
  std::vector<std::array<bool, 3>> usable;
  // Of each node: rates of the axes that are read as an angle and turn up to it too slowly for two of
  // its readings to say so, evenly from five nodes before it to five after [deg/s]; 0 of all others.
  std::vector<Vector3> slow_rate_deg_s;
  // Rotation of the reference about the sensor's axes over interval i, Earth's included [deg]; 0
  // at rest but for Earth's.
  std::vector<Vector3> rotation_deg;
  // Of each node: variance of each axis's angle relative to one reading's; means over rests and
  // over the readings of a node are better. And which axes of the stand err there: the angle of one
  // that rests is the same before and after.
  std::vector<Vector3> reading_share;
  std::vector<std::array<bool, 3>> axis_errs;
  // Variance of what the channel with this row of M makes of the rotation's error up to a node,
  // relative to one reading's: by each axis as much as the channel feels of it.
  double ReferenceShare(std::size_t node, const Vector3& m_row) const;
  // Standard deviation of a table angle at a moving node: noise of the readings averaged, or the
  // rounding to the steps of a coarse encoder [deg].
  double angle_error_deg = 0.0;
  // The error of each axis of the stand by what it is read as while it rests: the scatter of a
  // short rest, of which the above is made, may have the end of a motion in it.
  Vector3 axis_error_deg = {};
  // How each axis's readings flicker while it rests.
  std::array<RestFlicker, 3> rest_flicker;
  // Standard deviation by which the times of the readings are off, as the errors of the angle show
  // that grow with the rate; 0 where they do not show it clearly [s].
  double timing_error_s = 0.0;
  // What it may be at most where it is 0 [s].
  double timing_at_most_s = std::numeric_limits<double>::infinity();
  // What the steps of an encoder that are coarser than its noise make of an angle in motion, at most:
  // an error that is a function of the angle. 0 where they are not.
  double rounding_deg = 0.0;
  // Of each node: what the random walk of the angle makes the covariance of the rotations before and
  // after larger by, over N^2: ReadingsMean::walk_s, and a share of the sample at which it ends. 0
  // at rest.
  std::vector<double> reference_walk_s;
  // Of each interval: what the integral of the output may be off by, as of Node::between.
  std::vector<BetweenSamples> between;
  std::vector<double> covariates;    // of the points: nodes, then midpoints
  std::vector<GyroTurn> gyro_turns;  // of the nodes, which point to it
  // Of each of the table's axes, node by node, which point to it.
  std::array<std::vector<double>, 3> readings_off_mean_deg;
  bool gravity_known = false, temperature_known = false, vibration_known = false;
  std::vector<Defect> defects;  // what is missing for long, and was left out
  std::vector<std::string> remarks;
};

// `units_per_deg_s`: of each channel, for the shape of the motion between readings of the
// reference; NaN where it is not known. `covariates`: columns that the points shall have, in this
// order; all are in the recording.
StateHistory MakeStateHistory(const Recording& recording, const Vector3& units_per_deg_s,
                              bool new_power_on, const std::vector<std::string>& covariates);

// How many readings of an axis the angle of a node stands for, 1 at least.
double ReadingsBehind(const Node& node, std::size_t axis);

// Output units per deg/s of each channel: least squares of the output on the reference over what
// turns beyond the noise of its readings; the nominal value where the channel did not turn; NaN
// where neither says.
Vector3 RoughSensitivity(const Recording& recording);

}  // namespace gyrobench::calibration

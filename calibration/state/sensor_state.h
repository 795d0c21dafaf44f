// The state that effects depend on, at a sequence of times.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "base/geometry.h"
#include "base/measurement.h"
#include "calibration/signal/columns.h"

namespace gyrobench::calibration {

// How the gyro turned at and about a node [deg].
struct GyroTurn {
  double t_s = 0.0;
  // About each of the sensor's axes: since the measurement's first node, and from this time to
  // those kNear_s before and after it.
  Vector3 since_first_deg = {};
  Near near_deg = {};
  // The same from this time to instants before and after it, through which the gyro went on the way
  // to the last of the readings that the node stands for, which is so long after this time [s].
  Way way_deg = {};
  double way_end_s = 0.0;
  // About each of the table's axes, as SensorState::table_by_gyro_deg: through instants on the way
  // to the last of the readings that the node stands for, from the last one before them; and how
  // long a step of it takes, 0 where nothing turns.
  Way table_way_deg = {};
  double way_step_s = 0.0;
};

// What the sensor went through at one time. Values that are not known are NaN.
struct SensorState {
  double t_s = 0.0;               // of the measurement
  double length_s = 0.0;          // of the half of an interval that it stands for; 0: an instant
  double since_power_on_s = 0.0;  // t_s, which counts from it where power_on is given
  bool restart = false;           // first point of a power-on: memories of effects begin anew
  bool begins = false;            // first point of a measurement
  std::size_t run = 0;            // there: its place among the runs, from 1 (inputs_together.h)
  bool still = false;             // the reference stood still
  // True rate of the sensor, frame S, Earth's rotation included where it is known [deg/s].
  Vector3 rate_deg_s = {};
  bool earth_rate_known = false;
  // Of the half of an interval: change of that rate from its begin to its end [deg/s].
  Vector3 rate_span_deg_s = {};
  // Specific force at rest, frame S, in g: +1 on the axis that points up.
  Vector3 gravity_g = {kMissing, kMissing, kMissing};
  double temperature_degC = kMissing;
  double temperature_rate_degC_s = kMissing;
  double vibration_g2 = kMissing;  // mean square of the specific force about its mean
  // The table's axes: angle and rate. For a single-axis reference only that axis of the sensor.
  Vector3 table_deg = {kMissing, kMissing, kMissing};
  // At nodes in steady turns: what their own reading adds to that angle where its error must not be
  // found in the gyro's output, as for waves of few periods a turn (history_angles.cc), and how far
  // the axis turns from node to node.
  Vector3 own_part_deg = {}, steady_step_deg = {};
  Vector3 table_rate_deg_s = {};
  // World x, horizontal, in frame S; NaN where the orientation is not known.
  Vector3 world_x = {kMissing, kMissing, kMissing};
  // At nodes: how the gyro turned at all nodes of the measurement, and the place of this one among
  // them. Empty where it is not known.
  std::span<const GyroTurn> gyro_turns = {};
  // At nodes: by which the reference's readings are taken to be later than they were stamped.
  double drift_correction_s = 0.0;
  double stamp_s() const { return t_s - drift_correction_s; }
  std::size_t node = 0;
  // At nodes that are the mean of several readings of the reference: how many, the time
  // from one to the next, and what each of the table's axes turns in it.
  std::size_t readings = 1;
  double reading_step_s = 0.0;
  Vector3 reading_step_deg = {};
  // Of each of the table's axes: its angle at each of these readings less their mean [deg], as the
  // gyro felt it turn; empty where it does not turn, or the gyro does not say.
  std::array<std::span<const double>, 3> readings_off_mean_deg = {};
  // Time that they stand for [s]; 0: an instant.
  double span_s() const {
    return readings > 1 ? static_cast<double>(readings) * reading_step_s : 0.0;
  }
  // The i-th of them: so long after the point's time [s].
  double reading_after_s(std::size_t i) const {
    return (static_cast<double>(i) - 0.5 * static_cast<double>(readings - 1)) * reading_step_s;
  }
  // At nodes: how far the gyro has felt each of the table's axes turn [deg]; its scale and noise
  // add up in it, so only changes over a short time mean anything, and only those in which no node
  // is NaN: that is one up to which the gyro was not followed, or an axis that it cannot feel.
  Vector3 table_by_gyro_deg = {kMissing, kMissing, kMissing};
  const double* covariates = nullptr;  // of MeasurementInfo::covariates, in order
};

// Angle by which the gyro turned on from the point's time to `tau_s` after it [deg], by a cubic
// through the four known times about that; before the first node and after the last at constant
// rate. NaN where the point is no node.
double TurnedOn(const SensorState& point, std::size_t channel, double tau_s);
// Angular acceleration that the gyro shows so long after the point's time, over 10 ms either way
// [deg/s^2]. NaN where the point is no node.
double AccelerationAfter_deg_s2(const SensorState& point, std::size_t channel, double after_s);

}  // namespace gyrobench::calibration

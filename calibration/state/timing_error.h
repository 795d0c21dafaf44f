// How far the readings of the reference are off their times, as the errors of its angle show that
// grow with the rate.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace gyrobench::calibration {

// An angle of a table that turns steadily, and what it is off from the one that the gyro carried
// there from the readings about it.
struct SteadyAngle {
  double residual_deg = 0.0;
  double rate_deg_s = 0.0;  // by the gyro: the reading's own error must not choose
  double angle_deg = 0.0;   // of the table
  double readings = 1.0;    // that the angle is a mean of
  double neighbours = 1.0;  // of how many such angles the carried one is a mean
  std::size_t place = 0;    // in the measurement
};

struct AngleErrors {
  double reading_deg2 = 0.0;  // variance of an angle while the table hardly turns, gyro's included
  double timing_s2 = 0.0;     // variance of the time of one reading; 0 where it is not clear
  // Where it is not clear: what it may be at most.
  double timing_at_most_s2 = std::numeric_limits<double>::infinity();

  // How much of the variance of an angle the times make. The table did have the angle that was read,
  // at another time; the rest is an error of the reading.
  double TimingShare(double rate_deg_s, double readings) const;
};

// Variance [deg^2] of the mean of so many readings per s^2 of that of their times.
double VariancePerTiming(double rate_deg_s, double readings);

// By least squares: the variance is a straight line of rate^2 / readings. What the angle itself
// makes, as a wave of it or rounding does, is the same each time that the table passes there: of
// two passes at one speed only the difference counts. `step_deg`: that the readings are rounded to;
// 0 or NaN: to none. Nothing where too few are alike, or speeds do not differ.
std::optional<AngleErrors> FindAngleErrors(const std::vector<SteadyAngle>& angles, double step_deg);

}  // namespace gyrobench::calibration

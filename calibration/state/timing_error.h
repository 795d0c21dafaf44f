// How far the readings of the reference are off their times, as the errors of its angle show that
// grow with the rate.
#pragma once

#include <vector>

namespace gyrobench::calibration {

// An angle of a table that turns steadily, less what the gyro carried there from the readings about
// it.
struct AngleBesideGyro {
  double off_deg = 0.0;
  double rate_deg_s = 0.0;
  double readings = 1.0;  // that it is a mean of
  double beside = 1.0;    // how many such angles the gyro carried there: their mean errs as well
};

struct AngleErrors {
  double reading_deg2 = 0.0;  // variance of an angle while the table hardly turns
  double timing_s2 = 0.0;     // variance of the time of one reading; 0 where it is not clear

  // How much of the error of an angle its time makes. The table did have that angle, at another
  // time; the rest is an error of the reading.
  double ShareOfTiming(double rate_deg_s, double readings) const;
};

// By least squares: the squares of what is off are a straight line of rate^2 / readings.
AngleErrors FindAngleErrors(const std::vector<AngleBesideGyro>& angles);

}  // namespace gyrobench::calibration

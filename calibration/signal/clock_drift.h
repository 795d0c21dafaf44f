// Whether the clocks of the gyro and the reference part, and readings on one clock where they do.
#pragma once

#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace gyrobench::calibration {

struct Recording;

// More is no clock: of quartz crystals the worst are off by some 100 ppm.
inline constexpr double kMostDrift_ppm = 1000.0;

// By how much later the reference's readings are taken to be than they were stamped: nothing where
// the measurement begins, and more by the drift from there on. Positive where the gyro's clock is
// the faster one.
struct DriftCorrection {
  double drift_ppm = 0.0;
  double begin_s = 0.0;  // of the measurement

  double OfStamp_s(double stamp_s) const { return 1e-6 * drift_ppm * (stamp_s - begin_s); }
  // Of a time that is corrected already.
  double AtTime_s(double t_s) const { return OfStamp_s(t_s) / (1.0 + 1e-6 * drift_ppm); }
};

// As the motion of some measurements by one logger shows it, roughly.
struct ClockDrift {
  double drift_ppm = 0.0;
  double std_error_ppm = std::numeric_limits<double>::infinity();
  // In one of the measurements at least it is likely, and the clocks are so far apart at its end
  // that the motion is another by then: a ramp is over for the one while the other still sees it,
  // and a table that does not turn quite evenly is elsewhere.
  bool matters = false;
  // Mean square of what a constant delay leaves of the rates [deg^2/s^2].
  double misfit_deg2_s2 = 0.0;
};

// From node to node, the mean output y of each channel follows the rate w about the sensor's axes
// by the reference and, where it is late by d0 + drift t, its change dw over the interval:
//   y = b + sum_j m_j w_j - m (d0 + drift t) dw / dt
// by least squares in each measurement, with what lies far off left out. Errors by what is left in
// the ramps themselves (clustered sandwich estimator), infinite where no motion tells.
ClockDrift FindClockDrift(std::span<const Recording> recordings);

// The same measurements with the reference's readings on the gyro's clock, where the two part so
// far that it matters; `read` reads all of them so (EvenRows::reference_drift_ppm). `guess_ppm`:
// what was found of the same logger before, 0 where nothing was. As they were stamped where that
// does not come to rest in all of them, is not certain then, or leaves more of the rates.
std::vector<Recording> OnOneClock(
    std::vector<Recording> as_stamped, double guess_ppm,
    const std::function<std::vector<Recording>(double drift_ppm)>& read);

}  // namespace gyrobench::calibration

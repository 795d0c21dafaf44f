// Whether the clocks of the gyro and the reference part.
#pragma once

#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace gyrobench::calibration {

struct Recording;

// More is no clock: of quartz crystals the worst are off by some 100 ppm.
inline constexpr double kMostDrift_ppm = 1000.0;

// The delay of the gyro behind the reference where its clock is the faster one by `drift_ppm`.
inline double PartedBy_s(double drift_ppm, double t_s) { return 1e-6 * drift_ppm * t_s; }

// As the motion of some measurements on one stand shows it, roughly.
struct ClockDrift {
  double drift_ppm = 0.0;
  double std_error_ppm = std::numeric_limits<double>::infinity();
  double latest_s = 0.0;  // the time of a measurement at which they are farthest apart

  // Certain, and so far apart at the end that the motion is another by then: a ramp is over for the
  // one while the other still sees it, and a table that does not turn quite evenly is elsewhere.
  bool Matters() const;
};

// From node to node, the mean output y of each channel follows the rate w about the sensor's axes
// by the reference and, where it is late by d0 + drift t, its change dw over the interval:
//   y = b + sum_j m_j w_j - m (d0 + drift t) dw / dt
// by least squares in each measurement, with what lies far off left out. An error infinite where no
// motion tells.
ClockDrift FindClockDrift(std::span<const Recording> recordings);

// The same measurements with the reference's readings on the gyro's clock, where the two part so
// far that it matters; `read` reads all of them so (EvenRows::reference_drift_ppm). As they were
// stamped where that does not come to rest.
std::vector<Recording> OnOneClock(
    std::vector<Recording> as_stamped,
    const std::function<std::vector<Recording>(double drift_ppm)>& read);

}  // namespace gyrobench::calibration

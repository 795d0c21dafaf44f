// A slow quantity that was measured with noise: smoothing, and what is missing of it: short gaps
// are bridged, what is missing for longer is unknown.
#pragma once

#include <vector>

namespace gyrobench::calibration {

struct Smoothed {
  std::vector<double> value, rate;  // rate per second
};

// A straight line by least squares through what lies within `half_window_s` of each time, or a
// parabola where that fits better, or two lines that meet where those fit clearly better still.
// Values that are NaN do not count; where nothing is near, the result is NaN.
Smoothed SmoothByLines(const std::vector<double>& t_s, const std::vector<double>& value,
                       double half_window_s);

// What the quantity does in a longer gap no one can say.
inline constexpr double kLongestBridge_s = 60.0;
// So near to a known value it is taken for known, whatever lies on the other side.
inline constexpr double kNearKnown_s = 1.0;

// Straight lines between the known ends of gaps that are longer than `shortest_s` and no longer
// than kLongestBridge_s. `value`: one a time, NaN where missing.
void BridgeGaps(const std::vector<double>& t_s, double shortest_s, std::vector<double>* value);

// Of every time: whether the quantity can be told there: it is known, or lies in a gap of up to
// kLongestBridge_s or within kNearKnown_s of a known value. `value`: before or after bridging.
std::vector<bool> TellableTimes(const std::vector<double>& t_s, const std::vector<double>& value);

// Share of the time between neighbours that can be told at both, 0..1; 0 with fewer than two.
double TellableShare(const std::vector<double>& t_s, const std::vector<bool>& tellable);

}  // namespace gyrobench::calibration

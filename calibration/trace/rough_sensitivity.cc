#include <cmath>

#include "calibration/schedule.h"
#include "calibration/trace/trail.h"

namespace gyrobench::calibration {
namespace {

constexpr double kLeastTurn_deg = 5.0;

// Sums for the straight line of the output on the rate.
struct LineSums {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, path = 0;
  void Add(double rate, double output, double duration_s) {
    if (!std::isfinite(rate) || !std::isfinite(output)) return;
    n += 1;
    x += rate;
    y += output;
    xx += rate * rate;
    xy += rate * output;
    path += std::fabs(rate) * duration_s;
  }
};

}  // namespace

Vector3 RoughSensitivity(const Recording& recording) {
  Vector3 out;
  const std::vector<Node>& nodes = recording.columns.nodes;
  const double nominal = NominalUnitsPerDegPerS(recording.info);
  for (std::size_t c = 0; c < 3; ++c) {
    out[c] = recording.info.gyro_present[c] ? nominal : kMissing;
    LineSums sums;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
      const double dt = nodes[i + 1].at.t_s - nodes[i].at.t_s;
      sums.Add((nodes[i + 1].rotation_deg[c] - nodes[i].rotation_deg[c]) / dt,
               (nodes[i + 1].at.z[c] - nodes[i].at.z[c]) / dt, dt);
    }
    const double spread = sums.xx - sums.x * sums.x / sums.n;
    if (!recording.info.gyro_present[c] || !(sums.path > kLeastTurn_deg) || !(spread > 0)) continue;
    out[c] = (sums.xy - sums.x * sums.y / sums.n) / spread;
  }
  return out;
}

}  // namespace gyrobench::calibration

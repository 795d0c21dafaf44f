#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

// What the channel shows beside what it shows of the turns about all axes [deg/s], by least squares
// over all intervals. NaN where none is usable.
double ShownBesideTurns(const std::vector<Node>& nodes, double units_per_deg_s,
                        const std::vector<Vector3>& settled_deg, const StateHistory& history,
                        std::size_t channel) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    const double shown_deg =
        (nodes[i + 1].at.z[channel] - nodes[i].at.z[channel]) / units_per_deg_s;
    const Vector3& turned = settled_deg[i];
    const Eigen::Vector4d row(nodes[i + 1].at.t_s - nodes[i].at.t_s, turned[0], turned[1],
                              turned[2]);
    if (!history.usable[i][channel] || !std::isfinite(shown_deg) || !row.allFinite()) continue;
    normal += row * row.transpose();
    right += shown_deg * row;
  }
  // An axis that did not turn has no part.
  return normal(0, 0) > 0.0 ? normal.completeOrthogonalDecomposition().solve(right)(0) : kMissing;
}

}  // namespace

std::vector<Vector3> RatesAtRest(const std::vector<Node>& nodes, const Vector3& units_per_deg_s,
                                 const std::vector<Vector3>& settled_deg,
                                 const StateHistory& history, bool backward) {
  constexpr double kForget_s = 10.0;
  std::vector<Vector3> out(nodes.size(), {kMissing, kMissing, kMissing});
  const std::size_t intervals = history.still.size();
  auto node = [&](std::size_t n) { return backward ? intervals - n : n; };  // the n-th on the way
  for (std::size_t c = 0; c < 3; ++c) {
    double last = kMissing, sum = 0.0, time_s = 0.0;
    bool rests = false;
    for (std::size_t n = 0; n < intervals; ++n) {
      const std::size_t i = std::min(node(n), node(n + 1));
      if (history.still[i] && history.usable[i][c]) {
        const double length_s = nodes[i + 1].at.t_s - nodes[i].at.t_s;
        const double keep = std::exp(-length_s / kForget_s);
        sum = keep * sum + (nodes[i + 1].at.z[c] - nodes[i].at.z[c]) / units_per_deg_s[c];
        time_s = keep * time_s + length_s;
        last = sum / time_s;
        rests = true;
      } else {
        sum = time_s = 0.0;
      }
      out[node(n + 1)][c] = last;
    }
    for (std::size_t n = intervals; n > 0; --n) {
      if (!std::isfinite(out[node(n - 1)][c])) out[node(n - 1)][c] = out[node(n)][c];
    }
    if (rests) continue;
    const double shown = ShownBesideTurns(nodes, units_per_deg_s[c], settled_deg, history, c);
    for (Vector3& rate : out) rate[c] = shown;
  }
  return out;
}

}  // namespace gyrobench::calibration

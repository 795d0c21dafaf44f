#include "calibration/signal/rests_without_reference.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/signal/output_unit.h"

namespace gyrobench::calibration {
namespace {

// A signal at the nodes and what of its change over half a second counts as motion.
struct Handled {
  std::vector<double> value;
  double limit = 0.0;
};

Handled Watch(std::vector<double> value, double least) {
  Handled out{std::move(value), 0.0};
  std::vector<double> changes;
  for (std::size_t i = 5; i < out.value.size(); ++i) {
    const double change = std::fabs(out.value[i] - out.value[i - 5]);
    if (std::isfinite(change)) changes.push_back(change);
  }
  // 6 standard deviations, from the lower quartile: at least a quarter of the time it lay still.
  if (changes.empty()) return out;
  const auto quarter = changes.begin() + static_cast<std::ptrdiff_t>(changes.size() / 4);
  std::nth_element(changes.begin(), quarter, changes.end());
  out.limit = std::max(least, 6.0 * *quarter / 0.32);
  return out;
}

constexpr double kLeastRateChange_deg_s = 0.3;
constexpr double kLeastAccelChange_g = 0.01;
constexpr double kShortestStretch_s = 2.0;
constexpr std::size_t kMargin = 5;  // nodes on each side of a stretch at rest

}  // namespace

std::vector<Rest> RestsWithoutReference(const MeasurementInfo& info, const Columns& columns) {
  std::vector<Rest> out;
  const std::vector<Node>& nodes = columns.nodes;
  if (nodes.size() < 2) return out;
  const bool accel = info.accel_present[0] || info.accel_present[1] || info.accel_present[2];
  auto add = [&](std::size_t a, std::size_t b) {
    out.push_back(Rest{nodes[a].at, nodes[b].at, {}, 0.0, static_cast<std::int64_t>(b - a)});
  };
  if (!accel) {
    add(0, nodes.size() - 1);
    return out;
  }
  std::vector<Handled> watched;
  const double nominal = NominalUnitsPerDegPerS(info);
  const double units = std::isfinite(nominal) ? nominal : 100.0;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> rate(nodes.size(), 0.0), force(nodes.size(), 0.0);
    for (std::size_t i = 1; i < nodes.size(); ++i) {
      rate[i] = (nodes[i].at.z[c] - nodes[i - 1].at.z[c]) / (nodes[i].at.t_s - nodes[i - 1].at.t_s);
      force[i] = nodes[i].accel_g[c];
    }
    if (info.gyro_present[c])
      watched.push_back(Watch(std::move(rate), kLeastRateChange_deg_s * units));
    if (info.accel_present[c]) watched.push_back(Watch(std::move(force), kLeastAccelChange_g));
  }
  std::size_t begin = 0;
  auto close = [&](std::size_t end) {
    if (end > begin + 2 * kMargin + 1 &&
        nodes[end - 1 - kMargin].at.t_s - nodes[begin + kMargin].at.t_s >= kShortestStretch_s) {
      add(begin + kMargin, end - 1 - kMargin);
    }
  };
  for (std::size_t i = kMargin; i < nodes.size(); ++i) {
    const bool moved = std::any_of(watched.begin(), watched.end(), [&](const Handled& w) {
      return std::fabs(w.value[i] - w.value[i - kMargin]) > w.limit;
    });
    if (!moved) continue;
    close(i);
    begin = i;
  }
  close(nodes.size());
  return out;
}

}  // namespace gyrobench::calibration

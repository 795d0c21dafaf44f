#include "calibration/effects/catalogue/shared_bases.h"

#include <algorithm>
#include <cmath>

#include "calibration/signal/columns.h"

namespace gyrobench::calibration {

bool WaveOverReadings(const SensorState& point, std::size_t table_axis, double periods,
                      double* sin_and_cos) {
  if (point.readings < 2 || point.gyro_turns.empty() || point.node == 0) return false;
  const GyroTurn& turn = point.gyro_turns[point.node];
  const Way& way = turn.table_way_deg;
  const double begin_deg = point.gyro_turns[point.node - 1].table_way_deg.back()[table_axis];
  if (!(turn.way_step_s > 0.0) || begin_deg == way.back()[table_axis]) return false;
  constexpr auto kLast = static_cast<double>(kWaySteps);
  const auto after_deg = [&](std::size_t reading) {
    const double back_s = turn.way_end_s - point.reading_after_s(reading);
    const double place = std::clamp(kLast - back_s / turn.way_step_s, 0.0, kLast);
    const std::size_t step = std::min(static_cast<std::size_t>(place), kWaySteps - 1);
    const double from_deg = step > 0 ? way[step - 1][table_axis] : begin_deg;
    return std::lerp(from_deg, way[step][table_axis], place - static_cast<double>(step));
  };
  const auto count = static_cast<double>(point.readings);
  double mean_deg = 0.0;
  for (std::size_t i = 0; i < point.readings; ++i) mean_deg += after_deg(i) / count;
  if (!std::isfinite(mean_deg)) return false;
  sin_and_cos[0] = sin_and_cos[1] = 0.0;
  for (std::size_t i = 0; i < point.readings; ++i) {
    const double angle_deg = point.table_deg[table_axis] + after_deg(i) - mean_deg;
    sin_and_cos[0] += std::sin(periods * kRadPerDeg * angle_deg) / count;
    sin_and_cos[1] += std::cos(periods * kRadPerDeg * angle_deg) / count;
  }
  return true;
}

}  // namespace gyrobench::calibration

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "calibration/signal/columns.h"
#include "calibration/state/sensor_state.h"

namespace gyrobench::calibration {
namespace {

constexpr int kNearSteps = static_cast<int>(kNear_s.size()) / 2;  // steps either way
constexpr double kNearReach_s = kNearSteps * kNearStep_s;

// Both relative to the node that is asked.
struct Place {
  double tau_s, turned_deg;
};

double Cubic(const std::array<Place, 4>& places, double tau_s) {
  double sum_deg = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    double weight = 1.0;
    for (std::size_t j = 0; j < places.size(); ++j) {
      if (j != i) weight *= (tau_s - places[j].tau_s) / (places[i].tau_s - places[j].tau_s);
    }
    sum_deg += weight * places[i].turned_deg;
  }
  return sum_deg;
}

// About a node, in the very motion of its readings; up to kNearReach_s either way.
double TurnedNear_deg(const Near& near_deg, std::size_t channel, double tau_s) {
  const auto at = [&](int step) -> Place {
    if (step == 0) return {0.0, 0.0};
    const auto index =
        static_cast<std::size_t>(step < 0 ? step + kNearSteps : step + kNearSteps - 1);
    return {step * kNearStep_s, near_deg[index][channel]};
  };
  const int first = std::clamp(static_cast<int>(std::floor(tau_s / kNearStep_s)) - 1, -kNearSteps,
                               kNearSteps - 3);
  return Cubic({at(first), at(first + 1), at(first + 2), at(first + 3)}, tau_s);
}

// A channel's angle at any time, along the ways between the nodes; beyond the first and the last of
// them at constant rate. All relative to one node.
class AlongWays {
 public:
  AlongWays(std::span<const GyroTurn> turns, std::size_t asked, std::size_t channel)
      : turns_(turns), asked_(turns[asked]), node_(asked), channel_(channel) {}

  double Turned_deg(double by_s) const {
    if (turns_.size() < 2) return by_s / kNearReach_s * asked_.near_deg.back()[channel_];
    // The way that the time is on.
    std::size_t k = std::max<std::size_t>(node_, 1);
    while (k > 1 && By_s(k, 0) > by_s) --k;
    while (k + 1 < turns_.size() && By_s(k, kWaySteps) < by_s) ++k;
    const double step_s = (By_s(k, kWaySteps) - By_s(k, 0)) / static_cast<double>(kWaySteps);
    if (!(step_s > 0.0)) return At(k, kWaySteps).turned_deg;
    const auto steps = std::floor((by_s - By_s(k, 0)) / step_s);
    if (steps < 0.0) return Straight(At(k, 0), At(k, 1), by_s);
    if (steps >= static_cast<double>(kWaySteps))
      return Straight(At(k, kWaySteps - 1), At(k, kWaySteps), by_s);
    const std::size_t first =
        std::min(static_cast<std::size_t>(std::max(steps - 1.0, 0.0)), kWaySteps - 3);
    return Cubic({At(k, first), At(k, first + 1), At(k, first + 2), At(k, first + 3)}, by_s);
  }

 private:
  // At the end of a step of the way to node k, from 0 where it begins.
  double By_s(std::size_t k, std::size_t step) const {
    const double begin_s = turns_[k - 1].t_s + turns_[k - 1].way_end_s;
    const double end_s = turns_[k].t_s + turns_[k].way_end_s;
    const double part = static_cast<double>(step) / static_cast<double>(kWaySteps);
    return std::lerp(begin_s, end_s, part) - asked_.t_s;
  }
  Place At(std::size_t k, std::size_t step) const {
    const GyroTurn& turn = turns_[step == 0 ? k - 1 : k];
    const double way_deg = step > 0 ? turn.way_deg[step - 1][channel_]
                           : k > 1  ? turn.way_deg.back()[channel_]
                                    : 0.0;
    return {By_s(k, step),
            turn.since_first_deg[channel_] - asked_.since_first_deg[channel_] + way_deg};
  }
  static double Straight(const Place& from, const Place& to, double tau_s) {
    return from.turned_deg +
           (tau_s - from.tau_s) / (to.tau_s - from.tau_s) * (to.turned_deg - from.turned_deg);
  }

  std::span<const GyroTurn> turns_;
  const GyroTurn& asked_;
  std::size_t node_, channel_;
};

}  // namespace

double TurnedOn(const SensorState& point, std::size_t channel, double tau_s) {
  const std::span<const GyroTurn> turns = point.gyro_turns;
  if (turns.empty()) return kMissing;
  if (std::fabs(tau_s) <= kNearReach_s)
    return TurnedNear_deg(turns[point.node].near_deg, channel, tau_s);
  // At each of the readings: what their mean is like at another time, nodes that stand for another
  // number of them do not tell.
  const AlongWays ways(turns, point.node, channel);
  double sum_deg = 0.0;
  for (std::size_t i = 0; i < point.readings; ++i) {
    const double reading_s = point.reading_after_s(i);
    sum_deg += ways.Turned_deg(reading_s + tau_s) - ways.Turned_deg(reading_s);
  }
  return sum_deg / static_cast<double>(point.readings);
}

double AccelerationAfter_deg_s2(const SensorState& point, std::size_t channel, double after_s) {
  const std::span<const GyroTurn> turns = point.gyro_turns;
  if (turns.empty()) return kMissing;
  // All three by the same samples.
  const bool near = std::fabs(after_s) + kNearStep_s <= kNearReach_s;
  const AlongWays ways(turns, point.node, channel);
  const auto turned_deg = [&](double by_s) {
    return near ? TurnedNear_deg(turns[point.node].near_deg, channel, by_s) : ways.Turned_deg(by_s);
  };
  return (turned_deg(after_s + kNearStep_s) + turned_deg(after_s - kNearStep_s) -
          2.0 * turned_deg(after_s)) /
         (kNearStep_s * kNearStep_s);
}

}  // namespace gyrobench::calibration

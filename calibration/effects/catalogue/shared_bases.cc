#include "calibration/effects/catalogue/shared_bases.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "calibration/signal/columns.h"

namespace gyrobench::calibration {
namespace {

constexpr int kReach = static_cast<int>(kNear_s.size()) / 2;  // steps either way
constexpr double kReach_s = kReach * kNearStep_s;

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

double Line(const Place& from, const Place& to, double tau_s) {
  return from.turned_deg +
         (tau_s - from.tau_s) / (to.tau_s - from.tau_s) * (to.turned_deg - from.turned_deg);
}

// What is known of a channel's angle about a node.
class AboutNode {
 public:
  AboutNode(const GyroTurn& turn, const GyroTurn& asked, std::size_t channel)
      : near_deg_(turn.near_deg),
        channel_(channel),
        node_{turn.t_s - asked.t_s,
              turn.since_first_deg[channel] - asked.since_first_deg[channel]} {}

  // So many steps after the node.
  Place At(int step) const {
    if (step == 0) return node_;
    const auto index = static_cast<std::size_t>(step < 0 ? step + kReach : step + kReach - 1);
    return {node_.tau_s + step * kNearStep_s, node_.turned_deg + near_deg_[index][channel_]};
  }
  bool Knows(double tau_s) const { return std::fabs(tau_s - node_.tau_s) <= kReach_s; }
  double Turned_deg(double tau_s) const {
    const double steps = (tau_s - node_.tau_s) / kNearStep_s;
    const int first = std::clamp(static_cast<int>(std::floor(steps)) - 1, -kReach, kReach - 3);
    return Cubic({At(first), At(first + 1), At(first + 2), At(first + 3)}, tau_s);
  }

 private:
  const Near& near_deg_;
  std::size_t channel_;
  Place node_;
};

}  // namespace

double TurnedOn(const SensorState& point, std::size_t channel, double tau_s) {
  constexpr double kLongGap_s = 0.5;
  const std::span<const GyroTurn> turns = point.gyro_turns;
  if (turns.empty()) return kMissing;
  const GyroTurn& asked = turns[point.node];
  const std::size_t last = tau_s < 0.0 ? 0 : turns.size() - 1;
  auto next = [&](std::size_t k) { return tau_s < 0.0 ? k - 1 : k + 1; };
  auto away_s = [&](std::size_t k) { return std::fabs(turns[k].t_s - asked.t_s); };

  // The last node on the way there.
  std::size_t k = point.node;
  while (k != last && away_s(next(k)) <= std::fabs(tau_s)) k = next(k);
  const AboutNode before(turns[k], asked, channel);
  if (before.Knows(tau_s)) return before.Turned_deg(tau_s);
  const int way = tau_s < 0.0 ? -1 : 1;
  const Place inner = before.At(way * (kReach - 1)), edge = before.At(way * kReach);
  if (k == last) return Line(inner, edge, tau_s);
  const AboutNode beyond(turns[next(k)], asked, channel);
  if (beyond.Knows(tau_s)) return beyond.Turned_deg(tau_s);
  const Place far_edge = beyond.At(-way * kReach), far_inner = beyond.At(-way * (kReach - 1));
  return std::fabs(far_edge.tau_s - edge.tau_s) > kLongGap_s
             ? Line(edge, far_edge, tau_s)
             : Cubic({inner, edge, far_edge, far_inner}, tau_s);
}

}  // namespace gyrobench::calibration

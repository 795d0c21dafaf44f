// Which intervals of a history may be used.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/robust.h"
#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

constexpr double kTurning_deg_s = 3.0;
// From node to node; a turn at kTurning_deg_s goes thirty times as far.
constexpr double kStands_deg = 0.01;
constexpr double kDriftShare = 0.02;  // of what a drift is followed by in one interval

void MarkBad(const Recording& recording, StateHistory* history) {
  const std::vector<Node>& nodes = recording.columns.nodes;
  const bool none = recording.info.reference == ReferenceKind::kNone;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      history->usable[i][c] = recording.info.gyro_present[c] && (!none || history->still[i]);
  }
  for (const BadStretch& stretch : recording.columns.bad) {
    const auto after =
        std::upper_bound(nodes.begin(), nodes.end(), stretch.begin_s,
                         [](double t_s, const Node& node) { return t_s < node.at.t_s; });
    auto i = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - nodes.begin() - 1, 0));
    for (; i + 1 < nodes.size() && nodes[i].at.t_s < stretch.end_s; ++i) {
      // A node that is the mean of its readings carries what happens up to it into the next
      // interval.
      const bool next = i + 2 < nodes.size() && history->epochs[i + 1].mean.output_known;
      for (std::size_t c = 0; c < 3; ++c) {
        if (!stretch.channel[c]) continue;
        history->usable[i][c] = false;
        if (next) history->usable[i + 1][c] = false;
      }
    }
  }
}

// Of each interval: the reference stands. A measurement that ends in a turn which a dead reference
// does not show has no rest there, because the gyro ended it.
std::vector<bool> ReferenceStands(const StateHistory& history) {
  std::vector<bool> stands = history.still;
  const std::vector<Node>& nodes = history.epochs;
  for (std::size_t i = stands.size(); i-- > 0 && !stands[i];) {
    for (std::size_t a = 0; a < 3; ++a) {
      if (std::fabs(nodes[i + 1].rotation_deg[a] - nodes[i].rotation_deg[a]) > kStands_deg)
        return stands;
    }
    stands[i] = true;
  }
  return stands;
}

// Where the reference says rest and the gyro says turning, one of them is wrong: such stretches
// are not used, and what they hold is no effect. A bias that drifts with temperature goes as far,
// but slowly.
void MarkDeadReference(const Vector3& units_per_deg_s, StateHistory* history) {
  const std::vector<Node>& nodes = history->epochs;
  const std::vector<bool> stands = ReferenceStands(*history);
  std::size_t wrong = 0, rests = 0;
  std::pair<std::size_t, double> first;  // channel and time
  for (std::size_t c = 0; c < 3; ++c) {
    if (!std::isfinite(units_per_deg_s[c])) continue;
    std::vector<std::size_t> still;
    std::vector<double> rates;
    for (std::size_t i = 0; i < stands.size(); ++i) {
      if (!stands[i] || !history->usable[i][c]) continue;
      still.push_back(i);
      rates.push_back((nodes[i + 1].at.z[c] - nodes[i].at.z[c]) / units_per_deg_s[c] /
                      (nodes[i + 1].at.t_s - nodes[i].at.t_s));
    }
    if (rates.empty()) continue;
    rests += rates.size();
    const std::vector<bool> turning =
        AwayFromDrift(rates, Median(rates), {kTurning_deg_s, kDriftShare});
    for (std::size_t k = 0; k < still.size(); ++k) {
      if (!turning[k]) continue;
      if (wrong++ == 0) first = {c, nodes[still[k]].at.t_s};
      history->usable[still[k]] = {false, false, false};
    }
  }
  if (wrong == 0) return;
  if (history->recording->info.reference != ReferenceKind::kNone) {
    history->defects.push_back({"turned_at_rest", static_cast<std::int64_t>(wrong), first.second,
                                fmt::format("gyro {}", "xyz"[first.first])});
  }
  history->remarks.push_back(fmt::format(
      "{}: the gyro turns in {:.0f} % of the time in which the reference stands still (or no "
      "reference is given): not used; is the reference connected to what turns?",
      history->name, 100.0 * static_cast<double>(wrong) / static_cast<double>(rests)));
}

}  // namespace

void MarkUnusable(const Recording& recording, const Vector3& units_per_deg_s,
                  StateHistory* history) {
  MarkBad(recording, history);
  MarkDeadReference(units_per_deg_s, history);
}

}  // namespace gyrobench::calibration

// Axes of the stand that stand still while others turn.
#include <algorithm>
#include <cmath>

#include "base/robust.h"
#include "calibration/signal/line_sums.h"
#include "calibration/signal/rest_finder.h"
#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

constexpr std::size_t kShortestSettled = 6;
constexpr std::size_t kEnds = 2;  // nodes that may creep already
// Two nodes at rest differ by less than the first, and by no more than the second, of a node's
// errors.
constexpr double kErrors = 8.0, kSurely = 6.0;

// The best that a node's readings say of an axis.
double Angle(const Node& node, std::size_t axis) {
  return node.mean.readings > 0.0 ? node.mean.table_deg[axis] : node.table_deg[axis];
}

double Readings(const Node& node) { return std::max(1.0, node.mean.readings); }

// From the quietest changes from node to node; an axis that never rests has none so small.
// `error_deg`: of one node.
double RestTolerance(const std::vector<Node>& nodes, std::size_t axis, double error_deg) {
  std::vector<double> changes;
  for (std::size_t k = 1; k < nodes.size(); ++k) {
    const double change = std::fabs(Angle(nodes[k], axis) - Angle(nodes[k - 1], axis));
    if (std::isfinite(change)) changes.push_back(change);
  }
  if (changes.empty()) return 0.0;
  // Where the noise is not larger than the resolution most changes are none at all.
  double resolution = 0.1;
  for (const double change : changes) {
    if (change > 1e-9) resolution = std::min(resolution, change);
  }
  const auto fifth = changes.begin() + static_cast<std::ptrdiff_t>(changes.size() / 5);
  std::nth_element(changes.begin(), fifth, changes.end());
  // A fifth of normal changes is below 0.253 standard deviations.
  // Rounded readings differ by nothing or by a part of a step, whose least difference is that of
  // their printed digits.
  return std::clamp(std::max(6.0 * *fifth / 0.253, 10.0 * resolution),
                    std::max(0.005, kSurely * error_deg), std::max(0.1, kErrors * error_deg));
}

// Without the nodes at the ends that have left what the others are about: a motion that begins or
// ends softly stays within the tolerance for a while. What is left scatters as nodes at rest do.
void CutSoftEnds(const std::vector<Node>& nodes, std::size_t axis, double error_deg,
                 std::size_t* begin, std::size_t* end) {
  constexpr double kSigmas = 3.0, kScatter = 2.0;
  constexpr double kLeast_deg = 1e-4, kScatterOfRest_deg = 0.0025;
  std::vector<double> off;
  for (std::size_t k = *begin; k < *end; ++k) off.push_back(Angle(nodes[k], axis));
  const double median = Median(off);
  for (double& value : off) value = std::fabs(value - median);
  // Half of normal values are within 0.674 standard deviations.
  const double limit = kSigmas * std::max(Median(std::move(off)) / 0.674, kLeast_deg);
  // A measurement's first node is one reading alone, which scatters more than the others' means.
  std::vector<double> readings;
  for (std::size_t k = *begin; k < *end; ++k) readings.push_back(Readings(nodes[k]));
  const double usual = Median(std::move(readings));
  auto away = [&](std::size_t k) {
    return std::fabs(Angle(nodes[k], axis) - median) *
           std::min(1.0, std::sqrt(Readings(nodes[k]) / usual));
  };
  while (*end > *begin + 1 && away(*end - 1) > limit) --*end;
  while (*end > *begin + 1 && away(*begin) > limit) ++*begin;
  double square = 0.0;
  for (std::size_t k = *begin; k < *end; ++k) square += away(k) * away(k);
  const double scatter_deg = std::max(kScatterOfRest_deg, kScatter * error_deg);
  while (*end > *begin + 1 &&
         square > scatter_deg * scatter_deg * static_cast<double>(*end - *begin)) {
    const bool last = away(*end - 1) > away(*begin);
    // It is not the ends that scatter.
    if (away(last ? *end - 1 : *begin) <= scatter_deg) return;
    const double left = away(last ? *end - 1 : *begin);
    square -= left * left;
    if (last) {
      --*end;
    } else {
      ++*begin;
    }
  }
}

// Nodes of one axis that stay within the tolerance, long enough to be settled.
std::vector<NodeRange> StillStretches(const std::vector<Node>& nodes, std::size_t axis,
                                      double tolerance) {
  std::vector<NodeRange> out;
  std::size_t begin = 0;
  for (std::size_t k = 1; k <= nodes.size(); ++k) {
    const bool stays =
        k < nodes.size() &&
        std::fabs(Angle(nodes[k], axis) - Angle(nodes[begin], axis)) < 2.0 * tolerance &&
        std::fabs(Angle(nodes[k], axis) - Angle(nodes[k - 1], axis)) < tolerance;
    if (stays) continue;
    if (k >= begin + kShortestSettled) out.push_back({begin, k});
    begin = k;
  }
  return out;
}

// The axis turns, too slowly to leave the tolerance.
bool Drifts(const std::vector<Node>& nodes, std::size_t axis, const NodeRange& range) {
  LineSums line;
  for (std::size_t k = range.begin; k < range.end; ++k)
    line.Add(nodes[k].at.t_s - nodes[range.begin].at.t_s,
             Angle(nodes[k], axis) - Angle(nodes[range.begin], axis));
  return IsSlowTurn(line, nodes[range.end - 1].at.t_s - nodes[range.begin].at.t_s);
}

// Where the reference steps there are two angles.
void Settle(const std::vector<Node>& nodes, std::size_t axis, double error_deg,
            const StepLimits& limits, NodeRange range, SettledAngles* out) {
  if (range.end < range.begin + kShortestSettled) return;
  CutSoftEnds(nodes, axis, error_deg, &range.begin, &range.end);
  if (const std::optional<ReferenceStep> step = LargestStep(nodes, range, axis, limits)) {
    Settle(nodes, axis, error_deg, limits, {range.begin, step->at}, out);
    Settle(nodes, axis, error_deg, limits, {step->at, range.end}, out);
    return;
  }
  const auto& [begin, end] = range;
  if (end < begin + kShortestSettled + 2 * kEnds) return;
  double sum = 0.0;
  for (std::size_t k = begin + kEnds; k < end - kEnds; ++k) sum += Angle(nodes[k], axis);
  const double mean = sum / static_cast<double>(end - begin - 2 * kEnds);
  const std::size_t first = begin == 0 ? 0 : begin + kEnds;
  const std::size_t last = end == nodes.size() ? end : end - kEnds;
  for (std::size_t k = first; k < last; ++k) {
    out->angle_deg[k][axis] = mean;
    out->is_settled[k][axis] = true;
  }
}

// `of_stand`: the axes that are read.
void MarkCreeping(const std::array<bool, 3>& of_stand, SettledAngles* out) {
  const std::size_t nodes = out->angle_deg.size();
  out->may_creep.assign(nodes, {});
  const auto all_settled = [&](std::size_t k) {
    for (std::size_t a = 0; a < 3; ++a) {
      if (of_stand[a] && !out->is_settled[k][a]) return false;
    }
    return true;
  };
  std::size_t end = 0;
  for (std::size_t begin = 0; begin < nodes; begin = std::max(end, begin + 1)) {
    for (end = begin; end < nodes && all_settled(end);) ++end;
    const std::size_t from = begin - std::min<std::size_t>(begin, 1), to = std::min(end + 1, nodes);
    for (std::size_t a = 0; a < 3 && end > begin; ++a) {
      bool stays = true;
      for (std::size_t k = from; k < to; ++k) {
        stays = stays && out->is_settled[k][a] && out->angle_deg[k][a] == out->angle_deg[begin][a];
      }
      for (std::size_t k = begin; k < end; ++k) out->may_creep[k][a] = of_stand[a] && !stays;
    }
  }
}

}  // namespace

SettledAngles SettleAxes(const Recording& recording, const std::vector<Node>& nodes,
                         const Vector3& error_deg) {
  SettledAngles out;
  for (const Node& node : nodes) out.angle_deg.push_back(node.table_deg);
  out.is_settled.assign(nodes.size(), {});
  out.may_creep = out.is_settled;
  if (recording.info.reference != ReferenceKind::kStandAngles) return out;
  for (std::size_t a = 0; a < 3; ++a) {
    if (!recording.info.stand_axis_present[a]) continue;
    std::vector<NodeRange> still = StillStretches(nodes, a, RestTolerance(nodes, a, error_deg[a]));
    std::erase_if(still, [&](const NodeRange& range) { return Drifts(nodes, a, range); });
    const StepLimits limits = {recording.reference_step_deg[a], ScatterAtRest(nodes, still, a)};
    for (const NodeRange& range : still) Settle(nodes, a, error_deg[a], limits, range, &out);
  }
  MarkCreeping(recording.info.stand_axis_present, &out);
  return out;
}

}  // namespace gyrobench::calibration

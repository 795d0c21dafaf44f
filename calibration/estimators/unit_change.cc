// Whether the output of a gyro changes its unit or sensitivity within one measurement.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "calibration/estimators/exchanged_axes.h"
#include "calibration/signal/bad_times.h"
#include "calibration/signal/line_sums.h"
#include "calibration/signal/output_unit.h"
#include "calibration/signal/wrong_unit.h"

namespace gyrobench::calibration {
namespace {

// Of a channel on each side of the moment: what has to be turned by, and the share of the variance
// that its line explains, where one line for both sides leaves ten times as much.
constexpr double kLeastTurned_deg = 30.0, kLeastFollowed = 0.99, kLeavesLess = 0.1;
// A channel that rests at the moment tells it by its offset alone, or by its next turn.
constexpr double kTogether_s = 60.0;

struct Step {
  double begin_s = 0.0, turned_deg = 0.0, rate_deg_s = 0.0, output = 0.0;
};

struct Side {
  LineSums line;
  double turned_deg = 0.0;
  void Add(const Step& step, double weight) {
    line.n += weight;
    line.x += weight * step.rate_deg_s;
    line.y += weight * step.output;
    line.xx += weight * step.rate_deg_s * step.rate_deg_s;
    line.xy += weight * step.rate_deg_s * step.output;
    line.yy += weight * step.output * step.output;
    turned_deg += weight * std::fabs(step.turned_deg);
  }
  bool Follows() const {
    // Sums that others were taken off again are rounding where next to nothing is left of them.
    constexpr double kVaries_deg2_s2 = 1.0;
    return turned_deg > kLeastTurned_deg && line.SquareX() > kVaries_deg2_s2 &&
           line.Explained() > kLeastFollowed;
  }
};

struct Change {
  double at_s = kMissing, factor = kMissing;
};

// Those in which the table turned about this axis more than about the others, or rested.
std::vector<Step> StepsOf(const Columns& columns, std::size_t channel) {
  constexpr double kTurns_deg_s = 1.0;
  std::vector<Step> steps;
  BadTimes bad(columns.bad, channel);
  for (std::size_t i = 1; i < columns.nodes.size(); ++i) {
    const Node &before = columns.nodes[i - 1], &node = columns.nodes[i];
    const double span_s = node.at.t_s - before.at.t_s;
    if (bad.Touch(before.at.t_s, node.at.t_s)) continue;
    double turned_deg = 0.0, others_deg = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double own_deg = node.rotation_deg[c] - before.rotation_deg[c];
      (c == channel ? turned_deg : others_deg) += c == channel ? own_deg : std::fabs(own_deg);
    }
    const double output = node.at.z[channel] - before.at.z[channel];
    if (!(span_s > 0.0) || !std::isfinite(turned_deg) || !std::isfinite(output)) continue;
    const bool turns = std::fabs(turned_deg) > kTurns_deg_s * span_s;
    // What another axis feels of it would be a part of the output.
    if (others_deg > std::fabs(turned_deg) && others_deg > kTurns_deg_s * span_s) continue;
    steps.push_back(
        {before.at.t_s, turns ? turned_deg : 0.0, turned_deg / span_s, output / span_s});
  }
  return steps;
}

// nullopt where the channel was not turned on both sides of any moment; without a factor where it
// was, and one line does.
std::optional<Change> ChangeOf(const std::vector<Step>& steps) {
  Side before, after;
  for (const Step& step : steps) after.Add(step, 1.0);
  const double together = after.line.LeftOfY();
  std::optional<Change> change;
  double least = kLeavesLess * together;
  for (const Step& step : steps) {
    if (before.turned_deg > kLeastTurned_deg && after.turned_deg > kLeastTurned_deg) {
      if (!change) change.emplace();
      const double left = before.line.LeftOfY() + after.line.LeftOfY();
      if (before.Follows() && after.Follows() && left < least) {
        least = left;
        *change = {step.begin_s, after.line.Slope() / before.line.Slope()};
      }
    }
    before.Add(step, 1.0);
    after.Add(step, -1.0);
  }
  return change;
}

}  // namespace

std::string UnitChangeWithin(const Columns& columns) {
  std::optional<Change> common;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::optional<Change> own = ChangeOf(StepsOf(columns, c));
    if (!own) continue;
    const bool far = std::fabs(own->factor - 1.0) > kLargestScaleError &&
                     std::fabs(1.0 / own->factor - 1.0) > kLargestScaleError;
    if (!(own->factor > 0.0) || !far) return "";
    const bool together = !common || std::fabs(own->at_s - common->at_s) < kTogether_s;
    if (!together || (common && !IsNearFactor(own->factor, common->factor))) return "";
    common = own;
  }
  if (!common) return "";
  return fmt::format(
      "from {:.1f} s on the gyro puts out {:.4g} times what it did before at the same rate of the "
      "reference: the unit of its columns, its range or its sensitivity changes there, or the unit "
      "of the angles does. Split the measurement at that time, and let each part say in its head "
      "and in the names of its columns what holds in it",
      common->at_s, common->factor);
}

}  // namespace gyrobench::calibration

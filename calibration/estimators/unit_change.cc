// Whether the output of a gyro changes its unit or sensitivity within one measurement.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "calibration/estimators/exchanged_axes.h"
#include "calibration/signal/line_sums.h"
#include "calibration/signal/output_unit.h"
#include "calibration/signal/wrong_unit.h"

namespace gyrobench::calibration {
namespace {

// Of a channel on each side of the moment: what has to be turned by, and the share of the variance
// that its line explains, where one line for both sides leaves ten times as much.
constexpr double kLeastTurned_deg = 30.0, kLeastFollowed = 0.99, kLeavesLess = 0.1;

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
    return turned_deg > kLeastTurned_deg && line.Explained() > kLeastFollowed;
  }
};

struct Change {
  double at_s = kMissing, factor = kMissing;
};

std::vector<Step> StepsOf(const Columns& columns, std::size_t channel) {
  std::vector<Step> steps;
  auto bad = columns.bad.begin();
  for (std::size_t i = 1; i < columns.nodes.size(); ++i) {
    const Node &before = columns.nodes[i - 1], &node = columns.nodes[i];
    const double span_s = node.at.t_s - before.at.t_s;
    while (bad != columns.bad.end() && bad->end_s < before.at.t_s) ++bad;
    if (bad != columns.bad.end() && bad->begin_s < node.at.t_s) continue;
    const double turned_deg = node.rotation_deg[channel] - before.rotation_deg[channel];
    const double output = node.at.z[channel] - before.at.z[channel];
    if (!(span_s > 0.0) || !std::isfinite(turned_deg) || !std::isfinite(output)) continue;
    steps.push_back({before.at.t_s, turned_deg, turned_deg / span_s, output / span_s});
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
    if (common && !IsNearFactor(own->factor, common->factor)) return "";
    common = own;
  }
  if (!common) return "";
  return fmt::format(
      "from {:.1f} s on the gyro puts out {:.4g} times what it did before at the same rate: the "
      "unit of its columns, its range or its sensitivity changes within the measurement. Split it "
      "there, and let each part say in its head and in the names of its columns what holds in it",
      common->at_s, common->factor);
}

}  // namespace gyrobench::calibration

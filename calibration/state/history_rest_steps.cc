// Rests in which the reference steps while the sensor rests: two rests, one on each side.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "base/robust.h"
#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

constexpr double kStepSigmas = 7.0;
constexpr std::size_t kLeastSide = 3;
// Of the encoder's step: less is its rounding.
constexpr double kRounding = 1.5;
// Less is the creep of a table that holds, and what no reference is read to.
constexpr double kLeastStep_deg = 0.005, kLeastScatter_deg = 1e-4;

constexpr std::size_t kLeastChanges = 15;

class RestSplitter {
 public:
  RestSplitter(const Recording& recording, std::vector<std::size_t>* rest_of)
      : nodes_(recording.columns.nodes),
        rest_of_(*rest_of),
        next_(recording.columns.rests.size()),
        present_(AnglesRead(recording.info)) {
    for (std::size_t a = 0; a < 3; ++a)
      limits_[a] = {recording.reference_step_deg[a],
                    ScatterAtRest(nodes_, RangesOfRests(*rest_of), a)};
  }

  void Run() {
    std::vector<NodeRange> open = RangesOfRests(rest_of_);
    while (!open.empty()) {
      const NodeRange rest = open.back();
      open.pop_back();
      const std::optional<std::size_t> at = StepIn(rest);
      if (!at) continue;
      std::fill(rest_of_.begin() + static_cast<std::ptrdiff_t>(*at),
                rest_of_.begin() + static_cast<std::ptrdiff_t>(rest.end), next_++);
      open.push_back({rest.begin, *at});
      open.push_back({*at, rest.end});
    }
  }

 private:
  // First node after the clearest step of an axis.
  std::optional<std::size_t> StepIn(const NodeRange& rest) const {
    std::optional<ReferenceStep> clearest;
    for (std::size_t a = 0; a < 3; ++a) {
      if (!present_[a]) continue;
      const std::optional<ReferenceStep> step = LargestStep(nodes_, rest, a, limits_[a]);
      if (step && (!clearest || step->sigmas > clearest->sigmas)) clearest = step;
    }
    return clearest ? std::optional(clearest->at) : std::nullopt;
  }

  const std::vector<Node>& nodes_;
  std::vector<std::size_t>& rest_of_;
  std::size_t next_;
  std::array<bool, 3> present_;
  std::array<StepLimits, 3> limits_;  // of each axis
};

}  // namespace

bool HasReading(const ReadingsMean& mean, std::size_t axis) {
  return mean.own_readings[axis] > 0.0 && std::isfinite(mean.own_deg[axis]);
}

std::vector<double> ChangesAtRest(const std::vector<Node>& nodes, const NodeRange& rest,
                                  std::size_t axis) {
  std::vector<double> changes_deg;
  const ReadingsMean* last = nullptr;
  for (std::size_t k = rest.begin; k < rest.end; ++k) {
    const ReadingsMean& mean = nodes[k].mean;
    if (!HasReading(mean, axis)) continue;
    if (last != nullptr) {
      const double variances = 1.0 / last->own_readings[axis] + 1.0 / mean.own_readings[axis];
      changes_deg.push_back(std::fabs(mean.own_deg[axis] - last->own_deg[axis]) *
                            std::sqrt(2.0 / variances));
    }
    last = &mean;
  }
  return changes_deg;
}

// Of the median size of the changes: a step or two do not matter. 0.954: of a normal difference of
// two, in standard deviations of one.
double ScatterAtRest(const std::vector<Node>& nodes, const std::vector<NodeRange>& rests,
                     std::size_t axis) {
  std::vector<double> changes_deg;
  for (const NodeRange& rest : rests) {
    const std::vector<double> more_deg = ChangesAtRest(nodes, rest, axis);
    changes_deg.insert(changes_deg.end(), more_deg.begin(), more_deg.end());
  }
  if (changes_deg.size() < kLeastChanges) return kMissing;
  return Median(std::move(changes_deg)) / 0.954;
}

// The place that leaves the least square.
std::optional<ReferenceStep> LargestStep(const std::vector<Node>& nodes, const NodeRange& rest,
                                         std::size_t axis, const StepLimits& limits) {
  if (!std::isfinite(limits.scatter_deg)) return std::nullopt;
  double sum = 0.0, count = 0.0;
  for (std::size_t k = rest.begin; k < rest.end; ++k) {
    const ReadingsMean& mean = nodes[k].mean;
    if (!HasReading(mean, axis)) continue;
    sum += mean.own_readings[axis] * mean.own_deg[axis];
    count += mean.own_readings[axis];
  }
  constexpr auto kLeastReadings = static_cast<double>(kLeastSide);
  ReferenceStep step;
  double sum_before = 0.0, before = 0.0, off_deg = 0.0, most = 0.0;
  for (std::size_t k = rest.begin; k + kLeastSide < rest.end; ++k) {
    const ReadingsMean& mean = nodes[k].mean;
    if (HasReading(mean, axis)) {
      sum_before += mean.own_readings[axis] * mean.own_deg[axis];
      before += mean.own_readings[axis];
    }
    const double after = count - before;
    if (k + 1 < rest.begin + kLeastSide || before < kLeastReadings || after < kLeastReadings)
      continue;
    const double off = std::fabs((sum - sum_before) / after - sum_before / before);
    const double square = off * off * before * after / count;  // deg^2 readings
    if (square <= most) continue;
    most = square;
    step.at = k + 1;
    off_deg = off;
  }
  const double count_deg = std::isfinite(limits.count_deg) ? limits.count_deg : 0.0;
  // A rest may be noisier than most.
  const double own_deg = std::fmax(limits.scatter_deg, ScatterAtRest(nodes, {rest}, axis));
  const double scatter_deg = std::max({own_deg, count_deg / std::sqrt(12.0), kLeastScatter_deg});
  step.sigmas = std::sqrt(most) / scatter_deg;
  const bool clear =
      step.sigmas > kStepSigmas && off_deg > kRounding * count_deg && off_deg > kLeastStep_deg;
  return clear ? std::optional(step) : std::nullopt;
}

void SplitRestsAtSteps(const Recording& recording, std::vector<std::size_t>* rest_of) {
  RestSplitter(recording, rest_of).Run();
}

}  // namespace gyrobench::calibration

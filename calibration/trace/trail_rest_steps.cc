// Rests in which the reference steps while the sensor rests: two rests, one on each side.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "calibration/trace/trail_parts.h"

namespace gyrobench::calibration {
namespace {

constexpr double kStepSigmas = 7.0;
constexpr std::size_t kLeastSide = 3;
// Of the encoder's step: less is its rounding.
constexpr double kRounding = 1.5;
// Less is the creep of a table that holds, and what no reference is read to.
constexpr double kLeastStep_deg = 0.005, kLeastScatter_deg = 1e-4;

class RestSplitter {
 public:
  RestSplitter(const Recording& recording, std::vector<std::size_t>* rest_of)
      : recording_(recording),
        nodes_(recording.columns.nodes),
        rest_of_(*rest_of),
        next_(recording.columns.rests.size()) {}

  void Run() {
    std::vector<Stretch> open;
    for (std::size_t begin = 0, end = 0; begin < rest_of_.size(); begin = end) {
      for (end = begin + 1; end < rest_of_.size() && rest_of_[end] == rest_of_[begin];) ++end;
      if (rest_of_[begin] != kNoRest) open.push_back({begin, end});
    }
    while (!open.empty()) {
      const Stretch rest = open.back();
      open.pop_back();
      const std::size_t at = StepIn(rest);
      if (at == rest.end) continue;
      std::fill(rest_of_.begin() + static_cast<std::ptrdiff_t>(at),
                rest_of_.begin() + static_cast<std::ptrdiff_t>(rest.end), next_++);
      open.push_back({rest.begin, at});
      open.push_back({at, rest.end});
    }
  }

 private:
  struct Stretch {
    std::size_t begin = 0, end = 0;
  };
  struct Step {
    std::size_t at = 0;   // first node after it
    double square = 0.0;  // that two means explain beyond one [deg^2 readings]
    double sigmas = 0.0;
  };

  bool Present(std::size_t axis) const {
    return recording_.info.reference == ReferenceKind::kStandAngles &&
           recording_.info.stand_axis_present[axis];
  }

  // Scatter of one reading, from neighbouring nodes' means (0.954: of the median size of a normal
  // difference of two).
  double Scatter(const Stretch& rest, std::size_t axis) const {
    std::vector<double> changes;
    for (std::size_t k = rest.begin + 1; k < rest.end; ++k) {
      const ReadingsMean &a = nodes_[k - 1].mean, &b = nodes_[k].mean;
      const double change = std::fabs(b.table_deg[axis] - a.table_deg[axis]);
      if (!(a.readings > 0.0 && b.readings > 0.0) || !std::isfinite(change)) continue;
      changes.push_back(change * std::sqrt(2.0 / (1.0 / a.readings + 1.0 / b.readings)));
    }
    if (changes.empty()) return 0.0;
    const auto middle = changes.begin() + static_cast<std::ptrdiff_t>(changes.size() / 2);
    std::nth_element(changes.begin(), middle, changes.end());
    return *middle / 0.954;
  }

  // The largest of an axis, where it is clear: the place that leaves the least square.
  Step LargestStep(const Stretch& rest, std::size_t axis) const {
    double sum = 0.0, count = 0.0;
    for (std::size_t k = rest.begin; k < rest.end; ++k) {
      const ReadingsMean& mean = nodes_[k].mean;
      if (!(mean.readings > 0.0) || !std::isfinite(mean.table_deg[axis])) continue;
      sum += mean.readings * mean.table_deg[axis];
      count += mean.readings;
    }
    Step step;
    double sum_before = 0.0, before = 0.0, off_deg = 0.0;
    for (std::size_t k = rest.begin; k + kLeastSide < rest.end; ++k) {
      const ReadingsMean& mean = nodes_[k].mean;
      if (mean.readings > 0.0 && std::isfinite(mean.table_deg[axis])) {
        sum_before += mean.readings * mean.table_deg[axis];
        before += mean.readings;
      }
      const double after = count - before;
      if (k + 1 < rest.begin + kLeastSide || !(before > 0.0 && after > 0.0)) continue;
      const double off = std::fabs((sum - sum_before) / after - sum_before / before);
      const double square = off * off * before * after / count;
      if (square <= step.square) continue;
      step = {k + 1, square, 0.0};
      off_deg = off;
    }
    const double step_deg = recording_.reference_step_deg[axis];
    const double scatter_deg =
        std::max({Scatter(rest, axis), std::isfinite(step_deg) ? step_deg / std::sqrt(12.0) : 0.0,
                  kLeastScatter_deg});
    step.sigmas = std::sqrt(step.square) / scatter_deg;
    const bool clear =
        step.sigmas > kStepSigmas && off_deg > kRounding * step_deg && off_deg > kLeastStep_deg;
    return clear ? step : Step{};
  }

  // First node after the step, or the rest's end.
  std::size_t StepIn(const Stretch& rest) const {
    Step largest;
    for (std::size_t a = 0; a < 3; ++a) {
      if (!Present(a)) continue;
      const Step step = LargestStep(rest, a);
      if (step.sigmas > largest.sigmas) largest = step;
    }
    return largest.sigmas > 0.0 ? largest.at : rest.end;
  }

  const Recording& recording_;
  const std::vector<Node>& nodes_;
  std::vector<std::size_t>& rest_of_;
  std::size_t next_;
};

}  // namespace

void SplitRestsAtSteps(const Recording& recording, std::vector<std::size_t>* rest_of) {
  RestSplitter(recording, rest_of).Run();
}

}  // namespace gyrobench::calibration

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

class RestSplitter {
 public:
  RestSplitter(const Recording& recording, std::vector<std::size_t>* rest_of)
      : recording_(recording),
        nodes_(recording.columns.nodes),
        rest_of_(*rest_of),
        next_(recording.columns.rests.size()) {}

  void Run() {
    for (std::size_t begin = 0, end = 0; begin < rest_of_.size(); begin = end) {
      for (end = begin + 1; end < rest_of_.size() && rest_of_[end] == rest_of_[begin];) ++end;
      if (rest_of_[begin] != kNoRest) Split(begin, end);
    }
  }

 private:
  struct Step {
    std::size_t at = 0;  // first node after it
    double sigmas = 0.0;
  };

  bool Present(std::size_t axis) const {
    return recording_.info.reference == ReferenceKind::kStandAngles &&
           recording_.info.stand_axis_present[axis];
  }

  // Scatter of one reading, from neighbouring nodes' means (0.954: of the median size of a normal
  // difference of two).
  double Scatter(std::size_t begin, std::size_t end, std::size_t axis) const {
    std::vector<double> changes;
    for (std::size_t k = begin + 1; k < end; ++k) {
      const ReadingsMean &a = nodes_[k - 1].mean, &b = nodes_[k].mean;
      if (!(a.readings > 0.0 && b.readings > 0.0)) continue;
      changes.push_back(std::fabs(b.table_deg[axis] - a.table_deg[axis]) *
                        std::sqrt(2.0 / (1.0 / a.readings + 1.0 / b.readings)));
    }
    if (changes.empty()) return 0.0;
    const auto middle = changes.begin() + static_cast<std::ptrdiff_t>(changes.size() / 2);
    std::nth_element(changes.begin(), middle, changes.end());
    return *middle / 0.954;
  }

  // The largest of an axis, where it is clear.
  Step LargestStep(std::size_t begin, std::size_t end, std::size_t axis) const {
    double sum = 0.0, count = 0.0;
    for (std::size_t k = begin; k < end; ++k) {
      const ReadingsMean& mean = nodes_[k].mean;
      if (!(mean.readings > 0.0)) continue;
      sum += mean.readings * mean.table_deg[axis];
      count += mean.readings;
    }
    const double rounding_deg = kRounding * recording_.reference_step_deg[axis];
    const double scatter_deg = Scatter(begin, end, axis);
    Step step;
    double sum_before = 0.0, before = 0.0;
    for (std::size_t k = begin; k + kLeastSide < end; ++k) {
      const ReadingsMean& mean = nodes_[k].mean;
      if (mean.readings > 0.0) {
        sum_before += mean.readings * mean.table_deg[axis];
        before += mean.readings;
      }
      if (k + 1 < begin + kLeastSide || !(before > 0.0 && count > before)) continue;
      const double off = std::fabs((sum - sum_before) / (count - before) - sum_before / before);
      if (off < rounding_deg) continue;
      const double sigmas = off / (scatter_deg * std::sqrt(1.0 / before + 1.0 / (count - before)));
      if (sigmas > std::max(kStepSigmas, step.sigmas)) step = {k + 1, sigmas};
    }
    return step;
  }

  // Nodes [begin, end) of one rest.
  void Split(std::size_t begin, std::size_t end) {
    Step largest;
    for (std::size_t a = 0; a < 3; ++a) {
      if (!Present(a)) continue;
      const Step step = LargestStep(begin, end, a);
      if (step.sigmas > largest.sigmas) largest = step;
    }
    if (largest.at == 0) return;
    std::fill(rest_of_.begin() + static_cast<std::ptrdiff_t>(largest.at),
              rest_of_.begin() + static_cast<std::ptrdiff_t>(end), next_++);
    Split(begin, largest.at);
    Split(largest.at, end);
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

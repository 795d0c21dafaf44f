#include "calibration/gls/noise_search.h"

namespace gyrobench::calibration {

std::vector<Eigen::Index> InPieces(std::span<const Interval> intervals, double piece_s,
                                   std::vector<Interval>* pieces) {
  std::vector<Eigen::Index> piece(intervals.size());
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const Interval& interval = intervals[i];
    const bool joins = interval.still && interval.GoesOn() && interval.bias_jump_per_s == 0.0 &&
                       !pieces->empty() && pieces->back().still &&
                       pieces->back().duration_s + interval.duration_s <= piece_s + 1e-6;
    if (joins) {
      pieces->back().duration_s += interval.duration_s;
      pieces->back().more_walk_s += interval.more_walk_s;
    } else {
      pieces->push_back(interval);
    }
    piece[i] = static_cast<Eigen::Index>(pieces->size()) - 1;
  }
  return piece;
}

}  // namespace gyrobench::calibration

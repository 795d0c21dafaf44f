// Turns that are too slow for one reading after the other to tell them from its noise.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "calibration/signal/line_sums.h"
#include "calibration/signal/rest_finder.h"
#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

// Of nodes on either side, and how many there have to be in all.
constexpr std::size_t kAbout = 5, kLeastNodes = 6;
// A turn is even where its two halves have the same rate within this share, or their noise, and a
// line leaves no more than so many errors of a node.
constexpr double kEven = 0.3, kLeft = 1.8;

class SlowTurns {
 public:
  SlowTurns(const SettledAngles& settled, const StateHistory& history)
      : settled_(settled), history_(history) {}

  // Of an axis that turns up to node k, as slowly before it as after it; else 0.
  double RateUpTo(std::size_t k, std::size_t axis) const {
    if (k == 0 || !Moves(k, axis) || !Moves(k - 1, axis)) return 0.0;
    std::size_t begin = k - 1, end = k + 1;
    while (begin > 0 && k - begin < kAbout && Moves(begin - 1, axis)) --begin;
    while (end < history_.nodes.size() && end - k <= kAbout && Moves(end, axis)) ++end;
    if (end - begin < kLeastNodes) return 0.0;
    const std::size_t middle = (begin + end) / 2;
    const LineSums all = Angles(begin, end, axis);
    const double rate = all.Slope(), noise = SlopeNoise(all);
    if (!(std::fabs(rate) > std::max(kSlowestTurn_deg_s, noise))) return 0.0;
    const double left_deg = std::sqrt(std::max(all.LeftOfY(), 0.0) / (all.n - 2.0));
    if (left_deg > kLeft * history_.angle_error_deg) return 0.0;
    const LineSums first = Angles(begin, middle, axis), second = Angles(middle, end, axis);
    const double change_noise = std::hypot(SlopeNoise(first), SlopeNoise(second));
    const bool even =
        std::fabs(second.Slope() - first.Slope()) < std::max(kEven * std::fabs(rate), change_noise);
    return even ? rate : 0.0;
  }

 private:
  bool Moves(std::size_t k, std::size_t axis) const {
    const bool rests =
        k > 0 && history_.still[k - 1] && k < history_.still.size() && history_.still[k];
    return !rests && !settled_.is_settled[k][axis] && std::isfinite(settled_.angle_deg[k][axis]);
  }

  LineSums Angles(std::size_t begin, std::size_t end, std::size_t axis) const {
    LineSums out;
    for (std::size_t k = begin; k < end; ++k) {
      out.Add(history_.epochs[k].at.t_s - history_.epochs[begin].at.t_s,
              settled_.angle_deg[k][axis] - settled_.angle_deg[begin][axis]);
    }
    return out;
  }

  // So many standard deviations of the slope.
  double SlopeNoise(const LineSums& line) const {
    return kNoiseSigmas * history_.angle_error_deg / std::sqrt(line.SquareX());
  }

  const SettledAngles& settled_;
  const StateHistory& history_;
};

}  // namespace

bool IsOfMotion(const ReadingsMean& mean, const Columns& columns) {
  if (!mean.output_known || !mean.passed_for_rest) return mean.output_known;
  const auto after = std::ranges::upper_bound(columns.slow_turns, mean.t_s, {}, &TimeSpan::begin_s);
  return after != columns.slow_turns.begin() && mean.t_s <= std::prev(after)->end_s;
}

void MarkSlowTurns(const SettledAngles& settled, StateHistory* history) {
  history->slow_rate_deg_s.assign(history->nodes.size(), Vector3{});
  const std::array<bool, 3> axes = AnglesRead(history->recording->info);
  const SlowTurns turns(settled, *history);
  for (std::size_t k = 1; k < history->nodes.size(); ++k) {
    for (std::size_t a = 0; a < 3; ++a) {
      const bool fast = std::fabs(history->nodes[k].table_rate_deg_s[a]) > kLeastMotion_deg_s;
      if (!fast && axes[a]) history->slow_rate_deg_s[k][a] = turns.RateUpTo(k, a);
    }
  }
}

}  // namespace gyrobench::calibration

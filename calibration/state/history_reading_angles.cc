// Where along the way from node to node the readings of a moving node were made.
#include <algorithm>
#include <cmath>

#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

// Angle of one of the table's axes at any time of the way up to a node [deg], which goes in
// straight pieces.
class AngleOnWay {
 public:
  AngleOnWay(const GyroTurn& before, const GyroTurn& turn, std::size_t axis)
      : turn_(turn), axis_(axis), begin_deg_(before.table_way_deg.back()[axis]) {}

  bool moves() const {
    return turn_.way_step_s > 0.0 && begin_deg_ != turn_.table_way_deg.back()[axis_];
  }
  double At(double after_node_s) const {
    constexpr auto kLast = static_cast<double>(kWaySteps);
    const double back = (turn_.way_end_s - after_node_s) / turn_.way_step_s;
    if (!std::isfinite(back)) return kMissing;
    const double place = std::clamp(kLast - back, 0.0, kLast);
    const std::size_t step = std::min(static_cast<std::size_t>(place), kWaySteps - 1);
    const double from_deg = step > 0 ? turn_.table_way_deg[step - 1][axis_] : begin_deg_;
    return std::lerp(from_deg, turn_.table_way_deg[step][axis_], place - static_cast<double>(step));
  }

 private:
  const GyroTurn& turn_;
  std::size_t axis_;
  double begin_deg_;
};

// Of the readings of a node, less their mean, to the end of `all_deg`; nothing where the gyro does
// not say.
void Append(const AngleOnWay& way, const SensorState& point, std::vector<double>* all_deg) {
  if (point.readings < 2 || !way.moves()) return;
  const std::size_t begin = all_deg->size();
  double mean_deg = 0.0;
  for (std::size_t i = 0; i < point.readings; ++i) {
    all_deg->push_back(way.At(point.reading_after_s(i)));
    mean_deg += all_deg->back() / static_cast<double>(point.readings);
  }
  if (!std::isfinite(mean_deg)) return all_deg->resize(begin);
  for (std::size_t i = begin; i < all_deg->size(); ++i) (*all_deg)[i] -= mean_deg;
}

}  // namespace

void FillReadingAngles(StateHistory* history) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double>& all_deg = history->readings_off_mean_deg[axis];
    std::vector<std::size_t> ends(history->nodes.size(), 0);
    for (std::size_t k = 1; k < history->nodes.size(); ++k) {
      Append({history->gyro_turns[k - 1], history->gyro_turns[k], axis}, history->nodes[k],
             &all_deg);
      ends[k] = all_deg.size();
    }
    for (std::size_t k = 1; k < history->nodes.size(); ++k) {
      history->nodes[k].readings_off_mean_deg[axis] =
          std::span(all_deg).subspan(ends[k - 1], ends[k] - ends[k - 1]);
    }
  }
}

}  // namespace gyrobench::calibration

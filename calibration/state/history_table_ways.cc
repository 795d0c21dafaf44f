// How far the gyro felt the table's axes turn, on the way from node to node.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

constexpr std::size_t kNoAxis = 3;  // of the table's

class TableWays {
 public:
  TableWays(const FeltByGyro& gyro, StateHistory* history)
      : gyro_(gyro), history_(*history), nodes_(history->epochs) {}

  // Turns of the table's axes, summed up, and the way there. `recorded`: the nodes as they were,
  // which are instants, with the ways between them.
  void Fill(const MeasurementInfo& info, const std::vector<Node>& recorded) {
    const std::vector<std::size_t> next = NextToTurn(), last = LastToTurn();
    Vector3 sum = {}, end = {};
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      GyroTurn& turn = history_.gyro_turns[k];
      Vector3 by_gyro_deg = {};  // NaN where the gyro was not followed up to here
      turn.table_way_deg.fill(end);
      if (k > 0 && !history_.still[k - 1]) {
        const Matrix3 directions = DirectionsAt(k);
        auto felt = [&](const Vector3& z, double since_s) {
          return AboutAxes(info, directions, Turned(k, z, since_s), since_s, k);
        };
        const Vector3 doubt_deg_s = Doubt(k, directions);
        // What the gyro shows without a turn: its noise, and what its offset may be off by.
        auto noise_deg = [&](std::size_t a, double length_s) {
          return kNoiseSigmas * gyro_.walk_deg_sqrt_s * std::sqrt(length_s) +
                 doubt_deg_s[a] * length_s;
        };
        // What is felt of the turns of other axes is misalignment. While the play of an axis is
        // crossed its reference stands; what the gyro's noise says then, which is in the output as
        // well, must not pass for it: there would be a play in every bench.
        auto turns = [&](std::size_t a, double turned_deg, double length_s) {
          return Turns(k, a) || ((Turns(k + 1, a) || a == next[k] || a == last[k]) &&
                                 !(std::fabs(turned_deg) < noise_deg(a, length_s)));
        };
        const Vector3 turned = felt(Minus(nodes_[k].at.z, nodes_[k - 1].at.z), Length(k - 1));
        for (std::size_t a = 0; a < 3; ++a) {
          if (!turns(a, turned[a], Length(k - 1))) continue;
          (std::isfinite(turned[a]) ? sum[a] : by_gyro_deg[a]) += turned[a];
        }
        const IntegralMark& from = recorded[k - 1].at;
        const double length_s = recorded[k].at.t_s - from.t_s;
        turn.way_step_s = length_s / static_cast<double>(kWaySteps);
        const Vector3 whole = felt(Minus(recorded[k].at.z, from.z), length_s);
        Vector3 gone = {};
        for (std::size_t i = 0; i < kWaySteps; ++i) {
          const Vector3 way = felt(Minus(recorded[k].z_way[i], from.z),
                                   static_cast<double>(i + 1) * turn.way_step_s);
          for (std::size_t a = 0; a < 3; ++a) {
            if (!turns(a, whole[a], length_s)) continue;
            const int direction = Direction(k, a, whole[a], noise_deg(a, length_s));
            // Not known from here on: a play of this axis goes by its reference.
            if (!std::isfinite(way[a])) {
              gone[a] = kMissing;
            } else {
              gone[a] = direction == 0
                            ? way[a]
                            : direction * std::max(direction * gone[a], direction * way[a]);
            }
            turn.table_way_deg[i][a] += gone[a];
          }
        }
        end = turn.table_way_deg.back();
      }
      for (std::size_t a = 0; a < 3; ++a)
        history_.nodes[k].table_by_gyro_deg[a] = by_gyro_deg[a] + sum[a];
    }
  }

 private:
  static Vector3 Minus(const Vector3& a, const Vector3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  }

  // Of each node: the axis that turns there or, before the next rest, after it.
  std::vector<std::size_t> NextToTurn() const {
    std::vector<std::size_t> next(nodes_.size(), kNoAxis);
    for (std::size_t k = nodes_.size(); k-- > 1;) {
      if (k + 1 < nodes_.size() && !history_.still[k]) next[k] = next[k + 1];
      if (const std::size_t axis = MostTurned(k); axis != kNoAxis) next[k] = axis;
    }
    return next;
  }
  // The axis that turns there or, after the last rest, did before.
  std::vector<std::size_t> LastToTurn() const {
    std::vector<std::size_t> last(nodes_.size(), kNoAxis);
    for (std::size_t k = 1; k < nodes_.size(); ++k) {
      if (!history_.still[k - 1]) last[k] = last[k - 1];
      if (const std::size_t axis = MostTurned(k); axis != kNoAxis) last[k] = axis;
    }
    return last;
  }
  // Of the axes whose readings say that they turned up to node k.
  std::size_t MostTurned(std::size_t k) const {
    std::size_t axis = kNoAxis;
    double most = std::max(kLeastMotion_deg_s, RateNoise(history_, k - 1));
    for (std::size_t a = 0; a < 3; ++a) {
      const double slow = std::fabs(history_.slow_rate_deg_s[k][a]);
      const double rate = std::fabs(history_.nodes[k].table_rate_deg_s[a]);
      if (!(rate > most) && !(axis == kNoAxis && slow > 0.0)) continue;
      most = std::max(most, rate);
      axis = a;
    }
    return axis;
  }

  bool Turns(std::size_t k, std::size_t axis) const { return TurnsUpTo(history_, k, axis); }

  // What may be felt about each of the table's axes without a turn: an offset that is another after
  // a motion than before it changed at some time in it, and other axes are felt by misalignment.
  Vector3 Doubt(std::size_t k, const Matrix3& directions) const {
    constexpr double kMisalignment = 0.03;
    Vector3 doubt_deg_s = {};
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double change = gyro_.next_rest_deg_s[k][c] - gyro_.at_rest_deg_s[k][c];
        if (std::isfinite(change)) doubt_deg_s[a] += std::fabs(directions[c][a] * change);
      }
      for (std::size_t other = 0; other < 3; ++other) {
        if (other != a && Turns(k, other))
          doubt_deg_s[a] += kMisalignment * std::fabs(history_.nodes[k].table_rate_deg_s[other]);
      }
    }
    return doubt_deg_s;
  }

  // Way in which the axis turns about node k; 0 where it turns back. Where it does not, what the
  // gyro's noise says of turning back, as at the end of a motion, must not cross a play either:
  // only what is clearly felt does, as where a table swings back before it rests.
  int Direction(std::size_t k, std::size_t axis, double felt_deg, double noise_deg) const {
    bool forward = false, backward = false;
    for (std::size_t j = k - 1; j <= k + 1; ++j) {
      if (!Turns(j, axis)) continue;
      const double slow = history_.slow_rate_deg_s[j][axis];
      const double rate = slow != 0.0 ? slow : history_.nodes[j].table_rate_deg_s[axis];
      (rate > 0.0 ? forward : backward) = true;
    }
    if (forward && backward) return 0;
    if (!forward && !backward) forward = felt_deg > 0.0;
    if ((forward ? -felt_deg : felt_deg) > noise_deg) return 0;
    return forward ? 1 : -1;
  }

  // Change of the output's integral over `by_s` as rotation about the sensor's axes.
  Vector3 Turned(std::size_t k, const Vector3& z, double by_s) const {
    Vector3 turned;
    for (std::size_t c = 0; c < 3; ++c) {
      turned[c] = z[c] / gyro_.units_per_deg_s[c];
      if (std::isfinite(gyro_.at_rest_deg_s[k][c])) turned[c] -= gyro_.at_rest_deg_s[k][c] * by_s;
    }
    return turned;
  }

  Matrix3 DirectionsAt(std::size_t k) const {
    return history_.stand.Rates(history_.nodes[k].table_deg);
  }

  // Parts of a rotation about the sensor's axes over `by_s` up to node k that are about each of the
  // table's, less what the reference says that the others turned.
  Vector3 AboutAxes(const MeasurementInfo& info, const Matrix3& directions, const Vector3& turned,
                    double by_s, std::size_t k) const {
    Vector3 about = {};
    if (info.reference == ReferenceKind::kSensorAngle) {
      const auto axis = static_cast<std::size_t>(info.reference_axis);
      about[axis] = turned[axis];
      return about;
    }
    if (info.reference != ReferenceKind::kStandAngles) return {kMissing, kMissing, kMissing};
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t c = 0; c < 3; ++c) {
        // A channel that is not there is not missed where the axis does not turn it.
        if (!(std::fabs(directions[c][a]) > 1e-3)) continue;
        double of_others = 0.0;
        for (std::size_t other = 0; other < 3; ++other) {
          if (other != a && Turns(k, other))
            of_others += directions[c][other] * history_.nodes[k].table_rate_deg_s[other] * by_s;
        }
        about[a] += directions[c][a] * (turned[c] - of_others);
      }
    }
    return about;
  }

  double Length(std::size_t i) const { return nodes_[i + 1].at.t_s - nodes_[i].at.t_s; }

  const FeltByGyro& gyro_;
  StateHistory& history_;
  const std::vector<Node>& nodes_;
};

}  // namespace

bool TurnsUpTo(const StateHistory& history, std::size_t node, std::size_t axis) {
  return node < history.nodes.size() &&
         (history.slow_rate_deg_s[node][axis] != 0.0 ||
          std::fabs(history.nodes[node].table_rate_deg_s[axis]) > kLeastMotion_deg_s);
}

double RateNoise(const StateHistory& history, std::size_t interval) {
  if (interval >= history.still.size()) return 0.0;
  const double length_s = history.epochs[interval + 1].at.t_s - history.epochs[interval].at.t_s;
  return kNoiseSigmas * std::numbers::sqrt2 * history.angle_error_deg / length_s;
}

void FillTableWays(const Recording& recording, const FeltByGyro& gyro, StateHistory* history) {
  TableWays(gyro, history).Fill(recording.info, recording.columns.nodes);
}

}  // namespace gyrobench::calibration

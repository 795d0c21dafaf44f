// How far the gyro felt the table's axes turn, on the way from node to node.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

constexpr std::size_t kNoAxis = 3;  // of the table's

// Model of how a turn begins: size (t + before_s)^power [deg], with t [s] from the end of a way on.
// Power 1: at its full rate at once; 2: at an even acceleration; 3: at one that rises evenly.
struct SoftBegin {
  double power = 1.0, before_s = 0.0, size = 0.0;  // size: deg/s^power
  // The turn at t_s [deg], for a size of 1.
  double Grown(double t_s) const { return std::pow(std::max(0.0, t_s + before_s), power); }
};

// What the gyro felt over a step of a way that ends at end_s, as t of SoftBegin.
struct FeltStep {
  double end_s = 0.0, length_s = 0.0, turned_deg = 0.0;
};

// The one that begins with one of the steps before t = 0, or there, and leaves least of what was
// felt: in each step the gyro's noise is white. Of size 0 where nothing finite was felt.
SoftBegin BestBegin(const std::vector<FeltStep>& steps) {
  SoftBegin best;
  double most = 0.0;
  for (const double power : {1.0, 2.0, 3.0}) {
    for (const FeltStep& first : steps) {
      if (first.end_s - first.length_s > 0.0) break;
      SoftBegin begin{.power = power, .before_s = first.length_s - first.end_s};
      double felt_by_grown = 0.0, grown_square = 0.0;
      for (const FeltStep& step : steps) {
        const double grown = begin.Grown(step.end_s) - begin.Grown(step.end_s - step.length_s);
        felt_by_grown += grown * step.turned_deg / step.length_s;
        grown_square += grown * grown / step.length_s;
      }
      begin.size = felt_by_grown / grown_square;
      if (!(felt_by_grown * begin.size > most)) continue;
      most = felt_by_grown * begin.size;
      best = begin;
    }
  }
  return best;
}

class TableWays {
 public:
  // `recording`: its nodes are instants, with the ways between them.
  TableWays(const Recording& recording, const FeltByGyro& gyro, StateHistory* history)
      : info_(recording.info),
        recorded_(recording.columns.nodes),
        gyro_(gyro),
        history_(*history),
        nodes_(history->epochs),
        next_(NextToTurn()),
        last_(LastToTurn()) {}

  // Turns of the table's axes, summed up, and the way there.
  void Fill() {
    Vector3 sum = {}, end = {};
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      GyroTurn& turn = history_.gyro_turns[k];
      Vector3 by_gyro_deg = {};  // NaN where the gyro was not followed up to here
      turn.table_way_deg.fill(end);
      if (k > 0 && !history_.still[k - 1]) {
        const Vector3 turned =
            Felt(k, Minus(nodes_[k].at.z, nodes_[k - 1].at.z), Length(k - 1), Directions(k));
        const Vector3 doubt_deg_s = Doubt(k);
        for (std::size_t a = 0; a < 3; ++a) {
          if (!Turns(k, a, turned[a], Noise_deg(doubt_deg_s[a], Length(k - 1)))) continue;
          (std::isfinite(turned[a]) ? sum[a] : by_gyro_deg[a]) += turned[a];
        }
        AddWay(k, &turn);
        end = turn.table_way_deg.back();
      }
      for (std::size_t a = 0; a < 3; ++a)
        history_.nodes[k].table_by_gyro_deg[a] = by_gyro_deg[a] + sum[a];
    }
  }

 private:
  // How far each axis is felt to turn on the way to the last of a node's readings, whether it does
  // turn, and what is felt without a turn at most.
  struct Along {
    Way felt_deg;
    double length_s = 0.0;
    std::array<bool, 3> turns = {};
    Vector3 noise_deg = {};
    const Vector3& Whole_deg() const { return felt_deg.back(); }
    double StepEnd_s(std::size_t i) const {
      return static_cast<double>(i + 1) * length_s / static_cast<double>(kWaySteps);
    }
  };

  Along WayTo(std::size_t k) const {
    Along out;
    const IntegralMark& from = recorded_[k - 1].at;
    out.length_s = recorded_[k].at.t_s - from.t_s;
    const Matrix3 directions = Directions(k);
    for (std::size_t i = 0; i < kWaySteps; ++i)
      out.felt_deg[i] = Felt(k, Minus(recorded_[k].z_way[i], from.z), out.StepEnd_s(i), directions);
    const Vector3 doubt_deg_s = Doubt(k);
    for (std::size_t a = 0; a < 3; ++a) {
      out.noise_deg[a] = Noise_deg(doubt_deg_s[a], out.length_s);
      out.turns[a] = Turns(k, a, out.Whole_deg()[a], out.noise_deg[a]);
    }
    return out;
  }

  void AddWay(std::size_t k, GyroTurn* turn) const {
    const Along along = WayTo(k);
    turn->way_step_s = along.StepEnd_s(0);
    std::optional<Along> after;
    for (std::size_t a = 0; a < 3; ++a) {
      if (along.turns[a]) {
        AddTurn(k, a, along, turn);
      } else if (a == next_[k] && k + 1 < nodes_.size() && !history_.still[k]) {
        if (!after) after = WayTo(k + 1);
        AddBegin(k, a, along, *after, turn);
      }
    }
  }

  void AddTurn(std::size_t k, std::size_t a, const Along& along, GyroTurn* turn) const {
    const int direction = Direction(k, a, along.Whole_deg()[a], along.noise_deg[a]);
    double gone_deg = 0.0;
    for (std::size_t i = 0; i < kWaySteps; ++i) {
      const double way_deg = along.felt_deg[i][a];
      // Not known from here on: a play of this axis goes by its reference.
      if (!std::isfinite(way_deg)) {
        gone_deg = kMissing;
      } else {
        gone_deg = direction == 0 ? way_deg
                                  : direction * std::max(direction * gone_deg, direction * way_deg);
      }
      turn->table_way_deg[i][a] += gone_deg;
    }
  }

  // The axis is first felt to turn on the way after this one, and may have begun to on this one:
  // what the gyro shows of so little is mostly its noise, but how the turn goes on says when it
  // began. It is in the way alone, on which a play is crossed; that it adds to the sum is less than
  // the sum's noise.
  void AddBegin(std::size_t k, std::size_t a, const Along& along, const Along& after,
                GyroTurn* turn) const {
    const double whole_deg = after.Whole_deg()[a], noise_deg = after.noise_deg[a];
    const int direction = Direction(k + 1, a, whole_deg, noise_deg);
    if (!(direction * whole_deg > noise_deg)) return;
    const SoftBegin begin = BestBegin(StepsUntilFelt(a, along, after));
    const double gone_deg = begin.size * begin.Grown(0.0);
    if (!(direction * gone_deg > 0.0)) return;
    // More than its noise would have been felt.
    const double part = std::min(1.0, along.noise_deg[a] / std::fabs(gone_deg));
    for (std::size_t i = 0; i < kWaySteps; ++i) {
      turn->table_way_deg[i][a] +=
          part * begin.size * begin.Grown(along.StepEnd_s(i) - along.length_s);
    }
  }

  // Of both ways, up to where the turn stands clearly out of the noise: what it does from there on,
  // as at the end of a steep ramp, says nothing of its begin.
  static std::vector<FeltStep> StepsUntilFelt(std::size_t a, const Along& along,
                                              const Along& after) {
    constexpr double kClearly = 3.0;  // of Noise_deg
    std::vector<FeltStep> steps;
    auto add = [&](const Along& way, double from_s, double most_deg) {
      double before_deg = 0.0;
      for (std::size_t i = 0; i < kWaySteps && !(std::fabs(before_deg) > most_deg); ++i) {
        steps.push_back(
            {from_s + way.StepEnd_s(i), way.StepEnd_s(0), way.felt_deg[i][a] - before_deg});
        before_deg = way.felt_deg[i][a];
      }
    };
    add(along, -along.length_s, std::numeric_limits<double>::infinity());
    add(after, 0.0, kClearly * after.noise_deg[a]);
    return steps;
  }

  // What the gyro shows without a turn: its noise, and what its offset may be off by.
  double Noise_deg(double doubt_deg_s, double length_s) const {
    return kNoiseSigmas * gyro_.walk_deg_sqrt_s * std::sqrt(length_s) + doubt_deg_s * length_s;
  }
  // What is felt of the turns of other axes is misalignment. While the play of an axis is crossed
  // its reference stands; what the gyro's noise says then, which is in the output as well, must not
  // pass for it: there would be a play in every bench.
  bool Turns(std::size_t k, std::size_t a, double turned_deg, double noise_deg) const {
    return Turns(k, a) || ((Turns(k + 1, a) || a == next_[k] || a == last_[k]) &&
                           !(std::fabs(turned_deg) < noise_deg));
  }

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
  Vector3 Doubt(std::size_t k) const {
    constexpr double kMisalignment = 0.03;
    const Matrix3 directions = Directions(k);
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

  Matrix3 Directions(std::size_t k) const {
    return history_.stand.Rates(history_.nodes[k].table_deg);
  }

  // A change of the output's integral over `by_s`, up to node k or on the way there, as rotation
  // about the sensor's axes.
  Vector3 AboutSensor(std::size_t k, const Vector3& z, double by_s) const {
    Vector3 turned;
    for (std::size_t c = 0; c < 3; ++c) {
      turned[c] = z[c] / gyro_.units_per_deg_s[c];
      if (std::isfinite(gyro_.at_rest_deg_s[k][c])) turned[c] -= gyro_.at_rest_deg_s[k][c] * by_s;
    }
    return turned;
  }

  // Its parts that are about each of the table's axes, which `directions` has, less what the
  // reference says that the others turned.
  Vector3 Felt(std::size_t k, const Vector3& z, double by_s, const Matrix3& directions) const {
    const Vector3 turned = AboutSensor(k, z, by_s);
    Vector3 about = {};
    if (info_.reference == ReferenceKind::kSensorAngle) {
      const auto axis = static_cast<std::size_t>(info_.reference_axis);
      about[axis] = turned[axis];
      return about;
    }
    if (info_.reference != ReferenceKind::kStandAngles) return {kMissing, kMissing, kMissing};
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

  const MeasurementInfo& info_;
  const std::vector<Node>& recorded_;
  const FeltByGyro& gyro_;
  StateHistory& history_;
  const std::vector<Node>& nodes_;
  // Of each node: the axis that turns there or, before the next rest, after it; and the axis that
  // turns there or, after the last rest, did before.
  const std::vector<std::size_t> next_, last_;
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
  TableWays(recording, gyro, history).Fill();
}

}  // namespace gyrobench::calibration

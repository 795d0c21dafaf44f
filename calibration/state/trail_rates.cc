#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/median.h"
#include "calibration/state/trail_parts.h"

namespace gyrobench::calibration {
namespace {

constexpr double kLeastMotion_deg_s = 0.3;
// Less than so many standard deviations of a rate by two readings is its noise.
constexpr double kNoiseSigmas = 4.0;
// Rates that are steady over so many intervals either way.
constexpr std::size_t kReach = 4;
constexpr double kAlike_deg_s = 0.5, kAlikeShare = 0.03;
constexpr std::size_t kNone = 3;  // of the table's axes

// Mean rate of each channel [deg/s] over the rest a node is in, or the last one before; of the
// first one for what comes before all. NaN where the channel never rests.
std::vector<Vector3> RatesAtRest(const std::vector<Node>& nodes, const Vector3& units_per_deg_s,
                                 const Trail& trail) {
  std::vector<Vector3> out(nodes.size(), {kMissing, kMissing, kMissing});
  for (std::size_t c = 0; c < 3; ++c) {
    double last = kMissing, sum = 0.0, time_s = 0.0;
    for (std::size_t i = 0; i < trail.still.size(); ++i) {
      if (trail.still[i] && trail.usable[i][c]) {
        sum += (nodes[i + 1].at.z[c] - nodes[i].at.z[c]) / units_per_deg_s[c];
        time_s += nodes[i + 1].at.t_s - nodes[i].at.t_s;
        last = sum / time_s;
      } else {
        sum = time_s = 0.0;
      }
      out[i + 1][c] = last;
    }
    for (std::size_t k = nodes.size(); k-- > 1;) {
      if (!std::isfinite(out[k - 1][c])) out[k - 1][c] = out[k][c];
    }
  }
  return out;
}

class RateMaker {
 public:
  RateMaker(const std::vector<Node>& nodes, const Vector3& units, Trail* trail)
      : nodes_(nodes), units_(units), trail_(*trail), at_rest_(RatesAtRest(nodes, units, *trail)) {
    for (std::size_t c = 0; c < 3; ++c) walk_deg_sqrt_s_[c] = WalkAtRest(c);
  }

  void Halves() {
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      const double dt = Length(i);
      for (std::size_t c = 0; c < 3; ++c) {
        const double turned = trail_.rotation_deg[i][c];
        double uneven = 0.0;  // half the difference of the halves, as the gyro saw it
        if (Shapes(i, c) && !Quiet(i, c) && HasMiddle(i)) {
          uneven = 0.25 * dt * (MeanOutput(i, c, false) - MeanOutput(i, c, true)) / units_[c];
        }
        trail_.halves[2 * i].rate_deg_s[c] = (turned + 2.0 * uneven) / dt;
        trail_.halves[2 * i + 1].rate_deg_s[c] = (turned - 2.0 * uneven) / dt;
      }
    }
  }

  // At steady speed the rate is what the neighbours say: with the noise of its own two readings,
  // which is in the output as well, a steep function of the rate would find it.
  void Steady() {
    std::vector<Vector3> rates(trail_.still.size());
    for (std::size_t i = 0; i < rates.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) rates[i][c] = trail_.rotation_deg[i][c] / Length(i);
    }
    for (std::size_t i = kReach; i + kReach < rates.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0.0, count = 0.0;
        const double alike =
            std::max({kAlike_deg_s, kAlikeShare * std::fabs(rates[i][c]), RateNoise(i)});
        for (std::size_t j = i - kReach; j <= i + kReach; ++j) {
          if (trail_.still[j] || std::fabs(rates[j][c] - rates[i][c]) > alike) break;
          if (j + 1 >= i && j <= i + 1) continue;  // they share a reading with it
          sum += rates[j][c];
          count += 1.0;
        }
        if (count < 2 * kReach - 2) continue;
        trail_.halves[2 * i].rate_deg_s[c] = trail_.halves[2 * i + 1].rate_deg_s[c] = sum / count;
      }
    }
  }

  // Of the halves, once the nodes are known.
  void Spans() {
    for (std::size_t i = 0; i < trail_.halves.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double middle = 0.5 * (trail_.halves[i / 2 * 2].rate_deg_s[c] +
                                     trail_.halves[i / 2 * 2 + 1].rate_deg_s[c]);
        const double node = trail_.nodes[(i + 1) / 2].rate_deg_s[c];
        trail_.halves[i].rate_span_deg_s[c] = i % 2 == 0 ? middle - node : node - middle;
      }
    }
  }

  void Nodes() {
    std::vector<GyroTurn>& turns = trail_.gyro_turns;
    turns.assign(nodes_.size(), GyroTurn{});
    std::vector<Vector3> steady(nodes_.size());
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      turns[k].t_s = nodes_[k].at.t_s;
      trail_.nodes[k].node = k;
      trail_.nodes[k].gyro_turns = turns;
      for (std::size_t c = 0; c < 3; ++c) {
        steady[k][c] = SteadyOutput(k, c);
        Node(k, c, steady[k][c]);
      }
    }
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c)
        turns[i + 1].since_first_deg[c] =
            turns[i].since_first_deg[c] + Way(i, c, 0.5 * (steady[i][c] + steady[i + 1][c]));
    }
  }

  // Turns of the table's axes, summed up, and the way there. `recorded`: the nodes as they were,
  // which are instants, with the ways between them.
  void TableByGyro(const MeasurementInfo& info, const std::vector<calibration::Node>& recorded) {
    const std::vector<std::size_t> next = NextToTurn();
    const double walk_deg_sqrt_s =
        *std::max_element(walk_deg_sqrt_s_.begin(), walk_deg_sqrt_s_.end());
    Vector3 sum = {}, end = {};
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      TrackPoint& point = trail_.nodes[k];
      point.table_way_deg.fill(end);
      if (k > 0 && !trail_.still[k - 1]) {
        const Matrix3 directions = DirectionsAt(k);
        auto felt = [&](const Vector3& z, double since_s) {
          return AboutAxes(info, directions, Turned(k, z, since_s));
        };
        // What is felt of the turns of other axes is misalignment. While the play of an axis is
        // crossed its reference stands; what the gyro's noise says then, which is in the output as
        // well, must not pass for it: there would be a play in every bench.
        auto turns = [&](std::size_t a, double turned_deg, double length_s) {
          const double noise_deg = kNoiseSigmas * walk_deg_sqrt_s * std::sqrt(length_s);
          return Turns(k, a) ||
                 ((Turns(k + 1, a) || a == next[k]) && !(std::fabs(turned_deg) < noise_deg));
        };
        const Vector3 turned = felt(Minus(nodes_[k].at.z, nodes_[k - 1].at.z), Length(k - 1));
        for (std::size_t a = 0; a < 3; ++a)
          sum[a] += turns(a, turned[a], Length(k - 1)) ? turned[a] : 0.0;
        const IntegralMark& from = recorded[k - 1].at;
        const double length_s = recorded[k].at.t_s - from.t_s;
        point.way_step_s = length_s / static_cast<double>(kWaySteps);
        const Vector3 whole = felt(Minus(recorded[k].at.z, from.z), length_s);
        Vector3 gone = {};
        for (std::size_t i = 0; i < kWaySteps; ++i) {
          const Vector3 way = felt(Minus(recorded[k].z_way[i], from.z),
                                   static_cast<double>(i + 1) * point.way_step_s);
          for (std::size_t a = 0; a < 3; ++a) {
            if (!turns(a, whole[a], length_s)) continue;
            const int direction = Direction(k, a, whole[a]);
            gone[a] = direction == 0
                          ? way[a]
                          : direction * std::max(direction * gone[a], direction * way[a]);
            point.table_way_deg[i][a] += gone[a];
          }
        }
        end = point.table_way_deg.back();
      }
      point.table_by_gyro_deg = sum;
    }
    for (std::size_t a = 0; a < 3; ++a) SmoothAngles(a);
  }

 private:
  static Vector3 Minus(const Vector3& a, const Vector3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  }

  // Only where the gyro follows the table better than this: sampled vibration is no better than the
  // noise of a reading.
  void SmoothAngles(std::size_t axis) {
    constexpr double kFollows_deg = 0.2;
    std::vector<double> angles(nodes_.size());
    double square = 0.0, count = 0.0;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      angles[k] = WithoutOwnReading(k, axis);
      const double change = angles[k] - trail_.nodes[k].table_deg[axis];
      if (!(std::fabs(change) > 0.0)) continue;
      square += change * change;
      count += 1.0;
    }
    if (std::sqrt(square / count) > kFollows_deg) return;
    for (std::size_t k = 0; k < nodes_.size(); ++k) trail_.nodes[k].table_deg[axis] = angles[k];
  }

  // Angle of a turning axis without the noise of its own reading: what the gyro saw since the
  // readings on either side of it. In a term that depends on the angle that noise would be found
  // again, as a ripple.
  double WithoutOwnReading(std::size_t k, std::size_t axis) const {
    constexpr std::size_t kPairs = 3;
    auto off = [&](std::size_t j) {
      const TrackPoint& point = trail_.nodes[j];
      return point.table_deg[axis] - point.table_by_gyro_deg[axis];
    };
    double sum = 0.0, count = 0.0;
    for (std::size_t d = 1; d <= kPairs && d <= k && k + d < nodes_.size(); ++d) {
      if (!Turns(k + 1 - d, axis) || !Turns(k + d, axis)) break;
      sum += off(k - d) + off(k + d);
      count += 2.0;
    }
    const double angle_deg = trail_.nodes[k].table_by_gyro_deg[axis] + sum / count;
    return std::isfinite(angle_deg) ? angle_deg : trail_.nodes[k].table_deg[axis];
  }

  // Angle random walk of the channel at rest [deg/sqrt(s)]; 0 where it never rests.
  double WalkAtRest(std::size_t c) const {
    constexpr double kMedianOfNormal = 0.6745;
    std::vector<double> walks;
    for (std::size_t i = 0; i < trail_.still.size(); ++i) {
      if (!trail_.still[i] || !Shapes(i, c)) continue;
      const Vector3 turned = Turned(i, Minus(nodes_[i + 1].at.z, nodes_[i].at.z), Length(i));
      if (std::isfinite(turned[c])) walks.push_back(std::fabs(turned[c]) / std::sqrt(Length(i)));
    }
    return walks.empty() ? 0.0 : Median(std::move(walks)) / kMedianOfNormal;
  }

  // Of each node: the axis that turns there or, before the next rest, after it.
  std::vector<std::size_t> NextToTurn() const {
    std::vector<std::size_t> next(nodes_.size(), kNone);
    for (std::size_t k = nodes_.size(); k-- > 1;) {
      if (k + 1 < nodes_.size() && !trail_.still[k]) next[k] = next[k + 1];
      double most = std::max(kLeastMotion_deg_s, RateNoise(k - 1));
      for (std::size_t a = 0; a < 3; ++a) {
        const double rate = std::fabs(trail_.nodes[k].table_rate_deg_s[a]);
        if (!(rate > most)) continue;
        most = rate;
        next[k] = a;
      }
    }
    return next;
  }

  // The reference says that the axis turned up to node k.
  bool Turns(std::size_t k, std::size_t axis) const {
    return k < nodes_.size() &&
           std::fabs(trail_.nodes[k].table_rate_deg_s[axis]) > kLeastMotion_deg_s;
  }

  // Way in which the axis turns about node k; 0 where it turns back. Where it does not, what the
  // gyro's noise says of turning back, as at the end of a motion, must not cross a play either.
  int Direction(std::size_t k, std::size_t axis, double felt_deg) const {
    bool forward = false, backward = false;
    for (std::size_t j = k - 1; j <= k + 1; ++j) {
      if (!Turns(j, axis)) continue;
      (trail_.nodes[j].table_rate_deg_s[axis] > 0.0 ? forward : backward) = true;
    }
    if (forward && backward) return 0;
    if (!forward && !backward) forward = felt_deg > 0.0;
    return forward ? 1 : -1;
  }

  // Change of the output's integral over `by_s` as rotation about the sensor's axes.
  Vector3 Turned(std::size_t k, const Vector3& z, double by_s) const {
    Vector3 turned;
    for (std::size_t c = 0; c < 3; ++c) {
      turned[c] = z[c] / units_[c];
      if (std::isfinite(at_rest_[k][c])) turned[c] -= at_rest_[k][c] * by_s;
    }
    return turned;
  }

  Matrix3 DirectionsAt(std::size_t k) const {
    return trail_.stand.Rates(trail_.nodes[k].table_deg);
  }

  // Parts of a rotation about the sensor's axes that are about each of the table's.
  static Vector3 AboutAxes(const MeasurementInfo& info, const Matrix3& directions,
                           const Vector3& turned) {
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
        if (std::fabs(directions[c][a]) > 1e-3) about[a] += directions[c][a] * turned[c];
      }
    }
    return about;
  }

  double Length(std::size_t i) const { return nodes_[i + 1].at.t_s - nodes_[i].at.t_s; }
  bool Shapes(std::size_t i, std::size_t c) const {
    return trail_.usable[i][c] && std::isfinite(units_[c]);
  }

  // What the readings' errors can make of the rate over interval i [deg/s].
  double RateNoise(std::size_t i) const {
    return i < trail_.still.size()
               ? kNoiseSigmas * std::numbers::sqrt2 * trail_.angle_error_deg / Length(i)
               : 0.0;
  }

  // How far before node i + 1 the output's integral is known on the way [s].
  double Before(std::size_t i) const { return nodes_[i + 1].at.t_s - nodes_[i + 1].half_s; }
  // Near enough to the middle to say what each half saw.
  bool HasMiddle(std::size_t i) const {
    constexpr double kLeastPart = 0.2;
    const double part = Before(i) / Length(i);
    return part > kLeastPart && part < 1.0 - kLeastPart;
  }
  // Output over the part of interval i before its mark on the way, or after it.
  double MeanOutput(std::size_t i, std::size_t c, bool after) const {
    const double after_s = Before(i);
    return after ? (nodes_[i + 1].at.z[c] - nodes_[i + 1].z_half[c]) / after_s
                 : (nodes_[i + 1].z_half[c] - nodes_[i].at.z[c]) / (Length(i) - after_s);
  }

  // The channel hardly turns: what shape the gyro sees is its noise.
  bool Quiet(std::size_t i, std::size_t c) const {
    return trail_.still[i] || std::fabs(trail_.rotation_deg[i][c]) <
                                  std::max(kLeastMotion_deg_s, RateNoise(i)) * Length(i);
  }

  // Mean output about node k where it does not change by more than its own noise [deg/s]; NaN
  // elsewhere. The noise of the few samples about a node is in the output as well: a regressor that
  // has it makes the residual larger or smaller than the motion alone would.
  double SteadyOutput(std::size_t k, std::size_t c) const {
    if (k < kReach || k + kReach >= nodes_.size()) return kMissing;
    auto output = [&](std::size_t from, std::size_t to) {
      return (nodes_[to].at.z[c] - nodes_[from].at.z[c]) / units_[c] /
             (nodes_[to].at.t_s - nodes_[from].at.t_s);
    };
    const double mean = output(k - kReach, k + kReach);
    for (std::size_t j = k - kReach; j < k + kReach; ++j) {
      const double noise = kNoiseSigmas * walk_deg_sqrt_s_[c] / std::sqrt(Length(j));
      if (trail_.still[j] || !(std::fabs(output(j, j + 1) - mean) < noise)) return kMissing;
    }
    return mean;
  }

  // The gyro's shape within 40 ms, less its rate at rest; where it never rests, with the mean over
  // both neighbours as the reference has it.
  void Node(std::size_t k, std::size_t c, double steady) {
    TrackPoint& point = trail_.nodes[k];
    double turned = 0.0, seen = 0.0, time_s = 0.0;
    bool shapes = std::isfinite(units_[c]), quiet = true;
    for (std::size_t i = k > 0 ? k - 1 : k; i < k + 1 && i < trail_.still.size(); ++i) {
      turned += trail_.rotation_deg[i][c];
      seen += nodes_[i + 1].at.z[c] - nodes_[i].at.z[c];
      time_s += Length(i);
      shapes = shapes && Shapes(i, c);
      quiet = quiet && Quiet(i, c);
    }
    if (time_s <= 0.0) return;
    const double mean = turned / time_s;
    double offset = -at_rest_[k][c];
    if (!std::isfinite(offset)) offset = mean - seen / units_[c] / time_s;
    Near& near = trail_.gyro_turns[k].near_deg;
    for (std::size_t n = 0; n < kNear_s.size(); ++n) {
      const double shown =
          std::isfinite(steady) ? steady * kNear_s[n] : nodes_[k].z_near[n][c] / units_[c];
      const double by_gyro = shown + offset * kNear_s[n];
      near[n][c] = quiet || !shapes ? mean * kNear_s[n] : by_gyro;
    }
    constexpr std::size_t kBefore = 2, kAfter = 5;  // 20 ms
    point.rate_deg_s[c] =
        (near[kAfter][c] - near[kBefore][c]) / (kNear_s[kAfter] - kNear_s[kBefore]);
  }

  // What the gyro turned over interval i, less its rate at rest [deg]; `steady`: its mean output
  // there where that is steady.
  double Way(std::size_t i, std::size_t c, double steady) const {
    const double shown = std::isfinite(steady)
                             ? steady * Length(i)
                             : (nodes_[i + 1].at.z[c] - nodes_[i].at.z[c]) / units_[c];
    const double way_deg = shown - at_rest_[i + 1][c] * Length(i);
    return Quiet(i, c) || !Shapes(i, c) || !std::isfinite(way_deg) ? trail_.rotation_deg[i][c]
                                                                   : way_deg;
  }

  const std::vector<calibration::Node>& nodes_;
  const Vector3& units_;
  Trail& trail_;
  const std::vector<Vector3> at_rest_;
  Vector3 walk_deg_sqrt_s_ = {};
};

}  // namespace

void FillRates(const Recording& recording, const Vector3& units_per_deg_s, Trail* trail) {
  RateMaker maker(trail->epochs, units_per_deg_s, trail);
  maker.Halves();
  maker.Steady();
  maker.Nodes();
  maker.Spans();
  maker.TableByGyro(recording.info, recording.columns.nodes);
}

}  // namespace gyrobench::calibration

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/robust.h"
#include "calibration/state/even_turns.h"
#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

// Rates that are steady over so many intervals either way.
constexpr std::size_t kReach = 4;
constexpr double kAlike_deg_s = 0.5, kAlikeShare = 0.03;

class RateMaker {
 public:
  RateMaker(const std::vector<Node>& nodes, const Vector3& units,
            const std::vector<Vector3>& settled_deg, StateHistory* history)
      : nodes_(nodes),
        units_(units),
        settled_deg_(settled_deg),
        history_(*history),
        at_rest_(RatesAtRest(nodes, units, settled_deg, *history, false)) {
    for (std::size_t c = 0; c < 3; ++c) walk_deg_sqrt_s_[c] = WalkAtRest(c);
  }

  void Halves() {
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      const double dt = Length(i);
      for (std::size_t c = 0; c < 3; ++c) {
        const double turned = Turned_deg(i, c);
        double uneven = 0.0;  // half the difference of the halves, as the gyro saw it
        if (Shapes(i, c) && !Quiet(i, c) && HasMiddle(i)) {
          uneven = 0.25 * dt * (MeanOutput(i, c, false) - MeanOutput(i, c, true)) / units_[c];
        }
        history_.midpoints[2 * i].rate_deg_s[c] = (turned + 2.0 * uneven) / dt;
        history_.midpoints[2 * i + 1].rate_deg_s[c] = (turned - 2.0 * uneven) / dt;
      }
    }
  }

  // At steady speed the rate is what the neighbours say: with the noise of its own two readings,
  // which is in the output as well, a steep function of the rate would find it.
  void Steady() {
    std::vector<Vector3> rates(history_.still.size());
    for (std::size_t i = 0; i < rates.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) rates[i][c] = history_.rotation_deg[i][c] / Length(i);
    }
    for (std::size_t i = kReach; i + kReach < rates.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0.0, count = 0.0;
        const double alike = std::max(kAlike_deg_s, kAlikeShare * std::fabs(rates[i][c]));
        for (std::size_t j = i - kReach; j <= i + kReach; ++j) {
          const double noise = std::hypot(RateNoise(history_, i), RateNoise(history_, j));
          if (history_.still[j] || std::fabs(rates[j][c] - rates[i][c]) > std::max(alike, noise) ||
              FeltToDiffer(i, j, c, kAlikeShare * std::fabs(rates[i][c])))
            break;
          if (j + 1 >= i && j <= i + 1) continue;  // they share a reading with it
          sum += rates[j][c];
          count += 1.0;
        }
        if (count < 2 * kReach - 2) continue;
        history_.midpoints[2 * i].rate_deg_s[c] = history_.midpoints[2 * i + 1].rate_deg_s[c] =
            sum / count;
      }
    }
  }

  // In slow turns the neighbours' rates are no better than a reading's noise, and rounding to counts
  // errs from one to the next alike: a line through many nodes has next to none of it.
  void EvenTurns() {
    std::vector<double> t_s, felt_deg(nodes_.size(), 0.0);
    const std::array<std::vector<double>, 3> read_deg = {Read_deg(0), Read_deg(1), Read_deg(2)};
    for (const calibration::Node& node : nodes_) t_s.push_back(node.at.t_s);
    for (std::size_t c = 0; c < 3; ++c) {
      if (!(walk_deg_sqrt_s_[c] > 0.0) || !std::isfinite(units_[c])) continue;
      for (std::size_t k = 1; k < nodes_.size(); ++k)
        felt_deg[k] = (nodes_[k].at.z[c] - nodes_[0].at.z[c]) / units_[c];
      const AngleSeries series = {t_s, read_deg[c], felt_deg, history_.angle_error_deg,
                                  walk_deg_sqrt_s_[c]};
      std::size_t end = 0;
      for (std::size_t i = 0; i < history_.still.size(); i = std::max(end, i + 1)) {
        const auto goes_on = [&](std::size_t j) {
          return j < history_.still.size() && !history_.still[j] && Shapes(j, c) &&
                 std::isfinite(history_.rotation_deg[j][c]);
        };
        for (end = i; goes_on(end);) ++end;
        for (std::size_t part = i; part < end; part += kLongestReach) {
          const std::size_t from = part - std::min(part - i, kLongestReach);
          if (HasPartIn(read_deg, c, from, std::min(part + 2 * kLongestReach, end)))
            TakeEvenTurns(series, c, {i, end + 1}, {part, std::min(part + kLongestReach, end)});
        }
      }
    }
  }

  // Of the midpoints, once the nodes are known.
  void Spans() {
    for (std::size_t i = 0; i < history_.midpoints.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double middle = 0.5 * (history_.midpoints[i / 2 * 2].rate_deg_s[c] +
                                     history_.midpoints[i / 2 * 2 + 1].rate_deg_s[c]);
        const double node = history_.nodes[(i + 1) / 2].rate_deg_s[c];
        history_.midpoints[i].rate_span_deg_s[c] = i % 2 == 0 ? middle - node : node - middle;
      }
    }
  }

  // `recorded`: the nodes as they were, which are instants.
  void Nodes(const std::vector<calibration::Node>& recorded) {
    std::vector<GyroTurn>& turns = history_.gyro_turns;
    turns.assign(nodes_.size(), GyroTurn{});
    std::vector<Vector3> steady(nodes_.size());
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      turns[k].t_s = nodes_[k].at.t_s;
      history_.nodes[k].node = k;
      history_.nodes[k].gyro_turns = turns;
      for (std::size_t c = 0; c < 3; ++c) {
        steady[k][c] = SteadyOutput(k, c);
        Node(k, c, steady[k][c]);
      }
    }
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c)
        turns[i + 1].since_first_deg[c] =
            turns[i].since_first_deg[c] + TurnOver(i, c, 0.5 * (steady[i][c] + steady[i + 1][c]));
    }
    for (std::size_t k = 1; k < nodes_.size(); ++k) {
      for (std::size_t c = 0; c < 3; ++c)
        FillWay(recorded[k - 1].at.t_s, recorded[k], k, c, steady[k][c]);
    }
  }

  const std::vector<Vector3>& at_rest_deg_s() const { return at_rest_; }
  const Vector3& walk_deg_sqrt_s() const { return walk_deg_sqrt_s_; }

 private:
  // Of the intervals `here`, by nodes of the stretch.
  void TakeEvenTurns(const AngleSeries& series, std::size_t c, const NodeRange& stretch,
                     const NodeRange& here) {
    for (std::size_t j = here.begin; j < here.end; ++j) {
      const double middle_s = 0.5 * (series.t_s[j] + series.t_s[j + 1]);
      const auto turn = FindEvenTurn(series, j, middle_s, stretch.begin, stretch.end);
      if (!turn) continue;
      const double change = 0.25 * Length(j) * turn->acceleration_deg_s2;
      history_.midpoints[2 * j].rate_deg_s[c] = turn->rate_deg_s - change;
      history_.midpoints[2 * j + 1].rate_deg_s[c] = turn->rate_deg_s + change;
    }
  }

  // Angle random walk of the channel [deg/sqrt(s)], by how its mean output changes from one interval
  // at rest to the next; where it never rests, of those in which the reference hardly turns. 0 where
  // it always does.
  double WalkAtRest(std::size_t c) const {
    const double walk = Walk(c, [&](std::size_t i) { return history_.still[i]; });
    return walk > 0.0 ? walk : Walk(c, [&](std::size_t i) { return Quiet(i, c); });
  }
  template <typename Rests>
  double Walk(std::size_t c, const Rests& rests) const {
    constexpr double kMedianOfNormal = 0.6745;
    std::vector<double> walks;
    for (std::size_t i = 1; i < history_.still.size(); ++i) {
      if (!rests(i - 1) || !rests(i) || !Shapes(i - 1, c) || !Shapes(i, c)) continue;
      const double change_deg_s = Output(i, i + 1, c) - Output(i - 1, i, c);
      if (!std::isfinite(change_deg_s)) continue;
      walks.push_back(std::fabs(change_deg_s) / std::sqrt(1.0 / Length(i - 1) + 1.0 / Length(i)));
    }
    return walks.empty() ? 0.0 : Median(std::move(walks)) / kMedianOfNormal;
  }

  // How far the reference turned about the channel's axis up to each node.
  std::vector<double> Read_deg(std::size_t c) const {
    std::vector<double> out(nodes_.size(), 0.0);
    for (std::size_t k = 0; k + 1 < nodes_.size(); ++k) {
      const double turned_deg = history_.rotation_deg[k][c];
      out[k + 1] = out[k] + (std::isfinite(turned_deg) ? turned_deg : 0.0);
    }
    return out;
  }

  // Over interval i: as the gyro felt it, where the noise of the two readings is far larger than the
  // gyro's and both say the same. That noise is in the output as well, and columns that are nearly
  // one, such as a turn and what vibrates with it, would be told apart by it. The gyro's own scale
  // makes none of this the turn: what the readings say beyond the rates goes to the output
  // (ChannelProblem::MoveReadingErrorToOutput).
  double Turned_deg(std::size_t i, std::size_t c) const {
    constexpr double kFar = 3.0;
    const double read_deg = history_.rotation_deg[i][c];
    if (!Shapes(i, c) || Quiet(i, c) || !(walk_deg_sqrt_s_[c] > 0.0)) return read_deg;
    const double felt_deg = Felt_deg(i, c, kMissing);
    const double gyro_deg = walk_deg_sqrt_s_[c] * std::sqrt(Length(i)),
                 readings_deg = RateNoise(history_, i) * Length(i) / kNoiseSigmas;
    const bool same = std::fabs(felt_deg - read_deg) <
                      kNoiseSigmas * readings_deg + kAlikeShare * std::fabs(read_deg);
    return readings_deg > kFar * gyro_deg && same ? felt_deg : read_deg;
  }

  double Length(std::size_t i) const { return nodes_[i + 1].at.t_s - nodes_[i].at.t_s; }
  // Mean output from one node to another [deg/s].
  double Output(std::size_t from, std::size_t to, std::size_t c) const {
    return (nodes_[to].at.z[c] - nodes_[from].at.z[c]) / units_[c] /
           (nodes_[to].at.t_s - nodes_[from].at.t_s);
  }
  bool Shapes(std::size_t i, std::size_t c) const {
    return history_.usable[i][c] && std::isfinite(units_[c]);
  }

  // The gyro, whose noise may be far less than that of the readings, says that the rates over two
  // intervals differ by more than `alike` and its noise.
  bool FeltToDiffer(std::size_t i, std::size_t j, std::size_t c, double alike) const {
    if (!Shapes(i, c) || !Shapes(j, c)) return false;
    const double rate = (nodes_[i + 1].at.z[c] - nodes_[i].at.z[c]) / (units_[c] * Length(i));
    const double other = (nodes_[j + 1].at.z[c] - nodes_[j].at.z[c]) / (units_[c] * Length(j));
    const double noise =
        kNoiseSigmas * walk_deg_sqrt_s_[c] * std::sqrt(1.0 / Length(i) + 1.0 / Length(j));
    return std::fabs(other - rate) > std::max(alike, noise);
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
    return history_.still[i] ||
           std::fabs(settled_deg_[i][c]) <
               std::max(kLeastMotion_deg_s, RateNoise(history_, i)) * Length(i);
  }
  // The same, and the gyro agrees, or no turn is near: one that is early or late against the
  // reference turns while that stands still, and the other way round.
  bool QuietByGyro(std::size_t i, std::size_t c) const {
    constexpr std::size_t kEarlyOrLate = 4;  // intervals
    if (history_.still[i]) return true;
    if (!Quiet(i, c)) return false;
    const double noise_deg = kNoiseSigmas * walk_deg_sqrt_s_[c] * std::sqrt(Length(i));
    if (!(std::fabs(Felt_deg(i, c, kMissing) - settled_deg_[i][c]) > noise_deg)) return true;
    const std::size_t end = std::min(i + kEarlyOrLate + 1, history_.still.size());
    for (std::size_t j = i - std::min(i, kEarlyOrLate); j < end; ++j) {
      if (!Quiet(j, c)) return false;
    }
    return true;
  }

  // Mean output about node k where it does not change by more than its own noise [deg/s]; NaN
  // elsewhere. The noise of the few samples about a node is in the output as well: a regressor that
  // has it makes the residual larger or smaller than the motion alone would.
  double SteadyOutput(std::size_t k, std::size_t c) const {
    if (k < kReach || k + kReach >= nodes_.size()) return kMissing;
    const double mean = Output(k - kReach, k + kReach, c);
    for (std::size_t j = k - kReach; j < k + kReach; ++j) {
      const double noise = kNoiseSigmas * walk_deg_sqrt_s_[c] / std::sqrt(Length(j));
      if (history_.still[j] || !(std::fabs(Output(j, j + 1, c) - mean) < noise)) return kMissing;
    }
    return mean;
  }

  // The gyro's shape within 40 ms, less its rate at rest; where that is not known, with the mean over
  // both neighbours as the reference has it.
  void Node(std::size_t k, std::size_t c, double steady) {
    SensorState& point = history_.nodes[k];
    double turned = 0.0, seen = 0.0, time_s = 0.0;
    bool shapes = std::isfinite(units_[c]), quiet = true;
    for (std::size_t i = k > 0 ? k - 1 : k; i < k + 1 && i < history_.still.size(); ++i) {
      turned += settled_deg_[i][c];
      seen += nodes_[i + 1].at.z[c] - nodes_[i].at.z[c];
      time_s += Length(i);
      shapes = shapes && Shapes(i, c);
      quiet = quiet && QuietByGyro(i, c);
    }
    if (time_s <= 0.0) return;
    const double mean = turned / time_s;
    double offset = -at_rest_[k][c];
    if (!std::isfinite(offset)) offset = mean - seen / units_[c] / time_s;
    Near& near = history_.gyro_turns[k].near_deg;
    for (std::size_t n = 0; n < kNear_s.size(); ++n) {
      const double shown =
          std::isfinite(steady) ? steady * kNear_s[n] : nodes_[k].z_near[n][c] / units_[c];
      const double by_gyro = shown + offset * kNear_s[n];
      near[n][c] = quiet || !shapes ? mean * kNear_s[n] : by_gyro;
    }
    if (!quiet && shapes && !std::isfinite(steady)) StraightenNear(k, c, &near);
    constexpr std::size_t kBefore = 2, kAfter = 5;  // 20 ms
    point.rate_deg_s[c] =
        (near[kAfter][c] - near[kBefore][c]) / (kNear_s[kAfter] - kNear_s[kBefore]);
  }

  struct Acceleration {
    double value, noise;  // deg/s^2
  };
  // Over the intervals on both sides of a node, by the reference.
  std::optional<Acceleration> AccelerationByReference(std::size_t k, std::size_t c) const {
    if (k == 0 || k >= history_.still.size()) return std::nullopt;
    const double before_s = Length(k - 1), after_s = Length(k),
                 apart_s = 0.5 * (before_s + after_s);
    const double error_deg = std::numbers::sqrt2 * history_.angle_error_deg;
    return Acceleration{
        (settled_deg_[k][c] / after_s - settled_deg_[k - 1][c] / before_s) / apart_s,
        error_deg * (1.0 / before_s + 1.0 / after_s) / apart_s};
  }

  // Puts the rates of the steps about a node on a straight line, where they leave it by no more
  // than noise does: what noise makes of the rate within a few milliseconds is in the output as
  // well, and two columns that are one but for that noise (a delay, and a lag that takes it back)
  // would explain it.
  void StraightenNear(std::size_t k, std::size_t c, Near* near) const {
    constexpr int kSteps = static_cast<int>(kNear_s.size()), kHalf = kSteps / 2;
    constexpr double kMostChiSquare = 30.0;  // of 6 degrees: once in 25,000 by chance
    constexpr double kSquare = kSteps * (kSteps * kSteps - 1) / 12.0;
    const auto at = [&](int step) {
      if (step == 0) return 0.0;
      return (*near)[static_cast<std::size_t>(step < 0 ? step + kHalf : step + kHalf - 1)][c];
    };
    double sum = 0.0, squares = 0.0, product = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double turned = at(i + 1 - kHalf) - at(i - kHalf);
      sum += turned;
      squares += turned * turned;
      product += (i - 0.5 * (kSteps - 1)) * turned;
    }
    const double left = squares - sum * sum / kSteps - product * product / kSquare;
    if (!(left < kMostChiSquare * walk_deg_sqrt_s_[c] * walk_deg_sqrt_s_[c] * kNearStep_s)) return;
    const double rate = sum / (kSteps * kNearStep_s), step2 = kNearStep_s * kNearStep_s;
    double acceleration = product / (kSquare * step2);
    const double noise = walk_deg_sqrt_s_[c] * std::sqrt(kNearStep_s / kSquare) / step2;
    if (const auto read = AccelerationByReference(k, c);
        read && read->noise < noise &&
        std::fabs(read->value - acceleration) < kNoiseSigmas * std::hypot(noise, read->noise))
      acceleration = read->value;
    for (std::size_t n = 0; n < kNear_s.size(); ++n)
      (*near)[n][c] = kNear_s[n] * (rate + 0.5 * kNear_s[n] * acceleration);
  }

  // The way to node k, which was recorded as `to`, from `from_s`; `steady`: its mean output there
  // where that is steady [deg/s].
  void FillWay(double from_s, const calibration::Node& to, std::size_t k, std::size_t c,
               double steady) {
    GyroTurn& turn = history_.gyro_turns[k];
    turn.way_end_s = to.at.t_s - nodes_[k].at.t_s;
    const double step_s = (to.at.t_s - from_s) / static_cast<double>(kWaySteps);
    const double mean = settled_deg_[k - 1][c] / Length(k - 1);
    const bool shown = Shapes(k - 1, c) && !QuietByGyro(k - 1, c) && std::isfinite(at_rest_[k][c]);
    for (std::size_t i = 0; i < kWaySteps; ++i) {
      const double by_s = turn.way_end_s - static_cast<double>(kWaySteps - 1 - i) * step_s;
      const double by_gyro =
          std::isfinite(steady) ? steady * by_s : (to.z_way[i][c] - nodes_[k].at.z[c]) / units_[c];
      turn.way_deg[i][c] = shown ? by_gyro - at_rest_[k][c] * by_s : mean * by_s;
    }
  }

  // What the gyro turned over interval i, less its rate at rest [deg]; `steady`: its mean output
  // there where that is steady.
  double Felt_deg(std::size_t i, std::size_t c, double steady) const {
    const double shown = std::isfinite(steady)
                             ? steady * Length(i)
                             : (nodes_[i + 1].at.z[c] - nodes_[i].at.z[c]) / units_[c];
    return shown - at_rest_[i + 1][c] * Length(i);
  }
  // The same, or what the reference did where the gyro does not say.
  double TurnOver(std::size_t i, std::size_t c, double steady) const {
    const double felt_deg = Felt_deg(i, c, steady);
    return QuietByGyro(i, c) || !Shapes(i, c) || !std::isfinite(felt_deg) ? settled_deg_[i][c]
                                                                          : felt_deg;
  }

  const std::vector<calibration::Node>& nodes_;
  const Vector3& units_;
  const std::vector<Vector3>& settled_deg_;
  StateHistory& history_;
  const std::vector<Vector3> at_rest_;
  Vector3 walk_deg_sqrt_s_ = {};
};

}  // namespace

void FillRates(const Recording& recording, const Vector3& units_per_deg_s,
               const std::vector<Vector3>& settled_deg, StateHistory* history) {
  RateMaker maker(history->epochs, units_per_deg_s, settled_deg, history);
  maker.Halves();
  maker.Steady();
  maker.EvenTurns();
  maker.Nodes(recording.columns.nodes);
  maker.Spans();
  const std::vector<Vector3> next =
      RatesAtRest(history->epochs, units_per_deg_s, settled_deg, *history, true);
  const Vector3& walks = maker.walk_deg_sqrt_s();
  FillTableWays(recording, {units_per_deg_s, maker.at_rest_deg_s(), next, std::ranges::max(walks)},
                history);
  FillReadingAngles(history);
  SmoothAngles(walks, history);
}

}  // namespace gyrobench::calibration

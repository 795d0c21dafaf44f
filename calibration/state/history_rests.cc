// Which nodes are at rest.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/robust.h"
#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

// A motion that begins softly is below the noise of single readings for so long.
constexpr double kCreep_s = 0.2;
// Beyond so many standard deviations of the output between two nodes at rest the sensor turns.
constexpr double kTurnSigmas = 4.0;
// So long before the end (after the begin) of a rest a motion may have begun that neither single
// readings nor single samples show; what comes before is what the sensor shows at rest.
constexpr double kEdge_s = 1.5, kMostOfRest = 0.4;
// A rest that is no longer may be a reversal or the end of a motion; so near to it another in the
// same pose has the same offset.
constexpr double kShortRest_s = 1.5, kBeside_s = 10.0, kSamePose_deg = 1.0;
// Of a shorter one neither its readings nor the gyro tell that it is not a slow reversal.
constexpr double kLeastRest_s = 0.55;
// One that is so many times as long is less likely to be one of them itself.
constexpr double kLongerBeside = 3.0;
// A short rest in which the readings of an axis go on evenly by more than that is the slow part of
// a motion; in counts of the encoder, and at least.
constexpr double kDriftCounts = 1.5, kLeastDrift_deg = 0.005, kLeastAway_deg = 0.0005;
constexpr std::size_t kLeastQuiet = 3, kMostQuiet = 30;

// Of values over time by least squares, each with a weight: its inverse variance over one's.
class WeightedSlope {
 public:
  void Add(double t_s, double value, double weight) {
    w_ += weight;
    t_ += weight * t_s;
    v_ += weight * value;
    tt_ += weight * t_s * t_s;
    tv_ += weight * t_s * value;
  }
  double Size() const { return Spread() > 0.0 ? std::fabs(tv_ - t_ * v_ / w_) / Spread() : 0.0; }
  double InStandardErrors(double sigma_of_one) const {
    return Spread() > 0.0 ? Size() * std::sqrt(Spread()) / sigma_of_one : 0.0;
  }

 private:
  double Spread() const { return w_ > 0.0 ? tt_ - t_ * t_ / w_ : 0.0; }
  double w_ = 0.0, t_ = 0.0, v_ = 0.0, tt_ = 0.0, tv_ = 0.0;
};

class RestTrimmer {
 public:
  RestTrimmer(const Recording& recording, std::vector<std::size_t>* rest_of)
      : recording_(recording),
        nodes_(recording.columns.nodes),
        rest_of_(*rest_of),
        read_(AnglesRead(recording.info)),
        sigma_(Scatter()) {
    for (std::size_t a = 0; a < 3; ++a)
      reading_deg_[a] = ScatterAtRest(nodes_, RangesOfRests(rest_of_), a);
  }

  void Run() {
    for (const NodeRange& rest : RangesOfRests(rest_of_)) Trim(rest.begin, rest.end);
    DropThoseThatTurn();
  }

 private:
  double Rate(std::size_t i, std::size_t c) const {
    return (nodes_[i + 1].at.z[c] - nodes_[i].at.z[c]) / (nodes_[i + 1].at.t_s - nodes_[i].at.t_s);
  }
  bool Within(std::size_t i) const {
    return i + 1 < rest_of_.size() && rest_of_[i] != kNoRest && rest_of_[i] == rest_of_[i + 1];
  }

  // Of the output from node to node at rest: from the median difference of neighbours, which few
  // that turn do not move (0.954: of the size of a normal difference of two).
  Vector3 Scatter() const {
    Vector3 sigma = {};
    for (std::size_t c = 0; c < 3; ++c) {
      if (!recording_.info.gyro_present[c]) continue;
      std::vector<double> differences;
      for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
        if (Within(i) && Within(i + 1))
          differences.push_back(std::fabs(Rate(i + 1, c) - Rate(i, c)));
      }
      if (!differences.empty()) sigma[c] = Median(std::move(differences)) / 0.954;
    }
    return sigma;
  }

  // A noisy reference shows a reversal as a rest, in which the rate changes, and the slow end of a
  // motion, all of which turns alike: there a long rest beside it, in the same pose, says what the
  // sensor shows at rest. Of a few nodes no rate is known well enough.
  void DropThoseThatTurn() {
    const std::vector<NodeRange> rests = RangesOfRests(rest_of_);
    for (std::size_t r = 0; r < rests.size(); ++r) {
      if (Length(rests[r]) > kShortRest_s) continue;
      const bool turns = rests[r].end - rests[r].begin <= kLeastQuiet ||
                         Length(rests[r]) < kLeastRest_s || TurnsWithin(rests[r]) ||
                         ReadingsDrift(rests[r]) ||
                         (r > 0 && TurnsBeside(rests[r], rests[r - 1])) ||
                         (r + 1 < rests.size() && TurnsBeside(rests[r], rests[r + 1]));
      for (std::size_t k = rests[r].begin; turns && k < rests[r].end; ++k) rest_of_[k] = kNoRest;
    }
  }

  double Length(const NodeRange& rest) const {
    return nodes_[rest.end - 1].at.t_s - nodes_[rest.begin].at.t_s;
  }

  bool TurnsWithin(const NodeRange& rest) const {
    const Vector3 mean = Quiet(rest.begin, rest.end - 1);
    for (std::size_t i = rest.begin; i + 1 < rest.end; ++i) {
      if (Turns(i, mean)) return true;
    }
    return false;
  }

  bool TurnsBeside(const NodeRange& rest, const NodeRange& beside) const {
    const double apart_s = std::max(nodes_[beside.begin].at.t_s - nodes_[rest.end - 1].at.t_s,
                                    nodes_[rest.begin].at.t_s - nodes_[beside.end - 1].at.t_s);
    const double least_s = std::min(kShortRest_s, kLongerBeside * Length(rest));
    if (Length(beside) <= least_s || apart_s > kBeside_s || !SamePose(rest, beside)) return false;
    const Vector3 here = Quiet(rest.begin, rest.end - 1);
    const Vector3 there = Quiet(beside.begin, beside.end - 1);
    const double sigmas =
        kTurnSigmas * std::sqrt(1.0 / static_cast<double>(rest.end - rest.begin - 1) +
                                1.0 / static_cast<double>(beside.end - beside.begin - 1));
    for (std::size_t c = 0; c < 3; ++c) {
      if (sigma_[c] > 0.0 && std::fabs(here[c] - there[c]) > sigmas * sigma_[c]) return true;
    }
    return false;
  }

  double Count_deg(std::size_t axis) const {
    return std::fmax(0.0, recording_.reference_step_deg[axis]);
  }

  // By the slope of the nodes' mean readings over time.
  bool ReadingsDrift(const NodeRange& rest) const {
    for (std::size_t a = 0; a < 3; ++a) {
      if (!read_[a] || !std::isfinite(reading_deg_[a])) continue;
      const double count_deg = Count_deg(a);
      WeightedSlope slope;
      for (std::size_t k = rest.begin; k < rest.end; ++k) {
        const ReadingsMean& mean = nodes_[k].mean;
        if (HasReading(mean, a))
          slope.Add(nodes_[k].at.t_s - nodes_[rest.begin].at.t_s, mean.own_deg[a],
                    mean.own_readings[a]);
      }
      const double noise_deg = std::max(reading_deg_[a], count_deg / std::sqrt(12.0));
      const double least_deg = std::max(kDriftCounts * count_deg, kLeastDrift_deg);
      if (slope.InStandardErrors(noise_deg) > kTurnSigmas &&
          slope.Size() * Length(rest) > least_deg)
        return true;
    }
    return false;
  }

  bool SamePose(const NodeRange& rest, const NodeRange& beside) const {
    for (std::size_t a = 0; a < 3; ++a) {
      if (!read_[a]) continue;
      const double off_deg = nodes_[rest.begin].table_deg[a] - nodes_[beside.begin].table_deg[a];
      if (!(std::fabs(off_deg) < kSamePose_deg)) return false;
    }
    return read_[0] || read_[1] || read_[2];
  }

  // Nodes [begin, end) of one rest.
  void Trim(std::size_t begin, std::size_t end) {
    // A measurement that begins or ends at rest has no motion there.
    const std::size_t last = end < nodes_.size() ? MotionFrom(begin, end) : end;
    const std::size_t first = begin > 0 ? RestFrom(begin, last) : begin;
    for (std::size_t k = begin; k < first; ++k) rest_of_[k] = kNoRest;
    for (std::size_t k = last; k < end; ++k) rest_of_[k] = kNoRest;
  }

  // Mean output over intervals [from, to).
  Vector3 Quiet(std::size_t from, std::size_t to) const {
    Vector3 mean = {};
    for (std::size_t c = 0; c < 3; ++c) {
      mean[c] =
          (nodes_[to].at.z[c] - nodes_[from].at.z[c]) / (nodes_[to].at.t_s - nodes_[from].at.t_s);
    }
    return mean;
  }

  // By how many standard deviations the output over interval i differs from that at rest.
  double Sigmas(std::size_t i, const Vector3& quiet) const {
    double most = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      if (sigma_[c] > 0.0) most = std::fmax(most, std::fabs(Rate(i, c) - quiet[c]) / sigma_[c]);
    }
    return most;
  }
  bool Turns(std::size_t i, const Vector3& quiet) const { return Sigmas(i, quiet) > kTurnSigmas; }

  // Mean of the readings of an axis over nodes [from, to); NaN without any.
  double Level_deg(std::size_t from, std::size_t to, std::size_t axis) const {
    double sum = 0.0, count = 0.0;
    for (std::size_t k = from; k < to; ++k) {
      const ReadingsMean& mean = nodes_[k].mean;
      if (!HasReading(mean, axis)) continue;
      sum += mean.own_readings[axis] * mean.own_deg[axis];
      count += mean.own_readings[axis];
    }
    return count > 0.0 ? sum / count : kMissing;
  }

  // The readings of a node are off what they are in the quiet part of the rest: it still turns, or
  // already, too slowly for the gyro to say so.
  bool IsAway(std::size_t k, const Vector3& level_deg) const {
    for (std::size_t a = 0; a < 3; ++a) {
      if (!read_[a] || !std::isfinite(reading_deg_[a])) continue;
      const double noise_deg =
          kTurnSigmas * reading_deg_[a] / std::sqrt(std::max(1.0, nodes_[k].mean.own_readings[a]));
      const double off_deg = std::fabs(Level_deg(k, k + 1, a) - level_deg[a]);
      if (off_deg > std::max({noise_deg, kDriftCounts * Count_deg(a), kLeastAway_deg})) return true;
    }
    return false;
  }

  Vector3 Levels_deg(std::size_t from, std::size_t to) const {
    return {Level_deg(from, to, 0), Level_deg(from, to, 1), Level_deg(from, to, 2)};
  }

  // Of a short rest a part is left between its edges.
  double EdgeOf(std::size_t begin, std::size_t end) const {
    return std::min(kEdge_s, kMostOfRest * (nodes_[end - 1].at.t_s - nodes_[begin].at.t_s));
  }

  // For how long a motion that ends softly goes on after the gyro has felt it last: the rate goes to
  // nothing with the square of the time that is left, so that it falls by a factor of four in as long
  // as it then lasts. Looked for from interval `i`, on the side where it turns; a motion that begins
  // softly is the same the other way round. 0 where it is not felt that clearly, or too far off.
  double GoesOnFor_s(std::size_t i, bool before, const Vector3& quiet) const {
    constexpr double kLongest_s = 3.0, kClearly = 4.0 * kTurnSigmas;
    const double from_s = nodes_[i].at.t_s;
    double felt_s = kMissing;  // where it began to be felt without a break
    while (i + 1 < nodes_.size() && std::fabs(nodes_[i].at.t_s - from_s) < kLongest_s) {
      const double t_s = nodes_[i].at.t_s, sigmas = Sigmas(i, quiet);
      if (!(sigmas > kTurnSigmas)) {
        felt_s = kMissing;
      } else if (!std::isfinite(felt_s)) {
        felt_s = t_s;
      }
      if (sigmas > kClearly) return std::fabs(t_s - felt_s);
      if (before && i == 0) break;
      i = before ? i - 1 : i + 1;
    }
    return 0.0;
  }

  // At the ends of what the reference calls a rest so much is left out already.
  static double LeftToLeave_s(double soft_s) { return std::max(0.0, soft_s - kCreep_s); }

  // The first node that does not count as rest because a motion follows, in it or next to it.
  std::size_t MotionFrom(std::size_t begin, std::size_t end) const {
    std::size_t edge = end;
    const double edge_s = EdgeOf(begin, end);
    while (edge > begin && nodes_[end - 1].at.t_s - nodes_[edge - 1].at.t_s < edge_s) --edge;
    if (edge < begin + kLeastQuiet + 1) return end;
    const std::size_t from = edge > begin + kMostQuiet ? edge - kMostQuiet : begin;
    const Vector3 quiet = Quiet(from, edge), level_deg = Levels_deg(from, edge);
    std::size_t last = edge;
    while (last < end && !IsAway(last, level_deg) && !Turns(last, quiet)) ++last;
    const double soft_s = GoesOnFor_s(last, false, quiet);
    const double left_s = last < end ? std::max(kCreep_s, soft_s) : LeftToLeave_s(soft_s);
    const double begin_s = nodes_[last].at.t_s - left_s;
    while (last > edge && nodes_[last].at.t_s > begin_s) --last;
    return last;
  }

  // The first node that counts as rest after a motion.
  std::size_t RestFrom(std::size_t begin, std::size_t end) const {
    std::size_t edge = begin;
    const double edge_s = EdgeOf(begin, end);
    while (edge < end && nodes_[edge].at.t_s - nodes_[begin].at.t_s < edge_s) ++edge;
    if (edge + kLeastQuiet >= end) return begin;
    const std::size_t to = std::min(edge + kMostQuiet, end - 1);
    const Vector3 quiet = Quiet(edge, to), level_deg = Levels_deg(edge, to);
    std::size_t first = edge;
    while (first > begin && !IsAway(first - 1, level_deg) && !Turns(first - 1, quiet)) --first;
    const double soft_s = GoesOnFor_s(first - 1, true, quiet);
    const double left_s = first > begin ? std::max(kCreep_s, soft_s) : LeftToLeave_s(soft_s);
    const double end_s = nodes_[first].at.t_s + left_s;
    while (first < edge && nodes_[first].at.t_s < end_s) ++first;
    return first;
  }

  const Recording& recording_;
  const std::vector<Node>& nodes_;
  std::vector<std::size_t>& rest_of_;
  std::array<bool, 3> read_;     // axes
  Vector3 sigma_, reading_deg_;  // scatter at rest: of the output, of one reading
};

}  // namespace

std::array<bool, 3> AnglesRead(const MeasurementInfo& info) {
  std::array<bool, 3> axes = {};
  if (info.reference == ReferenceKind::kStandAngles) axes = info.stand_axis_present;
  if (info.reference == ReferenceKind::kSensorAngle)
    axes[static_cast<std::size_t>(info.reference_axis)] = true;
  return axes;
}

std::vector<NodeRange> RangesOfRests(const std::vector<std::size_t>& rest_of) {
  std::vector<NodeRange> out;
  for (std::size_t begin = 0, end = 0; begin < rest_of.size(); begin = end) {
    for (end = begin + 1; end < rest_of.size() && rest_of[end] == rest_of[begin];) ++end;
    if (rest_of[begin] != kNoRest) out.push_back({begin, end});
  }
  return out;
}

std::vector<std::size_t> RestsOfNodes(const Recording& recording) {
  const std::vector<Node>& nodes = recording.columns.nodes;
  const std::vector<Rest>& rests = recording.columns.rests;
  std::vector<std::size_t> rest_of(nodes.size(), kNoRest);
  std::size_t rest = 0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const double t_s = nodes[k].at.t_s;
    while (rest < rests.size() && rests[rest].end.t_s < t_s) ++rest;
    if (rest == rests.size() || rests[rest].begin.t_s > t_s) continue;
    if (t_s <= rests[rest].reference_begin_s + kCreep_s ||
        t_s >= rests[rest].reference_end_s - kCreep_s)
      continue;
    rest_of[k] = rest;
  }
  if (recording.info.reference != ReferenceKind::kNone) RestTrimmer(recording, &rest_of).Run();
  return rest_of;
}

}  // namespace gyrobench::calibration

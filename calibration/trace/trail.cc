#include "calibration/trace/trail.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "calibration/schedule.h"
#include "calibration/trace/trail_parts.h"

namespace gyrobench::calibration {
namespace {

// The error of a mean over a rest does not fall for ever: what is not noise stays.
constexpr double kLeastShare = 0.04;
// What is left of a reading's error, as a variance, where the channel does not feel the axis.
constexpr double kLeastFelt = 1e-4;
// A motion that begins softly is below the noise of single readings for so long.
constexpr double kCreep_s = 0.2;
constexpr double kLeastTurn_deg = 5.0;
constexpr double kTurning_deg_s = 3.0;
constexpr double kDriftShare = 0.02;  // of what a drift is followed by in one interval

Vector3 Minus(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

class TrailMaker {
 public:
  TrailMaker(const Recording& recording, const Vector3& units,
             const std::vector<std::string>& covariates, Trail* trail)
      : recording_(recording),
        covariates_(covariates),
        nodes_(recording.columns.nodes),
        units_(units),
        trail_(*trail),
        rest_of_(nodes_.size(), kNoRest) {}

  void Make() {
    trail_.nodes.resize(nodes_.size());
    const std::size_t intervals = nodes_.empty() ? 0 : nodes_.size() - 1;
    trail_.halves.resize(2 * intervals);
    trail_.still.assign(intervals, false);
    trail_.usable.assign(intervals, {true, true, true});
    trail_.rotation_deg.assign(intervals, Vector3{});
    trail_.reference_share.assign(nodes_.size(), {1.0, 1.0, 1.0});
    FindRests();
    MarkBad();
    MarkDeadReference();
    SettleAxes();
    RestAngles();
    Rotations();
    Tables();
    Shares();
    for (std::size_t k = 0; k < trail_.nodes.size(); ++k) trail_.nodes[k].still = AtRest(k);
    FillGravity(recording_, rest_of_, &trail_);
    FillRates(recording_, units_, &trail_);
    FillTemperature(recording_, &trail_);
    FillCovariates(recording_, covariates_, &trail_);
  }

 private:
  static constexpr std::size_t kShortestSettled = 6;

  bool AtRest(std::size_t k) const { return rest_of_[k] != kNoRest; }
  double Length(std::size_t i) const { return nodes_[i + 1].at.t_s - nodes_[i].at.t_s; }

  void FindRests() {
    std::size_t rest = 0;
    const std::vector<Rest>& rests = recording_.columns.rests;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      const double t_s = nodes_[k].at.t_s;
      trail_.nodes[k].t_s = trail_.nodes[k].since_power_on_s = t_s;
      while (rest < rests.size() && rests[rest].end.t_s < t_s) ++rest;
      if (rest == rests.size() || rests[rest].begin.t_s > t_s) continue;
      if (t_s <= rests[rest].reference_begin_s + kCreep_s ||
          t_s >= rests[rest].reference_end_s - kCreep_s)
        continue;
      rest_of_[k] = rest;
    }
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i)
      trail_.still[i] = AtRest(i) && rest_of_[i] == rest_of_[i + 1];
    if (!trail_.nodes.empty()) trail_.nodes.front().restart = trail_.new_power_on;
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      for (std::size_t h = 0; h < 2; ++h) {
        TrackPoint& point = trail_.halves[2 * i + h];
        point.t_s = nodes_[i].at.t_s + (0.25 + 0.5 * static_cast<double>(h)) * Length(i);
        point.since_power_on_s = point.t_s;
        point.length_s = 0.5 * Length(i);
        point.still = trail_.still[i];
        point.restart = trail_.new_power_on && i == 0 && h == 0;
      }
    }
  }

  void MarkBad() {
    const std::vector<BadStretch>& bad = recording_.columns.bad;
    const bool none = recording_.info.reference == ReferenceKind::kNone;
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        trail_.usable[i][c] = recording_.info.gyro_present[c] && (!none || trail_.still[i]);
      }
    }
    for (const BadStretch& stretch : bad) {
      const auto after =
          std::upper_bound(nodes_.begin(), nodes_.end(), stretch.begin_s,
                           [](double t_s, const Node& node) { return t_s < node.at.t_s; });
      auto i = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - nodes_.begin() - 1, 0));
      for (; i + 1 < nodes_.size() && nodes_[i].at.t_s < stretch.end_s; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
          if (stretch.channel[c]) trail_.usable[i][c] = false;
        }
      }
    }
  }

  // Where the reference says rest and the gyro says turning, one of them is wrong: such stretches
  // are not used, and what they hold is no effect. A bias that drifts with temperature goes as far,
  // but slowly.
  void MarkDeadReference() {
    std::size_t wrong = 0, rests = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      if (!std::isfinite(units_[c])) continue;
      std::vector<std::size_t> still;
      std::vector<double> rates;
      for (std::size_t i = 0; i < trail_.still.size(); ++i) {
        if (!trail_.still[i] || !trail_.usable[i][c]) continue;
        still.push_back(i);
        rates.push_back((nodes_[i + 1].at.z[c] - nodes_[i].at.z[c]) / units_[c] / Length(i));
      }
      if (rates.empty()) continue;
      rests += rates.size();
      std::vector<double> sorted = rates;
      const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
      std::nth_element(sorted.begin(), middle, sorted.end());
      // From where it is as usual, both ways.
      std::size_t anchor = 0;
      for (std::size_t k = 0; k < rates.size(); ++k) {
        if (std::fabs(rates[k] - *middle) < std::fabs(rates[anchor] - *middle)) anchor = k;
      }
      double drift = rates[anchor];
      auto look = [&](std::size_t k) {
        if (std::fabs(rates[k] - drift) > kTurning_deg_s) {
          ++wrong;
          trail_.usable[still[k]] = {false, false, false};
        } else {
          drift += kDriftShare * (rates[k] - drift);
        }
      };
      for (std::size_t k = anchor; k < rates.size(); ++k) look(k);
      drift = rates[anchor];
      for (std::size_t k = anchor; k-- > 0;) look(k);
    }
    if (wrong == 0) return;
    trail_.remarks.push_back(fmt::format(
        "{}: the gyro turns in {:.0f} % of the time in which the reference stands still (or no "
        "reference is given): not used; is the reference connected to what turns?",
        trail_.name, 100.0 * static_cast<double>(wrong) / static_cast<double>(rests)));
  }

  // An axis that stands still while another turns would bring the noise of its readings into the
  // rotation: along such stretches its angle is their mean.
  void SettleAxes() {
    for (const Node& node : nodes_) settled_.push_back(node.table_deg);
    is_settled_.assign(nodes_.size(), {});
    if (recording_.info.reference != ReferenceKind::kStandAngles) return;
    for (std::size_t a = 0; a < 3; ++a) {
      if (!recording_.info.stand_axis_present[a]) continue;
      const double tolerance = RestTolerance(a);
      std::size_t begin = 0;
      for (std::size_t k = 1; k <= nodes_.size(); ++k) {
        const bool stays =
            k < nodes_.size() &&
            std::fabs(nodes_[k].table_deg[a] - nodes_[begin].table_deg[a]) < 2.0 * tolerance &&
            std::fabs(nodes_[k].table_deg[a] - nodes_[k - 1].table_deg[a]) < tolerance;
        if (stays) continue;
        Settle(a, begin, k);
        begin = k;
      }
    }
  }

  // From the quietest changes from node to node; an axis that never rests has none so small.
  double RestTolerance(std::size_t a) const {
    std::vector<double> changes;
    for (std::size_t k = 1; k < nodes_.size(); ++k) {
      const double change = std::fabs(nodes_[k].table_deg[a] - nodes_[k - 1].table_deg[a]);
      if (std::isfinite(change)) changes.push_back(change);
    }
    if (changes.empty()) return 0.0;
    const auto fifth = changes.begin() + static_cast<std::ptrdiff_t>(changes.size() / 5);
    std::nth_element(changes.begin(), fifth, changes.end());
    // A fifth of normal changes is below 0.253 standard deviations.
    return std::clamp(6.0 * *fifth / 0.253, 0.005, 0.1);
  }

  // Nodes [begin, end) of one axis; the ends may creep already.
  void Settle(std::size_t a, std::size_t begin, std::size_t end) {
    constexpr std::size_t kEnds = 2;
    if (end < begin + kShortestSettled + 2 * kEnds) return;
    double sum = 0.0;
    for (std::size_t k = begin + kEnds; k < end - kEnds; ++k) sum += nodes_[k].table_deg[a];
    const double mean = sum / static_cast<double>(end - begin - 2 * kEnds);
    const std::size_t first = begin == 0 ? 0 : begin + kEnds;
    const std::size_t last = end == nodes_.size() ? end : end - kEnds;
    for (std::size_t k = first; k < last; ++k) {
      settled_[k][a] = mean;
      is_settled_[k][a] = true;
    }
  }

  Vector3 NodeRotation(std::size_t k) const {
    return AtRest(k) ? rest_rotation_[rest_of_[k]] : nodes_[k].rotation_deg;
  }

  void Rotations() {
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      Vector3 turned = Minus(NodeRotation(i + 1), NodeRotation(i));
      if (recording_.info.reference == ReferenceKind::kStandAngles) {
        const Matrix3 rates = StandRates(settled_[i]);
        for (std::size_t a = 0; a < 3; ++a) {
          const double change = (TurnedTo(i + 1, a) - TurnedTo(i, a)) -
                                (MeasuredAngle(i + 1, a) - MeasuredAngle(i, a));
          if (!std::isfinite(change) || change == 0.0) continue;
          for (std::size_t c = 0; c < 3; ++c) turned[c] += rates[c][a] * change;
        }
      }
      for (std::size_t c = 0; c < 3; ++c) {
        trail_.rotation_deg[i][c] = (trail_.still[i] ? 0.0 : turned[c]) +
                                    nodes_[i + 1].earth_deg[c] - nodes_[i].earth_deg[c];
      }
    }
  }

  // What the rotation at a node was made of: at rest of the mean over the rest.
  double MeasuredAngle(std::size_t k, std::size_t a) const {
    return AtRest(k) ? rest_angle_[rest_of_[k]][a] : nodes_[k].table_deg[a];
  }

  void RestAngles() {
    rest_angle_.assign(recording_.columns.rests.size(), Vector3{});
    rest_rotation_ = rest_angle_;
    std::vector<double> count(rest_angle_.size(), 0.0);
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      if (!AtRest(k)) continue;
      for (std::size_t a = 0; a < 3; ++a) {
        rest_angle_[rest_of_[k]][a] += nodes_[k].table_deg[a];
        rest_rotation_[rest_of_[k]][a] += nodes_[k].rotation_deg[a];
      }
      count[rest_of_[k]] += 1.0;
    }
    for (std::size_t rest = 0; rest < rest_angle_.size(); ++rest) {
      for (double& angle : rest_angle_[rest]) angle /= count[rest];
      for (double& angle : rest_rotation_[rest]) angle /= count[rest];
    }
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      if (AtRest(k)) trail_.reference_share[k].fill(std::max(kLeastShare, 1.0 / count[rest_of_[k]]));
      for (std::size_t a = 0; a < 3; ++a) {
        if (AtRest(k) && !is_settled_[k][a]) settled_[k][a] = rest_angle_[rest_of_[k]][a];
      }
    }
  }

  // Angle that goes into the rotation. Where no axis turns, but it is too near to a motion to count
  // as rest, each reading speaks for itself: a mean would look more exact than the noise allows
  // for. What depends on the angle keeps the mean: with a reading's noise in it, it would be found
  // there.
  double TurnedTo(std::size_t k, std::size_t a) const {
    return AllSettled(k) && !AtRest(k) ? nodes_[k].table_deg[a] : settled_[k][a];
  }

  bool AllSettled(std::size_t k) const {
    for (std::size_t a = 0; a < 3; ++a) {
      if (recording_.info.stand_axis_present[a] && !is_settled_[k][a]) return false;
    }
    return true;
  }

  // What a reading's error does to each channel: by each axis as much as the channel feels of it.
  void Shares() {
    const bool stand = recording_.info.reference == ReferenceKind::kStandAngles;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      Vector3& share = trail_.reference_share[k];
      const Matrix3 rates = StandRates(settled_[k]);
      const bool readings = AllSettled(k);
      for (std::size_t c = 0; c < 3; ++c) {
        if (stand) {
          double felt = 0.0;
          for (std::size_t a = 0; a < 3; ++a) {
            if (readings || AtRest(k) || !is_settled_[k][a]) felt += rates[c][a] * rates[c][a];
          }
          if (std::isfinite(felt)) share[c] *= std::max(felt, kLeastFelt);
        }
      }
    }
  }

  // Angles and rates of the table's axes.
  void Tables() {
    for (std::size_t k = 0; k < nodes_.size(); ++k) trail_.nodes[k].table_deg = settled_[k];
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      const TrackPoint& from = trail_.nodes[i];
      TrackPoint& to = trail_.nodes[i + 1];
      for (std::size_t a = 0; a < 3; ++a) {
        const double step = trail_.still[i] ? 0.0 : to.table_deg[a] - from.table_deg[a];
        const double rate = std::isfinite(step) ? step / Length(i) : 0.0;
        to.table_rate_deg_s[a] = rate;
        for (std::size_t h = 0; h < 2; ++h) {
          TrackPoint& half = trail_.halves[2 * i + h];
          half.table_rate_deg_s[a] = rate;
          half.table_deg[a] = from.table_deg[a] + (0.25 + 0.5 * static_cast<double>(h)) * step;
        }
      }
    }
  }

  const Recording& recording_;
  const std::vector<std::string>& covariates_;
  const std::vector<Node>& nodes_;
  const Vector3& units_;
  Trail& trail_;
  std::vector<std::size_t> rest_of_;
  std::vector<Vector3> settled_;  // of each node: angles of the axes
  std::vector<std::array<bool, 3>> is_settled_;
  std::vector<Vector3> rest_angle_;  // of each rest: means over its nodes
  std::vector<Vector3> rest_rotation_;
};

}  // namespace

Trail MakeTrail(const Recording& recording, const Vector3& units_per_deg_s, bool new_power_on,
                const std::vector<std::string>& covariates) {
  Trail trail;
  trail.recording = &recording;
  trail.name = recording.info.source;
  trail.new_power_on = new_power_on;
  TrailMaker(recording, units_per_deg_s, covariates, &trail).Make();
  return trail;
}

Vector3 RoughSensitivity(const Recording& recording) {
  Vector3 out;
  const std::vector<Node>& nodes = recording.columns.nodes;
  const double nominal = NominalUnitsPerDegPerS(recording.info);
  for (std::size_t c = 0; c < 3; ++c) {
    out[c] = recording.info.gyro_present[c] ? nominal : kMissing;
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, path = 0;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
      const double dt = nodes[i + 1].at.t_s - nodes[i].at.t_s;
      const double w = (nodes[i + 1].rotation_deg[c] - nodes[i].rotation_deg[c]) / dt;
      const double xi = (nodes[i + 1].at.z[c] - nodes[i].at.z[c]) / dt;
      if (!std::isfinite(w) || !std::isfinite(xi)) continue;
      n += 1;
      x += w;
      y += xi;
      xx += w * w;
      xy += w * xi;
      path += std::fabs(w) * dt;
    }
    const double spread = xx - x * x / n;
    if (!recording.info.gyro_present[c] || !(path > kLeastTurn_deg) || !(spread > 0)) continue;
    out[c] = (xy - x * y / n) / spread;
  }
  return out;
}

}  // namespace gyrobench::calibration

#include "calibration/trace/trail.h"

#include <algorithm>
#include <cmath>

#include "calibration/trace/trail_parts.h"

namespace gyrobench::calibration {
namespace {

// The error of a mean over a rest does not fall for ever: what is not noise stays.
constexpr double kLeastShare = 0.04;
// What is left of a reading's error, as a variance, where the channel does not feel the axis.
constexpr double kLeastFelt = 1e-4;
// A motion that begins softly is below the noise of single readings for so long.
constexpr double kCreep_s = 0.2;

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
    MarkUnusable(recording_, units_, &trail_);
    settled_ = SettleAxes(recording_);
    RestAngles();
    Rotations();
    Tables();
    Shares();
    for (std::size_t k = 0; k < trail_.nodes.size(); ++k) trail_.nodes[k].still = AtRest(k);
    FillGravity(recording_, rest_of_, &trail_);
    FillRates(recording_, units_, &trail_);
    FillTemperature(recording_, &trail_);
    FillCovariates(recording_, covariates_, &trail_);
    for (std::vector<TrackPoint>* points : {&trail_.nodes, &trail_.halves}) {
      for (TrackPoint& point : *points) point.earth_rate_known = trail_.earth_rate_known;
    }
  }

 private:
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

  Vector3 NodeRotation(std::size_t k) const {
    return AtRest(k) ? rest_rotation_[rest_of_[k]] : nodes_[k].rotation_deg;
  }

  void Rotations() {
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      Vector3 turned = Minus(NodeRotation(i + 1), NodeRotation(i));
      if (recording_.info.reference == ReferenceKind::kStandAngles) {
        const Matrix3 rates = trail_.stand.Rates(settled_.angle_deg[i]);
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
      if (AtRest(k))
        trail_.reference_share[k].fill(std::max(kLeastShare, 1.0 / count[rest_of_[k]]));
      for (std::size_t a = 0; a < 3; ++a) {
        if (AtRest(k) && !settled_.is_settled[k][a])
          settled_.angle_deg[k][a] = rest_angle_[rest_of_[k]][a];
      }
    }
  }

  // Angle that goes into the rotation. Where no axis turns, but it is too near to a motion to count
  // as rest, each reading speaks for itself: a mean would look more exact than the noise allows
  // for. What depends on the angle keeps the mean: with a reading's noise in it, it would be found
  // there.
  double TurnedTo(std::size_t k, std::size_t a) const {
    return AllSettled(k) && !AtRest(k) ? nodes_[k].table_deg[a] : settled_.angle_deg[k][a];
  }

  bool AllSettled(std::size_t k) const {
    for (std::size_t a = 0; a < 3; ++a) {
      if (recording_.info.stand_axis_present[a] && !settled_.is_settled[k][a]) return false;
    }
    return true;
  }

  // The angle that goes into the rotation has an error of its own: it is not the same before or
  // after.
  bool Errs(std::size_t k, std::size_t a) const {
    if (!AtRest(k)) return !settled_.is_settled[k][a];
    const double angle = settled_.angle_deg[k][a];
    return (k > 0 && settled_.angle_deg[k - 1][a] != angle) ||
           (k + 1 < nodes_.size() && settled_.angle_deg[k + 1][a] != angle);
  }

  // What a reading's error does to each channel: by each axis as much as the channel feels of it.
  void Shares() {
    const bool stand = recording_.info.reference == ReferenceKind::kStandAngles;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      Vector3& share = trail_.reference_share[k];
      const Matrix3 rates = trail_.stand.Rates(settled_.angle_deg[k]);
      const bool readings = AllSettled(k);
      for (std::size_t c = 0; c < 3; ++c) {
        if (stand) {
          double felt = 0.0;
          for (std::size_t a = 0; a < 3; ++a) {
            if (Errs(k, a) || (readings && !AtRest(k))) felt += rates[c][a] * rates[c][a];
          }
          if (std::isfinite(felt)) share[c] *= std::max(felt, kLeastFelt);
        }
      }
    }
  }

  // Angles and rates of the table's axes.
  void Tables() {
    for (std::size_t k = 0; k < nodes_.size(); ++k)
      trail_.nodes[k].table_deg = settled_.angle_deg[k];
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
  SettledAngles settled_;
  std::vector<Vector3> rest_angle_;  // of each rest: means over its nodes
  std::vector<Vector3> rest_rotation_;
};

}  // namespace

Trail MakeTrail(const Recording& recording, const Vector3& units_per_deg_s, bool new_power_on,
                const std::vector<std::string>& covariates) {
  Trail trail;
  trail.recording = &recording;
  trail.stand = StandFrame(recording.info.geometry);
  trail.name = recording.info.source;
  trail.new_power_on = new_power_on;
  trail.earth_rate_known =
      recording.orientation_known && recording.info.site_latitude_deg.has_value();
  TrailMaker(recording, units_per_deg_s, covariates, &trail).Make();
  return trail;
}

}  // namespace gyrobench::calibration

#include "calibration/state/state_history.h"

#include <algorithm>
#include <cmath>

#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

// What is left of a reading's error, as a variance, where the channel does not feel the axis.
constexpr double kLeastFelt = 1e-6;

Vector3 Minus(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

class TrailMaker {
 public:
  TrailMaker(const Recording& recording, const Vector3& units,
             const std::vector<std::string>& covariates, StateHistory* history)
      : recording_(recording),
        covariates_(covariates),
        units_(units),
        history_(*history),
        nodes_(history->epochs),
        rest_of_(RestsOfNodes(recording)) {
    SplitRestsAtSteps(recording, &rest_of_);
    for (const std::size_t rest : rest_of_)
      rests_ = rest == kNoRest ? rests_ : std::max(rests_, rest + 1);
  }

  void Make() {
    ChooseEpochs();
    history_.nodes.resize(nodes_.size());
    const std::size_t intervals = nodes_.empty() ? 0 : nodes_.size() - 1;
    history_.midpoints.resize(2 * intervals);
    history_.still.assign(intervals, false);
    history_.usable.assign(intervals, {true, true, true});
    history_.rotation_deg.assign(intervals, Vector3{});
    history_.axis_errs.assign(nodes_.size(), {});
    history_.reference_walk_s.assign(nodes_.size(), 0.0);
    Points();
    MarkUnusable(recording_, units_, &history_);
    const ReadingErrors errors(recording_, nodes_, rest_of_);
    AngleErrors(errors);
    settled_ = SettleAxes(recording_, nodes_, ErrorsAtRest_deg(errors));
    RestAngles(errors);
    Rotations();
    Tables();
    AxisErrors();
    MarkSlowTurns(settled_, &history_);
    FillGravity(recording_, rest_of_, &history_);
    FillRates(recording_, units_, Settled(), &history_);
    FillTemperature(recording_, &history_);
    FillCovariates(recording_, covariates_, &history_);
    for (std::vector<SensorState>* points : {&history_.nodes, &history_.midpoints}) {
      for (SensorState& point : *points) point.earth_rate_known = history_.earth_rate_known;
    }
  }

 private:
  bool AtRest(std::size_t k) const { return rest_of_[k] != kNoRest; }
  double Length(std::size_t i) const { return nodes_[i + 1].at.t_s - nodes_[i].at.t_s; }

  // A moving node is the mean of its readings; one at rest ends with whole samples, so that what
  // two intervals at rest show has no noise in common, however slow the gyro is sampled. Earth's
  // rotation, the table's angles and the world's axes go with them; what is sampled beside the gyro
  // follows in history_columns.cc.
  void ChooseEpochs() {
    history_.epochs = recording_.columns.nodes;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      Node& epoch = history_.epochs[k];
      const Node& before = recording_.columns.nodes[k > 0 ? k - 1 : 0];
      if (MeansReadings(k)) {
        epoch.at = {epoch.mean.t_s, epoch.mean.z};
        epoch.as_means = epoch.mean.as_means;
        epoch.as_means_later = epoch.mean.as_means_later;
        epoch.rotation_deg = epoch.mean.rotation_deg;
        epoch.earth_deg = epoch.mean.earth_deg;
        epoch.table_deg = epoch.mean.table_deg;
        epoch.world_x = epoch.mean.world_x;
        epoch.world_z = epoch.mean.world_z;
      } else {
        epoch.mean.output_known = false;
        if (AtRest(k) && EndsWithSamples(k)) {
          epoch.at = {epoch.samples.t_s, epoch.samples.z};
          epoch.as_means = epoch.as_means_later = {};  // the integral is the sum already
        }
      }
      if (k > 0) ChooseMiddle(before, history_.epochs[k - 1].at.t_s, &epoch);
    }
    DivideBetween();
  }

  // An epoch that comes before its node has a part of what the node's interval has.
  void DivideBetween() {
    const std::vector<Node>& recorded = recording_.columns.nodes;
    const auto up_to = [&](std::size_t k, Vector3 BetweenSamples::*part, std::size_t c) {
      const double all = (recorded[k].between.*part)[c];
      if (k == 0) return all;
      const double begin_s = recorded[k - 1].at.t_s, length_s = recorded[k].at.t_s - begin_s;
      const double share = std::clamp((nodes_[k].at.t_s - begin_s) / length_s, 0.0, 1.0);
      const double before = (recorded[k - 1].between.*part)[c];
      return before + share * (all - before);
    };
    history_.between.assign(nodes_.empty() ? 0 : nodes_.size() - 1, {});
    for (std::size_t i = 0; i < history_.between.size(); ++i) {
      for (const auto part :
           {&BetweenSamples::corners, &BetweenSamples::steps, &BetweenSamples::bends}) {
        for (std::size_t c = 0; c < 3; ++c)
          (history_.between[i].*part)[c] = up_to(i + 1, part, c) - up_to(i, part, c);
      }
    }
  }

  // The sum of the samples ends between the epoch before and the one after: the mean of the first
  // readings of a motion may lie close behind the node.
  bool EndsWithSamples(std::size_t k) const {
    const double end_s = history_.epochs[k].samples.t_s;
    if (!std::isfinite(end_s) || (k > 0 && end_s <= history_.epochs[k - 1].at.t_s)) return false;
    if (k + 1 == nodes_.size()) return true;
    const Node& next = recording_.columns.nodes[k + 1];
    return end_s < (MeansReadings(k + 1) ? next.mean.t_s : next.at.t_s);
  }

  // Its epoch is the mean of its readings.
  bool MeansReadings(std::size_t k) const {
    const ReadingsMean& mean = recording_.columns.nodes[k].mean;
    return !AtRest(k) && mean.readings > 0.0 && IsOfMotion(mean, recording_.columns);
  }

  // The mark of the output's integral that is nearest to the middle of the interval: that half way
  // between the nodes as recorded, or the node before itself, which its mean has gone ahead of.
  static void ChooseMiddle(const Node& before, double begin_s, Node* epoch) {
    const double middle_s = 0.5 * (begin_s + epoch->at.t_s);
    if (std::fabs(before.at.t_s - middle_s) >= std::fabs(epoch->half_s - middle_s)) return;
    epoch->half_s = before.at.t_s;
    epoch->z_half = before.at.z;
  }

  void AngleErrors(const ReadingErrors& errors) {
    double readings = 0.0, moving = 0.0;
    for (const Node& node : nodes_) {
      if (!node.mean.output_known) continue;
      readings += node.mean.readings;
      moving += 1.0;
    }
    const double averaged = moving > 0.0 ? readings / moving : 1.0;
    history_.angle_error_deg = errors.ErrorInMotion_deg(averaged);
    constexpr double kCoarse = 0.2;  // noise is a fifth of a step or less
    history_.rounding_deg = errors.LargestRounding_deg(kCoarse);
    history_.axis_error_deg.fill(history_.angle_error_deg);
    history_.rest_flicker = errors.flicker();
    const std::vector<NodeRange> rests = RangesOfRests(rest_of_);
    for (std::size_t a = 0; a < 3; ++a) {
      const double scatter_deg = ScatterAtRest(nodes_, rests, a);
      if (!std::isfinite(scatter_deg)) continue;
      // Readings that hardly ever change hide noise of half a step.
      const double least_deg = 0.5 * std::fmax(0.0, recording_.reference_step_deg[a]);
      history_.axis_error_deg[a] = std::min(history_.angle_error_deg,
                                            std::max(scatter_deg, least_deg) / std::sqrt(averaged));
    }
  }

  // An axis that rests may be read less often than the one that turns.
  Vector3 ErrorsAtRest_deg(const ReadingErrors& errors) const {
    constexpr std::size_t kFew = 20;  // one node in so many
    Vector3 error_deg;
    error_deg.fill(history_.angle_error_deg);
    for (std::size_t a = 0; a < 3; ++a) {
      std::vector<double> own;
      for (const Node& node : nodes_) {
        if (node.mean.output_known) own.push_back(node.mean.own_readings[a]);
      }
      if (own.empty()) continue;
      const auto few = own.begin() + static_cast<std::ptrdiff_t>(own.size() / kFew);
      std::nth_element(own.begin(), few, own.end());
      error_deg[a] = std::max(error_deg[a], errors.MostInMotion_deg(std::max(*few, 1.0)));
    }
    return error_deg;
  }

  // An integral up to a sample has half of it, and the next interval the other half: with its noise
  // they are alike by a quarter of the time between two samples; several readings share several.
  double SharedSample_s(const ReadingsMean& mean) const {
    const double interval_s = std::fmax(recording_.median_interval_s, 0.0);
    const std::size_t readings = mean.output_known ? std::max<std::size_t>(mean.steps, 1) : 1;
    return 0.25 * interval_s / static_cast<double>(readings);
  }

  // Axes that are read at times of their own may have nodes closer than two samples of the gyro. An
  // interval of length L has the variance N^2 (L - shared), and the covariances with its neighbours
  // are N^2 shared: with more than half of L no covariance matrix.
  void LimitSharedWalk() {
    constexpr double kMost = 0.5;
    std::vector<double>& walk_s = history_.reference_walk_s;
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      const double shared_s = walk_s[i] + walk_s[i + 1];
      if (!(shared_s > kMost * Length(i))) continue;
      const double part = kMost * Length(i) / shared_s;
      walk_s[i] *= part;
      walk_s[i + 1] *= part;
    }
  }

  void Points() {
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      SensorState& point = history_.nodes[k];
      point.t_s = point.since_power_on_s = nodes_[k].at.t_s;
      point.drift_correction_s = recording_.drift_correction.AtTime_s(point.t_s);
      point.still = AtRest(k);
      if (point.still) continue;
      history_.reference_walk_s[k] = SharedSample_s(nodes_[k].mean);
      if (!nodes_[k].mean.output_known) continue;
      history_.reference_walk_s[k] += nodes_[k].mean.walk_s;
      point.readings = nodes_[k].mean.steps;
      point.reading_step_s = nodes_[k].mean.step_s;
    }
    LimitSharedWalk();
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i)
      history_.still[i] = AtRest(i) && rest_of_[i] == rest_of_[i + 1];
    if (!history_.nodes.empty()) {
      history_.nodes.front().restart = history_.new_power_on;
      history_.nodes.front().begins = true;
    }
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      for (std::size_t h = 0; h < 2; ++h) {
        SensorState& point = history_.midpoints[2 * i + h];
        point.t_s = nodes_[i].at.t_s + (0.25 + 0.5 * static_cast<double>(h)) * Length(i);
        point.since_power_on_s = point.t_s;
        point.length_s = 0.5 * Length(i);
        point.still = history_.still[i];
        point.restart = history_.new_power_on && i == 0 && h == 0;
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
        const Matrix3 rates = history_.stand.Rates(settled_.angle_deg[i]);
        // About an axis that stays where it is in the sensor the readings of the axes that rest
        // have no part: their noise would tilt it.
        const bool fixed = OthersRest(i);
        if (fixed) turned = {};
        for (std::size_t a = 0; a < 3; ++a) {
          const double measured = fixed ? 0.0 : MeasuredAngle(i + 1, a) - MeasuredAngle(i, a);
          const double change = TurnedTo(i + 1, a) - TurnedTo(i, a) - measured;
          if (!std::isfinite(change) || change == 0.0) continue;
          for (std::size_t c = 0; c < 3; ++c) turned[c] += rates[c][a] * change;
        }
      }
      for (std::size_t c = 0; c < 3; ++c) {
        history_.rotation_deg[i][c] = (history_.still[i] ? 0.0 : turned[c]) +
                                      nodes_[i + 1].earth_deg[c] - nodes_[i].earth_deg[c];
      }
    }
  }

  // The rotations without what single readings of axes that rest add to them: their noise is in the
  // output too, and what depends on the rate would find it there.
  std::vector<Vector3> Settled() const {
    std::vector<Vector3> rotations = history_.rotation_deg;
    if (recording_.info.reference != ReferenceKind::kStandAngles) return rotations;
    for (std::size_t i = 0; i < rotations.size(); ++i) {
      if (history_.still[i]) continue;
      const Matrix3 rates = history_.stand.Rates(settled_.angle_deg[i]);
      for (std::size_t a = 0; a < 3; ++a) {
        const double noise_deg = (TurnedTo(i + 1, a) - settled_.angle_deg[i + 1][a]) -
                                 (TurnedTo(i, a) - settled_.angle_deg[i][a]);
        if (!std::isfinite(noise_deg) || noise_deg == 0.0) continue;
        for (std::size_t c = 0; c < 3; ++c) rotations[i][c] -= rates[c][a] * noise_deg;
      }
    }
    return rotations;
  }

  // All axes of the stand but one have the same angle at both ends of an interval.
  bool OthersRest(std::size_t i) const {
    std::size_t turning = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      if (!IsRead(a)) continue;
      const bool rests = settled_.is_settled[i][a] && settled_.is_settled[i + 1][a] &&
                         settled_.angle_deg[i][a] == settled_.angle_deg[i + 1][a];
      if (!rests) ++turning;
    }
    return turning <= 1;
  }

  // What the rotation at a node was made of: at rest of the mean over the rest.
  double MeasuredAngle(std::size_t k, std::size_t a) const {
    return AtRest(k) ? rest_angle_[rest_of_[k]][a] : nodes_[k].table_deg[a];
  }

  void RestAngles(const ReadingErrors& errors) {
    rest_angle_.assign(rests_, Vector3{});
    rest_rotation_ = rest_angle_;
    std::vector<double> count(rest_angle_.size(), 0.0);
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      if (!AtRest(k)) continue;
      const ReadingsMean& mean = nodes_[k].mean;
      const bool known = mean.readings > 0.0;
      const double readings = known ? mean.readings : 1.0;
      for (std::size_t a = 0; a < 3; ++a) {
        rest_angle_[rest_of_[k]][a] +=
            readings * (known ? mean.table_deg[a] : nodes_[k].table_deg[a]);
        rest_rotation_[rest_of_[k]][a] +=
            readings * (known ? mean.rotation_deg[a] : nodes_[k].rotation_deg[a]);
      }
      count[rest_of_[k]] += readings;
    }
    for (std::size_t rest = 0; rest < rest_angle_.size(); ++rest) {
      for (double& angle : rest_angle_[rest]) angle /= count[rest];
      for (double& angle : rest_rotation_[rest]) angle /= count[rest];
    }
    history_.reading_share = errors.Shares(nodes_, {rest_of_, count, rest_angle_});
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      for (std::size_t a = 0; a < 3; ++a) {
        if (AtRest(k) && !settled_.is_settled[k][a])
          settled_.angle_deg[k][a] = rest_angle_[rest_of_[k]][a];
      }
    }
  }

  // Angle that goes into the rotation. Where no axis turns, but one is too near to its motion to
  // count as at rest, each of its readings speaks for itself: a mean would look more exact than the
  // noise allows for. What depends on the angle keeps the mean: with a reading's noise in it, it
  // would be found there.
  double TurnedTo(std::size_t k, std::size_t a) const {
    return SpeaksForItself(k, a) ? nodes_[k].table_deg[a] : settled_.angle_deg[k][a];
  }
  bool SpeaksForItself(std::size_t k, std::size_t a) const {
    return settled_.may_creep[k][a] && !AtRest(k);
  }
  bool IsRead(std::size_t a) const { return recording_.info.stand_axis_present[a]; }

  // The angle that goes into the rotation has an error of its own: it is not the same before or
  // after.
  bool Errs(std::size_t k, std::size_t a) const {
    if (!AtRest(k)) return !settled_.is_settled[k][a];
    // A reading of its own may be the same by rounding.
    const auto differs = [&](std::size_t j) {
      const bool own = !AtRest(j) && (SpeaksForItself(j, a) || !settled_.is_settled[j][a]);
      return own || TurnedTo(j, a) != settled_.angle_deg[k][a];
    };
    return (k > 0 && differs(k - 1)) || (k + 1 < nodes_.size() && differs(k + 1));
  }

  void AxisErrors() {
    if (recording_.info.reference != ReferenceKind::kStandAngles) return;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      for (std::size_t a = 0; a < 3; ++a)
        history_.axis_errs[k][a] = IsRead(a) && (SpeaksForItself(k, a) || Errs(k, a));
    }
  }

  // Angles and rates of the table's axes.
  void Tables() {
    for (std::size_t k = 0; k < nodes_.size(); ++k)
      history_.nodes[k].table_deg = settled_.angle_deg[k];
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      const SensorState& from = history_.nodes[i];
      SensorState& to = history_.nodes[i + 1];
      for (std::size_t a = 0; a < 3; ++a) {
        const double step = history_.still[i] ? 0.0 : to.table_deg[a] - from.table_deg[a];
        const double rate = std::isfinite(step) ? step / Length(i) : 0.0;
        to.table_rate_deg_s[a] = rate;
        for (std::size_t h = 0; h < 2; ++h) {
          SensorState& half = history_.midpoints[2 * i + h];
          half.table_rate_deg_s[a] = rate;
          half.table_deg[a] = from.table_deg[a] + (0.25 + 0.5 * static_cast<double>(h)) * step;
        }
      }
    }
    for (std::size_t k = 1; k + 1 < nodes_.size(); ++k) {
      for (std::size_t a = 0; a < 3; ++a) {
        const double rate = 0.5 * (history_.nodes[k].table_rate_deg_s[a] +
                                   history_.nodes[k + 1].table_rate_deg_s[a]);
        history_.nodes[k].reading_step_deg[a] = rate * nodes_[k].mean.step_s;
      }
    }
  }

  const Recording& recording_;
  const std::vector<std::string>& covariates_;
  const Vector3& units_;
  StateHistory& history_;
  const std::vector<Node>& nodes_;  // the history's epochs
  std::vector<std::size_t> rest_of_;
  std::size_t rests_ = 0;
  SettledAngles settled_;
  std::vector<Vector3> rest_angle_;  // of each rest: means over its nodes
  std::vector<Vector3> rest_rotation_;
};

}  // namespace

double StateHistory::ReferenceShare(std::size_t node, const Vector3& m_row) const {
  const MeasurementInfo& info = recording->info;
  const Vector3& share = reading_share[node];
  if (info.reference == ReferenceKind::kSensorAngle)
    return share[static_cast<std::size_t>(info.reference_axis)];
  if (info.reference != ReferenceKind::kStandAngles) return share[0];
  const Matrix3 rates = stand.Rates(nodes[node].table_deg);
  double felt = 0.0, square = 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    double gain = 0.0;
    for (std::size_t c = 0; c < 3; ++c) gain += m_row[c] * rates[c][a];
    if (!axis_errs[node][a]) continue;
    felt += gain * gain;
    square += share[a] * gain * gain;
  }
  const double least = *std::min_element(share.begin(), share.end());
  return std::isfinite(felt) ? std::max(square, least * kLeastFelt) : least;
}

StateHistory MakeStateHistory(const Recording& recording, const Vector3& units_per_deg_s,
                              bool new_power_on, const std::vector<std::string>& covariates) {
  StateHistory history;
  history.recording = &recording;
  history.stand = kinematics::StandFrame(recording.info.geometry);
  history.name = recording.info.source;
  history.new_power_on = new_power_on;
  history.earth_rate_known =
      recording.orientation_known && recording.info.site_latitude_deg.has_value();
  TrailMaker(recording, units_per_deg_s, covariates, &history).Make();
  return history;
}

}  // namespace gyrobench::calibration

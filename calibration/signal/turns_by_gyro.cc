#include "calibration/signal/turns_by_gyro.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/geometry.h"
#include "calibration/signal/line_sums.h"
#include "calibration/signal/output_unit.h"
#include "calibration/signal/reference_track.h"
#include "kinematics/stand_frame.h"

namespace gyrobench::calibration {
namespace {

constexpr double kHalfTurn_deg = 180.0;
// Off whole turns: a third of what would make the next one as near.
constexpr double kNearWholeTurns_deg = 60.0;
// For a sensitivity: what has to be turned by in all, and the share of the output's variance that
// has to follow it.
constexpr double kLeastTurned_deg = 30.0, kLeastFollowed = 0.9;
// Less of the axis in the channels that are there says nothing of it.
constexpr double kLeastFelt = 0.9;

// From one node to the next, about the axis.
struct Step {
  std::size_t node = 0;  // at its end
  double span_s = 0.0;
  double read_deg = 0.0;    // of the axis
  double turned_deg = 0.0;  // of the sensor about the axis, by the reference
  double output = 0.0;      // of the gyro about the axis [output unit * s]
  Vector3 axis = {};        // in the sensor's frame
  bool usable = false;
  bool jumps() const { return std::fabs(read_deg) > kHalfTurn_deg; }
};

// Output about the axis: b + g times the rate.
struct Response {
  double b = 0.0, g = kMissing;
  double Missing_deg(const Step& step) const {
    return (step.output - b * step.span_s) / g - step.turned_deg;
  }
};

class TurnFinder {
 public:
  TurnFinder(const MeasurementInfo& info, std::size_t axis, Columns* columns)
      : info_(info), stand_(info.geometry), axis_(axis), columns_(*columns) {}

  void Find(DefectLog* defects) {
    MakeSteps();
    std::int64_t jumps = 0;
    double first_t_s = kMissing;
    for (const Step& step : steps_) {
      if (!step.jumps()) continue;
      if (jumps++ == 0) first_t_s = columns_.nodes[step.node].at.t_s;
    }
    if (jumps == 0) return;
    if (!TellTurns(Fitted()) && !TellTurns({0.0, NominalUnitsPerDegPerS(info_)})) {
      defects->Add(kTurnsUnknown, "", first_t_s, jumps);
      return;
    }
    AddTurns(defects);
  }

 private:
  Vector3 AxisAt(const Node& before, const Node& now) const {
    Vector3 axis = {};
    if (info_.reference == ReferenceKind::kSensorAngle) {
      axis[axis_] = 1.0;
      return axis;
    }
    Vector3 at = {};
    for (std::size_t a = 0; a < 3; ++a) at[a] = 0.5 * (before.table_deg[a] + now.table_deg[a]);
    const Matrix3 rates = stand_.Rates(at);
    for (std::size_t c = 0; c < 3; ++c) axis[c] = rates[c][axis_];
    return axis;
  }

  void MakeSteps() {
    auto bad = columns_.bad.begin();
    for (std::size_t i = 1; i < columns_.nodes.size(); ++i) {
      const Node &before = columns_.nodes[i - 1], &now = columns_.nodes[i];
      Step step{i, now.at.t_s - before.at.t_s, now.table_deg[axis_] - before.table_deg[axis_]};
      if (!std::isfinite(step.read_deg) || !(step.span_s > 0.0)) continue;
      while (bad != columns_.bad.end() && bad->end_s < before.at.t_s) ++bad;
      if (bad != columns_.bad.end() && bad->begin_s < now.at.t_s) continue;
      step.axis = AxisAt(before, now);
      double felt = 0.0;
      for (std::size_t c = 0; c < 3; ++c) {
        step.turned_deg += step.axis[c] * (now.rotation_deg[c] - before.rotation_deg[c]);
        if (!info_.gyro_present[c]) continue;
        felt += step.axis[c] * step.axis[c];
        step.output += step.axis[c] * (now.at.z[c] - before.at.z[c]);
      }
      step.usable = felt > kLeastFelt;
      steps_.push_back(step);
    }
  }

  // By the steps of less than half a turn; g is NaN where they do not say it.
  Response Fitted() const {
    LineSums line;
    double turned_deg = 0.0;
    for (const Step& step : steps_) {
      if (!step.usable || step.jumps()) continue;
      turned_deg += std::fabs(step.turned_deg);
      line.Add(step.turned_deg / step.span_s, step.output / step.span_s);
    }
    if (!(turned_deg > kLeastTurned_deg) || !(line.Explained() > kLeastFollowed)) return {};
    return {line.Offset(), line.Slope()};
  }

  // False where one of the steps is near no number of whole turns.
  bool TellTurns(const Response& response) {
    turns_.assign(steps_.size(), 0.0);
    if (!std::isfinite(response.g)) return false;
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      const double missing_deg = response.Missing_deg(steps_[i]);
      turns_[i] = std::round(missing_deg / kFullTurn_deg);
      const bool near = std::fabs(missing_deg - kFullTurn_deg * turns_[i]) < kNearWholeTurns_deg;
      if (!steps_[i].usable || !near) return false;
    }
    return true;
  }

  void AddTurns(DefectLog* defects) {
    std::vector<Rest>& rests = columns_.rests;
    auto rest = rests.begin();
    double table_deg = 0.0;
    Vector3 rotation_deg = {};
    std::size_t next = 0;
    for (std::size_t i = 0; i < columns_.nodes.size(); ++i) {
      Node& node = columns_.nodes[i];
      // Those that had begun by their first reading before this one.
      for (; rest != rests.end() && rest->reference_begin_s < node.at.t_s; ++rest)
        AddTo(rotation_deg, &rest->rotation_deg);
      if (next < steps_.size() && steps_[next].node == i) {
        const double more_deg = kFullTurn_deg * turns_[next];
        if (more_deg != 0.0) defects->Add("reference_wrapped", kByTheGyro, node.at.t_s);
        table_deg += more_deg;
        for (std::size_t c = 0; c < 3; ++c) rotation_deg[c] += more_deg * steps_[next].axis[c];
        ++next;
      }
      AddTo(rotation_deg, &node.rotation_deg);
      node.table_deg[axis_] += table_deg;
      if (!(node.mean.readings > 0.0)) continue;
      AddTo(rotation_deg, &node.mean.rotation_deg);
      node.mean.table_deg[axis_] += table_deg;
      node.mean.own_deg[axis_] += table_deg;
    }
    for (; rest != rests.end(); ++rest) AddTo(rotation_deg, &rest->rotation_deg);
  }

  static void AddTo(const Vector3& more, Vector3* sum) {
    for (std::size_t c = 0; c < 3; ++c) (*sum)[c] += more[c];
  }

  const MeasurementInfo& info_;
  kinematics::StandFrame stand_;
  std::size_t axis_;
  Columns& columns_;
  std::vector<Step> steps_;
  std::vector<double> turns_;
};

}  // namespace

void AddTurnsByGyro(const MeasurementInfo& info, const Vector3& read_range_deg, Columns* columns,
                    DefectLog* defects) {
  const bool stand = info.reference == ReferenceKind::kStandAngles;
  if (!stand && info.reference != ReferenceKind::kSensorAngle) return;
  for (std::size_t a = 0; a < 3; ++a) {
    const bool watched =
        stand ? info.stand_axis_present[a] : a == static_cast<std::size_t>(info.reference_axis);
    // Half a turn is the least that can jump by more than half of one.
    const bool one_turn =
        read_range_deg[a] > kHalfTurn_deg && read_range_deg[a] <= kFullTurn_deg + kWrapSlack_deg;
    if (watched && one_turn) TurnFinder(info, a, columns).Find(defects);
  }
}

}  // namespace gyrobench::calibration

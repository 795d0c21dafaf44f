#include "calibration/trace/trail.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "calibration/schedule.h"
#include "calibration/trace/smooth.h"

namespace gyrobench::calibration {
namespace {

constexpr double kTemperatureHalfWindow_s = 5.0;
// The error of a mean over a rest does not fall for ever: what is not noise stays.
constexpr double kLeastShare = 0.04;
constexpr double kLeastTurn_deg = 5.0;
constexpr double kTurning_deg_s = 3.0;
constexpr double kAccelDisagrees_deg = 10.0;

Vector3 Minus(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Vector3 Normalised(const Vector3& v) {
  const double norm = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  return {v[0] / norm, v[1] / norm, v[2] / norm};
}

// Between two directions that are not far apart.
Vector3 Between(const Vector3& a, const Vector3& b, double part) {
  Vector3 out;
  for (std::size_t c = 0; c < 3; ++c) out[c] = (1.0 - part) * a[c] + part * b[c];
  return Normalised(out);
}

// v, given in the frame at angle 0 about axis `axis`, in the frame turned by the angle.
Vector3 TurnedBack(const Vector3& v, std::size_t axis, double angle_deg) {
  const double angle = angle_deg * std::numbers::pi / 180.0;
  const std::size_t i = (axis + 1) % 3, j = (axis + 2) % 3;
  Vector3 out = v;
  out[i] = std::cos(angle) * v[i] + std::sin(angle) * v[j];
  out[j] = -std::sin(angle) * v[i] + std::cos(angle) * v[j];
  return out;
}

bool Finite(const Vector3& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
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
    trail_.reference_share.assign(nodes_.size(), 1.0);
    FindRests();
    MarkBad();
    MarkDeadReference();
    SettleAxes();
    RestAngles();
    Rotations();
    Tables();
    Gravity();
    Rates();
    Temperature();
    Covariates();
    for (std::size_t k = 0; k < trail_.nodes.size(); ++k) trail_.nodes[k].still = AtRest(k);
  }

 private:
  static constexpr std::size_t kShortestSettled = 6;
  static constexpr std::size_t kNoRest = static_cast<std::size_t>(-1);

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
      if (t_s <= rests[rest].reference_begin_s || t_s >= rests[rest].reference_end_s) continue;
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
  // are not used, and what they hold is no effect.
  void MarkDeadReference() {
    std::size_t wrong = 0, rests = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      if (!std::isfinite(units_[c])) continue;
      std::vector<double> rates;
      auto rate = [&](std::size_t i) {
        return (nodes_[i + 1].at.z[c] - nodes_[i].at.z[c]) / units_[c] / Length(i);
      };
      for (std::size_t i = 0; i < trail_.still.size(); ++i) {
        if (trail_.still[i] && trail_.usable[i][c]) rates.push_back(rate(i));
      }
      if (rates.empty()) continue;
      const auto middle = rates.begin() + static_cast<std::ptrdiff_t>(rates.size() / 2);
      std::nth_element(rates.begin(), middle, rates.end());
      const double median = *middle;
      for (std::size_t i = 0; i < trail_.still.size(); ++i) {
        if (!trail_.still[i] || !trail_.usable[i][c]) continue;
        ++rests;
        if (!(std::fabs(rate(i) - median) > kTurning_deg_s)) continue;
        ++wrong;
        trail_.usable[i] = {false, false, false};
      }
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
          const double change = (settled_[i + 1][a] - settled_[i][a]) -
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
      if (AtRest(k)) trail_.reference_share[k] = std::max(kLeastShare, 1.0 / count[rest_of_[k]]);
      for (std::size_t a = 0; a < 3; ++a) {
        if (AtRest(k) && !is_settled_[k][a]) settled_[k][a] = rest_angle_[rest_of_[k]][a];
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

  void Gravity() {
    const ReferenceKind kind = recording_.info.reference;
    if (kind == ReferenceKind::kStandAngles || kind == ReferenceKind::kOrientation) {
      for (std::size_t k = 0; k < nodes_.size(); ++k) {
        trail_.nodes[k].gravity_g = nodes_[k].world_z;
        trail_.nodes[k].world_x = nodes_[k].world_x;
      }
      trail_.gravity_known = !nodes_.empty() && Finite(nodes_.back().world_z);
      if (trail_.gravity_known) CompareWithAccelerometer();
    } else if (kind == ReferenceKind::kSensorAngle) {
      GravityFromAccelerometer(static_cast<std::size_t>(recording_.info.reference_axis));
    } else {
      GravityByPose();
    }
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      const TrackPoint& a = trail_.nodes[i];
      const TrackPoint& b = trail_.nodes[i + 1];
      for (std::size_t h = 0; h < 2; ++h) {
        const double part = 0.25 + 0.5 * static_cast<double>(h);
        trail_.halves[2 * i + h].gravity_g = Between(a.gravity_g, b.gravity_g, part);
        trail_.halves[2 * i + h].world_x = Between(a.world_x, b.world_x, part);
      }
    }
  }

  // One axis turns, the accelerometer turns with it: taken back to angle 0 it must say the same
  // all the time.
  void GravityFromAccelerometer(std::size_t axis) {
    Vector3 sum = {};
    double count = 0.0;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      const Vector3& a = nodes_[k].accel_g;
      if (!Finite(a) || !std::isfinite(nodes_[k].table_deg[axis])) continue;
      const Vector3 back = TurnedBack(a, axis, -nodes_[k].table_deg[axis]);
      for (std::size_t c = 0; c < 3; ++c) sum[c] += back[c];
      count += 1.0;
    }
    if (count < 10.0) return;
    for (double& part : sum) part /= count;
    const double size = std::hypot(sum[0], sum[1], sum[2]);
    if (size < 0.5 || size > 1.5) {
      trail_.remarks.push_back(
          fmt::format("the accelerometer shows {:.2f} g where 1 g is expected: gravity in the "
                      "sensor's frame is not known, its effects are not looked for",
                      size));
      return;
    }
    sum = Normalised(sum);
    for (TrackPoint& point : trail_.nodes)
      point.gravity_g = TurnedBack(sum, axis, point.table_deg[axis]);
    trail_.gravity_known = true;
  }

  void GravityByPose() {
    const std::vector<Rest>& rests = recording_.columns.rests;
    std::vector<Vector3> sum(rests.size(), Vector3{});
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      if (!AtRest(k) || !Finite(nodes_[k].accel_g)) continue;
      for (std::size_t c = 0; c < 3; ++c) sum[rest_of_[k]][c] += nodes_[k].accel_g[c];
    }
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      if (!AtRest(k)) continue;
      const Vector3 direction = Normalised(sum[rest_of_[k]]);
      if (!Finite(direction)) continue;
      trail_.nodes[k].gravity_g = direction;
      trail_.gravity_known = true;
    }
  }

  // Gravity comes from the reference; the accelerometer is its witness.
  void CompareWithAccelerometer() {
    double product = 0.0, count = 0.0;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      const Vector3& a = nodes_[k].accel_g;
      if (!Finite(a) || std::hypot(a[0], a[1], a[2]) < 0.5) continue;
      const Vector3 direction = Normalised(a);
      const Vector3& g = trail_.nodes[k].gravity_g;
      product += direction[0] * g[0] + direction[1] * g[1] + direction[2] * g[2];
      count += 1.0;
    }
    if (count < 10.0) return;
    const double off_deg =
        std::acos(std::clamp(product / count, -1.0, 1.0)) * 180.0 / std::numbers::pi;
    if (off_deg < kAccelDisagrees_deg) return;
    trail_.remarks.push_back(fmt::format(
        "the accelerometer points {:.0f} deg away from the gravity that the reference says: check "
        "how the sensor is mounted; effects of gravity are taken by the reference",
        off_deg));
  }

  void Rates() {
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      const double dt = Length(i);
      for (std::size_t c = 0; c < 3; ++c) {
        const double turned = trail_.rotation_deg[i][c];
        double uneven = 0.0;  // half the difference of the halves, as the gyro saw it
        if (Shapes(i, c)) {
          const double first = nodes_[i + 1].z_half[c] - nodes_[i].at.z[c];
          const double second = nodes_[i + 1].at.z[c] - nodes_[i + 1].z_half[c];
          uneven = 0.5 * (first - second) / units_[c];
        }
        trail_.halves[2 * i].rate_deg_s[c] = (turned + 2.0 * uneven) / dt;
        trail_.halves[2 * i + 1].rate_deg_s[c] = (turned - 2.0 * uneven) / dt;
      }
    }
    for (std::size_t k = 0; k < nodes_.size(); ++k) NodeRates(k);
  }

  bool Shapes(std::size_t i, std::size_t c) const {
    return !trail_.still[i] && trail_.usable[i][c] && std::isfinite(units_[c]);
  }

  // At the node: the gyro's shape within 40 ms, with the mean over both neighbours as the reference
  // has it.
  void NodeRates(std::size_t k) {
    TrackPoint& point = trail_.nodes[k];
    const std::size_t intervals = trail_.still.size();
    const std::size_t first = k > 0 ? k - 1 : k;
    const std::size_t end = std::min(k + 1, intervals);
    for (std::size_t c = 0; c < 3; ++c) {
      double turned = 0.0, seen = 0.0, time_s = 0.0;
      bool shapes = end > first && std::isfinite(units_[c]);
      bool still = true;
      for (std::size_t i = first; i < end; ++i) {
        turned += trail_.rotation_deg[i][c];
        seen += nodes_[i + 1].at.z[c] - nodes_[i].at.z[c];
        time_s += Length(i);
        shapes = shapes && trail_.usable[i][c];
        still = still && trail_.still[i];
      }
      if (time_s <= 0.0) continue;
      const double mean = turned / time_s;
      point.rate_deg_s[c] = point.rate_last_deg_s[c] = mean;
      point.rate_before_deg_s[c] = point.rate_earlier_deg_s[c] = mean;
      if (still || !shapes) continue;
      const std::array<Vector3, 4>& near = nodes_[k].z_near;
      const double offset = mean - seen / units_[c] / time_s;
      auto rate = [&](double change, double dt) { return change / units_[c] / dt + offset; };
      point.rate_deg_s[c] = rate(near[2][c] - near[1][c], kNear_s[2] - kNear_s[1]);
      point.rate_last_deg_s[c] = rate(-near[1][c], -kNear_s[1]);
      point.rate_before_deg_s[c] = rate(near[1][c] - near[0][c], kNear_s[1] - kNear_s[0]);
      const double half_s = 0.5 * Length(first);
      if (k > 0 && half_s > 0.045) {
        point.rate_earlier_deg_s[c] =
            rate(near[0][c] - (nodes_[k].z_half[c] - nodes_[k].at.z[c]), half_s + kNear_s[0]);
      } else {
        point.rate_earlier_deg_s[c] = point.rate_before_deg_s[c];
      }
    }
  }

  void Temperature() {
    std::vector<double> t_s, value;
    std::size_t known = 0;
    for (const Node& node : nodes_) {
      t_s.push_back(node.at.t_s);
      value.push_back(node.temperature_degC);
      known += std::isfinite(node.temperature_degC) ? 1U : 0U;
    }
    if (known < 2 || 10 * known < nodes_.size()) return;
    const Smoothed smooth = SmoothByLines(t_s, value, kTemperatureHalfWindow_s);
    // Without a value near, the last known one.
    double last = kMissing, last_rate = 0.0;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      if (std::isfinite(smooth.value[k])) {
        last = smooth.value[k];
        last_rate = smooth.rate[k];
      }
      trail_.nodes[k].temperature_degC = last;
      trail_.nodes[k].temperature_rate_degC_s = last_rate;
    }
    for (std::size_t k = nodes_.size(); k-- > 0;) {
      if (std::isfinite(trail_.nodes[k].temperature_degC)) continue;
      trail_.nodes[k].temperature_degC = trail_.nodes[k + 1].temperature_degC;
    }
    for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
      for (std::size_t h = 0; h < 2; ++h) {
        const double part = 0.25 + 0.5 * static_cast<double>(h);
        TrackPoint& half = trail_.halves[2 * i + h];
        const TrackPoint& a = trail_.nodes[i];
        const TrackPoint& b = trail_.nodes[i + 1];
        half.temperature_degC =
            a.temperature_degC + part * (b.temperature_degC - a.temperature_degC);
        half.temperature_rate_degC_s =
            a.temperature_rate_degC_s +
            part * (b.temperature_rate_degC_s - a.temperature_rate_degC_s);
      }
    }
    trail_.temperature_known = true;
  }

  void Covariates() {
    trail_.vibration_known = true;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      trail_.nodes[k].vibration_g2 = nodes_[k].vibration_g2;
      if (k == 0) continue;
      if (!std::isfinite(nodes_[k].vibration_g2)) trail_.vibration_known = false;
      for (std::size_t h = 0; h < 2; ++h)
        trail_.halves[2 * (k - 1) + h].vibration_g2 = nodes_[k].vibration_g2;
    }
    const std::size_t count = covariates_.size();
    if (count == 0) return;
    // The mean up to a node is that of its interval: both halves have it.
    trail_.covariates.resize(nodes_.size() * count);
    const std::vector<std::string>& names = recording_.info.covariates;
    for (std::size_t j = 0; j < count; ++j) {
      const auto from = static_cast<std::size_t>(
          std::find(names.begin(), names.end(), covariates_[j]) - names.begin());
      for (std::size_t k = 0; k < nodes_.size(); ++k) {
        trail_.covariates[k * count + j] = recording_.columns.covariates[k * names.size() + from];
      }
    }
    std::vector<double> last(count, kMissing);
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      for (std::size_t j = 0; j < count; ++j) {
        double& value = trail_.covariates[k * count + j];
        if (std::isfinite(value)) last[j] = value;
        value = last[j];
      }
    }
    for (std::size_t k = nodes_.size(); k-- > 0;) {
      for (std::size_t j = 0; j < count; ++j) {
        double& value = trail_.covariates[k * count + j];
        if (!std::isfinite(value) && k + 1 < nodes_.size())
          value = trail_.covariates[(k + 1) * count + j];
      }
    }
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      const double* values = trail_.covariates.data() + k * count;
      trail_.nodes[k].covariates = values;
      if (k == 0) continue;
      trail_.halves[2 * k - 2].covariates = trail_.halves[2 * k - 1].covariates = values;
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

#include "calibration/plan/foresee.h"

#include <algorithm>
#include <cmath>

#include "kinematics/stand_frame.h"

namespace gyrobench::calibration {
namespace {

constexpr double kGyroStep_s = 0.02;
constexpr int kSamplesPerReading = 5;
constexpr double kDrift_s = 250.0, kFan_s = 120.0;
constexpr double kDriftSeenOver_s = 60.0;
// A sensor that gives the same value again and again is taken for frozen.
constexpr double kDither_deg_s = 1e-4, kDither_g = 1e-4;

class Temperature {
 public:
  Temperature(const Recording& so_far, double warms_degC) : warms_degC_(warms_degC) {
    const std::vector<Node>& nodes = so_far.columns.nodes;
    double last_s = 0.0, first_s = 0.0, first_degC = kMissing;
    for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) {
      if (!std::isfinite(node->temperature_degC)) continue;
      if (!std::isfinite(now_degC_)) {
        now_degC_ = node->temperature_degC;
        last_s = node->at.t_s;
      }
      first_s = node->at.t_s;
      first_degC = node->temperature_degC;
      if (last_s - first_s >= kDriftSeenOver_s) break;
    }
    if (last_s - first_s >= 0.5 * kDriftSeenOver_s)
      drift_degC_ = (now_degC_ - first_degC) / (last_s - first_s) * kDrift_s;
  }
  double At(double t_s) const {
    return now_degC_ + drift_degC_ * (1.0 - std::exp(-t_s / kDrift_s)) +
           warms_degC_ * (1.0 - std::exp(-t_s / kFan_s));
  }

 private:
  double now_degC_ = kMissing, drift_degC_ = 0.0, warms_degC_ = 0.0;
};

class Motion {
 public:
  explicit Motion(const Manoeuvre& manoeuvre)
      : moves_(manoeuvre.moves), angles_deg_(manoeuvre.begin_deg) {}

  // Asked in the order of time.
  Vector3 At(double t_s) {
    for (std::size_t k = next_; k < moves_.size() && moves_[k].begin_s <= t_s; ++k) {
      const ForeseenMove& move = moves_[k];
      const double angle_deg = AngleOf(move, t_s - move.begin_s);
      angles_deg_[static_cast<std::size_t>(move.axis)] = angle_deg;
      if (k == next_ && angle_deg == move.to_deg) ++next_;
    }
    return angles_deg_;
  }

 private:
  const std::vector<ForeseenMove>& moves_;
  Vector3 angles_deg_;
  std::size_t next_ = 0;
};

// Mean rate of the sensor between two poses of the stand [deg/s], frame S.
Vector3 MeanRate(const kinematics::StandFrame& stand, const Vector3& from_deg,
                 const Vector3& to_deg, double step_s) {
  Vector3 middle_deg = {}, rate = {};
  for (std::size_t a = 0; a < 3; ++a) middle_deg[a] = 0.5 * (from_deg[a] + to_deg[a]);
  const Matrix3 rates = stand.Rates(middle_deg);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t a = 0; a < 3; ++a) rate[c] += rates[c][a] * (to_deg[a] - from_deg[a]) / step_s;
  }
  return rate;
}

}  // namespace

double AngleOf(const ForeseenMove& move, double t_s) {
  const double way_deg = std::fabs(move.to_deg - move.from_deg);
  const double a = move.acceleration_deg_s2;
  const double rate = std::min(move.rate_deg_s, std::sqrt(way_deg * a));
  if (!(rate > 0.0)) return move.to_deg;
  const double ramp_s = rate / a, duration_s = way_deg / rate + ramp_s;
  if (t_s >= duration_s) return move.to_deg;
  if (t_s <= 0.0) return move.from_deg;
  const double left_s = duration_s - t_s;
  const double gone_deg = t_s < ramp_s      ? 0.5 * a * t_s * t_s
                          : left_s < ramp_s ? way_deg - 0.5 * a * left_s * left_s
                                            : rate * (t_s - 0.5 * ramp_s);
  return move.from_deg + std::copysign(gone_deg, move.to_deg - move.from_deg);
}

Recording Foresee(const Manoeuvre& manoeuvre, const Recording& so_far,
                  const Vector3& units_per_deg_s) {
  Collector collector;
  MeasurementInfo info = so_far.info;
  info.source = manoeuvre.name;
  info.covariates.clear();
  collector.OnInfo(info);
  const Temperature temperature(so_far, manoeuvre.warms_degC);
  Motion motion(manoeuvre);
  const kinematics::StandFrame stand(info.geometry);
  const double begin_s = so_far.last_time_s + kGyroStep_s;
  const auto samples = static_cast<std::int64_t>(manoeuvre.duration_s / kGyroStep_s);
  Vector3 last_deg = manoeuvre.begin_deg;
  for (std::int64_t k = 0; k <= samples; ++k) {
    const double t_s = static_cast<double>(k) * kGyroStep_s;
    const Vector3 angles_deg = motion.At(t_s);
    if (k % kSamplesPerReading == 0) {
      for (const int axis : {0, 1, 2}) {
        const auto a = static_cast<std::size_t>(axis);
        if (info.stand_axis_present[a]) collector.OnAngle({begin_s + t_s, axis, angles_deg[a]});
      }
    }
    // The rate at the sample itself.
    const Vector3 next_deg = Motion(motion).At(t_s + 0.5 * kGyroStep_s);
    const Vector3 rate =
        MeanRate(stand, last_deg, next_deg, k == 0 ? 0.5 * kGyroStep_s : kGyroStep_s);
    last_deg = next_deg;
    GyroSample sample;
    sample.t_s = begin_s + t_s;
    sample.temperature_degC = info.temperature_present ? temperature.At(t_s) : kMissing;
    const Vector3 up = kinematics::TransposedTimes(stand.Orientation(angles_deg), {0.0, 0.0, 1.0});
    const double dither = std::sin(2.4 * static_cast<double>(k));
    for (std::size_t c = 0; c < 3; ++c) {
      if (info.gyro_present[c])
        sample.xi[c] = units_per_deg_s[c] * (rate[c] + kDither_deg_s * dither);
      if (info.accel_present[c]) sample.accel_g[c] = up[c] + kDither_g * dither;
    }
    collector.OnGyro(sample);
  }
  return collector.Take();
}

}  // namespace gyrobench::calibration

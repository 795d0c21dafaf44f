#include "tests/calibration/synthetic_bench.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <span>

namespace gyrobench::testing {
namespace {

constexpr double kPi = std::numbers::pi, kRad = kPi / 180.0;
constexpr double kGyro_hz = 100.0, kReference_hz = 50.0;
constexpr double kAccelerometer_g = 0.001;
// Whole periods in the time between two nodes, on the grid of the samples.
constexpr double kVibration_hz = 20.0;

// The way of a ramp from rest to `rate`, t into it.
double RampWay(double rate, double t_s, double ramp_s) {
  return 0.5 * rate * (t_s - ramp_s / kPi * std::sin(kPi * t_s / ramp_s));
}
double RampRate(double rate, double t_s, double ramp_s) {
  return 0.5 * rate * (1.0 - std::cos(kPi * t_s / ramp_s));
}

struct Warmth {
  double degC = 0.0, rate_degC_s = 0.0;
};
// Warms up, is cooled by a fan from 110 s to 200 s, and warms up again: three first-order ways.
Warmth WarmthAt(double t_s) {
  struct Way {
    double begin_s, target_degC, tau_s;
  };
  constexpr std::array<Way, 3> kWays = {
      {{0.0, 34.0, 120.0}, {110.0, 22.0, 100.0}, {200.0, 35.0, 110.0}}};
  double from_degC = 22.0;
  Warmth out;
  for (std::size_t i = 0; i < kWays.size() && t_s >= kWays[i].begin_s; ++i) {
    const Way& way = kWays[i];
    const double end_s = i + 1 < kWays.size() ? std::min(t_s, kWays[i + 1].begin_s) : t_s;
    const double left_degC =
        (way.target_degC - from_degC) * std::exp(-(end_s - way.begin_s) / way.tau_s);
    out = {way.target_degC - left_degC, left_degC / way.tau_s};
    from_degC = out.degC;
  }
  return out;
}
Warmth SwingingWarmth(double t_s, double period_s) {
  const double w = 2.0 * kPi / period_s;
  return {27.0 + 5.0 * std::sin(w * t_s - 1.2), 5.0 * w * std::cos(w * t_s - 1.2)};
}
double Bias(double temperature_degC) {
  const double x = temperature_degC - 27.0;
  return 0.3 + 0.02 * x - 0.001 * x * x;
}
// Shaken for 7 s out of each 23, at rest and in motion.
double Vibration(double t_s) { return std::fmod(t_s, 23.0) < 7.0 ? 0.1 : 0.0; }
double Supply(double t_s) {
  return 5.0 + 0.10 * std::sin(2.0 * kPi * t_s / 37.0) + 0.05 * std::sin(2.0 * kPi * t_s / 11.3);
}

MeasurementInfo InfoOf(bool with_supply) {
  MeasurementInfo info;
  info.source = "synthetic";
  info.power_on = "1";
  info.gyro_unit = RateUnit::kDegPerSecond;
  info.gyro_units_per_deg_s = 1.0;
  info.gyro_present = {false, false, true};
  info.accel_present = {true, true, true};
  info.temperature_present = true;
  info.reference = ReferenceKind::kStandAngles;
  info.stand_axis_present = {true, true, true};
  info.gear_ratio = 40.0;
  if (with_supply) info.covariates = {"supply_v"};
  return info;
}

}  // namespace

void Motion::Add(Piece piece, double way_deg) {
  piece.begin_s = end_s_;
  piece.from_deg = angle_deg_;
  end_s_ += piece.duration_s;
  angle_deg_[piece.axis] += way_deg;
  pieces_.push_back(piece);
}

Motion& Motion::Rest(double duration_s) {
  Add({.duration_s = duration_s}, 0.0);
  return *this;
}

Motion& Motion::Turn(TableAxis axis, double angle_deg, double rate_deg_s) {
  Add({.duration_s = std::fabs(angle_deg) / rate_deg_s + ramp_s_,
       .kind = Kind::kTurn,
       .axis = axis,
       .rate_deg_s = std::copysign(rate_deg_s, angle_deg)},
      angle_deg);
  return Rest(kPause_s);
}

Motion& Motion::ThereAndBack(TableAxis axis, double angle_deg, double rate_deg_s) {
  return Turn(axis, angle_deg, rate_deg_s).Turn(axis, -angle_deg, rate_deg_s);
}

Motion& Motion::Swing(TableAxis axis, double amplitude_deg, double frequency_hz, int periods) {
  Add({.duration_s = periods / frequency_hz,
       .kind = Kind::kSwing,
       .axis = axis,
       .amplitude_deg = amplitude_deg,
       .frequency_hz = frequency_hz},
      0.0);
  return Rest(kPause_s);
}

TablePose Motion::At(double t_s) const {
  const double within_s = std::clamp(t_s, 0.0, end_s_);
  auto after = std::upper_bound(pieces_.begin() + 1, pieces_.end(), within_s,
                                [](double t, const Piece& piece) { return t < piece.begin_s; });
  const Piece& piece = *(after - 1);
  const double since_s = within_s - piece.begin_s;
  TablePose pose{piece.from_deg, {}};
  double& angle = pose.angle_deg[piece.axis];
  double& rate = pose.rate_deg_s[piece.axis];
  if (piece.kind == Kind::kSwing) {
    const double phase = 2.0 * kPi * piece.frequency_hz * since_s;
    angle += 0.5 * piece.amplitude_deg * (1.0 - std::cos(phase));
    rate = kPi * piece.frequency_hz * piece.amplitude_deg * std::sin(phase);
  } else if (piece.kind == Kind::kTurn) {
    const double left_s = piece.duration_s - since_s;
    const double w = piece.rate_deg_s;
    if (since_s < ramp_s_) {
      angle += RampWay(w, since_s, ramp_s_);
      rate = RampRate(w, since_s, ramp_s_);
    } else if (left_s < ramp_s_) {
      angle += w * (piece.duration_s - ramp_s_) - RampWay(w, left_s, ramp_s_);
      rate = RampRate(w, left_s, ramp_s_);
    } else {
      angle += w * (since_s - 0.5 * ramp_s_);
      rate = w;
    }
  }
  return pose;
}

Motion ManySpeeds() {
  Motion motion;
  motion.Rest(8.0);
  const std::array<std::array<double, 2>, 8> legs = {
      {{32, 200}, {5, 31}, {18, 108}, {2.5, 17}, {40, 370}, {12, 75}, {25, 140}, {8, 47}}};
  for (const auto& [rate, angle] : legs) motion.ThereAndBack(kInnerAxis, angle, rate);
  return motion;
}

Motion EveryMotion() {
  Motion motion = ManySpeeds();
  for (const double pose_deg : {90.0, 180.0}) {
    motion.Turn(kMiddleAxis, 90.0, 40.0).Rest(4.0);
    for (const double rate : {40.0, 15.0, 26.0})
      motion.ThereAndBack(kInnerAxis, pose_deg == 90.0 ? 8.0 * rate : -5.0 * rate, rate);
    if (pose_deg != 90.0) continue;
    for (int heading = 0; heading < 4; ++heading) motion.Turn(kOuterAxis, 90.0, 40.0).Rest(6.0);
  }
  motion.Turn(kMiddleAxis, -180.0, 40.0).Swing(kInnerAxis, 6.0, 0.5, 4);
  return motion.Swing(kInnerAxis, 5.0, 1.0, 6).Rest(6.0);
}

BenchState SyntheticBench::At(double t_s) const {
  BenchState state;
  state.t_s = t_s;
  state.table = motion_.At(t_s);
  const auto& [o, m, i] = state.table.angle_deg;
  const auto& [wo, wm, wi] = state.table.rate_deg_s;
  const double sm = std::sin(m * kRad), cm = std::cos(m * kRad);
  const double si = std::sin(i * kRad), ci = std::cos(i * kRad);
  state.g = {sm * si, sm * ci, cm};
  state.rate_deg_s = {wo * sm * si + wm * ci, wo * sm * ci - wm * si, wo * cm + wi};
  state.z_axis_in_world = {std::sin(o * kRad) * sm, -std::cos(o * kRad) * sm, cm};
  const double period_s = sensor_.temperature_period_s;
  const Warmth warmth =
      period_s > 0.0 ? SwingingWarmth(t_s, period_s) : WarmthAt(std::max(t_s, 0.0));
  state.temperature_degC = warmth.degC;
  state.temperature_rate_degC_s = warmth.rate_degC_s;
  state.vibration_g = Vibration(t_s);
  state.supply_v = Supply(t_s);
  return state;
}

double SyntheticBench::Read(double angle_deg, std::size_t axis) const {
  if (!(sensor_.step_deg > 0.0)) return angle_deg;
  const double zero = sensor_.zero_steps[axis];
  return sensor_.step_deg * (std::round(angle_deg / sensor_.step_deg + zero) - zero);
}

calibration::Recording SyntheticBench::Measure(const Injection& injection, std::uint64_t seed,
                                               bool with_supply, double reference_drift_ppm) const {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  calibration::EvenRows clocks;
  clocks.reference_drift_ppm = reference_drift_ppm;
  calibration::Collector collector(calibration::Collector::kNode_s, clocks);
  MeasurementInfo info = InfoOf(with_supply);
  if (sensor_.three_channels) info.gyro_present = {true, true, true};
  collector.OnInfo(info);
  const double white_deg_s = sensor_.angle_random_walk_deg_sqrt_s * std::sqrt(kGyro_hz);
  std::int64_t readings = 0;
  for (std::int64_t n = 0; static_cast<double>(n) / kGyro_hz <= motion_.duration_s(); ++n) {
    const BenchState state = At(static_cast<double>(n) / kGyro_hz);
    if (with_supply) collector.OnCovariates(state.t_s, std::span(&state.supply_v, 1));
    GyroSample sample;
    sample.t_s = state.t_s;
    double output = Bias(state.temperature_degC) + white_deg_s * normal(random);
    for (std::size_t c = 0; c < 3; ++c) output += sensor_.m_row[c] * state.rate_deg_s[c];
    if (injection.rate_deg_s) output += injection.rate_deg_s(state);
    sample.xi[2] = output;
    for (std::size_t c = 0; c < 2 && sensor_.three_channels; ++c)
      sample.xi[c] = kOtherScale * state.rate_deg_s[c] + white_deg_s * normal(random);
    sample.temperature_degC = state.temperature_degC + sensor_.thermometer_degC * normal(random);
    for (std::size_t c = 0; c < 3; ++c)
      sample.accel_g[c] = state.g[c] + kAccelerometer_g * normal(random);
    sample.accel_g[2] += state.vibration_g * std::sin(2.0 * kPi * kVibration_hz * state.t_s);
    collector.OnGyro(sample);
    for (; static_cast<double>(readings) / kReference_hz <= state.t_s; ++readings) {
      const double t_s = static_cast<double>(readings) / kReference_hz;
      const BenchState shown = At(injection.shown_s ? injection.shown_s(t_s) : t_s);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool rests = shown.table.rate_deg_s[axis] == 0.0;
        if (rests && readings % sensor_.reads_resting_axes != 0) continue;
        double angle_deg = shown.table.angle_deg[axis] + sensor_.reading_deg * normal(random);
        if (axis == injection.axis && injection.angle_deg) angle_deg -= injection.angle_deg(shown);
        collector.OnAngle({t_s, static_cast<int>(axis), Read(angle_deg, axis)});
      }
    }
  }
  return collector.Take();
}

}  // namespace gyrobench::testing

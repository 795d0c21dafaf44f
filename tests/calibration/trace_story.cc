#include "tests/calibration/trace_story.h"

#include <cmath>
#include <numbers>

namespace gyrobench::testing {
namespace {

constexpr double kTurn_s = 3.0, kRest_s = 3.0, kTurn_deg = 90.0;

// Half a period is a rest and a turn; every other turn goes back. A turn is a raised cosine.
struct Phase {
  double in_turn_s;
  bool back;
};
Phase PhaseAt(double t_s) {
  const double half = std::floor(t_s / (kTurn_s + kRest_s));
  const double in_half_s = t_s - half * (kTurn_s + kRest_s);
  return {std::max(0.0, in_half_s - kRest_s), std::fmod(half, 2.0) != 0.0};
}

double TurnRate(double t_s) {
  const Phase phase = PhaseAt(t_s);
  const double rate =
      kTurn_deg / kTurn_s * (1.0 - std::cos(2.0 * std::numbers::pi * phase.in_turn_s / kTurn_s));
  return phase.back ? -rate : rate;
}

double TurnAngle(double t_s) {
  const Phase phase = PhaseAt(t_s);
  const double part = phase.in_turn_s / kTurn_s;
  const double angle =
      kTurn_deg * (part - std::sin(2.0 * std::numbers::pi * part) / (2.0 * std::numbers::pi));
  return phase.back ? kTurn_deg - angle : angle;
}

GyroSample SampleAt(const Story& story, double t_s, std::mt19937_64& random) {
  constexpr double kBias_deg_s[3] = {0.3, -0.2, 0.15};
  std::normal_distribution<double> normal;
  const double temperature = story.temperature_degC(t_s);
  const double units = story.info.gyro_unit == RateUnit::kRadPerSecond ? std::numbers::pi / 180.0
                       : story.info.gyro_unit == RateUnit::kLsb        ? 131.0
                                                                       : 1.0;
  GyroSample sample;
  sample.t_s = t_s;
  for (std::size_t c = 0; c < 3; ++c) {
    const double drift =
        std::isfinite(temperature) ? story.drift_deg_s_per_degC * (temperature - 25.0) : 0.0;
    const double output = story.scale[c] * story.rate_deg_s(t_s) + kBias_deg_s[c] + drift +
                          story.white_deg_s * normal(random);
    if (story.info.gyro_present[c]) sample.xi[c] = output * units;
  }
  sample.accel_g = {0.002 * normal(random), 0.002 * normal(random), 1.0 + 0.002 * normal(random)};
  if (story.info.temperature_present) sample.temperature_degC = temperature;
  return sample;
}

void TellReference(const Story& story, double t_s, std::mt19937_64& random, MeasurementSink& sink) {
  std::normal_distribution<double> noise(0.0, story.reading_deg);
  const double angle_deg = story.angle_deg(t_s) + noise(random);
  const double half_rad = 0.5 * angle_deg * std::numbers::pi / 180.0;
  AngleSample sample{t_s, 2, angle_deg};
  if (story.info.reference == ReferenceKind::kSensorAngle)
    sample.axis = static_cast<int>(story.info.reference_axis);
  switch (story.info.reference) {
    case ReferenceKind::kNone:
      return;
    case ReferenceKind::kOrientation:
      return sink.OnOrientation({t_s, {std::cos(half_rad), 0.0, 0.0, std::sin(half_rad)}});
    case ReferenceKind::kStandAngles:
    case ReferenceKind::kSensorAngle:
      if (!story.spoil_angle || story.spoil_angle(&sample)) sink.OnAngle(sample);
  }
}

}  // namespace

Story::Story()
    : rate_deg_s(TurnRate),
      angle_deg(TurnAngle),
      temperature_degC([](double t_s) { return 24.0 + 6.0 * (1.0 - std::exp(-t_s / 90.0)); }) {
  info.source = "story.csv";
  info.gyro_present = info.accel_present = {true, true, true};
  info.temperature_present = true;
  info.gyro_units_per_deg_s = 131.0;
  info.reference = ReferenceKind::kStandAngles;
  info.stand_axis_present = {false, false, true};
  info.gear_ratio = 40.0;
}

void Story::Follow(const Motion& motion) {
  duration_s = motion.duration_s();
  rate_deg_s = [motion](double t_s) { return motion.At(t_s).rate_deg_s[kInnerAxis]; };
  angle_deg = [motion](double t_s) { return motion.At(t_s).angle_deg[kInnerAxis]; };
}

void Story::UseTurningChannelAlone() {
  info.gyro_present = {false, false, true};
  info.accel_present = {};
}

void Story::UseSensorAngle(SensorAxis axis) {
  info.reference = ReferenceKind::kSensorAngle;
  info.reference_axis = axis;
}

void Story::UseOrientation() { info.reference = ReferenceKind::kOrientation; }

void Story::Tell(MeasurementSink& sink) const {
  std::mt19937_64 random(seed);
  sink.OnInfo(info);
  std::vector<double> values(covariates.size());
  std::int64_t readings = 0;
  const auto samples = static_cast<std::int64_t>(duration_s * gyro_hz);
  for (std::int64_t i = 0; i < samples; ++i) {
    const double t_s = static_cast<double>(i) / gyro_hz;
    for (; static_cast<double>(readings) / reference_hz <= t_s; ++readings) {
      TellReference(*this, static_cast<double>(readings) / reference_hz, random, sink);
    }
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = covariates[k](t_s);
    GyroSample sample = SampleAt(*this, t_s, random);
    if (spoil_gyro && !spoil_gyro(&sample)) continue;
    if (!values.empty()) sink.OnCovariates(sample.t_s, values);
    sink.OnGyro(sample);
  }
}

calibration::Recording Story::Collect() const {
  calibration::Collector collector;
  Tell(collector);
  return collector.Take();
}

}  // namespace gyrobench::testing

// Turns whose rate grows and falls softly, an even jerk at both ends of each ramp: the gyro's noise
// hides where they begin and end.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "calibration/estimators/analyzer.h"

namespace gyrobench::calibration {
namespace {

struct SoftTurns {
  double ramp_s = 0.5, rate_deg_s = 9.0, angle_deg = 9.0, rest_s = 1.2;
  int turns = 80;  // half of them there, half back
};

// Of a ramp from 0 to 1 within the time 1: u^3 - u^4 / 2 is what 3 u^2 - 2 u^3 turns.
double RampAngle(double u) { return u * u * u * (1.0 - 0.5 * u); }

double Turned(const SoftTurns& motion, double since_s) {
  const double level_s = motion.angle_deg / motion.rate_deg_s - motion.ramp_s;
  const auto part = [](double t_s, double length_s) {
    return std::clamp(t_s / length_s, 0.0, 1.0);
  };
  const double up = part(since_s, motion.ramp_s);
  const double level = std::clamp(since_s - motion.ramp_s, 0.0, level_s);
  const double down = part(since_s - motion.ramp_s - level_s, motion.ramp_s);
  return motion.rate_deg_s *
         (motion.ramp_s * (RampAngle(up) + 0.5 - RampAngle(1.0 - down)) + level);
}

double TableAngle(const SoftTurns& motion, double t_s) {
  const double cycle_s = motion.angle_deg / motion.rate_deg_s + motion.ramp_s + motion.rest_s;
  const double begun = std::floor((t_s - 5.0) / cycle_s);
  if (begun < 0.0) return 0.0;
  const int turn = std::min(static_cast<int>(begun), motion.turns - 1);
  const int half = motion.turns / 2;
  const double stands_deg = motion.angle_deg * (turn < half ? turn : motion.turns - turn);
  const double turned_deg = Turned(motion, t_s - 5.0 - turn * cycle_s);
  return stands_deg + (turn < half ? turned_deg : -turned_deg);
}

constexpr double kScale = 1.001;

// Errors of the scale factor over its standard error.
double ErrorOf(const SoftTurns& motion, std::uint64_t seed) {
  constexpr double kStep_s = 0.01, kLsbPerDegS = 131.0, kWalk_deg_sqrt_s = 0.0035;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  MeasurementInfo info;
  info.gyro_present = {false, false, true};
  info.gyro_units_per_deg_s = kLsbPerDegS;
  info.reference = ReferenceKind::kStandAngles;
  info.stand_axis_present = {false, false, true};
  Analyzer analyzer;
  analyzer.OnInfo(info);
  const double end_s =
      10.0 + motion.turns * (motion.angle_deg / motion.rate_deg_s + motion.ramp_s + motion.rest_s);
  for (int i = 0; i * kStep_s < end_s; ++i) {
    GyroSample sample;
    sample.t_s = i * kStep_s;
    const double rate =
        (TableAngle(motion, sample.t_s + 1e-4) - TableAngle(motion, sample.t_s - 1e-4)) / 2e-4;
    const double noise = kWalk_deg_sqrt_s / std::sqrt(kStep_s) * normal(random);
    sample.xi[2] = std::round(kLsbPerDegS * (kScale * rate + noise) - 170.0);
    analyzer.OnGyro(sample);
    if (i % 10 != 3) continue;
    const double read_deg = TableAngle(motion, sample.t_s) + 0.0012 * normal(random);
    analyzer.OnAngle({sample.t_s, 2, read_deg});
  }
  const AnalysisResult result = analyzer.Result();
  EXPECT_EQ(result.scale.size(), 1u);
  if (result.scale.empty()) return kMissing;
  const ScaleResult& scale = result.scale[0];
  return (scale.alpha * kScale * kLsbPerDegS - 1.0) / (scale.alpha_std_error * kLsbPerDegS);
}

struct Errors {
  double mean = 0.0, square = 0.0;
};

Errors ErrorsOf(const SoftTurns& motion) {
  constexpr int kSeeds = 24;
  Errors out;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const double error = ErrorOf(motion, static_cast<std::uint64_t>(seed));
    out.mean += error / kSeeds;
    out.square += error * error / kSeeds;
  }
  return out;
}

// Of 24 seeds the mean is beyond 3.5 / 24^(1/2) = 0.71 for 5 of 10000 choices, and the mean square
// below 0.36 or above 2.1 for one of 1000 each.
TEST(SoftRamps, LeaveNothingOfATurnToItsRests) {
  for (const double ramp_s : {0.3, 0.5, 0.9}) {
    SCOPED_TRACE(ramp_s);
    const Errors errors = ErrorsOf({.ramp_s = ramp_s});
    EXPECT_LT(std::fabs(errors.mean), 0.71);
    EXPECT_GT(errors.square, 0.36);
    EXPECT_LT(errors.square, 2.1);
  }
}

TEST(SoftRamps, OfTwoSecondsNeedAsMuchOfALongerRest) {
  const Errors errors =
      ErrorsOf({.ramp_s = 2.0, .rate_deg_s = 18.0, .angle_deg = 54.0, .rest_s = 4.0, .turns = 30});
  EXPECT_LT(std::fabs(errors.mean), 0.71);
  EXPECT_LT(errors.square, 2.1);
}

}  // namespace
}  // namespace gyrobench::calibration

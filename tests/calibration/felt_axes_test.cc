// An axis of the stand that is read wrong turns the direction from which the motions of the axes
// outside of it come.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "calibration/state/state_history.h"
#include "calibration/trace/problem.h"
#include "kinematics/stand_frame.h"
#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;
using calibration::FeltAxis;
using calibration::Recording;
using calibration::StateHistory;
using calibration::TracedEffect;
using kinematics::StandFrame;

// One interval of a second, in which the axes turn at such rates about such angles.
StateHistory OneInterval(const Recording& recording, const StandFrame& stand,
                         const Vector3& angles_deg, const Vector3& rates_deg_s) {
  StateHistory history;
  history.recording = &recording;
  history.stand = stand;
  history.nodes.resize(2);
  history.nodes[1].t_s = 1.0;
  history.midpoints.resize(2);
  for (auto& half : history.midpoints) {
    half.table_deg = angles_deg;
    half.table_rate_deg_s = rates_deg_s;
  }
  history.still = {false};
  const auto directions = stand.Rates(angles_deg);
  history.rotation_deg.resize(1);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t a = 0; a < 3; ++a)
      history.rotation_deg[0][c] += directions[c][a] * rates_deg_s[a];
  }
  // In one second, of which the halves need not be alike.
  for (std::size_t c = 0; c < 3; ++c) {
    history.midpoints[0].rate_deg_s[c] = 0.5 * history.rotation_deg[0][c];
    history.midpoints[1].rate_deg_s[c] = 1.5 * history.rotation_deg[0][c];
  }
  return history;
}

// The rotation by the readings, less that by the true angles, is what the error makes of it.
TEST(TheDirectionOfAMotion, IsTurnedByWhatAnAxisIsMisreadBy) {
  constexpr double kError_deg = 1e-3;
  Recording recording;
  recording.info.reference = ReferenceKind::kStandAngles;
  StandGeometry skew;
  skew.outer_middle_deg = 0.7;
  skew.middle_inner_deg = -0.4;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> angle(-180.0, 180.0), rate(-40.0, 40.0);
  for (int draw = 0; draw < 40; ++draw) {
    const StandFrame stand(draw % 2 == 0 ? StandGeometry{} : skew);
    const Vector3 angles = {angle(random), angle(random), angle(random)};
    const Vector3 rates = {rate(random), rate(random), rate(random)};
    const StateHistory history = OneInterval(recording, stand, angles, rates);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vector3 wrong = angles;
      wrong[axis] += kError_deg;
      const StateHistory misread = OneInterval(recording, stand, wrong, rates);
      for (std::size_t c = 0; c < 3; ++c) {
        const FeltAxis felt = calibration::FeelAxes(history, 0, c)[axis];
        EXPECT_NEAR((misread.rotation_deg[0][c] - history.rotation_deg[0][c]) / kError_deg,
                    felt.direction, 1e-4)
            << "axis " << axis << ", channel " << c;
      }
    }
  }
}

// Turns of the outer axis, which x and y feel from where the inner one stands, and z in part.
Motion Headings() {
  Motion motion;
  motion.Rest(20.0);
  for (const double rate : {10.0, 25.0, 40.0}) motion.ThereAndBack(kInnerAxis, 160.0, rate);
  for (int round = 0; round < 2; ++round) {
    for (const double tilt_deg : {20.0, 25.0, 30.0, 40.0}) {
      motion.Turn(kMiddleAxis, round == 0 ? tilt_deg : -tilt_deg, 30.0);
      motion.ThereAndBack(kOuterAxis, 170.0, 35.0).ThereAndBack(kInnerAxis, 60.0, 30.0);
    }
  }
  return motion;
}

BenchSensor ThreeChannels() {
  BenchSensor sensor;
  sensor.m_row = {0.006, -0.004, 1.0};
  sensor.three_channels = true;
  return sensor;
}

TEST(ASlipOfTheInnerAxis, IsNamedAloneOnEveryChannel) {
  constexpr double kSlip_deg = 0.3;
  const Motion motion = Headings();
  const double slip_s = 0.5 * motion.duration_s();
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    Injection slip;
    slip.angle_deg = [=](const BenchState& s) { return s.t_s > slip_s ? kSlip_deg : 0.0; };
    const Recording recording = SyntheticBench(motion, ThreeChannels()).Measure(slip, seed);
    const Recording* const inputs[] = {&recording};
    calibration::TraceOptions options;
    options.curves = false;
    for (const ChannelTrace& channel : calibration::Trace(inputs, options).result.channels) {
      ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", seed " << seed;
      const TracedEffect& effect = channel.effects[0];
      EXPECT_EQ(effect.id, "angle.step") << channel.summary;
      EXPECT_EQ(effect.parameters[0].name, "b_inner");
      EXPECT_NEAR(effect.parameters[0].value, kSlip_deg,
                  5.0 * effect.parameters[0].std_error + 0.02 * kSlip_deg);
      EXPECT_NEAR(effect.parameters[1].value, slip_s, 0.5);
    }
  }
}

// A table may slip by more than stands of its class are usually off.
TEST(ASlipOfTheTable, IsNamedBeyondWhatIsUsual) {
  const SyntheticBench bench(ManySpeeds());
  const double slip_s = 0.5 * ManySpeeds().duration_s();
  for (const double slip_deg : {0.3, 5.0, -10.0}) {
    Injection slip;
    slip.angle_deg = [=](const BenchState& s) { return s.t_s > slip_s ? slip_deg : 0.0; };
    const ChannelTrace channel = TraceOf(bench.Measure(slip, 1));
    ASSERT_EQ(channel.effects.size(), 1u) << channel.summary;
    EXPECT_EQ(channel.effects[0].id, "angle.step") << channel.summary;
    EXPECT_NEAR(channel.effects[0].parameters[0].value, slip_deg,
                5.0 * channel.effects[0].parameters[0].std_error + 0.02 * std::fabs(slip_deg));
  }
}

// z does not feel the middle axis turn: x and y say what is wrong with it.
TEST(AnErrorOfTheMiddleAxis, IsNamedByWhatZFeelsOfTheOuter) {
  constexpr double kWave_deg = 0.05;
  const SyntheticBench bench(Headings(), ThreeChannels());
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    Injection wave;
    wave.axis = kMiddleAxis;
    wave.angle_deg = [](const BenchState& s) {
      return kWave_deg * std::sin(2.0 * s.table.angle_deg[kMiddleAxis] * std::numbers::pi / 180.0);
    };
    const Recording recording = bench.Measure(wave, seed);
    const Recording* const inputs[] = {&recording};
    calibration::TraceOptions options;
    options.curves = false;
    for (const ChannelTrace& channel : calibration::Trace(inputs, options).result.channels) {
      EXPECT_THAT(channel.effects, ::testing::Not(::testing::IsEmpty())) << channel.summary;
      for (const TracedEffect& effect : channel.effects) {
        EXPECT_EQ(effect.owner, calibration::EffectOwner::kReference) << channel.summary;
        EXPECT_THAT(effect.parameters[0].name, ::testing::EndsWith("_middle")) << channel.summary;
      }
    }
  }
}

// Turns of the middle axis at two places of the inner one, whose own turns show its disc.
Motion TurnsAtTwoPlaces() {
  Motion motion;
  motion.Rest(20.0);
  for (const double rate : {10.0, 25.0, 40.0}) motion.ThereAndBack(kInnerAxis, 360.0, rate);
  for (const double heading_deg : {90.0, -90.0}) {
    for (const double rate : {20.0, 40.0}) motion.ThereAndBack(kMiddleAxis, 360.0, rate);
    motion.Turn(kInnerAxis, heading_deg, 30.0);
  }
  return motion;
}

// With the disc off centre the table is not where the readings say, and x and y feel turns of the
// middle axis from another direction: a rotation of both, which would be cross-axis parts. Each in
// units of its standard error, over seeds and phases of the disc: mean squares of 12 beyond these
// bounds are met once in a thousand times.
TEST(AnEccentricDiscOfTheInnerAxis, LeavesNoCrossAxisParts) {
  constexpr double kWave_deg = 0.05, kMostError = 5e-5, kLow = 0.18, kHigh = 2.75;
  constexpr int kSeeds = 12;
  const SyntheticBench bench(TurnsAtTwoPlaces(), ThreeChannels());
  double xy2 = 0.0, yx2 = 0.0, rotation2 = 0.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const double phase_deg = 30.0 * static_cast<double>(seed);
    Injection wave;
    wave.angle_deg = [=](const BenchState& s) {
      return kWave_deg *
             std::sin((s.table.angle_deg[kInnerAxis] + phase_deg) * std::numbers::pi / 180.0);
    };
    const Recording recording = bench.Measure(wave, seed);
    const Recording* const inputs[] = {&recording};
    calibration::TraceOptions options;
    options.curves = false;
    const calibration::TraceResult result = calibration::Trace(inputs, options).result;
    ASSERT_EQ(result.channels.size(), 3u);
    EXPECT_THAT(result.channels[2].summary, ::testing::HasSubstr("angle.eccentricity_1"));
    for (std::size_t c = 0; c < 2; ++c) {
      EXPECT_THAT(
          result.channels[c].remarks,
          ::testing::Contains(::testing::HasSubstr("another channel shows that the inner axis")));
    }
    ASSERT_TRUE(result.vector.matrix);
    const calibration::VectorMatrix& matrix = *result.vector.matrix;
    EXPECT_LT(std::max(matrix.m_std_error[0][1], matrix.m_std_error[1][0]), kMostError);
    const double xy = matrix.m[0][1], yx = matrix.m[1][0];
    const auto covariance = [&](std::size_t i, std::size_t j) {
      return matrix.m_covariance[9 * i + j];
    };
    xy2 += xy * xy / covariance(1, 1);
    yx2 += yx * yx / covariance(3, 3);
    const double both = covariance(1, 1) + covariance(3, 3) - 2.0 * covariance(1, 3);
    rotation2 += (xy - yx) * (xy - yx) / both;
  }
  for (const double sum : {xy2, yx2, rotation2}) {
    EXPECT_GT(sum / kSeeds, kLow);
    EXPECT_LT(sum / kSeeds, kHigh);
  }
}

// Which axis turns at the speed of its resonance is all one to a stand that shakes.
TEST(AStandThatShakesWithAnyAxis, IsNamedAlone) {
  constexpr double kAmplitude_deg_s = 0.05, kResonance_deg_s = 22.0, kWidth_deg_s = 3.0;
  Motion motion;
  motion.Rest(20.0);
  for (const double rate : {12.0, 16.0, 20.0, 24.0, 30.0, 40.0}) {
    motion.ThereAndBack(kInnerAxis, 120.0, rate);
    motion.ThereAndBack(kOuterAxis, 120.0, rate + 1.0);
  }
  motion.Turn(kMiddleAxis, 90.0, 30.0);
  for (const double rate : {14.0, 22.0, 35.0}) motion.ThereAndBack(kOuterAxis, 120.0, rate);
  const SyntheticBench bench(motion);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Injection shake;
    shake.rate_deg_s = [=](const BenchState& state) {
      double sum = 0.0;
      for (const double rate : state.table.rate_deg_s) {
        if (rate == 0.0) continue;
        sum += kAmplitude_deg_s /
               (1.0 + std::pow((std::fabs(rate) - kResonance_deg_s) / kWidth_deg_s, 2));
      }
      return sum;
    };
    const ChannelTrace channel = TraceOf(bench.Measure(shake, seed));
    ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", seed " << seed;
    EXPECT_EQ(channel.effects[0].id, "bias.vibration") << channel.summary;
    const std::vector<double> truth = {kAmplitude_deg_s, kResonance_deg_s, kWidth_deg_s};
    for (std::size_t k = 0; k < truth.size(); ++k) {
      const auto& parameter = channel.effects[0].parameters.at(k);
      EXPECT_NEAR(parameter.value, truth[k], 4.0 * parameter.std_error + 0.02 * truth[k])
          << parameter.name << ", seed " << seed;
    }
  }
}

// It shakes with the speed of the gyro's own axis: a part of that is not also a stand that shakes
// with the speed of all.
TEST(AStandThatShakesWithOneAxis, IsNotNamedInTwoShapes) {
  constexpr double kAmplitude_deg_s = 0.2, kResonance_deg_s = 22.0, kWidth_deg_s = 3.0;
  Motion motion;
  motion.Rest(20.0);
  for (const double rate : {12.0, 16.0, 20.0, 22.0, 24.0, 30.0, 40.0}) {
    motion.ThereAndBack(kInnerAxis, 120.0, rate);
    motion.ThereAndBack(kOuterAxis, 120.0, rate + 1.0);
  }
  motion.Turn(kMiddleAxis, 90.0, 30.0);
  for (const double rate : {14.0, 22.0, 35.0}) motion.ThereAndBack(kOuterAxis, 120.0, rate);
  const SyntheticBench bench(motion);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Injection shake;
    shake.rate_deg_s = [=](const BenchState& state) {
      const double rate = std::fabs(state.rate_deg_s[2]);
      return rate == 0.0
                 ? 0.0
                 : kAmplitude_deg_s / (1.0 + std::pow((rate - kResonance_deg_s) / kWidth_deg_s, 2));
    };
    const ChannelTrace channel = TraceOf(bench.Measure(shake, seed));
    ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", seed " << seed;
    EXPECT_EQ(channel.effects[0].id, "bias.vibration") << channel.summary;
    EXPECT_NEAR(channel.effects[0].parameters.at(0).value, kAmplitude_deg_s,
                4.0 * channel.effects[0].parameters.at(0).std_error + 0.02 * kAmplitude_deg_s);
  }
}

}  // namespace
}  // namespace gyrobench::testing

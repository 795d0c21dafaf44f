// What a gyro turned between two samples that have a corner of the motion between them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "calibration/signal/gyro_ring.h"
#include "tests/calibration/trace_once.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::AsMeans;
using calibration::BetweenSamples;
using calibration::ChannelTrace;
using calibration::GyroRing;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kInterval_s = 0.1;

// Of 41 samples, some lost, between the third and the last but three, where nothing bends.
struct Between {
  double spline = 0.0;
  BetweenSamples open;
};
Between Sampled(const std::function<double(double)>& rate, int lost = -1) {
  GyroRing ring;
  for (int i = 0; i <= 40; ++i)
    if (i != lost) ring.Push(kInterval_s * i, {rate(kInterval_s * i), 0.0, 0.0}, false);
  const double begin_s = 2.0 * kInterval_s, end_s = 37.0 * kInterval_s;
  calibration::IntegralMark from, to;
  EXPECT_TRUE(ring.IntegralAt(begin_s, &from) && ring.IntegralAt(end_s, &to));
  const BetweenSamples first = ring.BetweenUpTo(begin_s), last = ring.BetweenUpTo(end_s);
  Between out;
  out.spline = to.z[0] - from.z[0];
  out.open.corners[0] = last.corners[0] - first.corners[0];
  out.open.steps[0] = last.steps[0] - first.steps[0];
  out.open.bends[0] = last.bends[0] - first.bends[0];
  return out;
}

// At rest, then at a constant acceleration from `at_s` on, for `ramp_s`.
std::function<double(double)> RampFrom(double at_s, double ramp_s, double a) {
  return [=](double t) { return a * std::clamp(t - at_s, 0.0, ramp_s); };
}
// Its integral from the third sample to the last but three.
double AngleOf(double at_s, double ramp_s, double a) {
  const double end_s = 37.0 * kInterval_s;
  return 0.5 * a * ramp_s * ramp_s + a * ramp_s * (end_s - at_s - ramp_s);
}

TEST(BetweenSamples, AStraightRampIsIntegratedExactlyWhereverItBegins) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (int i = 0; i < 200; ++i) {
    const double at_s = 0.8 + any(random), ramp_s = 0.4 + any(random),
                 a = 50.0 * any(random) - 25.0;
    const Between found = Sampled(RampFrom(at_s, ramp_s, a));
    EXPECT_NEAR(found.spline + found.open.bends[0], AngleOf(at_s, ramp_s, a), 1e-12);
    const Between with_lost = Sampled(RampFrom(at_s, ramp_s, a), 8 + i % 10);
    if (ramp_s > 0.6) {
      EXPECT_NEAR(with_lost.spline + with_lost.open.bends[0], AngleOf(at_s, ramp_s, a), 1e-12);
    }
  }
}

TEST(BetweenSamples, NothingIsOpenWhereTheRateIsALine) {
  const Between found = Sampled([](double t) { return 3.0 - 7.0 * t; });
  EXPECT_NEAR(found.open.corners[0], 0.0, 1e-20);
  EXPECT_NEAR(found.open.steps[0], 0.0, 1e-20);
  EXPECT_NEAR(found.open.bends[0], 0.0, 1e-12);
}

// Over corners anywhere in an interval the variance is the mean square of what the spline errs by.
TEST(BetweenSamples, TheVarianceIsThatOfTheSplineAtCornersAndAtSteps) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (const double ramp_s : {5.0, 1e-9}) {  // one corner; a step
    const double a = ramp_s > 1.0 ? 20.0 : 20.0 / ramp_s;
    double square = 0.0, variance = 0.0;
    constexpr int kMany = 4000;
    for (int i = 0; i < kMany; ++i) {
      const double at_s = 0.8 + 10.0 * kInterval_s * any(random);
      const Between found = Sampled(RampFrom(at_s, ramp_s, a));
      const double turned =
          ramp_s > 1.0 ? 0.5 * a * std::pow(3.7 - at_s, 2) : AngleOf(at_s, ramp_s, a);
      const double off = found.spline - turned;
      square += off * off;
      variance += found.open.corners[0] + found.open.steps[0];
    }
    EXPECT_NEAR(variance / square, 1.0, 0.1) << ramp_s;
  }
}

// The sum of means is the integral up to half way to the next, and so is a cubic through these sums
// between them where the rate is a line.
TEST(BetweenSamples, MeansAreIntegratedExactlyWhereTheRateIsALine) {
  for (const double acceleration : {0.0, 12.0, -40.0}) {
    const auto rate = [=](double t) { return 3.0 + acceleration * t; };
    GyroRing ring;
    for (int i = 0; i <= 40; ++i) ring.Push(kInterval_s * i, {rate(kInterval_s * i), 0, 0}, false);
    for (const double t_s : {0.4, 0.93, 2.05, 3.0}) {
      EXPECT_NEAR(ring.AsMeansAt(t_s)[0], -acceleration * kInterval_s * kInterval_s / 24.0, 1e-12);
    }
  }
}

// Of means whose intervals end `after_s` after their times, at corners anywhere: their sums say
// `as_means` at `later_s` after a time how far the gyro turned.
void ExpectExactAtCorners(std::uint64_t seed, double after_s, double later_s,
                          AsMeans (GyroRing::*as_means)(double) const) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (int i = 0; i < 200; ++i) {
    const double at_s = 0.8 + any(random), a = 50.0 * any(random) - 25.0;
    const auto angle = [&](double t) { return 0.5 * a * std::pow(std::max(0.0, t - at_s), 2); };
    GyroRing ring;
    for (int k = 0; k <= 40; ++k) {
      const double t_s = kInterval_s * k, end_s = t_s + after_s;
      ring.Push(t_s, {(angle(end_s) - angle(end_s - kInterval_s)) / kInterval_s, 0, 0}, false);
    }
    calibration::IntegralMark from, to;
    // At samples and half way between them.
    for (double end_s = 0.5; end_s < 3.5; end_s += 0.5 * kInterval_s) {
      ASSERT_TRUE(ring.IntegralAt(0.3 + later_s, &from) && ring.IntegralAt(end_s + later_s, &to));
      const double means = (ring.*as_means)(end_s)[0] - (ring.*as_means)(0.3)[0];
      EXPECT_NEAR(to.z[0] - from.z[0] + means, angle(end_s), 1e-12) << at_s << " to " << end_s;
    }
  }
}

TEST(BetweenSamples, MeansAreIntegratedExactlyAtACornerToo) {
  ExpectExactAtCorners(5, 0.5 * kInterval_s, 0.0, &GyroRing::AsMeansAt);
}
// Each is the mean over the interval before its time.
TEST(BetweenSamples, MeansOverTheIntervalBeforeAreTheSameHalfAnIntervalLater) {
  ExpectExactAtCorners(6, 0.0, 0.5 * kInterval_s, &GyroRing::AsMeansHalfAfter);
}

// A node waits for what it is made of.
TEST(BetweenSamples, MeansThatAreSettledDoNotChange) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> any(0.0, 10.0);
  GyroRing growing, whole;
  std::vector<double> rates;
  for (int k = 0; k <= 60; ++k) {
    rates.push_back(any(random));
    whole.Push(kInterval_s * k, {rates.back(), 0, 0}, false);
  }
  int settled = 0;
  for (int k = 0; k <= 50; ++k) {
    growing.Push(kInterval_s * k, {rates[static_cast<std::size_t>(k)], 0, 0}, false);
    for (double t_s = kInterval_s * (k - 6); t_s < kInterval_s * k; t_s += 0.3 * kInterval_s) {
      if (t_s < 0.2 || !growing.MeansSettledAt(t_s)) continue;
      ++settled;
      EXPECT_EQ(growing.AsMeansAt(t_s)[0], whole.AsMeansAt(t_s)[0]) << k << " " << t_s;
      EXPECT_EQ(growing.AsMeansHalfAfter(t_s)[0], whole.AsMeansHalfAfter(t_s)[0])
          << k << " " << t_s;
    }
  }
  EXPECT_GT(settled, 100);
}

// A rate that bends all along has no corners: taken for some, it would seem larger by 3 in 10^5.
TEST(BetweenSamples, MeansOfASineAreNotTakenForCorners) {
  constexpr double kRate_deg_s = 30.0, kOmega_s = 1.2, kHalf_s = 0.5 * kInterval_s;
  const auto angle = [](double t) {
    return kRate_deg_s / kOmega_s * (1.0 - std::cos(kOmega_s * t));
  };
  GyroRing ring;
  for (int k = 0; k <= 200; ++k) {
    const double t_s = kInterval_s * k;
    ring.Push(t_s, {(angle(t_s + kHalf_s) - angle(t_s - kHalf_s)) / kInterval_s, 0, 0}, false);
  }
  double found = 0.0, turned = 0.0;
  calibration::IntegralMark from, to;
  ASSERT_TRUE(ring.IntegralAt(1.0, &from));
  for (int k = 11; k <= 190; ++k) {
    const double t_s = kInterval_s * k, now = angle(t_s) - angle(1.0);
    ASSERT_TRUE(ring.IntegralAt(t_s, &to));
    found += (to.z[0] - from.z[0] + ring.AsMeansAt(t_s)[0] - ring.AsMeansAt(1.0)[0]) * now;
    turned += now * now;
  }
  EXPECT_NEAR(found / turned, 1.0, 1e-5);
}

TEST(BetweenSamples, OfALostSampleAStraightRampKeepsItsMeans) {
  constexpr double kAcceleration_deg_s2 = 50.0;
  GyroRing ring;
  for (int k = 0; k <= 40; ++k)
    if (k != 20) ring.Push(kInterval_s * k, {kAcceleration_deg_s2 * kInterval_s * k, 0, 0}, false);
  for (const double t_s : {1.85, 1.9, 1.93, 2.0, 2.1, 2.15}) {
    EXPECT_NEAR(ring.AsMeansAt(t_s)[0], -kAcceleration_deg_s2 * kInterval_s * kInterval_s / 24.0,
                1e-12)
        << t_s;
  }
}

TEST(BetweenSamples, MeansOfFastSamplesAreNothing) {
  GyroRing ring;
  for (int i = 0; i <= 40; ++i) ring.Push(0.01 * i, {1.0 * i * i, 0, 0}, false);
  EXPECT_EQ(ring.AsMeansAt(0.2)[0], 0.0);
}

// Straight ramps of 0.7 s to 35 deg/s, 3.3 s at that rate, rests of 2.13 s, to and fro: their
// corners lie anywhere between samples.
constexpr double kRamp_s = 0.7, kTurn_s = 4.7, kWhole_s = 6.83;
double RampedAngle(double t_s) {
  const auto half = [](double u) {
    const double ramp = 25.0 * std::pow(std::clamp(u, 0.0, kRamp_s), 2);
    const double last = 25.0 * std::pow(std::clamp(kTurn_s - u, 0.0, kRamp_s), 2);
    const double ends = 25.0 * kRamp_s * kRamp_s;
    return ramp + 35.0 * std::clamp(u - kRamp_s, 0.0, kTurn_s - 2.0 * kRamp_s) +
           (u > kTurn_s - kRamp_s ? ends - last : 0.0);
  };
  const double turn = std::floor(std::max(t_s, 0.0) / kWhole_s), u = t_s - turn * kWhole_s - 1.0;
  const bool fro = std::fmod(turn, 2.0) == 1.0;
  return fro ? half(kTurn_s) - half(u) : half(u);
}
double RampedRate(double t_s) {
  const double turn = std::floor(t_s / kWhole_s), u = t_s - turn * kWhole_s - 1.0;
  const double size = 50.0 * std::clamp(std::min(u, kTurn_s - u), 0.0, kRamp_s);
  return std::fmod(turn, 2.0) == 1.0 ? -size : size;
}

// What a sample says of the motion about its time.
enum class Sample { kMoment, kMean, kMeanBefore };

Story StoryOf(double gyro_hz, Sample sample, std::uint64_t seed, double bus_s = 0.0) {
  Story story;
  story.UseTurningChannelAlone();
  story.seed = seed;
  story.duration_s = 400.0;
  story.gyro_hz = story.reference_hz = gyro_hz;
  story.reading_deg = 0.003;
  story.white_deg_s = 0.0035 * std::sqrt(gyro_hz);
  story.rate_deg_s = RampedRate;
  if (sample != Sample::kMoment) {
    const double end_s = (sample == Sample::kMean ? 0.5 / gyro_hz : 0.0) - bus_s;
    story.rate_deg_s = [=](double t_s) {
      return (RampedAngle(t_s + end_s) - RampedAngle(t_s + end_s - 1.0 / gyro_hz)) * gyro_hz;
    };
  }
  story.angle_deg = RampedAngle;
  return story;
}
ChannelTrace Traced(double gyro_hz, Sample sample, std::uint64_t seed, double declared_s = 0.0,
                    double bus_s = 0.0) {
  Story story = StoryOf(gyro_hz, sample, seed, bus_s);
  story.info.gyro_delay_s = declared_s;
  return TraceOf(story.Collect());
}

std::string NamesOf(const ChannelTrace& trace) {
  std::string names;
  for (const calibration::TracedEffect& effect : trace.effects) names += effect.id + " ";
  return names;
}

void ExpectNothing(Sample sample) {
  for (const double gyro_hz : {10.0, 16.0, 25.0}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const ChannelTrace trace = Traced(gyro_hz, sample, seed);
      EXPECT_EQ(NamesOf(trace), "") << gyro_hz << " Hz, seed " << seed;
      EXPECT_LT(trace.fitted_whitened_rms.after, 1.1) << gyro_hz << " Hz, seed " << seed;
    }
  }
}

TEST(AGyroSampledSeldom, HasNoEffectOfTheCornersBetweenItsSamples) {
  ExpectNothing(Sample::kMoment);
}
TEST(AGyroSampledSeldom, HasNoEffectOfTheMeansThatItsSamplesAre) { ExpectNothing(Sample::kMean); }

// They are late by half of their interval, and nothing else is wrong with them: no filter.
TEST(AGyroSampledSeldom, IsLateByHalfOfItsIntervalWhereItsSamplesAreMeansOverThatBefore) {
  constexpr double kLatency_s = 0.001;
  for (const double gyro_hz : {10.0, 16.0, 25.0}) {
    const double half_s = 0.5 / gyro_hz;
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      const std::string which = fmt::format("{} Hz, seed {}", gyro_hz, seed);
      const ChannelTrace trace = Traced(gyro_hz, Sample::kMeanBefore, seed);
      ASSERT_EQ(NamesOf(trace), "angle.latency ") << which;
      const calibration::ModelParameter& tau = trace.effects[0].parameters[0];
      EXPECT_LT(std::fabs(tau.value - half_s), std::min(4.0 * tau.std_error, kLatency_s)) << which;
      EXPECT_THAT(trace.remarks, Contains(HasSubstr(fmt::format("gyro_delay_s = {:.3g}", half_s))))
          << which;
      EXPECT_EQ(NamesOf(Traced(gyro_hz, Sample::kMeanBefore, seed, half_s)), "") << which;
    }
  }
}

// A bus adds to that, and there is still no filter. Where it is late by more than an interval, its
// latency is right to a thousandth only.
TEST(AGyroSampledSeldom, IsLaterYetByItsBus) {
  for (const double gyro_hz : {10.0, 25.0}) {
    for (const double of_half : {0.4, 1.1, 2.0}) {
      const double late_s = (1.0 + of_half) * 0.5 / gyro_hz;
      for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        const std::string which = fmt::format("{} Hz, {} of half, seed {}", gyro_hz, of_half, seed);
        const ChannelTrace trace =
            Traced(gyro_hz, Sample::kMeanBefore, seed, 0.0, late_s - 0.5 / gyro_hz);
        ASSERT_EQ(NamesOf(trace), "angle.latency ") << which;
        const calibration::ModelParameter& tau = trace.effects[0].parameters[0];
        EXPECT_LT(std::fabs(tau.value - late_s), std::max(4.0 * tau.std_error, 1e-3 * late_s))
            << which;
        EXPECT_LT(tau.std_error, 2e-3 * late_s) << which;
      }
    }
  }
}

// A channel that feels a twentieth of the turns cannot tell, and its sensor's samples are what
// another channel shows.
TEST(AGyroSampledSeldom, IsSampledAlikeInAllItsChannels) {
  constexpr double kGyro_hz = 10.0;
  for (const Sample sample : {Sample::kMoment, Sample::kMean, Sample::kMeanBefore}) {
    Story story = StoryOf(kGyro_hz, sample, 1);
    story.info.gyro_present = {true, true, true};
    story.scale = {0.05, -0.2, 1.012};
    const calibration::Recording recording = story.Collect();
    for (const ChannelTrace& trace : TraceAll(recording).channels) {
      const std::string names = NamesOf(trace);
      EXPECT_TRUE(names.empty() || (sample == Sample::kMeanBefore && names == "angle.latency "))
          << names;
    }
  }
}

// A column of zeros beside it has no noise to be told.
TEST(AGyroSampledSeldom, IsTracedBesideAChannelThatIsDead) {
  Story story = StoryOf(10.0, Sample::kMean, 1);
  story.info.gyro_present = {true, false, true};
  story.spoil_gyro = [](GyroSample* sample) {
    sample->xi[0] = 0.0;
    return true;
  };
  const calibration::Recording recording = story.Collect();
  const calibration::TraceResult result = TraceAll(recording);
  ASSERT_EQ(result.channels.size(), 2U);
  EXPECT_EQ(NamesOf(result.channels[1]), "");
}

}  // namespace
}  // namespace gyrobench::testing

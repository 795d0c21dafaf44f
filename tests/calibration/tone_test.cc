// A tone of the gyro's output is found between turns.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "tests/calibration/trace_once.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;

constexpr double kRest_s = 2.5, kTurn_s = 17.5, kRate_deg_s = 20.0;

// Raised cosines to and fro, with short rests: an eighth of the time.
double TurnedFor(double t_s) { return std::fmod(t_s, kRest_s + kTurn_s) - kRest_s; }
double Sign(double t_s) {
  return std::fmod(std::floor(t_s / (kRest_s + kTurn_s)), 2.0) == 0.0 ? 1.0 : -1.0;
}
double RateAt(double t_s) {
  const double u = TurnedFor(t_s);
  return u < 0.0 ? 0.0
                 : Sign(t_s) * kRate_deg_s * (1.0 - std::cos(2.0 * std::numbers::pi * u / kTurn_s));
}
double AngleAt(double t_s) {
  const double u = std::max(0.0, TurnedFor(t_s)), whole_deg = kRate_deg_s * kTurn_s;
  const double turned_deg = kRate_deg_s * (u - kTurn_s / (2.0 * std::numbers::pi) *
                                                   std::sin(2.0 * std::numbers::pi * u / kTurn_s));
  return Sign(t_s) > 0.0 ? turned_deg : whole_deg - turned_deg;
}

double FrequencyOf(const ChannelTrace& trace) {
  for (const calibration::ModelParameter& parameter : trace.effects.at(0).parameters) {
    if (parameter.name == "f") return parameter.value;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

void AddTone(double tone_hz, double size_deg_s, Story* story) {
  story->spoil_gyro = [=](GyroSample* sample) {
    sample->xi[2] += 131.0 * size_deg_s * std::sin(2.0 * std::numbers::pi * tone_hz * sample->t_s);
    return true;
  };
}

TEST(ATone, IsFoundInRestsOfASecondOrTwoBetweenTurns) {
  constexpr double kTone_hz = 1.3, kTone_deg_s = 0.01;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Story story;
    story.UseTurningChannelAlone();
    story.seed = seed;
    story.duration_s = 600.0;
    story.rate_deg_s = RateAt;
    story.angle_deg = AngleAt;
    AddTone(kTone_hz, kTone_deg_s, &story);
    const ChannelTrace trace = TraceOf(story.Collect());
    ASSERT_EQ(trace.effects.size(), 1U) << seed << ": " << trace.summary;
    EXPECT_EQ(trace.effects[0].id, "bias.tone") << seed;
    EXPECT_NEAR(FrequencyOf(trace), kTone_hz, 1e-3) << seed;
    EXPECT_LT(trace.fitted_whitened_rms.after, 1.1) << seed;
  }
}

// Rows follow each other at about 10 Hz, and show such a tone as a slower one.
TEST(ATone, IsFoundBeyondHalfOfTheRateOfTheRows) {
  constexpr double kTone_deg_s = 0.5;
  for (const double tone_hz : {6.2, 7.0, 9.1}) {
    Story story;
    story.UseTurningChannelAlone();
    story.seed = 1;
    story.duration_s = 280.0;
    const auto turns = [](double t_s) { return t_s >= 80.0 && t_s < 200.0; };
    story.rate_deg_s = [=](double t_s) { return turns(t_s) ? RateAt(t_s) : 0.0; };
    story.angle_deg = [=](double t_s) { return turns(t_s) ? AngleAt(t_s) : 0.0; };
    AddTone(tone_hz, kTone_deg_s, &story);
    const ChannelTrace trace = TraceOf(story.Collect());
    ASSERT_EQ(trace.effects.size(), 1U) << tone_hz << ": " << trace.summary;
    EXPECT_EQ(trace.effects[0].id, "bias.tone") << tone_hz;
    EXPECT_NEAR(FrequencyOf(trace), tone_hz, 1e-3);
    EXPECT_NEAR(trace.effects[0].parameters[0].value, kTone_deg_s, 0.07 * kTone_deg_s) << tone_hz;
  }
}

// Rows of evenly 0.1 s, within a digit: it is no slower one, and no faster one either.
TEST(ATone, IsFoundNearHalfOfTheRateOfTheRows) {
  for (const double tone_hz : {3.9, 4.7}) {
    Story story;
    story.UseTurningChannelAlone();
    story.seed = 2;
    story.gyro_hz = story.reference_hz = 100.0;
    story.duration_s = 200.0;
    story.rate_deg_s = RateAt;
    story.angle_deg = AngleAt;
    AddTone(tone_hz, 0.05, &story);
    const ChannelTrace trace = TraceOf(story.Collect());
    ASSERT_EQ(trace.effects.size(), 1U) << tone_hz << ": " << trace.summary;
    EXPECT_EQ(trace.effects[0].id, "bias.tone") << tone_hz;
    EXPECT_NEAR(FrequencyOf(trace), tone_hz, 1e-3);
  }
}

// To and fro without a rest, but 20 s before and after: these two show several tones as clearly.
constexpr double kBefore_s = 20.0, kSweeps_s = 200.0, kSweep_s = 10.0,
                 kSweep_rad_s = 0.1 * std::numbers::pi;
double SweepsFor(double t_s) { return std::clamp(t_s - kBefore_s, 0.0, kSweeps_s); }
double SweepRate(double t_s) {
  const double u = SweepsFor(t_s);
  const double sign = std::fmod(std::floor(u / kSweep_s), 2.0) == 0.0 ? 1.0 : -1.0;
  return sign * kRate_deg_s * (1.0 - std::cos(2.0 * kSweep_rad_s * u));
}
double SweepAngle(double t_s) {
  const double u = std::fmod(SweepsFor(t_s), 2.0 * kSweep_s);
  const auto turned_deg = [](double s) {
    return kRate_deg_s * (s - std::sin(2.0 * kSweep_rad_s * s) / (2.0 * kSweep_rad_s));
  };
  return u < kSweep_s ? turned_deg(u) : turned_deg(kSweep_s) - turned_deg(u - kSweep_s);
}

TEST(ATone, IsTheOneOfAllThatRestsFarFromEachOtherShowAlike) {
  for (const double tone_hz : {0.13, 0.31, 0.77}) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      Story story;
      story.UseTurningChannelAlone();
      story.seed = seed;
      story.white_deg_s = 0.01;
      story.duration_s = kSweeps_s + 2.0 * kBefore_s;
      story.rate_deg_s = SweepRate;
      story.angle_deg = SweepAngle;
      AddTone(tone_hz, 0.01, &story);
      const ChannelTrace trace = TraceOf(story.Collect());
      ASSERT_EQ(trace.effects.size(), 1U) << tone_hz << ", " << seed << ": " << trace.summary;
      EXPECT_EQ(trace.effects[0].id, "bias.tone") << tone_hz;
      EXPECT_NEAR(FrequencyOf(trace), tone_hz, 1e-3) << seed;
    }
  }
}

}  // namespace
}  // namespace gyrobench::testing

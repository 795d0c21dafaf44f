// A tone of the gyro's output is found between turns.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
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

TEST(ATone, IsFoundInRestsOfASecondOrTwoBetweenTurns) {
  constexpr double kTone_hz = 1.3, kTone_deg_s = 0.01;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Story story;
    story.UseTurningChannelAlone();
    story.seed = seed;
    story.duration_s = 600.0;
    story.rate_deg_s = RateAt;
    story.angle_deg = AngleAt;
    story.spoil_gyro = [](GyroSample* sample) {
      const double phase = 2.0 * std::numbers::pi * kTone_hz * sample->t_s;
      sample->xi[2] += 131.0 * kTone_deg_s * std::sin(phase);
      return true;
    };
    const ChannelTrace trace = TraceOf(story.Collect());
    ASSERT_EQ(trace.effects.size(), 1U) << seed << ": " << trace.summary;
    EXPECT_EQ(trace.effects[0].id, "bias.tone") << seed;
    for (const calibration::ModelParameter& parameter : trace.effects[0].parameters) {
      if (parameter.name == "f") {
        EXPECT_LT(std::fabs(parameter.value - kTone_hz), 1e-3) << seed;
      }
    }
    EXPECT_LT(trace.fitted_whitened_rms.after, 1.1) << seed;
  }
}

}  // namespace
}  // namespace gyrobench::testing

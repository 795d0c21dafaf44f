// A gyro whose noise is smaller than its last digit: what rounding makes is no finding, and what
// stands still is not hung.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "calibration/state/trail.h"
#include "calibration/trace/trace.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;
using calibration::MakeTrail;
using calibration::Recording;
using calibration::RoughSensitivity;
using calibration::TracedEffect;

constexpr double kDigit_deg_s = 1.0 / 131.0;

// The story's sensor with noise of so many digits, and a tone of so many on its x channel.
Story Rounded(double noise_digits, double tone_digits, std::uint64_t seed) {
  Story story;
  story.seed = seed;
  story.white_deg_s = noise_digits * kDigit_deg_s;
  story.spoil_gyro = [=](GyroSample* sample) {
    constexpr double kTone_Hz = 0.37;
    sample->xi[0] += tone_digits * std::sin(2.0 * std::numbers::pi * kTone_Hz * sample->t_s);
    for (double& count : sample->xi) count = std::round(count);
    return true;
  };
  return story;
}

// The largest error of the mean of a Gaussian variable that is rounded to whole numbers, by its
// probabilities.
double WorstMeanError(double sigma) {
  double worst = 0.0;
  for (double x = 0.0; x < 1.0; x += 0.01) {
    double mean = 0.0;
    for (int n = -8; n <= 9; ++n) {
      const auto below = [&](double edge) {
        return 0.5 * std::erfc(-(edge - x) / (std::numbers::sqrt2 * sigma));
      };
      mean += n * (below(n + 0.5) - below(n - 0.5));
    }
    worst = std::max(worst, std::fabs(mean - x));
  }
  return worst;
}

TEST(OutputRounding, IsBoundedByWhatItsNoiseLeaves) {
  for (const double noise_digits : {0.05, 0.2, 0.3, 0.4, 1.0}) {
    const Recording recording = Rounded(noise_digits, 0.0, 3).Collect();
    const calibration::Trail trail =
        MakeTrail(recording, RoughSensitivity(recording), true, recording.info.covariates);
    const double worst = WorstMeanError(noise_digits);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_LE(trail.output_rounding[c], 0.5) << noise_digits;
      EXPECT_GE(trail.output_rounding[c], 0.8 * worst - 0.01) << noise_digits;
      if (noise_digits < 0.4) continue;
      // The prefactor is half a digit in place of the first harmonic's 1 / pi.
      const double with_less_noise = 0.5 * std::numbers::pi * WorstMeanError(0.8 * noise_digits);
      EXPECT_LE(trail.output_rounding[c], with_less_noise) << noise_digits;
    }
  }
}

TEST(OutputRounding, OfASensorWithoutNoiseIsNoEffectAndNoFreeze) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Recording recording = Rounded(0.0, 0.0, seed).Collect();
    EXPECT_TRUE(recording.defects.empty());
    const Recording* const one[] = {&recording};
    for (const ChannelTrace& channel : Trace(one).result.channels) {
      EXPECT_TRUE(channel.effects.empty()) << "seed " << seed << ": " << channel.summary;
    }
  }
}

TEST(OutputRounding, HidesAToneOfAThirdOfADigitAndNotOneOfFive) {
  for (const double tone_digits : {0.3, 5.0}) {
    const Recording recording = Rounded(0.0, tone_digits, 1).Collect();
    const Recording* const one[] = {&recording};
    const std::vector<TracedEffect> effects = Trace(one).result.channels[0].effects;
    ASSERT_EQ(effects.size(), tone_digits > 1.0 ? 1u : 0u) << tone_digits;
    if (effects.empty()) continue;
    EXPECT_EQ(effects[0].id, "bias.tone");
    EXPECT_NEAR(effects[0].parameters[0].value, tone_digits * kDigit_deg_s, 0.5 * kDigit_deg_s);
  }
}

}  // namespace
}  // namespace gyrobench::testing

// What the noise of a gyro must not do to the terms that are made of its own rate.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;

constexpr double kLag_s = 0.0073;

// Rate of the inner axis behind a lag of first order, tau dv/dt = w - v, exact for a rate that is
// linear between steps.
class LaggedRate {
 public:
  explicit LaggedRate(const Motion& motion) {
    const double decay = std::exp(-kStep_s / kLag_s);
    double shown = 0.0, before = 0.0;
    for (double t_s = 0.0; t_s < motion.duration_s() + kStep_s; t_s += kStep_s) {
      const double now = motion.At(t_s).rate_deg_s[kInnerAxis];
      const double slope = (now - before) / kStep_s;
      shown = now - kLag_s * slope + (shown - before + kLag_s * slope) * decay;
      before = now;
      rates_.push_back(shown);
    }
  }
  double At(double t_s) const {
    const double step = t_s / kStep_s;
    const std::size_t i = std::min(static_cast<std::size_t>(step), rates_.size() - 2);
    const double part = step - static_cast<double>(i);
    return (1.0 - part) * rates_[i] + part * rates_[i + 1];
  }

 private:
  static constexpr double kStep_s = 1e-3;
  std::vector<double> rates_;
};

Motion RoundsOfTurns() {
  Motion motion;
  motion.Rest(10.0);
  for (int round = 0; round < 4; ++round) {
    for (const double rate : {10.0, 20.0, 40.0, 80.0}) motion.ThereAndBack(kInnerAxis, 360.0, rate);
  }
  return motion;
}

bool Names(const calibration::TracedEffect& effect, const char* id) {
  return effect.id == id || std::count(effect.rivals.begin(), effect.rivals.end(), id) > 0;
}

// A gyro of four times the usual noise, sampled at 100 Hz. A lag's term is the rate that the gyro
// itself shows: with the noise of the samples about a reading in it, which is in the output as
// well, the residual grew, and a pure delay was named as certain in two seeds of five.
TEST(NoisyGyro, ItsNoiseDoesNotRuleOutTheLagThatItHas) {
  const Motion motion = RoundsOfTurns();
  const LaggedRate lagged(motion);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Story story;
    story.Follow(motion);
    story.UseTurningChannelAlone();
    story.seed = seed;
    story.gyro_hz = story.reference_hz = 100.0;
    story.white_deg_s = 0.13;
    story.reading_deg = 0.003;
    story.rate_deg_s = [&lagged](double t_s) { return lagged.At(t_s); };
    const ChannelTrace channel = TraceOf(story.Collect());
    ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", seed " << seed;
    EXPECT_TRUE(Names(channel.effects[0], "bandwidth.first_order"))
        << channel.summary << ", seed " << seed;
    EXPECT_NEAR(channel.effects[0].parameters.at(0).value, kLag_s, 0.001) << "seed " << seed;
  }
}

}  // namespace
}  // namespace gyrobench::testing

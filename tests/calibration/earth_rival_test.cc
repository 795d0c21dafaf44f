// Earth's rotation, of measurements that do not say where they were made: it is what a sensitivity
// to gravity may be taken for where its pattern over poses and headings, and its size, permit it.
#include <gtest/gtest.h>

#include <algorithm>

#include "calibration/trace/trace_result.h"
#include "tests/calibration/injected.h"
#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;
using calibration::TracedEffect;

constexpr double kEarthRate_deg_s = 15.041 / 3600.0;  // IERS: 7.292115e-5 rad/s

// Of one g along the given axis of the sensor.
ChannelTrace TraceOfSensitivity(std::size_t axis, double deg_s) {
  return TraceOf(SyntheticBench(EveryMotion())
                     .Measure(Rate([=](const BenchState& s) { return deg_s * s.g[axis]; }), 7));
}

bool MayBeEarth(const ChannelTrace& channel) {
  return std::ranges::any_of(channel.effects, [](const TracedEffect& effect) {
    return effect.id == "bias.earth_rate" ||
           std::ranges::count(effect.rivals, "bias.earth_rate") > 0;
  });
}

bool NamesGravity(const ChannelTrace& channel) {
  return std::ranges::count(channel.effects, "bias.g_linear", &TracedEffect::id) > 0;
}

// The vertical part of the Earth's rotation, as z sees it, goes with gravity along z.
TEST(EarthsRotation, PassesForASensitivityAlongZThatIsNoLarger) {
  const ChannelTrace channel = TraceOfSensitivity(2, 0.7 * kEarthRate_deg_s);
  EXPECT_TRUE(MayBeEarth(channel)) << channel.summary;
}

// Of two poses both are one offset there and another here: neither has more to be known.
TEST(EarthsRotation, PassesForASensitivityThatTwoPosesShow) {
  Motion motion;
  motion.Rest(60.0).Turn(kMiddleAxis, 180.0, 20.0).Rest(60.0);
  const ChannelTrace channel = TraceOf(SyntheticBench(motion).Measure(
      Rate([](const BenchState& s) { return 0.7 * kEarthRate_deg_s * s.g[2]; }), 7));
  ASSERT_FALSE(channel.effects.empty()) << channel.summary;
  EXPECT_TRUE(MayBeEarth(channel)) << channel.summary;
}

TEST(EarthsRotation, PassesForNoneThatIsLarger) {
  const ChannelTrace channel = TraceOfSensitivity(2, 2.0 * kEarthRate_deg_s);
  EXPECT_TRUE(NamesGravity(channel)) << channel.summary;
  EXPECT_FALSE(MayBeEarth(channel)) << channel.summary;
}

// As the sensor turns about z gravity along x changes its sign, and z sees the Earth as before.
TEST(EarthsRotation, PassesForNoneThatItsPatternDoesNotFit) {
  for (const std::size_t axis : {0u, 1u}) {
    const ChannelTrace channel = TraceOfSensitivity(axis, 0.7 * kEarthRate_deg_s);
    EXPECT_TRUE(NamesGravity(channel)) << channel.summary;
    EXPECT_FALSE(MayBeEarth(channel)) << channel.summary;
  }
}

}  // namespace
}  // namespace gyrobench::testing

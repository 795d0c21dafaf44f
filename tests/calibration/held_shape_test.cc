// A resonance that one speed alone meets: its offset at that speed is known, its place and width
// are not, because one that is farther off and higher does the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;
using calibration::ModelParameter;
using calibration::TracedEffect;

constexpr double kMet_deg_s = 20.0, kShift_deg_s = 0.01;

Motion ThreeSpeeds() {
  Motion motion;
  for (int round = 0; round < 3; ++round) {
    for (const double rate_deg_s : {8.0, kMet_deg_s, 45.0})
      motion.Rest(4.0).ThereAndBack(kInnerAxis, 90.0, rate_deg_s);
  }
  return motion;
}

const ModelParameter& Named(const TracedEffect& effect, const std::string& name) {
  static const ModelParameter kNone;
  const auto found = std::ranges::find(effect.parameters, name, &ModelParameter::name);
  EXPECT_NE(found, effect.parameters.end()) << name;
  return found != effect.parameters.end() ? *found : kNone;
}

TEST(AResonanceThatOneSpeedMeets, IsNamedWithWhatItDoesThereAndNoErrorOfItsShape) {
  BenchSensor sensor;
  sensor.angle_random_walk_deg_sqrt_s = 0.005;
  const SyntheticBench bench(ThreeSpeeds(), sensor);
  Injection shift;
  shift.rate_deg_s = [](const BenchState& s) {
    const double rate_deg_s = std::fabs(s.table.rate_deg_s[kInnerAxis]);
    return std::fabs(rate_deg_s - kMet_deg_s) < 2.0 ? kShift_deg_s : 0.0;
  };
  int held = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const ChannelTrace channel = TraceOf(bench.Measure(shift, seed));
    ASSERT_EQ(channel.effects.size(), 1u) << channel.summary << ", seed " << seed;
    const TracedEffect& effect = channel.effects[0];
    ASSERT_EQ(effect.id, "bias.vibration") << channel.summary << ", seed " << seed;
    const ModelParameter &amplitude = Named(effect, "A"), &place = Named(effect, "f0"),
                         &width = Named(effect, "width");
    const double off = (kMet_deg_s - place.value) / width.value;
    const double there = 1.0 / (1.0 + off * off);
    if (!std::isnan(place.std_error)) continue;
    ++held;
    EXPECT_TRUE(std::isnan(width.std_error));
    EXPECT_TRUE(std::isnan(amplitude.std_error));
    const ModelParameter& largest = Named(effect, "largest_in_data");
    EXPECT_NEAR(amplitude.value * there, largest.value, 0.1 * largest.value);
    EXPECT_GT(largest.value, 2.0 * largest.std_error);
    // 1.3 in 100,000 of each.
    EXPECT_NEAR(largest.value, kShift_deg_s, 4.2 * largest.std_error);
    EXPECT_TRUE(std::ranges::any_of(channel.remarks, [](const std::string& remark) {
      return remark.starts_with("bias.vibration: ") &&
             remark.find("not its size, f0 and width apart") != std::string::npos;
    }));
  }
  EXPECT_GE(held, 3);
}

// The narrowest shape whose flank one speed meets explains as much as a wide one, and would be six
// or ten times as high.
TEST(AResonanceThatOneSpeedMeetsOnItsFlank, IsNoLargerThanItNeedsToBe) {
  constexpr double kTop_deg_s = 0.02, kPlace_deg_s = 19.5, kWidth_deg_s = 3.0;
  constexpr int kSeeds = 12;
  Motion motion;
  for (const double rate_deg_s : {8.0, 17.0, 45.0})
    motion.Rest(4.0).ThereAndBack(kInnerAxis, 120.0, rate_deg_s);
  BenchSensor sensor;
  sensor.angle_random_walk_deg_sqrt_s = 0.005;
  const SyntheticBench bench(motion, sensor);
  Injection shift;
  shift.rate_deg_s = [](const BenchState& s) {
    const double rate_deg_s = std::fabs(s.table.rate_deg_s[kInnerAxis]);
    const double off = (rate_deg_s - kPlace_deg_s) / kWidth_deg_s;
    return rate_deg_s > 0.3 ? kTop_deg_s / (1.0 + off * off) : 0.0;
  };
  int named = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const ChannelTrace channel = TraceOf(bench.Measure(shift, static_cast<std::uint64_t>(seed)));
    const auto found = std::ranges::find(channel.effects, "bias.vibration", &TracedEffect::id);
    if (found == channel.effects.end()) continue;
    ++named;
    EXPECT_LT(Named(*found, "A").value, 1.5 * kTop_deg_s) << "seed " << seed;
    EXPECT_GT(Named(*found, "A").value, 0.3 * kTop_deg_s) << "seed " << seed;
  }
  EXPECT_GE(named, kSeeds / 2);
}

// Of so few seconds nothing can be held out, and nothing can speak against an effect.
TEST(AShortRecord, KeepsAnEffectThoughNoPartOfItCanBeHeldOut) {
  Motion motion;
  motion.Rest(2.0).ThereAndBack(kInnerAxis, 90.0, 30.0).Rest(2.0);
  for (const double rate_deg_s : {40.0, 60.0}) motion.ThereAndBack(kInnerAxis, 90.0, rate_deg_s);
  ASSERT_LT(motion.duration_s(), 30.0);
  const SyntheticBench bench(motion);
  Injection late;
  late.angle_deg = [](const BenchState& s) { return 0.01 * s.table.rate_deg_s[kInnerAxis]; };
  const ChannelTrace channel = TraceOf(bench.Measure(late, 1));
  EXPECT_FALSE(channel.effects.empty()) << channel.summary;
}

}  // namespace
}  // namespace gyrobench::testing

// Ripple of the angle that hardly stands out. One of few periods a turn is slow against the nodes:
// its sum has far less noise than that of a fast one, and must be seen as what it is worth.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;
using calibration::TracedEffect;

Motion Turns(int times, double rate_deg_s) {
  Motion motion;
  for (int i = 0; i < times; ++i) motion.Rest(3.0).ThereAndBack(kInnerAxis, 360.0, rate_deg_s);
  return motion;
}

// How many of `seeds` name a ripple of so many periods, and nothing else, with its size right.
int Named(const Motion& motion, int periods, double amplitude_deg, int seeds) {
  const SyntheticBench bench(motion);
  Injection ripple;
  ripple.angle_deg = [=](const BenchState& s) {
    const double turn_rad = s.table.angle_deg[kInnerAxis] * std::numbers::pi / 180.0;
    return amplitude_deg * std::sin(periods * turn_rad + 1.0);
  };
  int named = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const ChannelTrace channel = TraceOf(bench.Measure(ripple, static_cast<std::uint64_t>(seed)));
    if (channel.effects.size() != 1) continue;
    const TracedEffect& effect = channel.effects[0];
    if (effect.id != "angle.ripple") continue;
    EXPECT_NEAR(effect.parameters[0].value, amplitude_deg, 4.5 * effect.parameters[0].std_error);
    ++named;
  }
  return named;
}

TEST(AWeakRipple, OfFewPeriodsATurnIsNamedAsOneOfManyIs) {
  for (const int periods : {4, 36}) {
    // Seven of its standard deviations and more, of which four and a half are asked for.
    EXPECT_GE(Named(Turns(6, 20.0), periods, 0.0006, 6), 5) << periods << " periods a turn";
  }
}

// A row is a few thousandths of the ripple's period.
TEST(AWeakRipple, OfATableThatTurnsSlowlyIsNamed) {
  EXPECT_GE(Named(Turns(1, 2.0), 4, 0.01, 6), 5);
}

}  // namespace
}  // namespace gyrobench::testing

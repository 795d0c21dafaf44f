// Two effects, of which the first is found while the second is still missing: what it took of the
// second's shape is given back. The parameters are those of both together, in whichever order they
// were found.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tests/calibration/injected.h"
#include "tests/calibration/trace_once.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;

constexpr double kTau_s = 150.0, kWarm_deg_s = 0.4;
constexpr double kResonance_deg_s = 22.0, kWidth_deg_s = 4.0, kShaken_deg_s = 0.12;

double WarmUp(const BenchState& s) { return kWarm_deg_s * std::exp(-s.t_s / kTau_s); }

double Resonance(const BenchState& s) {
  const double rate = std::fabs(Wz(s));
  if (rate < 1e-6) return 0.0;
  return kShaken_deg_s / (1.0 + std::pow((rate - kResonance_deg_s) / kWidth_deg_s, 2));
}

// The jump of the offset is the smaller one.
void ExpectBothBesideAJump(const std::function<double(const BenchState&)>& rate,
                           const std::string& searched, const std::vector<Expected>& expected) {
  // A temperature that swings tells what follows it from what follows the time.
  BenchSensor sensor;
  sensor.temperature_period_s = 70.0;
  const SyntheticBench bench(ManySpeeds(), sensor);
  const double jump_s = 0.3 * bench.motion().duration_s();
  for (const double jump_deg_s : {-0.05, -0.02, 0.02, 0.05}) {
    const auto both = [&](const BenchState& s) {
      return rate(s) + (s.t_s > jump_s ? jump_deg_s : 0.0);
    };
    const ChannelTrace channel = TraceOf(bench.Measure(Rate(both), 1));
    ASSERT_EQ(channel.effects.size(), 2u) << channel.summary << ", a jump of " << jump_deg_s;
    const std::size_t at = channel.effects[0].id == searched ? 0 : 1;
    ASSERT_EQ(channel.effects[at].id, searched) << channel.summary;
    ASSERT_EQ(channel.effects[1 - at].id, "bias.step") << channel.summary;
    for (const Expected& parameter : expected)
      ExpectWithinItsInterval(channel.effects[at].parameters, parameter);
    ExpectWithinItsInterval(channel.effects[1 - at].parameters, {"b", jump_deg_s});
  }
}

TEST(AMemberThatIsSearched, AWarmUpHasItsOwnTimeBesideAJump) {
  ExpectBothBesideAJump(WarmUp, "bias.warm_up", {{"A", kWarm_deg_s}, {"tau", kTau_s}});
}

TEST(AMemberThatIsSearched, AResonanceHasItsOwnPlaceBesideAJump) {
  ExpectBothBesideAJump(Resonance, "bias.vibration",
                        {{"A", kShaken_deg_s}, {"f0", kResonance_deg_s}, {"width", kWidth_deg_s}});
}

}  // namespace
}  // namespace gyrobench::testing

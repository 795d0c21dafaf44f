#include "daemon/run_trace.h"

#include <gtest/gtest.h>

namespace gyrobench::daemon {
namespace {

bool MayBeAStep(const std::string& id, const std::vector<std::string>& rivals = {}) {
  calibration::ChannelTrace channel;
  calibration::TracedEffect effect;
  effect.id = id;
  effect.rivals = rivals;
  channel.effects.push_back(effect);
  return VerdictOf(channel).effects.at(0).may_be_a_step;
}

TEST(VerdictOfATrace, TellsTheProcedureWhatMayBeAStep) {
  EXPECT_TRUE(MayBeAStep("bias.step"));
  EXPECT_TRUE(MayBeAStep("angle.step"));
  EXPECT_TRUE(MayBeAStep("bias.warm_up", {"bias.step"}));
  EXPECT_FALSE(MayBeAStep("bias.warm_up", {"bias.hysteresis"}));
  EXPECT_FALSE(MayBeAStep("bias.tone"));
  EXPECT_FALSE(MayBeAStep("composed(w*T)"));
}

}  // namespace
}  // namespace gyrobench::daemon

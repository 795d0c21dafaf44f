// Held poses: asked of a hand, or taken by the stand in its place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "procedures/engine/dry_bench.h"
#include "tests/procedures/fake_bench.h"
#include "tests/procedures/shipped.h"

namespace gyrobench::procedures {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Hold, AsksAHandForEachPoseAndShowsWhatIsStillMissingWithoutAnyAxis) {
  FakeBench bench;
  bench.axes = {};
  RunProcedure(Shipped("hold"), {{"poses", 12.0}}, bench);
  ASSERT_EQ(bench.questions.size(), 13U);
  EXPECT_EQ(bench.questions[1].id, "pose");
  EXPECT_THAT(bench.questions[1].text, HasSubstr("Pose 1 of 12"));
  EXPECT_THAT(bench.questions[1].text, HasSubstr("Still missing: +z, -x, +y, -z, +x, -y ..."));
  EXPECT_THAT(bench.questions[12].text, HasSubstr("Still missing: -y-z"));
  EXPECT_THAT(bench.questions[12].text, Not(HasSubstr("...")));
  EXPECT_TRUE(bench.turns.empty());
}

TEST(Hold, LetsTheAxesTakeThePartOfTheHand) {
  FakeBench bench;
  bench.answers["hold"] = "stand";
  for (AxisFacts& axis : bench.axes) {
    axis.min_deg = -400.0;
    axis.max_deg = 400.0;
  }
  RunProcedure(Shipped("hold"), {{"poses", 20.0}}, bench);
  EXPECT_EQ(bench.questions.size(), 1U);
  EXPECT_GE(bench.turns.size(), 19U);
}

TEST(Hold, SaysThatAStandWithTooFewAxesNeedsAHand) {
  FakeBench bench;
  bench.answers["hold"] = "stand";
  bench.axes = {bench.axes[2]};
  try {
    RunProcedure(Shipped("hold"), {}, bench);
    FAIL() << "no error";
  } catch (const std::exception& error) {
    EXPECT_THAT(error.what(), HasSubstr("answer hand"));
  }
}

TEST(Hold, CanBeRunDryWithoutAnyAxis) {
  const Plan plan = DryRun(Shipped("hold"), {}, {});
  EXPECT_NEAR(plan.duration_s, 80.0, 1e-9);
}

}  // namespace
}  // namespace gyrobench::procedures

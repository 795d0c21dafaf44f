// What the procedures that move do on stands that lack an axis, or whose limits are in the way:
// they adapt and say so, or refuse with the reason before anything moves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ostream>

#include "tests/procedures/motion.h"
#include "tests/procedures/shipped.h"

namespace gyrobench::procedures {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

AxisFacts Free(const std::string& name) { return {name, 40, 0, -3600, 3600, 60, 200}; }
AxisFacts Within(const std::string& name, double min_deg, double max_deg) {
  AxisFacts axis = Free(name);
  axis.min_deg = min_deg;
  axis.max_deg = max_deg;
  return axis;
}
// The middle axis cannot leave 0 deg: outer and inner axis are parallel for ever.
std::vector<AxisFacts> Locked() {
  return {Free("outer"), Within("middle", -0.01, 0.01), Free("inner")};
}

struct Refused {
  std::string procedure;
  Parameters parameters;
  std::vector<AxisFacts> axes;
  std::string because;
};

void PrintTo(const Refused& refused, std::ostream* out) {
  *out << refused.procedure << ", " << refused.axes.size() << " axes: " << refused.because;
}

class Refuses : public ::testing::TestWithParam<Refused> {};

TEST_P(Refuses, BeforeAnythingMovesAndWithTheReason) {
  const Refused& refused = GetParam();
  EXPECT_THAT(RefusalOf(refused.procedure, refused.parameters, refused.axes),
              AllOf(HasSubstr(refused.procedure + ".lua:"), HasSubstr(refused.because)));
  FeltBench bench(refused.axes);
  EXPECT_THROW(RunProcedure(Shipped(refused.procedure), refused.parameters, bench), Error);
  EXPECT_TRUE(bench.turns.empty());
  EXPECT_TRUE(bench.swings.empty());
}

const std::string kLocked = "axis.middle would stand at";

INSTANTIATE_TEST_SUITE_P(
    HinderedStands, Refuses,
    ::testing::Values(
        // Gimbal lock.
        Refused{"poses", {}, Locked(), kLocked},
        Refused{"rates", {{"axes", "x"}}, Locked(), kLocked},
        Refused{"sweep", {{"about", "y"}}, Locked(), "axis.middle allows an amplitude of 0.01"},
        Refused{
            "thermal", {{"about", "y"}}, Locked(), "the limits leave axis.middle a turn of 0.02"},
        // One axis alone.
        Refused{"poses", {}, {Free("inner")}, "no outer and no middle axis"},
        Refused{"rates", {{"axes", "y"}}, {Free("inner")}, "no outer and no middle axis"},
        Refused{"sweep", {{"about", "x"}}, {Free("outer")}, "no middle and no inner axis"},
        Refused{"thermal", {{"about", "z"}}, {Free("middle")}, "no outer and no inner axis"},
        Refused{"full", {}, {Free("middle")}, "the sequence needs turns about z with z up"},
        // Limits that make every pose unreachable but those near the present one.
        Refused{"poses",
                {},
                {Within("outer", -10, 10), Within("middle", -10, 10), Within("inner", -10, 10)},
                "limits -10 .. 10 deg"},
        // An axis that cannot turn far enough.
        Refused{"thermal", {}, {Within("inner", -1, 1)}, "which is too short"},
        Refused{"sweep", {}, {Within("inner", -0.05, 0.05)}, "no frequency is possible"}));

TEST(GimbalLock, IsLeftWhereTheMiddleAxisMayTurn) {
  FeltBench bench({Free("outer"), Free("middle"), Free("inner")});
  RunProcedure(
      Script("assert(bench.find_pose{ up = '+z' }.gimbal_lock)\n"
             "assert(not bench.find_pose{ about = 'x', up = '+x' }.gimbal_lock)\n"
             "local pose = bench.take_pose{ about = 'x', up = '+x' }\n"
             "bench.turn{ axis = pose.axis, angle_deg = 30 * pose.sense, rate_deg_s = 10 }"),
      {}, bench);
  EXPECT_NEAR(Dot(bench.turned.back().rate_deg_s, {1, 0, 0}), 10, 1e-6);
}

TEST(GimbalLock, LeavesTheTurnsAboutZAndNamesTheRest) {
  for (const char* name : {"rates", "full"}) {
    const Plan plan = DryRun(Shipped(name), {}, Locked());
    EXPECT_THAT(plan.notes, Contains(AllOf(HasSubstr("left out"), HasSubstr(kLocked)))) << name;
    EXPECT_FALSE(plan.moves.empty());
    for (const PlannedMove& move : plan.moves) EXPECT_NE(move.axis, "middle") << name;
  }
}

TEST(AnAxisThatCannotTurnFully, KeepsEveryMoveWithinItsLimits) {
  const std::vector<AxisFacts> narrow = {Within("outer", -50, 60), Within("middle", -100, 95),
                                         Within("inner", -40, 170)};
  for (const char* name : {"poses", "rates", "sweep", "thermal", "full"}) {
    const Plan plan = DryRun(Shipped(name), {}, narrow);
    EXPECT_FALSE(plan.moves.empty()) << name;
    for (const PlannedMove& move : plan.moves) {
      const AxisFacts& axis = narrow[IndexOf(move.axis)];
      EXPECT_GE(move.to_deg, axis.min_deg - 1e-6) << name;
      EXPECT_LE(move.to_deg, axis.max_deg + 1e-6) << name;
    }
  }
}

// A run that was planned goes through: what it measures there does not lead it elsewhere.
TEST(AnAxisThatIsMissing, LeavesAPlanThatTheRunKeeps) {
  for (const char* name : {"rates", "sweep", "thermal", "full"}) {
    for (const std::vector<AxisFacts>& axes : std::vector<std::vector<AxisFacts>>{
             {Free("inner")}, {Free("outer")}, {Free("middle"), Free("inner")}}) {
      const Plan plan = DryRun(Shipped(name), {}, axes);
      FeltBench bench(axes);
      bench.warms_degC = {{"fan_on", -8.0}, {"fan_off", 8.0}};
      RunProcedure(Shipped(name), {}, bench);
      EXPECT_EQ(plan.moves.size(), bench.turns.size()) << name;
      EXPECT_NEAR(plan.duration_s, bench.ElapsedS(), 0.02 * plan.duration_s) << name;
    }
  }
}

}  // namespace
}  // namespace gyrobench::procedures

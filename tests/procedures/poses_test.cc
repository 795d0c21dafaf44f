// The procedure `poses`, and the commands that take poses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/procedures/motion.h"
#include "tests/procedures/shipped.h"

namespace gyrobench::procedures {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::vector<AxisFacts> FreeAxes() {
  std::vector<AxisFacts> axes = ThreeAxes();
  for (AxisFacts& axis : axes) {
    axis.min_deg = -3600;
    axis.max_deg = 3600;
  }
  return axes;
}

TEST(PoseCommands, AFoundPoseIsTheOneThatIsTaken) {
  FeltBench bench;
  RunProcedure(Script("local found = bench.find_pose{ up = '-x+y', forward = 'z' }\n"
                      "assert(found.possible and found.reason == '' and found.axis == nil)\n"
                      "bench.take_pose{ up = '-x+y', forward = 'z' }\n"
                      "local axes = bench.axes()\n"
                      "for name, angle_deg in pairs(found.angles_deg) do\n"
                      "  assert(math.abs(axes[name].angle_deg - angle_deg) < 1e-9, name)\n"
                      "end"),
               {}, bench);
  EXPECT_NEAR(Dot(bench.Up(), {-std::sqrt(0.5), std::sqrt(0.5), 0}), 1.0, 1e-9);
}

TEST(PoseCommands, TellWhichAxisTurnsAboutASensorAxisAndWhichWay) {
  FeltBench bench(FreeAxes());
  RunProcedure(
      Script("for _, about in ipairs{ '+x', '-x', '+y', '-y', '+z', '-z' } do\n"
             "  local pose = bench.take_pose{ about = about, axis = 'outer' }\n"
             "  bench.rest{ duration_s = 1 }\n"
             "  bench.turn{ axis = pose.axis, angle_deg = 10 * pose.sense, rate_deg_s = 5 }\n"
             "end"),
      {}, bench);
  ASSERT_EQ(bench.rests.size(), 6U);
  std::size_t turn = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    while (bench.calls[turn] != "rest") ++turn;
    ++turn;
  }
  const Vector3 expected = {0, 0, -5};
  const Vector3 rate = bench.turned.back().rate_deg_s;
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(rate[k], expected[k], 1e-9);
}

TEST(PoseCommands, AxesThatAreThereStayAndSlowOnesGoAtTheirLimit) {
  FeltBench bench;
  bench.axes[0].angle_deg = 0.02;
  bench.axes[2].angle_deg = 90.05;
  RunProcedure(Script("bench.take_pose{ up = 'x', rate_deg_s = 35 }"), {}, bench);
  ASSERT_EQ(bench.turns.size(), 1U);
  EXPECT_EQ(bench.turns[0].axis, "middle");
  EXPECT_EQ(bench.turns[0].rate_deg_s, 30.0);
}

TEST(PoseCommands, AMountedSensorIsPointedUpAllTheSame) {
  FeltBench bench(FreeAxes());
  bench.geometry = {.mount_deg = {180.0, 1.0, 30.0}, .outer_middle_deg = 0.2};
  RunProcedure(Script("bench.take_pose{ up = '+y' }"), {}, bench);
  EXPECT_NEAR(bench.Up()[1], 1.0, 1e-7);
}

TEST(PoseCommands, WrongDirectionsAndImpossiblePosesAreRefusedWithTheReason) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"bench.find_pose{ up = 'w' }", "up = \"w\": expected a direction of the sensor"},
      {"bench.find_pose{ up = '' }", "expected a direction"},
      {"bench.find_pose{ up = 'xy' }", "expected a direction"},
      {"bench.find_pose{ up = '+x-x' }", "expected a direction"},
      {"bench.find_pose{ about = 'z', axis = 'upper' }", "expected outer, middle or inner"},
      {"bench.find_pose{}", "a pose needs up or about"},
      {"bench.find_pose{ up = 'z', forward = 'z' }", "expected 90 deg"},
      {"bench.take_pose{ up = 'z', rate_deg_s = 0 }", "rate_deg_s = 0: expected a number above 0"},
      {"bench.take_pose{ up = '-z' }",
       "there is no such pose: axis.middle would stand at 180.0 deg"},
  };
  for (const auto& [body, message] : cases) {
    FakeBench bench;
    EXPECT_THAT(MessageOf<Error>([&] { RunProcedure(Script(body), {}, bench); }),
                AllOf(HasSubstr("try.lua:2: "), HasSubstr(message)))
        << body;
    EXPECT_TRUE(bench.turns.empty()) << body;
  }
}

TEST(Poses, RestsInEveryOrientationOnce) {
  for (const auto& [poses, count] : {std::pair{"6", 6U}, {"18", 18U}, {"26", 26U}}) {
    FeltBench bench(FreeAxes());
    RunProcedure(Shipped("poses"), {{"poses", poses}, {"rest_s", 7.0}}, bench);
    ASSERT_EQ(bench.rests.size(), count + 1U);
    std::set<std::array<long, 3>> directions;
    Vector3 sum = {};
    for (std::size_t i = 1; i < bench.rests.size(); ++i) {
      EXPECT_EQ(bench.rest_s[i], 7.0);
      const Vector3& up = bench.rests[i];
      directions.insert(
          {std::lround(1e3 * up[0]), std::lround(1e3 * up[1]), std::lround(1e3 * up[2])});
      for (std::size_t k = 0; k < 3; ++k) sum[k] += up[k];
    }
    EXPECT_EQ(directions.size(), count);
    for (const double s : sum) EXPECT_NEAR(s, 0.0, 1e-9) << "each direction has its opposite";
  }
}

// A command line gives 6 as a number.
TEST(Poses, TakesItsChoicesAsNumbersToo) {
  EXPECT_EQ(DryRun(Shipped("poses"), {{"poses", 6.0}}, FreeAxes()).segments.size(),
            DryRun(Shipped("poses"), {{"poses", "6"}}, FreeAxes()).segments.size());
  EXPECT_THAT(RefusalOf("poses", {{"poses", 7.0}}, FreeAxes()),
              HasSubstr("expected one of 6, 18, 26"));
}

TEST(Poses, LeavesOutWhatAStandCannotDoAndNamesIt) {
  const Plan plan = DryRun(Shipped("poses"), {{"poses", "6"}}, ThreeAxes());
  EXPECT_THAT(plan.notes, ::testing::Contains(AllOf(HasSubstr("left out, -z up"),
                                                    HasSubstr("limits -80 .. 90 deg"))));
  FeltBench bench;
  RunProcedure(Shipped("poses"), {{"poses", "6"}}, bench);
  EXPECT_EQ(bench.rests.size(), 6U);
}

TEST(Poses, AdaptsToAMissingOuterOrInnerAxis) {
  FeltBench no_outer(AxesNamed({"middle", "inner"}));
  RunProcedure(Shipped("poses"), {{"poses", "6"}}, no_outer);
  EXPECT_EQ(no_outer.rests.size(), 6U);
  EXPECT_THAT(RefusalOf("poses", {{"poses", "6"}}, AxesNamed({"outer", "middle"})),
              HasSubstr("the stand has no inner axis"));
}

TEST(Poses, RefusesAOneAxisTableBeforeMotion) {
  EXPECT_THAT(RefusalOf("poses", {}, AxesNamed({"inner"})),
              AllOf(HasSubstr("the stand can take 1 of these poses"),
                    HasSubstr("no outer and no middle axis")));
}

}  // namespace
}  // namespace gyrobench::procedures

// The procedures and the examples that users get.
#include "tests/procedures/shipped.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "procedures/engine/commands.h"
#include "procedures/engine/dry_bench.h"
#include "tests/procedures/fake_bench.h"

namespace gyrobench::procedures {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;

std::string ReadFile(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

// Texts of the ```lua blocks of a document.
std::vector<std::string> LuaBlocks(const std::string& document) {
  const std::string open = "```lua\n";
  std::vector<std::string> blocks;
  for (std::size_t at = document.find(open); at != std::string::npos;) {
    const std::size_t begin = at + open.size();
    const std::size_t end = document.find("```", begin);
    blocks.push_back(document.substr(begin, end - begin));
    at = document.find(open, end);
  }
  return blocks;
}

TEST(Shipped, AllProceduresAreInOrder) {
  const auto list = ProcedureLibrary({kShippedFolder}).List();
  EXPECT_GE(list.size(), 7U);
  for (const ProcedureInfo& info : list) {
    EXPECT_EQ(info.problem, "") << info.name;
    EXPECT_EQ(info.measures.empty(), info.commissions) << info.name;
    EXPECT_NO_THROW(DryRun(Shipped(info.name), {}, ThreeAxes())) << info.name;
  }
}

class PlanOf : public ::testing::TestWithParam<const char*> {};

// The plan is by formula, the fake bench moves step by step.
TEST_P(PlanOf, TakesTheTimeThatTheRunTakes) {
  FakeBench bench;
  RunProcedure(Shipped(GetParam()), {}, bench);
  const Plan plan = DryRun(Shipped(GetParam()), {}, ThreeAxes());
  EXPECT_NEAR(plan.duration_s, bench.ElapsedS(),
              1e-6 + 2e-3 * static_cast<double>(plan.moves.size()));
  ASSERT_EQ(plan.moves.size(), bench.turns.size());
  for (std::size_t i = 0; i < plan.moves.size(); ++i) {
    EXPECT_NEAR(plan.moves[i].to_deg - plan.moves[i].from_deg, bench.turns[i].angle_deg, 1e-9);
  }
  EXPECT_LE(plan.expected_duration_s, plan.duration_s);
}

INSTANTIATE_TEST_SUITE_P(Shipped, PlanOf,
                         ::testing::Values("bias", "scale", "poses", "hold", "rates", "full",
                                           "sweep", "thermal"));

TEST(Bias, AsksForCoolingAndPlacingThenRestsAndSoaks) {
  FakeBench bench;
  RunProcedure(Shipped("bias"),
               {{"initial_rest_s", 30.0},
                {"drift_degC", 0.2},
                {"window_s", 90.0},
                {"max_duration_s", 1800.0}},
               bench);
  bench.calls.pop_back();  // what it says at the end
  EXPECT_THAT(bench.calls, ElementsAre("ask cool", "ask place", "rest", "soak"));
  EXPECT_EQ(bench.soaks.at(0).drift_degC, 0.2);
  EXPECT_EQ(bench.soaks.at(0).window_s, 90.0);
  EXPECT_EQ(bench.soaks.at(0).max_s, 1800.0);
  EXPECT_EQ(bench.ElapsedS(), 1830.0);
  EXPECT_THAT(Shipped("bias").info().measures, ElementsAre("bias"));
}

TEST(Bias, SaysWhenTheTemperatureDidNotSettle) {
  FakeBench bench;
  RunProcedure(Shipped("bias"), {}, bench);
  EXPECT_THAT(bench.LastSaid(), HasSubstr("settled at 21.50 degC"));
  bench.settles = false;
  RunProcedure(Shipped("bias"), {}, bench);
  EXPECT_THAT(bench.LastSaid(), HasSubstr("not settled"));
}

TEST(Bias, RefusesAWindowLongerThanTheRunBeforeAnythingIsAsked) {
  FakeBench bench;
  EXPECT_THROW(
      RunProcedure(Shipped("bias"), {{"window_s", 600.0}, {"max_duration_s", 60.0}}, bench),
      ScriptError);
  EXPECT_TRUE(bench.calls.empty());
}

TEST(Scale, TurnsTheShaftByWholeTurnsThereAndBackToTheStart) {
  FakeBench bench;
  bench.axes[1].angle_deg = 12.0;
  RunProcedure(Shipped("scale"), {{"axis", "middle"}, {"turns", 5.0}, {"rate_deg_s", 15.0}}, bench);
  ASSERT_EQ(bench.turns.size(), 10U);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(bench.turns[i].axis, "middle");
    EXPECT_DOUBLE_EQ(bench.turns[i].angle_deg, i < 5 ? 6.0 : -6.0);
    EXPECT_EQ(bench.turns[i].rate_deg_s, 15.0);
  }
  EXPECT_NEAR(bench.axes[1].angle_deg, 12.0, 1e-9);
  EXPECT_EQ(bench.fractions.size(), 10U);
  EXPECT_TRUE(std::is_sorted(bench.fractions.begin(), bench.fractions.end()));
  EXPECT_EQ(bench.fractions.back(), 1.0);
}

TEST(Scale, HasARestBeforeAndAfterEveryTurn) {
  FakeBench bench;
  RunProcedure(Shipped("scale"), {{"turns", 3.0}}, bench);
  ASSERT_EQ(bench.calls.size(), 13U);
  for (std::size_t i = 0; i < bench.calls.size(); ++i) {
    EXPECT_EQ(bench.calls[i], i % 2 == 0 ? "rest" : "turn inner");
  }
}

TEST(Scale, IsRefusedDryWhereItWouldPassASoftLimitOrARate) {
  const auto refusal = [](const Parameters& parameters) {
    return MessageOf<LimitError>([&] { DryRun(Shipped("scale"), parameters, ThreeAxes()); });
  };
  EXPECT_EQ(refusal({}), "");
  EXPECT_THAT(
      refusal({{"turns", 41.0}}),
      MatchesRegex("scale.lua:[0-9]+: axis.inner: 369 deg is beyond the soft limit 360 deg.*"));
  EXPECT_THAT(
      refusal({{"rate_deg_s", 41.0}}),
      MatchesRegex("scale.lua:[0-9]+: axis.inner: 41 deg/s is beyond the rate limit 40 deg/s"));
}

TEST(Readme, EveryLuaBlockRunsDry) {
  const auto blocks = LuaBlocks(ReadFile(kShippedFolder / "README.md"));
  EXPECT_GE(blocks.size(), 4U);
  for (const std::string& block : blocks) {
    const bool whole = block.find("procedure = {") != std::string::npos;
    const Procedure procedure =
        whole ? Procedure::FromSource("example", "example.lua", block) : Script(block);
    EXPECT_NO_THROW(DryRun(procedure, {}, ThreeAxes())) << block;
    FakeBench bench;
    EXPECT_NO_THROW(RunProcedure(procedure, {}, bench)) << block;
  }
}

TEST(Readme, MentionsEveryCommandAndEveryFunctionThatAScriptSees) {
  const std::string text = ReadFile(kShippedFolder / "README.md");
  for (const std::string& name : CommandNames()) EXPECT_THAT(text, HasSubstr("`bench." + name));
  FakeBench bench;
  RunProcedure(Script("local t = {} for name in pairs(_G) do t[#t + 1] = name end\n"
                      "bench.say(table.concat(t, ' '))"),
               {}, bench);
  std::istringstream names(bench.LastSaid());
  for (std::string name; names >> name;) {
    if (name == "_G" || name == "_VERSION" || name == "procedure" || name == "run") continue;
    EXPECT_THAT(text, HasSubstr(name));
  }
}

}  // namespace
}  // namespace gyrobench::procedures

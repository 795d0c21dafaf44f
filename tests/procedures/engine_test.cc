#include "procedures/engine/engine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "procedures/engine/commands.h"
#include "procedures/engine/dry_bench.h"
#include "tests/procedures/fake_bench.h"

namespace gyrobench::procedures {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

RunResult RunBody(FakeBench& bench, const std::string& body) {
  return RunProcedure(Script(body), {}, bench);
}

template <class E = ScriptError>
std::string Failure(FakeBench& bench, const std::string& body) {
  return MessageOf<E>([&] { RunBody(bench, body); });
}

constexpr const char* kTurn = "bench.turn{axis='inner', angle_deg=9, rate_deg_s=9}";

TEST(Commands, TurnPassesEveryFieldAndReturnsEveryOutcome) {
  FakeBench bench;
  RunBody(
      bench,
      "local t = bench.turn{axis='middle', angle_deg=-7, rate_deg_s=11, acceleration_deg_s2=13}\n"
      "bench.say(string.format('%.2f %.1f %s', t.moved_deg, t.rate_deg_s, t.duration_s > 0))");
  ASSERT_EQ(bench.turns.size(), 1U);
  EXPECT_EQ(bench.turns[0].axis, "middle");
  EXPECT_EQ(bench.turns[0].angle_deg, -7.0);
  EXPECT_EQ(bench.turns[0].rate_deg_s, 11.0);
  EXPECT_EQ(bench.turns[0].acceleration_deg_s2, 13.0);
  EXPECT_EQ(bench.LastSaid(), "-6.99 11.5 true");
}

TEST(Commands, AccelerationIsHalfOfTheAxisLimitUnlessGiven) {
  FakeBench bench;
  RunBody(bench, kTurn);
  EXPECT_EQ(bench.turns.at(0).acceleration_deg_s2, 40.0);
}

TEST(Commands, ShaftTurnsAreDividedByTheGearRatioOfTheirAxis) {
  FakeBench bench;
  RunBody(bench,
          "bench.turn{axis='inner', shaft_turns=-2, rate_deg_s=9}\n"
          "bench.turn{axis='middle', shaft_turns=0.5, rate_deg_s=9}");
  EXPECT_DOUBLE_EQ(bench.turns.at(0).angle_deg, -18.0);
  EXPECT_DOUBLE_EQ(bench.turns.at(1).angle_deg, 3.0);
}

TEST(Commands, MoveToGoesToTheAngleAndThenNoFurther) {
  FakeBench bench;
  RunBody(bench,
          "bench.move_to{axis='outer', angle_deg=-20, rate_deg_s=9}\n"
          "bench.move_to{axis='outer', angle_deg=-20, rate_deg_s=9}");
  ASSERT_EQ(bench.turns.size(), 1U);
  EXPECT_DOUBLE_EQ(bench.axes[0].angle_deg, -20.0);
}

TEST(Commands, ARestOfNoTimeIsNoSegment) {
  FakeBench bench;
  RunBody(bench, "bench.rest{duration_s=0} bench.rest{duration_s=3}");
  EXPECT_THAT(bench.calls, ElementsAre("rest"));
  EXPECT_EQ(bench.ElapsedS(), 3.0);
}

TEST(Commands, SoakPassesItsFieldsAndOutcome) {
  FakeBench bench;
  bench.settles = false;
  RunBody(bench,
          "local s = bench.soak{drift_degC=0.2, window_s=30, min_s=40, max_s=50}\n"
          "bench.say(string.format('%s %.1f %.0f', s.settled, s.temperature_degC, s.duration_s))");
  const SoakCommand& soak = bench.soaks.at(0);
  EXPECT_THAT((std::vector<double>{soak.drift_degC, soak.window_s, soak.min_s, soak.max_s}),
              ElementsAre(0.2, 30.0, 40.0, 50.0));
  EXPECT_EQ(bench.LastSaid(), "false 21.5 50");
}

TEST(Commands, AskPassesTheQuestionAndReturnsTheAnswer) {
  FakeBench bench;
  bench.answers["id1"] = "b";
  RunBody(bench, "bench.say(bench.ask{id='id1', text='Which?', choices={'a','b'}, timeout_s=7})");
  EXPECT_EQ(bench.LastSaid(), "b");
  EXPECT_EQ(bench.questions.at(0).text, "Which?");
  EXPECT_THAT(bench.questions.at(0).choices, ElementsAre("a", "b"));
  EXPECT_EQ(bench.questions.at(0).timeout_s, 7.0);
}

TEST(Commands, EstimatesAreNilUntilThereIsOne) {
  FakeBench bench;
  bench.estimates["scale_factor"] = {true, 0.5, 0.25, "deg/s per LSB"};
  RunBody(bench,
          "assert(bench.estimate('bias') == nil)\n"
          "local e = bench.estimate('scale_factor')\n"
          "bench.say(e.value .. ' ' .. e.std_error .. ' ' .. e.unit)");
  EXPECT_EQ(bench.LastSaid(), "0.5 0.25 deg/s per LSB");
}

TEST(Commands, TemperatureAndTimeAreTheBenchs) {
  FakeBench bench;
  RunBody(bench,
          "bench.rest{duration_s=5} bench.say(bench.temperature() .. ' ' .. bench.elapsed())");
  EXPECT_EQ(bench.LastSaid(), "21.5 5.0");
  bench.temperature_degC = std::numeric_limits<double>::quiet_NaN();
  RunBody(bench, "assert(bench.temperature() == nil)");
}

TEST(Commands, AxesGiveEveryFact) {
  FakeBench bench;
  RunBody(bench,
          "local a = bench.axes().middle\n"
          "assert(a.name == 'middle' and a.gear_ratio == 60 and a.angle_deg == 2)\n"
          "assert(a.min_deg == -80 and a.max_deg == 90)\n"
          "assert(a.max_rate_deg_s == 30 and a.max_acceleration_deg_s2 == 100)");
}

TEST(Commands, WrongFieldsAreRefusedWithLineAndTheKnownOnes) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"bench.turn{axis='inner', angel_deg=9, rate_deg_s=9}",
       "bench.turn: unknown field \"angel_deg\" (did you mean angle_deg?); fields: axis"},
      {"bench.rest{duration_s='5'}", "bench.rest: duration_s = \"5\": expected a number"},
      {"bench.rest{}", "bench.rest: duration_s is missing: expected a number"},
      {"bench.rest(5)", "bench.rest: expected a table { ... } with the fields duration_s, got 5"},
      {"bench.rest{5}", "bench.rest: 5 stands without a name; fields: duration_s"},
      {"bench.rest{duration_s=0/0}", "bench.rest: duration_s ="},
      {"bench.rest{duration_s=math.huge}", "bench.rest: duration_s = inf: expected a finite"},
      {"bench.turn{axis='inner', rate_deg_s=9}", "bench.turn: expected either angle_deg"},
      {"bench.turn{axis='inner', rate_deg_s=9, angle_deg=1, shaft_turns=1}", "expected either"},
      {"bench.turn{axis='inner', rate_deg_s=9, angle_deg=0}", "a turn by 0 deg is none"},
      {"bench.turn{axis=3, rate_deg_s=9, angle_deg=1}", "bench.turn: axis = 3: expected a text"},
      {"bench.ask{id='x', text='y', choices='z'}", "choices = \"z\": expected a list of texts"},
      {"bench.ask{id='x', text='y', choices={{}}}", "bench.ask.choices[1]: expected a text"},
      {"bench.ask{id='x', text='y', timeout_s=-1}", "timeout_s = -1: expected a number above 0"},
      {"bench.estimate('scale')",
       "bench.estimate: \"scale\" is not known (did you mean scale_factor"},
      {"bench.progress(1.5)", "bench.progress: expected a number 0 .. 1, got 1.5"},
      {"bench.progress(0/0)", "bench.progress: expected a number 0 .. 1"},
      {"bench.say{}", "bench.say: expected a text, got a table"},
      {"bench.say('\\xff')", "bench.say: expected UTF-8 text"},
      {"bench.limit{name='x', value=1}", "bench.limit: expected min, max or both"},
      {"bench.limit{name='x', value=1, min=2, max=1}", "bench.limit: min = 2 is above max = 1"},
      {"bench.limit{name='x', min=2}", "bench.limit: value is missing"},
      {"bench:rest{duration_s=1}", "bench:rest: write bench.rest, with a dot"},
      {"bench.rest({duration_s=1}, 2)", "bench.rest takes one value, got 2"},
      {"bench.trun{}", "bench.trun: there is no such command; commands: "},
      {"table.sort({1,2}, function() bench.elapsed() end)",
       "cannot be called from within table.sort"},
  };
  for (const auto& [body, message] : cases) {
    FakeBench bench;
    EXPECT_THAT(Failure(bench, "\n" + body), AllOf(StartsWith("try.lua:3: "), HasSubstr(message)))
        << body;
    EXPECT_TRUE(bench.calls.empty()) << body;
  }
}

TEST(Commands, ImpossibleTimesAreLimitErrors) {
  for (const char* body :
       {"bench.rest{duration_s=-1}", "bench.rest{duration_s=1e9}", "bench.soak{max_s=-1}",
        "bench.soak{max_s=10, window_s=20}", "bench.soak{max_s=300, min_s=400}",
        "bench.soak{max_s=300, drift_degC=0}"}) {
    FakeBench bench;
    EXPECT_THAT(Failure<LimitError>(bench, body), StartsWith("try.lua:2: ")) << body;
    EXPECT_TRUE(bench.calls.empty()) << body;
  }
}

TEST(Engine, ErrorsOfTheScriptCarryFileAndLine) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"local x = nil\nreturn x.y", "try.lua:3: attempt to index a nil value (local 'x')"},
      {"error('own')", "try.lua:2: own"},
      {"error('bare', 0)", "try.lua:2: bare"},
      {"error()", "try.lua:2: error() was called with a value of type nil"},
      {"error({})", "try.lua:2: error() was called with a value of type table"},
      {"\n\nbench.fail('hands off')", "try.lua:4: hands off"},
      {"assert(false, 'asserted')", "try.lua:2: asserted"},
  };
  for (const auto& [body, message] : cases) {
    FakeBench bench;
    EXPECT_THAT(Failure(bench, body), StartsWith(message)) << body;
  }
}

TEST(Engine, AScriptErrorTellsFileAndLineApart) {
  FakeBench bench;
  try {
    RunBody(bench, "\n\nerror('x')");
    FAIL();
  } catch (const ScriptError& error) {
    ASSERT_TRUE(error.place());
    EXPECT_EQ(error.place()->file, "try.lua");
    EXPECT_EQ(error.place()->line, 4);
  }
}

TEST(Engine, AnErrorInAHelperNamesTheLineOfTheCommand) {
  FakeBench bench;
  EXPECT_THAT(Failure(bench, "local function wait(s)\nbench.rest{duration=s}\nend\nwait(1)"),
              StartsWith("try.lua:3: bench.rest: unknown field"));
}

template <class E>
void ExpectEndsTheRun(const std::string& thrown, const std::string& seen) {
  FakeBench bench;
  bench.on_turn = [&] { throw E(thrown); };
  const std::string body = std::string("\nlocal ok = pcall(function() ") + kTurn +
                           " end)\nbench.say('went on')\n" + kTurn;
  EXPECT_EQ(MessageOf<E>([&] { RunBody(bench, body); }), seen);
  EXPECT_TRUE(bench.turns.empty());
  EXPECT_EQ(bench.LastSaid(), "");
}

// The type says what kind of end it is, the message is whole, and the script cannot go on.
TEST(Engine, WhatTheBenchThrowsEndsTheRunWithItsTypeAndTheScriptsLine) {
  ExpectEndsTheRun<LimitError>("axis.inner: beyond", "try.lua:3: axis.inner: beyond");
  ExpectEndsTheRun<DeviceError>("axis.inner: silent", "try.lua:3: axis.inner: silent");
  ExpectEndsTheRun<DataError>("record: disk full", "try.lua:3: record: disk full");
  ExpectEndsTheRun<ConfigError>("key", "try.lua:3: key");
  ExpectEndsTheRun<Error>("other", "try.lua:3: other");
  class OwnFault : public DeviceError {
   public:
    using DeviceError::DeviceError;
  };
  ExpectEndsTheRun<OwnFault>("exception 03", "try.lua:3: exception 03");
}

TEST(Engine, WhatTheBenchThrowsKeepsItsFieldsAndHasTheScriptsPlace) {
  FakeBench bench;
  bench.on_turn = [] {
    throw DeviceError("exception 03", {.device = "axis.inner drive", .address = 0x6200});
  };
  try {
    RunBody(bench, kTurn);
    FAIL();
  } catch (const DeviceError& error) {
    EXPECT_EQ(error.failure().device, "axis.inner drive");
    EXPECT_EQ(error.failure().address, 0x6200);
    ASSERT_TRUE(error.place());
    EXPECT_EQ(error.place()->file, "try.lua");
    EXPECT_EQ(error.place()->line, 2);
  }
}

TEST(Engine, AnAbortAndForeignExceptionsComeThroughAsTheyAre) {
  ExpectEndsTheRun<Aborted>("aborted by the operator", "aborted by the operator");
  ExpectEndsTheRun<std::logic_error>("foreign", "foreign");
}

TEST(Engine, AnAbortInTheMiddleEndsTheRunAtTheNextSafePoint) {
  FakeBench bench;
  int points = 0;
  bench.on_safe_point = [&] {
    if (++points > 3) throw Aborted("stop");
  };
  EXPECT_THROW(RunBody(bench, std::string("while true do pcall(function() ") + kTurn + " end) end"),
               Aborted);
  EXPECT_EQ(bench.turns.size(), 3U);
}

TEST(Engine, AnAbortAfterTheLastCommandCounts) {
  FakeBench bench;
  bench.on_safe_point = [&] {
    if (!bench.turns.empty()) throw Aborted("stop");
  };
  EXPECT_THROW(RunBody(bench, kTurn), Aborted);
}

TEST(Engine, TellsLineAndNameOfEveryCommand) {
  FakeBench bench;
  RunHooks hooks;
  std::vector<std::string> seen;
  hooks.on_command = [&](int line, const std::string& name) {
    seen.push_back(std::to_string(line) + " " + name);
  };
  const auto result = RunProcedure(Script("bench.elapsed()\nbench.say('x')"), {}, bench, hooks);
  EXPECT_THAT(seen, ElementsAre("2 bench.elapsed", "3 bench.say"));
  EXPECT_EQ(result.commands, 2);
}

TEST(Limits, BothEndsPassAndTheRunPasses) {
  FakeBench bench;
  const RunResult result =
      RunBody(bench,
              "assert(bench.limit{name='a', value=1, min=1, max=2, unit='LSB'} == true)\n"
              "assert(bench.limit{name='b', value=2, max=2})\n"
              "assert(bench.limit{name='c', value=2, min=2})");
  EXPECT_EQ(result.outcome, RunOutcome::kPassed);
  ASSERT_EQ(bench.checks.size(), 3U);
  EXPECT_EQ(bench.checks[0].unit, "LSB");
  EXPECT_EQ(Describe(bench.checks[0]), "a = 1 LSB: PASS (1 .. 2 LSB)");
}

TEST(Limits, OneFailureFailsTheLimitsButNotTheRun) {
  FakeBench bench;
  const RunResult result = RunBody(bench,
                                   "assert(not bench.limit{name='a', value=3, max=2})\n"
                                   "bench.limit{name='b', value=1, max=2}\nbench.say('went on')");
  EXPECT_EQ(result.outcome, RunOutcome::kFailedLimits);
  EXPECT_EQ(result.checks.size(), 2U);
  EXPECT_EQ(bench.LastSaid(), "went on");
}

TEST(Limits, NotANumberNeverPasses) {
  FakeBench bench;
  EXPECT_EQ(RunBody(bench, "bench.limit{name='a', value=0/0, min=-math.maxinteger}").outcome,
            RunOutcome::kFailedLimits);
  EXPECT_EQ(RunBody(bench, "bench.limit{name='a', value=math.huge, max=1}").outcome,
            RunOutcome::kFailedLimits);
  EXPECT_THROW(RunBody(bench, "bench.limit{name='a', value=1, min=0/0}"), ScriptError);
}

TEST(Engine, ParametersReachTheScriptWithTheirTypes) {
  const Procedure script = Procedure::FromSource("typed", "typed.lua", R"(
procedure = { summary = "s", parameters = {
  { name = "n", type = "number", default = 1.5, help = "h" },
  { name = "i", type = "integer", default = 3, help = "h" },
  { name = "c", type = "choice", default = "a", choices = { "a", "b" }, help = "h" },
  { name = "t", type = "text", default = "", help = "h" },
  { name = "b", type = "boolean", default = false, help = "h" } } }
function run(p)
  bench.say(p.n .. " " .. math.type(p.i) .. p.i .. " " .. p.c .. " " .. p.t .. " " .. tostring(p.b))
end)");
  FakeBench bench;
  RunProcedure(script, {}, bench);
  EXPECT_EQ(bench.LastSaid(), "1.5 integer3 a  false");
  RunProcedure(script, {{"n", 2.5}, {"i", 7.0}, {"c", "b"}, {"t", "x y"}, {"b", true}}, bench);
  EXPECT_EQ(bench.LastSaid(), "2.5 integer7 b x y true");
}

TEST(Engine, WrongParametersAreRefusedBeforeTheScriptStarts) {
  FakeBench bench;
  EXPECT_THROW(RunProcedure(Script("bench.say('started')"), {{"x", 1.0}}, bench), ParameterError);
  EXPECT_TRUE(bench.calls.empty());
}

// Every field has a value of its own, so that a swap shows.
TEST(TraceCommand, GivesTheScriptVerdictsEffectsParametersAndRivals) {
  FakeBench bench;
  bench.verdicts = {{"z",
                     "partly_explained",
                     "two words",
                     {{"angle.latency",
                       "bench",
                       {{"tau", 0.003, 0.001, "s"}, {"second", 7.0, 2.0, "deg"}},
                       {"angle.clock_drift", "angle.backlash"},
                       "reverse"}}}};
  RunProcedure(Script(R"(
    local z = bench.trace().z
    local e = z.effects[1]
    bench.say(table.concat({z.axis, z.verdict, z.summary, #z.effects, e.id, e.owner, e.settled_by,
      #e.parameters, e.parameters[1].name, e.parameters[1].value, e.parameters[1].std_error,
      e.parameters[1].unit, e.parameters[2].name, #e.rivals, e.rivals[1], e.rivals[2]}, " ")))"),
               {}, bench);
  EXPECT_EQ(bench.LastSaid(),
            "z partly_explained two words 1 angle.latency bench reverse 2 tau 0.003 0.001 s second "
            "2 angle.clock_drift angle.backlash");
}

TEST(TraceCommand, IsNilWhileThereIsNothingToTraceAndTakesNoArgument) {
  FakeBench bench;
  RunProcedure(Script("bench.say(tostring(bench.trace()))"), {}, bench);
  EXPECT_EQ(bench.LastSaid(), "nil");
  const std::string error =
      MessageOf<Error>([&] { RunProcedure(Script("bench.trace{ axis = 'z' }"), {}, bench); });
  EXPECT_NE(error.find("bench.trace: takes nothing"), std::string::npos) << error;
}

TEST(TraceCommand, OfADryRunFindsNothingAndTakesNoTime) {
  const Plan plan = DryRun(Script(R"(
    for _, axis in ipairs{ "x", "y", "z" } do
      local traced = bench.trace()[axis]
      assert(traced.verdict == "none" and #traced.effects == 0)
    end)"),
                           {}, ThreeAxes());
  EXPECT_EQ(plan.duration_s, 0.0);
  EXPECT_TRUE(plan.segments.empty());
}

}  // namespace
}  // namespace gyrobench::procedures

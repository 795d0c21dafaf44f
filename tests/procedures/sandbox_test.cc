// A script is a stranger's: whatever it does, files, processes and the daemon's life are out of its
// reach.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "procedures/engine/engine.h"
#include "tests/procedures/fake_bench.h"

namespace gyrobench::procedures {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

RunHooks SmallLimits() {
  RunHooks hooks;
  hooks.limits.instructions_per_step = 200'000;
  hooks.limits.memory_bytes = std::size_t{8} << 20;
  hooks.limits.processor_s_per_step = 5.0;
  hooks.max_commands = 1000;
  return hooks;
}

// Runs a script's body under small limits; the message of its ScriptError, empty when it ended
// well.
std::string Failure(FakeBench& bench, const std::string& body) {
  return MessageOf<ScriptError>([&] { RunProcedure(Script(body), {}, bench, SmallLimits()); });
}

std::string Failure(const std::string& body) {
  FakeBench bench;
  return Failure(bench, body);
}

TEST(Sandbox, HasNothingThatReachesFilesProcessesCodeOrTime) {
  for (const char* name : {"io",
                           "os",
                           "package",
                           "debug",
                           "require",
                           "dofile",
                           "load",
                           "loadfile",
                           "loadstring",
                           "collectgarbage",
                           "coroutine",
                           "setmetatable",
                           "getmetatable",
                           "rawset",
                           "rawget",
                           "rawlen",
                           "rawequal",
                           "print",
                           "warn",
                           "xpcall",
                           "utf8",
                           "arg",
                           "string.dump",
                           "string.find",
                           "string.match",
                           "string.gmatch",
                           "string.gsub",
                           "string.pack",
                           "string.unpack",
                           "table.move",
                           "math.randomseed"}) {
    EXPECT_EQ(Failure(std::string("assert(") + name + " == nil)"), "") << name;
  }
}

TEST(Sandbox, StringMethodsAreTheKeptOnesOnly) {
  EXPECT_EQ(Failure("assert((''):upper() == '') assert(('x').dump == nil and ('x').find == nil)"),
            "");
  EXPECT_THAT(Failure("return ('x'):find('y')"), HasSubstr("attempt to call a nil value"));
}

TEST(Sandbox, OneScriptLeavesNothingBehindForTheNext) {
  EXPECT_EQ(Failure("string.upper = nil secret = 1 bench.rest = nil"), "");
  EXPECT_EQ(Failure("assert(secret == nil and string.upper and bench.rest)"), "");
}

TEST(Sandbox, PrecompiledCodeIsRefused) {
  EXPECT_THROW(Procedure::FromSource("binary", "binary.lua", "\x1bLua\x54"), ScriptError);
}

TEST(Sandbox, EndlessLoopsAreStoppedWithTheirLine) {
  for (const char* body :
       {"while true do end", "pcall(function() while true do end end)",
        "while true do pcall(function() while true do end end) end",
        "local function f() return pcall(f) end while true do f() end",
        "table.sort({1,2,3}, function() while true do end end)",
        "pcall(table.sort, {1,2,3}, function() while true do pcall(error) end end)",
        "for _ in function() return 1 end do end",
        "local t <close> = nil; while true do pcall(error, 'x') end", "::again:: goto again"}) {
    EXPECT_THAT(Failure(body), StartsWith("try.lua:2: the script computed")) << body;
  }
}

TEST(Sandbox, AStoppedScriptDoesNotMoveAgain) {
  FakeBench bench;
  Failure(bench,
          "pcall(function() while true do end end)\n"
          "bench.turn{axis='inner', angle_deg=9, rate_deg_s=9}");
  EXPECT_TRUE(bench.turns.empty());
}

TEST(Sandbox, MemoryBombsEndAsAnErrorNotAsTheProcess) {
  for (const char* body :
       {"local s = 'x' while true do s = s .. s end",
        "pcall(function() local s = 'x' while true do s = s .. s end end)",
        "while true do pcall(function() local s = 'x' while true do s = s .. s end end) end",
        "local t = {} for i = 1, 1e9 do t[i] = ('x'):rep(1000) .. i end",
        "local t = {} while true do t[#t + 1] = ('x'):rep(1000000) .. #t end",
        "local t = {} for i = 1, 8 do t[i] = ('x'):rep(1000000) end return table.concat(t, "
        "('y'):rep(1000000))"}) {
    EXPECT_THAT(Failure(body), StartsWith("try.lua:2: the script needs more than 8 MB")) << body;
  }
}

TEST(Sandbox, AMemoryBombInPcallMovesNothingAfterwards) {
  FakeBench bench;
  Failure(bench,
          "pcall(function() local s = 'x' while true do s = s .. s end end)\n"
          "bench.turn{axis='inner', angle_deg=9, rate_deg_s=9}");
  EXPECT_TRUE(bench.turns.empty());
}

TEST(Sandbox, EndlessRecursionEndsAsAnError) {
  EXPECT_NE(Failure("local function f() return 1 + f() end f()"), "");
  EXPECT_NE(Failure("local function f() table.sort({1,2}, function() f() end) end f()"), "");
  EXPECT_NE(Failure("local function f(...) f(1, ...) end f()"), "");
}

// Each level's pcall could catch, and pass the error on, at a cost that grows with the depth.
TEST(Sandbox, EndlessRecursionThroughPcallEndsAsAnErrorToo) {
  for (const char* body : {"local function f() while true do pcall(f) end end f()",
                           "local function f() local ok = pcall(f) return f() + 1 end f()"}) {
    EXPECT_THAT(Failure(body), StartsWith("try.lua:2: the script ")) << body;
  }
}

TEST(Sandbox, DeeplyNestedSourceIsRefused) {
  const std::string deep = "x = " + std::string(5000, '(') + "1" + std::string(5000, ')');
  EXPECT_THAT(MessageOf<ScriptError>([&] { Procedure::FromSource("deep", "deep.lua", deep); }),
              StartsWith("deep.lua: "));
}

// string.rep loops once a repetition even for nothing; no instruction is counted meanwhile.
TEST(Sandbox, RepetitionsOfNothingAreBoundedToo) {
  EXPECT_THAT(Failure("(''):rep(1 << 62)"), HasSubstr("string.rep: more than"));
  EXPECT_THAT(Failure("string.rep('ab', 1 << 20)"), HasSubstr("string.rep: more than"));
  EXPECT_THAT(Failure("string.rep('', 1 << 40, '')"), HasSubstr("string.rep: more than"));
  EXPECT_EQ(Failure("assert(('ab'):rep(3, '-') == 'ab-ab-ab' and ('x'):rep(-1) == '')"), "");
}

TEST(Sandbox, LongWorkInOneLibraryCallEndsByProcessorTime) {
  RunHooks hooks;
  hooks.limits.processor_s_per_step = 0.05;
  FakeBench bench;
  const Procedure script = Script(
      "local t = {} for i = 1, 100000 do t[i] = 1 end\n"
      "while true do table.insert(t, 1, 1) end");
  EXPECT_THAT(MessageOf<ScriptError>([&] { RunProcedure(script, {}, bench, hooks); }),
              HasSubstr("without a bench command"));
}

TEST(Sandbox, ALoopOfCommandsWithoutEndIsStopped) {
  FakeBench bench;
  EXPECT_THAT(MessageOf<LimitError>([&] {
                RunProcedure(Script("while true do pcall(bench.elapsed) end"), {}, bench,
                             SmallLimits());
              }),
              StartsWith("try.lua:2: more than 1000 bench commands"));
}

TEST(Sandbox, InstructionsInAllAreBoundedAcrossCommands) {
  RunHooks hooks;
  hooks.limits.instructions = 1'000'000;
  FakeBench bench;
  const Procedure script = Script("while true do for i = 1, 10000 do end bench.elapsed() end");
  EXPECT_THAT(MessageOf<ScriptError>([&] { RunProcedure(script, {}, bench, hooks); }),
              HasSubstr("more than 1000000 instructions in all"));
}

TEST(Sandbox, TheTopLevelOfAScriptIsBoundedToo) {
  EXPECT_THAT(MessageOf<ScriptError>(
                  [] { Procedure::FromSource("loop", "loop.lua", "while true do end"); }),
              StartsWith("loop.lua:1: the script computed"));
}

// All comparisons of a sort are within one instruction, and each takes as long as its texts are.
TEST(Sandbox, ASortIsBoundedWhateverItCompares) {
  const std::string fill =
      "local t, s = {}, string.rep('x', 1000000)\n"
      "for i = 1, 100000 do t[i] = s end\n";
  for (const char* sort :
       {"table.sort(t)", "pcall(table.sort, t)", "table.sort(t, function(a, b) return a < b end)",
        "for i = 1, #t do t[i] = '1000' end table.sort(t, string.rep)"}) {
    RunHooks hooks;
    hooks.limits.processor_s_per_step = 0.2;
    FakeBench bench;
    const std::string body = fill + sort;
    EXPECT_THAT(MessageOf<ScriptError>([&] { RunProcedure(Script(body), {}, bench, hooks); }),
                HasSubstr("computed for more than 0.2 s"))
        << sort;
  }
}

TEST(Sandbox, ASortSortsAsLuaDoes) {
  EXPECT_EQ(
      Failure("local t = {3, 1, 2} table.sort(t) assert(table.concat(t) == '123')\n"
              "table.sort(t, function(a, b) return a > b end) assert(table.concat(t) == '321')\n"
              "table.sort(t, nil) assert(table.concat(t) == '123')\n"
              "local ok, why = pcall(table.sort, {1, 'a'}) assert(not ok and #why > 0)\n"
              "assert(not pcall(table.sort, t, 7) and not pcall(table.sort))"),
      "");
}

// Whatever a script does, and however often it says something in between.
TEST(Sandbox, ADryRunIsBoundedInAllAndGivenUpWhenNobodyWantsIt) {
  for (const char* body : {"while true do bench.elapsed() end", "while true do end"}) {
    RunHooks hooks;
    hooks.limits.processor_s = 0.2;
    hooks.max_commands = 1'000'000'000;
    hooks.limits.instructions_per_step = hooks.limits.instructions = 1'000'000'000'000;
    FakeBench bench;
    EXPECT_THAT(MessageOf<ScriptError>([&] { RunProcedure(Script(body), {}, bench, hooks); }),
                HasSubstr("more than 0.2 s in all"));
    hooks.limits.processor_s = 100.0;
    int asked = 0;
    hooks.limits.cancelled = [&] { return ++asked > 3; };
    EXPECT_THROW(RunProcedure(Script(body), {}, bench, hooks), Aborted);
  }
}

// The host itself allocates on the script's account.
TEST(Sandbox, AStateTooSmallForTheHostIsAnErrorNotAPanic) {
  const Procedure script = Script("bench.rest{duration_s=1}");
  for (std::size_t bytes = 1000; bytes < 60000; bytes += 1000) {
    RunHooks hooks;
    hooks.limits.memory_bytes = bytes;
    FakeBench bench;
    try {
      RunProcedure(script, {}, bench, hooks);
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("try.lua")) << bytes;
    }
  }
}

TEST(Sandbox, RandomNumbersAreTheSameInEveryRun) {
  const char* body = "bench.say(math.random(1, 1000000) .. ' ' .. math.random())";
  FakeBench first;
  FakeBench second;
  Failure(first, body);
  Failure(second, body);
  EXPECT_NE(first.LastSaid(), "");
  EXPECT_EQ(first.LastSaid(), second.LastSaid());
}

TEST(Sandbox, PcallPassesValuesAndErrorsOnAsLuaDoes) {
  EXPECT_EQ(Failure("local ok, a, b = pcall(function(x) return x, 2 end, 1)\n"
                    "assert(ok and a == 1 and b == 2)\n"
                    "local bad, why = pcall(error, {code = 7})\n"
                    "assert(not bad and why.code == 7)\n"
                    "assert(select('#', pcall(function() end)) == 1)"),
            "");
}

TEST(Sandbox, CommandsWorkWithinPcall) {
  FakeBench bench;
  EXPECT_EQ(Failure(bench,
                    "local ok, out = pcall(bench.turn, {axis='inner', angle_deg=9, rate_deg_s=9})\n"
                    "assert(ok and out.duration_s > 0)\n"
                    "assert(not pcall(function() bench.rest{duration_s=1} error('own') end))"),
            "");
  EXPECT_EQ(bench.turns.size(), 1U);
}

}  // namespace
}  // namespace gyrobench::procedures

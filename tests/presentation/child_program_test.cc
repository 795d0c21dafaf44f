#include "presentation/child_program.h"

#include <gtest/gtest.h>

namespace gyrobench::presentation {
namespace {

using namespace std::chrono_literals;

TEST(RunProgram, GivesTheInputAndBringsTheOutput) {
  const std::string input(300'000, 'x');  // more than a pipe holds
  const ProgramRun run = RunProgram({"cat"}, input, 30s);
  EXPECT_TRUE(run.started);
  EXPECT_EQ(run.exit_status, 0);
  EXPECT_EQ(run.out, input);
}

TEST(RunProgram, NeverAsksAShell) {
  EXPECT_EQ(RunProgram({"echo", "$(id) `id` ; id"}, "", 30s).out, "$(id) `id` ; id\n");
}

TEST(RunProgram, SurvivesAProgramThatDoesNotReadItsInput) {
  const ProgramRun run = RunProgram({"true"}, std::string(300'000, 'x'), 30s);
  EXPECT_EQ(run.exit_status, 0);
}

TEST(RunProgram, TellsErrorOutputAndStatus) {
  const ProgramRun run = RunProgram({"sh", "-c", "echo trouble >&2; exit 7"}, "", 30s);
  EXPECT_EQ(run.exit_status, 7);
  EXPECT_EQ(run.err, "trouble\n");
}

TEST(RunProgram, SaysWhereThereIsNoSuchProgram) {
  EXPECT_FALSE(RunProgram({"/nowhere/gnuplot"}, "", 30s).started);
}

TEST(RunProgram, EndsAProgramThatHangs) {
  EXPECT_TRUE(RunProgram({"sleep", "600"}, "", 50ms).timed_out);
}

TEST(RunProgram, EndsAProgramThatHangsAfterItClosedItsOutput) {
  EXPECT_TRUE(RunProgram({"sh", "-c", "exec sleep 600 >&-"}, "", 50ms).timed_out);
}

}  // namespace
}  // namespace gyrobench::presentation

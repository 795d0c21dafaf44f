// What a user meets first: help, errors, exit statuses. The built program is run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "tests/cli/child_process.h"
#include "tests/cli/fake_daemon.h"
#include "tests/cli/program.h"
#include "tests/temporary_folder.h"

namespace gyrobench::cli {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class EveryCommand : public testing::TestWithParam<const char*> {};

TEST_P(EveryCommand, ShowsAnExampleThatBeginsWithItsOwnName) {
  const Finished help = Gyrobench({GetParam(), "--help"});
  EXPECT_EQ(help.status, 0);
  EXPECT_THAT(help.out, HasSubstr("Example:\n  gyrobench " + std::string(GetParam())));
  EXPECT_THAT(help.out, HasSubstr("--json"));
}

TEST_P(EveryCommand, CallsAnUnknownOptionAnErrorOfUsage) {
  const Finished finished = Gyrobench({GetParam(), "--no-such-option"});
  EXPECT_EQ(finished.status, 2);
  EXPECT_THAT(finished.err, HasSubstr(std::string("gyrobench ") + GetParam()));
  EXPECT_THAT(finished.out, IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(All, EveryCommand,
                         testing::Values("procedures", "check", "run", "status", "watch", "pause",
                                         "resume", "abort", "answer", "stop", "reset", "runs",
                                         "show", "analyze", "export", "trace", "hold", "apply",
                                         "report"),
                         [](const auto& tested) { return std::string(tested.param); });

TEST(Gyrobench, ExplainsTheExitStatusesAndTheVersion) {
  EXPECT_THAT(Gyrobench({"--help"}).out, HasSubstr("3 the part failed its limits"));
  EXPECT_EQ(Gyrobench({"--version"}).status, 0);
}

TEST(Gyrobench, CallsAMissingOrUnknownCommandAnErrorOfUsage) {
  EXPECT_EQ(Gyrobench({}).status, 2);
  const Finished finished = Gyrobench({"calibrate"});
  EXPECT_EQ(finished.status, 2);
  EXPECT_THAT(finished.err, HasSubstr("calibrate"));
}

TEST(Gyrobench, SaysHowToNameTheBenchWhenItIsNotTold) {
  const Finished finished = Gyrobench({"status"});
  EXPECT_EQ(finished.status, 2);
  EXPECT_THAT(finished.err, HasSubstr("--config"));
  EXPECT_THAT(finished.err, HasSubstr("GYROBENCH_CONFIG"));
  EXPECT_THAT(finished.err, HasSubstr("--socket"));
}

TEST(Gyrobench, NamesTheSocketAndTheCommandWhenNoDaemonRuns) {
  const TemporaryFolder folder;
  const std::string socket = folder / "control.sock";
  const Finished finished = Gyrobench({"status", "--socket", socket});
  EXPECT_EQ(finished.status, 1);
  EXPECT_THAT(finished.err, HasSubstr(socket));
  EXPECT_THAT(finished.err, HasSubstr("gyrobenchd --config"));
}

// A daemon that died leaves its socket behind.
TEST(Gyrobench, KnowsAnAbandonedSocket) {
  const TemporaryFolder folder;
  const std::string socket = folder / "control.sock";
  {
    FakeDaemon daemon(folder / "other.sock", [](const FakeRequest&) { return FakeReply{}; });
    std::filesystem::create_hard_link(folder / "other.sock", socket);
  }
  const Finished finished = Gyrobench({"status", "--socket", socket});
  EXPECT_EQ(finished.status, 1);
  EXPECT_THAT(finished.err, HasSubstr("not running"));
}

TEST(Gyrobench, NamesTheGroupAndModeOfASocketThatItMayNotOpen) {
  if (geteuid() == 0) GTEST_SKIP() << "root may open every socket";
  const TemporaryFolder folder;
  FakeDaemon daemon(folder / "control.sock", [](const FakeRequest&) { return FakeReply{}; });
  std::filesystem::permissions(folder / "control.sock", std::filesystem::perms::none);
  const Finished finished = Gyrobench({"status", "--socket", folder / "control.sock"});
  EXPECT_EQ(finished.status, 1);
  EXPECT_THAT(finished.err, HasSubstr("group"));
  EXPECT_THAT(finished.err, HasSubstr("mode 0000"));
}

TEST(Gyrobench, PassesOnWhatTheStandFileIsNotRightIn) {
  const TemporaryFolder folder;
  const auto file = folder.Write("stand.toml", "records = 3\n");
  const Finished finished = Gyrobench({"status", "--config", file});
  EXPECT_EQ(finished.status, 1);
  EXPECT_THAT(finished.err, HasSubstr("stand.toml:1"));
}

TEST(Gyrobench, RefusesAParameterThatIsNoKeyAndValue) {
  const Finished finished = Gyrobench({"run", "scale", "-p", "turns", "--socket", "none"});
  EXPECT_EQ(finished.status, 2);
  EXPECT_THAT(finished.err, HasSubstr("key=value"));
}

TEST(Gyrobench, KnowsWhatAMistypedCommandWasMeantToBe) {
  EXPECT_THAT(Gyrobench({"trase", "x.csv"}).err, HasSubstr("did you mean \"trace\"?"));
  EXPECT_THAT(Gyrobench({"frobnicate"}).err, Not(HasSubstr("did you mean")));
}

TEST(Gyrobench, SaysHowAParameterIsGiven) {
  const Finished finished = Gyrobench({"run", "scale", "turns=20"});
  EXPECT_EQ(finished.status, 2);
  EXPECT_THAT(finished.err, HasSubstr("-p turns=20"));
  EXPECT_THAT(Gyrobench({"run", "scale", "--turns=20"}).err, HasSubstr("-p turns=20"));
}

TEST(Gyrobench, OffersAParameterToCommandsThatTakeOneOnly) {
  EXPECT_THAT(Gyrobench({"watch", "x=1"}).err, Not(HasSubstr("-p ")));
}

TEST(Gyrobench, TakesTheWordHelpForAQuestion) {
  const Finished finished = Gyrobench({"help"});
  EXPECT_EQ(finished.status, 0);
  EXPECT_EQ(finished.out, Gyrobench({"--help"}).out);
}

TEST(Gyrobench, SaysWhatASeedIs) {
  for (const char* command : {"trace", "report"}) {
    for (const char* seed : {"x", "1.5", "7 ", "-1", "99999999999999999999"}) {
      const Finished finished = Gyrobench({command, "a.csv", std::string("--seed=") + seed});
      EXPECT_EQ(finished.status, 2);
      EXPECT_THAT(finished.err, HasSubstr("expected a whole number from 0 on, found '"));
    }
  }
}

TEST(Gyrobench, SaysWhatUnitNumbersAndBaudRatesAre) {
  for (const char* units : {"0", "248", "5-1", "1-", "-3", "1-31,x", "1 2"}) {
    const Finished finished = Gyrobench({"devices", std::string("--units=") + units});
    EXPECT_EQ(finished.status, 2) << units;
    EXPECT_THAT(finished.err, HasSubstr("expected unit numbers of 1 to 247")) << units;
  }
  for (const char* baud : {"31", "250000", "x", "9600,7"}) {
    const Finished finished = Gyrobench({"devices", std::string("--baud=") + baud});
    EXPECT_EQ(finished.status, 2) << baud;
    EXPECT_THAT(finished.err, HasSubstr("is no baud rate that can be set here")) << baud;
  }
}

TEST(Gyrobench, SaysWhatIsNoTableAndNoRun) {
  const Finished no_file = Gyrobench({"analyze", "absent.csv"});
  EXPECT_EQ(no_file.status, 1);
  EXPECT_THAT(no_file.err, HasSubstr("absent.csv"));
  const TemporaryFolder folder;
  const Finished no_run = Gyrobench({"analyze", "20200101-000000-scale", "--records", folder / ""});
  EXPECT_EQ(no_run.status, 1);
  EXPECT_THAT(no_run.err, HasSubstr("20200101-000000-scale"));
}

}  // namespace
}  // namespace gyrobench::cli

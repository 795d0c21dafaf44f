// A run is not begun, nor gone on with, where its record would not find room.
#include "daemon/disk_room.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <chrono>

#include "base/error.h"
#include "tests/daemon/fake_bench.h"
#include "tests/daemon/slow_disk.h"
#include "tests/temporary_folder.h"

namespace gyrobench::daemon {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(DiskRoom, IsThatOfTheNearestFolderThatIsThere) {
  const TemporaryFolder folder;
  EXPECT_THAT(WhyNoRoom(folder / "records", 0.0), IsEmpty());
  EXPECT_THAT(WhyNoRoom(folder / "not" / "there" / "yet", 1e9),
              testing::AllOf(HasSubstr("not/there/yet"), HasSubstr("expected at least 1e+09 MiB")));
}

TEST(DiskRoom, ARunEndsAsAFaultWhenItRunsOutOfItAndNoOtherBegins) {
  FakeBench bench;
  bench.Script("rests", "bench.rest{ duration_s=80000 }");
  bench.engine->Start("rests", {});
  bench.Wait(60.0);
  ASSERT_TRUE(bench.control.run_is_on());
  {
    const LittleRoom little(50 * 1024 * 1024);
    // The disk lives in real time, and is looked at once a second of it: the run is a long one.
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!bench.control.fault() && std::chrono::steady_clock::now() < deadline) bench.Wait(0.001);
    const RunView run = bench.Ended();
    EXPECT_EQ(run.outcome, Outcome::kFault);
    EXPECT_THAT(run.progress.message, HasSubstr("50.0 MiB are free"));
    bench.engine->Reset();
    EXPECT_THROW(bench.engine->Start("rests", {}), DataError);
    EXPECT_EQ(bench.control.state(), State::kIdle);
  }
  bench.engine->Start("rests", {});
}

TEST(DiskRoom, ADiskThatFailsToSayIsSaidAndOneFailureIsNone) {
  const TemporaryFolder folder;
  {
    const FailingDisk interrupted(EINTR, 1);
    EXPECT_THAT(WhyNoRoom(folder / "records", 0.0), IsEmpty());
  }
  const FailingDisk failing(EIO);
  EXPECT_THAT(WhyNoRoom(folder / "records", 0.0),
              testing::AllOf(HasSubstr("cannot be asked how much room it has"),
                             HasSubstr("Input/output error (3 tries)"), HasSubstr("records")));
}

TEST(DiskRoom, AFolderThatCannotBeLookedAtIsNotTakenForOneThatIsNotThere) {
  const TemporaryFolder folder;
  const UnreadableFolder records(folder / "records", EIO);
  EXPECT_THAT(WhyNoRoom(folder / "records", 0.0), HasSubstr("Input/output error"));
}

TEST(DiskRoom, ARunEndsAsAFaultWhenTheDiskFailsToSayAndNoOtherBegins) {
  FakeBench bench;
  bench.Script("rests", "bench.rest{ duration_s=80000 }");
  bench.engine->Start("rests", {});
  bench.Wait(60.0);
  ASSERT_TRUE(bench.control.run_is_on());
  const FailingDisk failing(EIO);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!bench.control.fault() && std::chrono::steady_clock::now() < deadline) bench.Wait(0.001);
  const RunView run = bench.Ended();
  EXPECT_EQ(run.outcome, Outcome::kFault);
  EXPECT_THAT(run.progress.message, HasSubstr("record: "));
  EXPECT_THAT(run.progress.message, HasSubstr("cannot be asked how much room it has"));
  bench.engine->Reset();
  EXPECT_THROW(bench.engine->Start("rests", {}), DataError);
  EXPECT_EQ(bench.control.state(), State::kIdle);
}

}  // namespace
}  // namespace gyrobench::daemon

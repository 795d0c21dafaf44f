// A run is not begun, nor gone on with, where its record would not find room.
#include "daemon/disk_room.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  EXPECT_THAT(TooLittleRoom(folder / "records", 0.0), IsEmpty());
  EXPECT_THAT(TooLittleRoom(folder / "not" / "there" / "yet", 1e9),
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

}  // namespace
}  // namespace gyrobench::daemon

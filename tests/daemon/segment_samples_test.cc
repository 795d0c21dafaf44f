// A segment of a run has the gyro's samples to its end.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "gyrobench/gyro_t.hpp"
#include "gyrobench/run_t.hpp"
#include "tests/daemon/fake_bench.h"
#include "tests/daemon/published.h"

namespace gyrobench::daemon {
namespace {

// A silence is told only after a second, and its samples are gone: a turn in whose last moments it
// began must not pass for a whole one.
TEST(Segment, ATurnThatCountsHasTheGyroThroughoutItsMotion) {
  constexpr Utime kTurn = FromSeconds(90.0 / 3.0), kSample = FromSeconds(1.0 / 200.0);
  for (double after_begin_s = 28.0; after_begin_s < 29.3; after_begin_s += 0.2) {
    SCOPED_TRACE(after_begin_s);
    FakeBench bench;
    bench.Script("turns",
                 "bench.rest{ duration_s=20 }\n"
                 "bench.turn{ axis='inner', angle_deg=90, rate_deg_s=3 }\n"
                 "bench.rest{ duration_s=20 }\n"
                 "bench.turn{ axis='inner', angle_deg=-90, rate_deg_s=3 }\n"
                 "bench.rest{ duration_s=20 }");
    bench.engine->Start("turns", {});
    ASSERT_TRUE(bench.InnerTurns());
    bench.Wait(after_begin_s);
    bench.devices.gyro->faults().FailAlways("no answer");
    bench.Wait(5.0);
    bench.devices.gyro->faults().Recover();
    const RunView run = bench.Ended();
    ASSERT_EQ(run.outcome, Outcome::kDone) << run.progress.message;
    const auto events = EventsOf(std::filesystem::path(run.record) / "events.lcmlog");
    std::set<Utime> samples;
    for (const gyro_t& block : MessagesOn<gyro_t>("TEST_GYRO", events))
      samples.insert(block.sample_utime.begin(), block.sample_utime.end());
    int turns = 0;
    for (const run_t& message : MessagesOn<run_t>("TEST_RUN", events)) {
      if (message.event != run_t::SEGMENT_END || message.segment_kind != "turn") continue;
      ++turns;
      for (Utime at = message.segment_begin_utime; at < message.segment_begin_utime + kTurn;) {
        const auto next = samples.upper_bound(at);
        ASSERT_NE(next, samples.end());
        ASSERT_LE(*next - at, 2 * kSample) << ToSeconds(at - message.segment_begin_utime);
        at = *next;
      }
    }
    EXPECT_EQ(turns, 2);
  }
}

}  // namespace
}  // namespace gyrobench::daemon

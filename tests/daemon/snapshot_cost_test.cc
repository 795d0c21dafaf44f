// What a bus may have to wait for while a snapshot of the run is taken. Counted, not timed.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "calibration/estimators/analyzer.h"
#include "tests/daemon/long_measurement.h"
#include "tests/drivers/allocation_count.h"

namespace gyrobench::daemon {
namespace {

constexpr double kHour_s = 3600.0;

// Of the dearest of 120 snapshots, one a second from `begin_s` on.
std::int64_t BytesOfASnapshot(LongMeasurement& measurement, calibration::Analyzer& analyzer,
                              double begin_s) {
  std::int64_t most = 0;
  for (int i = 0; i < 120; ++i) {
    measurement.FeedUntil(begin_s + i, analyzer);
    const std::int64_t before = BytesAllocatedByThisThread();
    const auto snapshot = std::make_shared<const calibration::Analyzer>(analyzer);
    most = std::max(most, BytesAllocatedByThisThread() - before);
  }
  return most;
}

// All that grows with the run is shared in chunks; a pointer to each is what is left of it.
TEST(Snapshot, CopiesAsMuchAfterTenHoursAsAfterHalfAnHour) {
  LongMeasurement measurement(20.0);
  calibration::Analyzer analyzer;
  analyzer.OnInfo(LongMeasurement::Info());
  const std::int64_t early = BytesOfASnapshot(measurement, analyzer, 0.5 * kHour_s);
  const std::int64_t late = BytesOfASnapshot(measurement, analyzer, 10.0 * kHour_s);
  const calibration::Recording recording = analyzer.Take();
  EXPECT_GT(recording.columns.nodes.size(), 350'000u);
  EXPECT_GT(recording.columns.rests.size(), 1'500u);
  // Nodes and rests of the part that is still open.
  const std::int64_t open_chunk = 1024 * static_cast<std::int64_t>(sizeof(calibration::Rest));
  EXPECT_LT(late, early + open_chunk);
}

}  // namespace
}  // namespace gyrobench::daemon

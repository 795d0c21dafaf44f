// Measured data: channels that carry little of the motion.
#include <gtest/gtest.h>

#include <filesystem>

#include "calibration/signal/clock_offset.h"
#include "calibration/trace/trace.h"
#include "recording/replay.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;

// The sensor turns about its y axis; x and z feel a hundredth of that. What the encoder and its
// gear do is in them as well, a hundred times smaller, and must not be found.
TEST(TraceOfAMeasuredTurn, NamesNoEffectOfTheReferenceOnTheAxesThatDoNotTurn) {
  const std::filesystem::path file = std::filesystem::path(GYROBENCH_SOURCE_DIR) /
                                     "../shared/datasets/stepper-encoder-y-slow.csv.gz";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no recording at ../shared/datasets";
  calibration::Collector collector;
  recording::ReplayTable(file, collector);
  const calibration::Recording recording = collector.Take();
  const calibration::Recording* const list[] = {&recording};
  calibration::TraceOptions options;
  options.curves = false;
  const calibration::TraceResult result = calibration::Trace(list, options).result;
  for (const ChannelTrace& channel : result.channels) {
    if (channel.axis == SensorAxis::kY) continue;
    for (const calibration::TracedEffect& effect : channel.effects) {
      EXPECT_FALSE(effect.id.starts_with("angle.") || effect.id.starts_with("scale.") ||
                   effect.id.starts_with("bandwidth."))
          << effect.id << " of gyro "
          << "xyz"[static_cast<std::size_t>(channel.axis)];
    }
  }
}

// One clock for both: motion that repeats with the encoder of a stepper and a hand's are no
// occasion for a remark.
TEST(TraceOfMeasuredData, SaysNothingOfClocks) {
  const auto folder = std::filesystem::path(GYROBENCH_SOURCE_DIR) / "../shared/datasets";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no recordings at ../shared/datasets";
  int recordings = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".gz") continue;
    ++recordings;
    calibration::Collector collector;
    recording::ReplayTable(entry.path(), collector);
    EXPECT_EQ(calibration::RemarkOnClocks(collector.Take()), "") << entry.path();
  }
  EXPECT_GT(recordings, 0);
}

}  // namespace
}  // namespace gyrobench::testing

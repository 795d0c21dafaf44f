// A direction of gravity that no pose shows has no number, not the number 0.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "calibration/trace/trace.h"
#include "tests/calibration/synthetic_bench.h"

namespace gyrobench::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

// Tilted about its own x axis alone: gravity lies along y and z, never along x.
TEST(BlindGravity, OfATermThatTheModelHoldsAtZeroIsNotKnown) {
  Motion motion;
  motion.Rest(30.0);
  for (int i = 0; i < 3; ++i) motion.ThereAndBack(kInnerAxis, 360.0, 20.0 + 5.0 * i);
  for (int i = 0; i < 12; ++i) motion.Turn(kMiddleAxis, i < 6 ? 60.0 : -60.0, 30.0).Rest(10.0);
  BenchSensor sensor;
  sensor.three_channels = true;
  const SyntheticBench bench(motion, sensor);
  const auto gravity = [](const BenchState& state) { return 0.3 * state.g[1]; };
  const calibration::Recording recording = bench.Measure({gravity, {}}, 5);
  const std::array<const calibration::Recording*, 1> inputs = {&recording};
  const calibration::TraceResult result = calibration::Trace(inputs).result;
  ASSERT_TRUE(result.vector.g_sensitivity);
  const calibration::GSensitivity& found = *result.vector.g_sensitivity;
  ASSERT_TRUE(found.in_model[2]);
  EXPECT_NEAR(found.value[2][1], 0.3, 0.01);
  EXPECT_GT(found.std_error[2][1], 0.0);
  EXPECT_TRUE(std::isnan(found.value[2][0])) << found.value[2][0];
  EXPECT_TRUE(std::isnan(found.std_error[2][0]));
  EXPECT_THAT(found.because, Contains(HasSubstr("x: the poses do not tell gravity along it")));
}

}  // namespace
}  // namespace gyrobench::testing

// A direction of gravity that no pose shows has no number, not the number 0.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "calibration/artefact/trace_json.h"
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

  // In the effect's own list, and in the JSON made of it: null with the reason, where there is no
  // number, and no reason where there is one.
  const auto written = nlohmann::json(calibration::ToJson(result));
  std::set<std::string> held, determined;
  for (const nlohmann::json& channel : written.at("channels")) {
    for (const nlohmann::json& effect : channel.at("effects")) {
      if (effect.at("id") != "bias.g_linear" || channel.at("gyro") != "z") continue;
      for (const nlohmann::json& parameter : effect.at("parameters")) {
        const bool known = parameter.at("std_error").is_number();
        EXPECT_EQ(parameter.at("value").is_number(), known) << parameter;
        EXPECT_EQ(parameter.contains("because"), !known) << parameter;
        (known ? determined : held).insert(parameter.at("name").get<std::string>());
      }
    }
  }
  EXPECT_THAT(held, Contains("k_x"));
  EXPECT_THAT(determined, Contains("k_y"));
}

}  // namespace
}  // namespace gyrobench::testing

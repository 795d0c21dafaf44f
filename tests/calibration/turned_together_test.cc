// Axes of the sensor that turn only together, as on a table with one axis and a crooked sensor.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "calibration/trace/trace.h"
#include "kinematics/stand_frame.h"
#include "tests/calibration/trace_once.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

struct Value {
  double value = kMissing, std_error = kMissing;
};

Value ParameterOf(const calibration::ChannelTrace& channel, const std::string& name) {
  for (const calibration::ModelParameter& parameter : channel.baseline.parameters) {
    if (parameter.name == name) return {parameter.value, parameter.std_error};
  }
  return {};
}

// The mounting is declared, so that x and y are known to turn a little with z. What they show of it
// is their nominal scale factor, and nothing tells theirs.
TEST(AxesThatTurnOnlyTogether, HaveOneScaleFactorThatIsTheirOwn) {
  constexpr double kScale = 1.01;
  for (const double mount_deg : {0.5, 2.0, 8.0}) {
    Story story;
    story.info.geometry.mount_deg[0] = mount_deg;
    story.info.geometry.mount_deg[1] = -0.7 * mount_deg;
    const Matrix3 felt = kinematics::StandFrame(story.info.geometry).Rates({0.0, 0.0, 0.0});
    for (std::size_t c = 0; c < 3; ++c) story.scale[c] = kScale * felt[c][2];
    const calibration::TraceResult result = TraceAll(story.Collect());
    ASSERT_EQ(result.channels.size(), 3u);
    for (const calibration::ChannelTrace& channel : result.channels) {
      EXPECT_EQ(channel.verdict, calibration::Verdict::kNone) << channel.summary;
      const bool is_z = channel.axis == SensorAxis::kZ;
      const Value scale = ParameterOf(channel, "scale_factor");
      EXPECT_EQ(std::isfinite(scale.value), is_z);
      if (is_z) {
        EXPECT_NEAR(scale.value, kScale, 4.0 * scale.std_error) << mount_deg;
        continue;
      }
      const auto c = static_cast<std::size_t>(channel.axis);
      const Value part = ParameterOf(channel, c == 0 ? "cross_axis_xz" : "cross_axis_yz");
      EXPECT_NEAR(part.value, (kScale - 1.0) * felt[c][2] / felt[2][2], 4.0 * part.std_error)
          << mount_deg;
    }
  }
}

}  // namespace
}  // namespace gyrobench::testing

// Axes of the sensor that turn only together, as on a table with one axis and a crooked sensor.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
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

// The Earth turns it as well, by the same scale factor, and once.
TEST(AxesThatTurnOnlyTogether, AreTurnedByTheEarthOnce) {
  constexpr double kEarth_deg_s = 15.041 / 3600.0, kLatitude_rad = 0.9, kRadPerDeg = 0.0174532925;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Story story;
    story.seed = seed;
    story.duration_s = 400.0;
    story.white_deg_s = 0.005;
    story.info.site_latitude_deg = kLatitude_rad / kRadPerDeg;
    story.info.geometry.mount_deg[0] = 0.5;
    story.info.geometry.mount_deg[1] = -0.3;
    const Matrix3 felt = kinematics::StandFrame(story.info.geometry).Rates({0.0, 0.0, 0.0});
    for (std::size_t c = 0; c < 3; ++c) story.scale[c] = felt[c][2];
    // World x points north, and the tilt is too small to matter.
    story.spoil_gyro = [angle_deg = story.angle_deg](GyroSample* sample) {
      const double turned_rad = kRadPerDeg * angle_deg(sample->t_s);
      const double north_deg_s = kEarth_deg_s * std::cos(kLatitude_rad);
      sample->xi[0] += 131.0 * north_deg_s * std::cos(turned_rad);
      sample->xi[1] -= 131.0 * north_deg_s * std::sin(turned_rad);
      sample->xi[2] += 131.0 * kEarth_deg_s * std::sin(kLatitude_rad);
      return true;
    };
    for (const calibration::ChannelTrace& channel : TraceAll(story.Collect()).channels) {
      EXPECT_EQ(channel.verdict, calibration::Verdict::kNone) << channel.summary << seed;
      EXPECT_LT(channel.fitted_whitened_rms.after, 1.05) << channel.summary << seed;
    }
  }
}

// Nothing is declared, and the sensor sits crooked: the angles that are proposed are those of the
// mounting, to what they print, and none are where axes are as square as data sheets say.
TEST(AxesThatTurnOnlyTogether, ShowAMountingThatNobodyDeclared) {
  struct Case {
    double x_deg, y_deg;
    std::string proposal;
  };
  for (const Case& one :
       {Case{2.0, -1.4, "mount_x_deg = 2.00 and mount_y_deg = -1.40"},
        Case{-8.0, 5.6, "mount_x_deg = -8.00 and mount_y_deg = 5.60"}, Case{0.5, -0.35, ""}}) {
    StandGeometry crooked;
    crooked.mount_deg[0] = one.x_deg;
    crooked.mount_deg[1] = one.y_deg;
    const Matrix3 felt = kinematics::StandFrame(crooked).Rates({0.0, 0.0, 0.0});
    Story story;
    for (std::size_t c = 0; c < 3; ++c) story.scale[c] = 1.01 * felt[c][2];
    const calibration::TraceResult result = TraceAll(story.Collect());
    std::string all;
    for (const std::string& remark : result.vector.remarks) all += remark + "\n";
    if (one.proposal.empty()) {
      EXPECT_EQ(all.find("tilted"), std::string::npos) << all;
    } else {
      EXPECT_NE(all.find(one.proposal), std::string::npos) << all;
    }
  }
}

}  // namespace
}  // namespace gyrobench::testing

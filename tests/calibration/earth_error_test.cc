// What the Earth's rotation may be of a sensitivity to gravity, where poses at rest are all that
// there is: gravity is the accelerometer's, and no heading is known. Only the vertical part counts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "calibration/signal/collector.h"
#include "calibration/trace/trace.h"

namespace gyrobench::testing {
namespace {

using calibration::ModelParameter;
using calibration::TracedEffect;

constexpr double kVariance = (15.041 / 3600.0) * (15.041 / 3600.0) / 3.0;  // (deg/s)^2

using Up = std::array<double, 3>;  // gravity along x, y, z [g]

// A minute in each pose, in turn, ten times; nothing between them. Sensitivity: k . g.
calibration::Recording Held(const std::vector<Up>& poses, const Up& k_deg_s_per_g,
                            double accelerometer_noise_g) {
  calibration::Collector collector;
  MeasurementInfo info;
  info.source = "poses.csv";
  info.gyro_unit = RateUnit::kDegPerSecond;
  info.gyro_present = {false, false, true};
  info.accel_present = {true, true, true};
  collector.OnInfo(info);
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise;
  for (int n = 0; n < 120'000; ++n) {
    const Up& up = poses.at(static_cast<std::size_t>(n / 6'000) % poses.size());
    GyroSample sample;
    sample.t_s = 0.01 * n;
    sample.xi[2] = 0.3 + 0.01 * noise(random);
    for (std::size_t c = 0; c < 3; ++c) {
      sample.xi[2] += k_deg_s_per_g.at(c) * up.at(c);
      sample.accel_g[c] = up.at(c) + accelerometer_noise_g * noise(random);
    }
    collector.OnGyro(sample);
  }
  return collector.Take();
}

struct Sensitivity {
  std::vector<ModelParameter> k;  // of x, y, z; empty where it is not named
  std::array<double, 3> model_variance = {};
};

Sensitivity SensitivityFrom(const calibration::Recording& recording) {
  const calibration::Recording* const inputs[] = {&recording};
  const calibration::Traced traced = calibration::Trace(inputs);
  const calibration::ChannelModel& model = traced.models.at(0);
  const std::vector<TracedEffect>& effects = traced.result.channels.at(0).effects;
  const auto named = std::ranges::find(effects, "bias.g_linear", &TracedEffect::id);
  if (named == effects.end()) return {};
  Sensitivity out{named->parameters, {}};
  for (std::size_t c = 0; c < 3; ++c) {
    const std::string name = "bias.g_linear." + out.k.at(c).name;
    const auto at = std::ranges::find(model.parameter_names, name);
    const auto i = static_cast<std::size_t>(at - model.parameter_names.begin());
    out.model_variance.at(c) = model.covariance.at(i * model.parameter_names.size() + i);
  }
  return out;
}

double Square(double value) { return value * value; }

// `axes`: where the Earth's vertical part goes, whole in each.
void ExpectCounted(const Sensitivity& found, const std::vector<std::size_t>& axes) {
  ASSERT_EQ(found.k.size(), 3U);
  for (std::size_t c = 0; c < 3; ++c) {
    const ModelParameter& k = found.k.at(c);
    if (k.because) continue;
    const double earth = std::ranges::count(axes, c) > 0 ? kVariance : 0.0;
    EXPECT_NEAR(Square(k.std_error) - Square(k.statistical_std_error), earth, 1e-3 * kVariance)
        << k.name;
    EXPECT_NEAR(found.model_variance.at(c) - Square(k.bound), earth, 1e-3 * kVariance) << k.name;
  }
}

TEST(SensitivityOfHeldPoses, CountsTheVerticalPartOfTheEarthAlongItsOwnAxis) {
  const std::vector<Up> poses = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                 {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
  const Sensitivity found = SensitivityFrom(Held(poses, {0.05, -0.08, 0.06}, 0.002));
  ExpectCounted(found, {2});
  for (const ModelParameter& k : found.k) EXPECT_TRUE(std::isfinite(k.std_error)) << k.name;
}

// On one circle, as an accelerometer without noise shows it, g_x + g_y + g_z is 1, and an offset is
// one with equal sensitivities to all. The model holds the last of what depends on others at 0: the
// Earth is w in the offset and -w in both of the other sensitivities.
TEST(SensitivityOfHeldPoses, CountsAllOfItWhereTheAxisItselfIsHeldAtNothing) {
  constexpr double kTwo = 2.0 / 3.0, kOne = -1.0 / 3.0;
  const std::vector<Up> poses = {{1, 0, 0},          {kTwo, kTwo, kOne}, {0, 1, 0},
                                 {kOne, kTwo, kTwo}, {0, 0, 1},          {kTwo, kOne, kTwo}};
  const Sensitivity found = SensitivityFrom(Held(poses, {0.05, -0.08, 0.0}, 0.0));
  ASSERT_EQ(found.k.size(), 3U);
  EXPECT_TRUE(found.k.at(2).because.has_value());
  for (const std::size_t c : {0U, 1U}) EXPECT_FALSE(found.k.at(c).because.has_value()) << c;
  ExpectCounted(found, {0, 1});
}

}  // namespace
}  // namespace gyrobench::testing

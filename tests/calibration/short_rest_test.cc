#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "calibration/estimators/analyzer.h"

namespace gyrobench::calibration {
namespace {

// The first result of a run rests on ten seconds: too few pieces for the longest polynomial. It
// must be the offset of each axis all the same, not that of some column of the fit.
TEST(ShortRest, TheOffsetOfEachAxisIsItsMeanOutput) {
  constexpr std::array<double, 3> kOffset_lsb = {-270.0, -157.0, 241.0};
  MeasurementInfo info;
  info.gyro_present = {true, true, true};
  info.temperature_present = true;
  info.gyro_units_per_deg_s = 131.0;
  Analyzer analyzer;
  analyzer.OnInfo(info);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 6.0);
  for (int i = 0; i < 2000; ++i) {
    GyroSample sample;
    sample.t_s = 0.005 * i;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sample.xi[axis] = std::round(kOffset_lsb[axis] + noise(random));
    }
    sample.temperature_degC = -9.5 + 0.18 * sample.t_s;
    analyzer.OnGyro(sample);
  }
  const AnalysisResult result = analyzer.Result();
  ASSERT_EQ(result.bias.size(), 3u);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const BiasResult& bias = result.bias[axis];
    ASSERT_FALSE(bias.coefficients.empty());
    // The mean of 2000 samples of 6 LSB is good to 0.13 LSB; a polynomial's value at the middle to
    // less than ten times that.
    EXPECT_NEAR(bias.coefficients[0], kOffset_lsb[axis], 1.3);
    EXPECT_LT(bias.residual_rms, 3.0);
  }
}

}  // namespace
}  // namespace gyrobench::calibration

#include "daemon/result_messages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace gyrobench::daemon {
namespace {

// Every field has a value of its own, so that a swap shows.
TEST(ResultMessages, EveryFieldOfAScaleResultArrivesWhereItBelongs) {
  calibration::ScaleResult result;
  result.axis = SensorAxis::kY;
  result.turns = 41;
  result.alpha = 1;
  result.alpha_std_error = 2;
  result.scale_error = 3;
  result.bias = 4;
  result.bias_std_error = 5;
  result.alpha_bias_covariance = 6;
  result.bias_temperature_degC = 7;
  result.residual_rms_deg = 8;
  result.whitened_rms = 9;
  result.paper_alpha = 10;
  result.paper_alpha_std_error = 11;
  result.paper_first_rest_alpha = 12;
  result.min_rate_deg_s = 13;
  result.max_rate_deg_s = 14;
  result.min_temperature_degC = 15;
  result.max_temperature_degC = 16;
  result.noise = {17, 18, 19};
  result.tick_ratio = 20;
  result.tick_ratio_std_error = 21;
  const scale_result_t m = ToMessage(result);
  EXPECT_EQ(m.sensor_axis, 1);
  EXPECT_EQ(m.turns, 41);
  const std::vector<double> values = {m.alpha_deg_s_per_lsb,
                                      m.alpha_std_error,
                                      m.scale_error,
                                      m.bias_lsb,
                                      m.bias_std_error,
                                      m.alpha_bias_covariance,
                                      m.bias_temperature_degC,
                                      m.residual_rms_deg,
                                      m.whitened_rms,
                                      m.paper_alpha_deg_s_per_lsb,
                                      m.paper_alpha_std_error,
                                      m.paper_first_rest_alpha_deg_s_per_lsb,
                                      m.min_rate_deg_s,
                                      m.max_rate_deg_s,
                                      m.min_temperature_degC,
                                      m.max_temperature_degC,
                                      m.angle_random_walk_deg_sqrt_s,
                                      m.bias_random_walk_deg_s_sqrt_s,
                                      m.reference_deg,
                                      m.tick_ratio,
                                      m.tick_ratio_std_error};
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(values[i], static_cast<double>(i + 1));
}

// LCM encodes as many elements as the count says; short vectors must not make it read past their
// end.
TEST(ResultMessages, ABiasResultWithMissingErrorsIsPaddedNotOverread) {
  calibration::BiasResult result;
  result.coefficients = {1.0, 2.0, 3.0};
  result.std_errors = {0.1};
  const bias_result_t message = ToMessage(result);
  EXPECT_EQ(message.n, 3);
  EXPECT_EQ(message.order, 2);
  ASSERT_EQ(message.std_error.size(), 3u);
  EXPECT_TRUE(std::isnan(message.std_error[2]));
  ASSERT_EQ(message.covariance.size(), 3u);
  ASSERT_EQ(message.covariance[2].size(), 3u);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  EXPECT_EQ(message.encode(bytes.data(), 0, static_cast<int>(bytes.size())),
            static_cast<int>(bytes.size()));
}

}  // namespace
}  // namespace gyrobench::daemon

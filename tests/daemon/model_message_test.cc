#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "daemon/messages.h"

namespace gyrobench::daemon {
namespace {

constexpr double kUnits = 131.0;

// Of three parameters beside the row of M, whose errors are correlated.
constexpr std::array<std::array<double, 3>, 3> kCovariance = {
    {{4e-6, 1e-7, -2e-8}, {1e-7, 9e-8, 1e-9}, {-2e-8, 1e-9, 5e-9}}};

calibration::ChannelModel Channel(SensorAxis axis, double reference_degC) {
  calibration::ChannelModel model;
  model.axis = axis;
  model.units_per_deg_s = kUnits;
  model.reference_degC = reference_degC;
  model.bias_deg_s = {0.5, -0.03, 0.002};
  model.parameter_names = {"scale_factor", "zero_rate_offset", "offset_temperature_1",
                           "offset_temperature_2"};
  model.covariance.assign(16, 0.0);
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t l = 0; l < 3; ++l) model.covariance[4 * (k + 1) + l + 1] = kCovariance[k][l];
  return model;
}

calibration::Traced ThreeAxes() {
  calibration::Traced traced;
  for (const auto& [axis, reference_degC] :
       {std::pair{SensorAxis::kX, 25.0}, {SensorAxis::kY, 25.0}, {SensorAxis::kZ, 29.0}}) {
    traced.models.push_back(Channel(axis, reference_degC));
    calibration::ChannelTrace channel;
    channel.axis = axis;
    channel.heldout_whitened_rms.after = 1.01;
    channel.fitted_whitened_rms.after = 0.99;
    traced.result.channels.push_back(channel);
  }
  calibration::VectorMatrix matrix;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      matrix.a[i][j] = static_cast<double>(10 * i + j);
      matrix.a_std_error[i][j] = static_cast<double>(100 * i + j);
    }
  }
  traced.result.vector.matrix = matrix;
  return traced;
}

TEST(ModelMessage, IsSentOnlyWhereAllThreeAxesWereTurned) {
  calibration::Traced traced = ThreeAxes();
  EXPECT_TRUE(ModelMessage(traced));
  traced.result.vector.matrix.reset();
  EXPECT_FALSE(ModelMessage(traced));
}

TEST(ModelMessage, HasTheMatrixAsItIs) {
  const model_result_t message = *ModelMessage(ThreeAxes());
  EXPECT_EQ(message.a_deg_s_per_lsb[1][2], 12.0);
  EXPECT_EQ(message.a_std_error[2][1], 201.0);
  EXPECT_EQ(message.whitened_rms[0], 1.01);
}

// An axis whose offset is counted from another temperature has the same offset at every one.
TEST(ModelMessage, CountsAllOffsetsFromOneTemperature) {
  const calibration::Traced traced = ThreeAxes();
  const model_result_t message = *ModelMessage(traced);
  ASSERT_EQ(message.n, 3);
  EXPECT_EQ(message.reference_temperature_degC, 25.0);
  for (std::size_t c = 0; c < 3; ++c) {
    for (const double degC : {-20.0, 25.0, 31.0, 70.0}) {
      const double own = degC - traced.models[c].reference_degC, common = degC - 25.0;
      const auto& b = traced.models[c].bias_deg_s;
      EXPECT_NEAR(message.b_lsb[0][c] + message.b_lsb[1][c] * common +
                      message.b_lsb[2][c] * common * common,
                  kUnits * (b[0] + b[1] * own + b[2] * own * own), 1e-9);
    }
  }
}

// The constant's error is that of the offset at the common temperature, correlations and all.
TEST(ModelMessage, PropagatesTheErrorsToThatTemperature) {
  calibration::Traced traced = ThreeAxes();
  const double d = 25.0 - 29.0;
  const std::array<double, 3> at = {1.0, d, d * d};
  double variance = 0.0;
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t l = 0; l < 3; ++l) variance += at[k] * at[l] * kCovariance[k][l];
  EXPECT_NEAR(ModelMessage(traced)->b_std_error[0][2], kUnits * std::sqrt(variance), 1e-9);
  EXPECT_NEAR(ModelMessage(traced)->b_std_error[1][0], kUnits * std::sqrt(9e-8), 1e-9);
  traced.result.channels[2].fitted_whitened_rms.after = 1.5;
  EXPECT_NEAR(ModelMessage(traced)->b_std_error[0][2], 1.5 * kUnits * std::sqrt(variance), 1e-9);
}

TEST(ModelMessage, OfSeveralPowerOnsStatesNoErrorOfTheOffset) {
  calibration::Traced traced = ThreeAxes();
  traced.models[1].parameter_names[1] = "zero_rate_offset_run_1";
  EXPECT_TRUE(std::isnan(ModelMessage(traced)->b_std_error[0][1]));
}

TEST(ModelMessage, AChannelWithoutATemperatureHasZerosBeyondItsConstant) {
  calibration::Traced traced = ThreeAxes();
  traced.models[1].bias_deg_s = {0.5};
  const model_result_t message = *ModelMessage(traced);
  EXPECT_EQ(message.n, 3);
  EXPECT_EQ(message.b_lsb[0][1], 0.5 * kUnits);
  EXPECT_EQ(message.b_lsb[1][1], 0.0);
}

}  // namespace
}  // namespace gyrobench::daemon

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "daemon/messages.h"

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

calibration::ChannelTrace TracedChannel() {
  calibration::ChannelTrace channel;
  channel.axis = SensorAxis::kY;
  channel.verdict = calibration::Verdict::kPartlyExplained;
  channel.summary = "in words";
  channel.heldout_whitened_rms = {1, 2, {}};
  channel.heldout_angle_rms_deg = {3, 4, {}};
  calibration::TracedEffect effect;
  effect.id = "angle.latency";
  effect.origin = calibration::EffectOrigin::kComposed;
  effect.owner = calibration::EffectOwner::kBench;
  effect.parameters = {{"tau", 5, "s", 6, 7}, {"k", 8, "deg", kMissing, kMissing}};
  effect.p_value = 9;
  effect.rivals = {"angle.clock_drift"};
  effect.settled_by = "reverse";
  effect.heldout_whitened_rms = {10, 11, {}};
  effect.heldout_angle_rms_deg = {12, 13, {}};
  channel.effects = {effect, effect};
  channel.effects[1].id = "bias.step";
  return channel;
}

TEST(ResultMessages, ATraceIsAVerdictThenItsEffectsOneAMessage) {
  const std::vector<trace_result_t> messages = ToMessages(TracedChannel());
  ASSERT_EQ(messages.size(), 3u);
  for (const trace_result_t& message : messages) {
    EXPECT_EQ(message.sensor_axis, 1);
    EXPECT_EQ(message.verdict, "partly_explained");
    EXPECT_EQ(message.effect_count, 2);
  }
  EXPECT_EQ(messages[0].effect_index, -1);
  EXPECT_EQ(messages[0].summary, "in words");
  EXPECT_EQ(messages[0].whitened_rms_before, 1);
  EXPECT_EQ(messages[0].whitened_rms_after, 2);
  EXPECT_EQ(messages[0].angle_rms_deg_before, 3);
  EXPECT_EQ(messages[0].angle_rms_deg_after, 4);
  EXPECT_EQ(messages[1].effect_index, 0);
  EXPECT_EQ(messages[2].effect_index, 1);
  EXPECT_EQ(messages[2].effect_id, "bias.step");
}

TEST(ResultMessages, EveryFieldOfATracedEffectArrivesWhereItBelongs) {
  const trace_result_t message = ToMessages(TracedChannel())[1];
  EXPECT_EQ(message.effect_id, "angle.latency");
  EXPECT_EQ(message.origin, "composed");
  EXPECT_EQ(message.owner, "bench");
  EXPECT_EQ(message.n_parameters, 2);
  EXPECT_EQ(message.parameter_name, (std::vector<std::string>{"tau", "k"}));
  EXPECT_EQ(message.parameter_value, (std::vector<double>{5, 8}));
  EXPECT_EQ(message.parameter_std_error[0], 6);
  EXPECT_TRUE(std::isnan(message.parameter_std_error[1]));
  EXPECT_EQ(message.parameter_unit, (std::vector<std::string>{"s", "deg"}));
  EXPECT_EQ(message.p_value, 9);
  EXPECT_EQ(message.whitened_rms_before, 10);
  EXPECT_EQ(message.whitened_rms_after, 11);
  EXPECT_EQ(message.angle_rms_deg_before, 12);
  EXPECT_EQ(message.angle_rms_deg_after, 13);
  EXPECT_EQ(message.rivals, std::vector<std::string>{"angle.clock_drift"});
  EXPECT_EQ(message.n_rivals, 1);
  EXPECT_EQ(message.next_manoeuvre, "reverse");
}

}  // namespace
}  // namespace gyrobench::daemon

#include "daemon/result_messages.h"

namespace gyrobench::daemon {

bias_result_t ToMessage(const calibration::BiasResult& result) {
  bias_result_t message{};
  message.sensor_axis = static_cast<std::int8_t>(result.axis);
  message.reference_temperature_degC = result.reference_temperature_degC;
  message.min_temperature_degC = result.min_temperature_degC;
  message.max_temperature_degC = result.max_temperature_degC;
  message.n = static_cast<std::int8_t>(result.coefficients.size());
  message.order = static_cast<std::int8_t>(message.n - 1);
  // Encoding reads as many elements as n says, whatever the vector holds.
  const std::size_t n = result.coefficients.size();
  message.coefficient = result.coefficients;
  message.std_error = result.std_errors;
  message.std_error.resize(n, kMissing);
  message.covariance = result.covariance;
  message.covariance.resize(n);
  for (std::vector<double>& row : message.covariance) row.resize(n, kMissing);
  message.rms_error_lsb = result.rms_error;
  message.residual_rms_lsb = result.residual_rms;
  message.paper_n = static_cast<std::int8_t>(result.paper_coefficients.size());
  message.paper_coefficient = result.paper_coefficients;
  message.paper_rms_error_lsb = result.paper_rms_error;
  message.angle_random_walk_deg_sqrt_s = result.noise.angle_random_walk_deg_sqrt_s;
  message.bias_random_walk_deg_s_sqrt_s = result.noise.bias_random_walk_deg_s_sqrt_s;
  return message;
}

scale_result_t ToMessage(const calibration::ScaleResult& result) {
  scale_result_t message{};
  message.sensor_axis = static_cast<std::int8_t>(result.axis);
  message.turns = static_cast<std::int32_t>(result.turns);
  message.alpha_deg_s_per_lsb = result.alpha;
  message.alpha_std_error = result.alpha_std_error;
  message.scale_error = result.scale_error;
  message.bias_lsb = result.bias;
  message.bias_std_error = result.bias_std_error;
  message.alpha_bias_covariance = result.alpha_bias_covariance;
  message.bias_temperature_degC = result.bias_temperature_degC;
  message.residual_rms_deg = result.residual_rms_deg;
  message.whitened_rms = result.whitened_rms;
  message.paper_alpha_deg_s_per_lsb = result.paper_alpha;
  message.paper_alpha_std_error = result.paper_alpha_std_error;
  message.paper_first_rest_alpha_deg_s_per_lsb = result.paper_first_rest_alpha;
  message.min_rate_deg_s = result.min_rate_deg_s;
  message.max_rate_deg_s = result.max_rate_deg_s;
  message.min_temperature_degC = result.min_temperature_degC;
  message.max_temperature_degC = result.max_temperature_degC;
  message.angle_random_walk_deg_sqrt_s = result.noise.angle_random_walk_deg_sqrt_s;
  message.bias_random_walk_deg_s_sqrt_s = result.noise.bias_random_walk_deg_s_sqrt_s;
  message.reference_deg = result.noise.reference_deg;
  message.tick_ratio = result.tick_ratio;
  message.tick_ratio_std_error = result.tick_ratio_std_error;
  return message;
}

namespace {

void Set(trace_result_t& message, const calibration::HeldOut& whitened,
         const calibration::HeldOut& angle) {
  message.whitened_rms_before = whitened.before;
  message.whitened_rms_after = whitened.after;
  message.angle_rms_deg_before = angle.before;
  message.angle_rms_deg_after = angle.after;
}

trace_result_t VerdictMessage(const calibration::ChannelTrace& channel) {
  trace_result_t message{};
  message.sensor_axis = static_cast<std::int8_t>(channel.axis);
  message.verdict = Name(channel.verdict);
  message.effect_index = -1;
  message.effect_count = static_cast<std::int32_t>(channel.effects.size());
  message.p_value = kMissing;
  return message;
}

trace_result_t EffectMessage(const calibration::ChannelTrace& channel, std::size_t index) {
  const calibration::TracedEffect& effect = channel.effects[index];
  trace_result_t message = VerdictMessage(channel);
  message.effect_index = static_cast<std::int32_t>(index);
  message.effect_id = effect.id;
  message.origin = Name(effect.origin);
  message.owner = Name(effect.owner);
  message.n_parameters = static_cast<std::int32_t>(effect.parameters.size());
  for (const calibration::ModelParameter& parameter : effect.parameters) {
    message.parameter_name.push_back(parameter.name);
    message.parameter_value.push_back(parameter.value);
    message.parameter_std_error.push_back(parameter.std_error);
    message.parameter_unit.push_back(parameter.unit);
  }
  message.p_value = effect.p_value;
  Set(message, effect.heldout_whitened_rms, effect.heldout_angle_rms_deg);
  message.n_rivals = static_cast<std::int32_t>(effect.rivals.size());
  message.rivals = effect.rivals;
  message.next_manoeuvre = effect.settled_by;
  return message;
}

}  // namespace

std::vector<trace_result_t> ToMessages(const calibration::ChannelTrace& channel) {
  std::vector<trace_result_t> messages = {VerdictMessage(channel)};
  messages[0].summary = channel.summary;
  Set(messages[0], channel.heldout_whitened_rms, channel.heldout_angle_rms_deg);
  for (std::size_t i = 0; i < channel.effects.size(); ++i)
    messages.push_back(EffectMessage(channel, i));
  return messages;
}

}  // namespace gyrobench::daemon

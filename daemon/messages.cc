#include "daemon/messages.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

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

void FillMessage(const drivers::GyroBlock& block, const drivers::GyroIdentity& identity,
                 gyro_t& message) {
  const std::size_t n = block.samples.size();
  message.utime = block.utime;
  message.unit_tick = block.tick;
  message.tick_rate_hz = identity.tick_rate_hz;
  message.boot_count = block.boot_count;
  message.missed = block.missed;
  message.gyro_lsb_per_deg_s = identity.gyro_lsb_per_deg_s;
  message.accel_lsb_per_g = identity.accel_lsb_per_g;
  message.n = static_cast<std::int32_t>(n);
  message.first_counter = n == 0 ? 0 : block.samples.front().counter;
  message.sample_utime.resize(n);
  message.sample_tick.resize(n);
  message.temperature_degC.resize(n);
  message.gyro_lsb.resize(3);
  message.accel_lsb.resize(3);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    message.gyro_lsb[axis].resize(n);
    message.accel_lsb[axis].resize(n);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const drivers::GyroRawSample& sample = block.samples[i];
    message.sample_utime[i] = sample.utime;
    message.sample_tick[i] = sample.tick;
    message.temperature_degC[i] = static_cast<float>(sample.temperature_degC);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      message.gyro_lsb[axis][i] = sample.gyro_lsb[axis];
      message.accel_lsb[axis][i] = sample.accel_lsb[axis];
    }
  }
}

namespace {

using calibration::ChannelModel;

// Of sum_k b_k (T - T0)^k as a polynomial of T - T1: row j has the weights of b_k in the
// coefficient j, binomial(k, j) (T1 - T0)^(k - j).
std::vector<std::vector<double>> Shift(std::size_t n, double by_degC) {
  std::vector<std::vector<double>> weights(n, std::vector<double>(n, 0.0));
  for (std::size_t k = 0; k < n; ++k) {
    double weight = 1.0;
    for (std::size_t j = k + 1; j-- > 0;) {
      weights[j][k] = weight;
      weight *= by_degC * static_cast<double>(j) / static_cast<double>(k - j + 1);
    }
  }
  return weights;
}

// Covariances of the coefficients of b(T), which follow each other among the model's parameters;
// NaN where they do not, as with several power-ons.
double Covariance(const ChannelModel& model, std::size_t k, std::size_t l) {
  const auto& names = model.parameter_names;
  const auto first =
      static_cast<std::size_t>(std::ranges::find(names, "zero_rate_offset") - names.begin());
  const std::size_t place = (first + k) * names.size() + first + l;
  return first < names.size() && place < model.covariance.size() ? model.covariance[place]
                                                                 : kMissing;
}

// b(T) of one channel, about `reference_degC`; what the model does not have is 0, and certain.
// `grow`: of the standard errors, where the residual is larger than the noise explains.
void SetOffsets(const ChannelModel& model, double reference_degC, double grow, std::size_t channel,
                model_result_t* message) {
  const std::size_t n = model.bias_deg_s.size();
  const double by_degC = n > 1 ? reference_degC - model.reference_degC : 0.0;
  const std::vector<std::vector<double>> weights = Shift(n, by_degC);
  for (std::size_t j = 0; j < n; ++j) {
    double value = 0.0, variance = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      value += weights[j][k] * model.bias_deg_s[k];
      for (std::size_t l = 0; l < n; ++l) {
        const double weight = weights[j][k] * weights[j][l];
        if (weight != 0.0) variance += weight * Covariance(model, k, l);
      }
    }
    message->b_lsb[j][channel] = model.units_per_deg_s * value;
    message->b_std_error[j][channel] = grow * model.units_per_deg_s * std::sqrt(variance);
  }
}

}  // namespace

std::optional<model_result_t> ModelMessage(const calibration::Traced& traced) {
  if (!traced.result.vector.matrix || traced.models.size() != 3) return std::nullopt;
  const calibration::VectorMatrix& matrix = *traced.result.vector.matrix;
  model_result_t message{};
  std::size_t n = 0;
  for (const ChannelModel& model : traced.models) n = std::max(n, model.bias_deg_s.size());
  message.n = static_cast<std::int8_t>(n);
  // Of the first channel that has one.
  message.reference_temperature_degC = kMissing;
  for (const ChannelModel& model : traced.models) {
    if (std::isnan(message.reference_temperature_degC))
      message.reference_temperature_degC = model.reference_degC;
  }
  message.b_lsb.assign(n, std::vector<double>(3, 0.0));
  message.b_std_error = message.b_lsb;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t j = 0; j < 3; ++j) {
      message.a_deg_s_per_lsb[c][j] = matrix.a[c][j];
      message.a_std_error[c][j] = matrix.a_std_error[c][j];
    }
    const double grow = std::fmax(1.0, traced.result.channels[c].fitted_whitened_rms.after);
    SetOffsets(traced.models[c], message.reference_temperature_degC, grow, c, &message);
    message.whitened_rms[c] = traced.result.channels[c].heldout_whitened_rms.after;
  }
  return message;
}

}  // namespace gyrobench::daemon

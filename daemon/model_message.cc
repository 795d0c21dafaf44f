#include "daemon/model_message.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace gyrobench::daemon {
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

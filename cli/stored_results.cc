#include "cli/stored_results.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/json_field.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;

SensorAxis Axis(const Json& json, const std::string& key) {
  const std::string axis = Text(json, key);
  return axis == "x" ? SensorAxis::kX : axis == "y" ? SensorAxis::kY : SensorAxis::kZ;
}

std::vector<std::string> Texts(const Json& list) {
  std::vector<std::string> texts;
  for (const Json& text : list) texts.push_back(Plain(text));
  return texts;
}

calibration::NoiseModel Noise(const Json& json) {
  return {Number(json, "angle_random_walk_deg_sqrt_s"),
          Number(json, "bias_random_walk_deg_s_sqrt_s"), Number(json, "reference_deg")};
}

calibration::BiasResult Bias(const Json& json) {
  calibration::BiasResult bias;
  bias.axis = Axis(json, "axis");
  bias.unit = Text(json, "unit");
  bias.reference_temperature_degC = Number(json, "reference_temperature_degC");
  bias.min_temperature_degC = Number(json, "min_temperature_degC");
  bias.max_temperature_degC = Number(json, "max_temperature_degC");
  bias.coefficients = Numbers(Field(json, "coefficients"));
  bias.std_errors = Numbers(Field(json, "std_errors"));
  bias.rms_error = Number(json, "rms_error");
  bias.residual_rms = Number(json, "residual_rms");
  bias.paper_coefficients = Numbers(Field(json, "paper_coefficients"));
  bias.paper_rms_error = Number(json, "paper_rms_error");
  bias.noise = Noise(Field(json, "noise"));
  bias.remarks = Texts(Field(json, "remarks"));
  return bias;
}

calibration::ScaleResult Scale(const Json& json) {
  calibration::ScaleResult scale;
  scale.axis = Axis(json, "axis");
  scale.unit = Text(json, "unit");
  scale.turns = Integer(json, "turns");
  scale.schedule = Text(json, "schedule");
  scale.alpha = Number(json, "alpha");
  scale.alpha_std_error = Number(json, "alpha_std_error");
  scale.alpha_statistical_std_error = Number(json, "alpha_statistical_std_error");
  scale.reference_uncertainty = Number(json, "reference_uncertainty");
  scale.scale_error = Number(json, "scale_error");
  scale.bias = Number(json, "bias");
  scale.bias_std_error = Number(json, "bias_std_error");
  scale.bias_temperature_degC = Number(json, "bias_temperature_degC");
  scale.residual_rms_deg = Number(json, "residual_rms_deg");
  scale.whitened_rms = Number(json, "whitened_rms");
  scale.paper_alpha = Number(json, "paper_alpha");
  scale.paper_alpha_std_error = Number(json, "paper_alpha_std_error");
  scale.paper_first_rest_alpha = Number(json, "paper_first_rest_alpha");
  scale.min_rate_deg_s = Number(json, "min_rate_deg_s");
  scale.max_rate_deg_s = Number(json, "max_rate_deg_s");
  scale.min_temperature_degC = Number(json, "min_temperature_degC");
  scale.max_temperature_degC = Number(json, "max_temperature_degC");
  scale.noise = Noise(Field(json, "noise"));
  scale.tick_ratio = Number(json, "tick_ratio");
  scale.tick_ratio_std_error = Number(json, "tick_ratio_std_error");
  scale.remarks = Texts(Field(json, "remarks"));
  return scale;
}

calibration::Verdict VerdictNamed(const std::string& name) {
  for (const auto verdict :
       {calibration::Verdict::kExplained, calibration::Verdict::kPartlyExplained,
        calibration::Verdict::kUnexplained}) {
    if (name == calibration::Name(verdict)) return verdict;
  }
  return calibration::Verdict::kNone;
}

calibration::ChannelTrace Channel(const Json& json) {
  calibration::ChannelTrace channel;
  channel.axis = Axis(json, "gyro");
  channel.verdict = VerdictNamed(Text(json, "verdict"));
  channel.summary = Text(json, "summary");
  channel.baseline.whitened_rms = Number(Field(json, "baseline"), "whitened_rms");
  for (const Json& effect : Field(json, "effects")) {
    channel.effects.emplace_back().id = Text(effect, "id");
    channel.effects.back().rivals = Texts(Field(effect, "rivals"));
  }
  return channel;
}

}  // namespace

calibration::AnalysisResult ReadAnalysis(const Json& json) {
  calibration::AnalysisResult result;
  const Json& info = Field(json, "info");
  result.info.source = Text(info.is_null() ? json : info, "source");
  result.samples = Integer(json, "samples");
  result.reference_samples = Integer(json, "reference_samples");
  result.duration_s = Number(json, "duration_s");
  result.gyro_rate_hz = Number(json, "gyro_rate_hz");
  for (const Json& defect : Field(json, "defects")) {
    result.defects.push_back({Text(defect, "kind"), Integer(defect, "count"),
                              Number(defect, "first_t_s"), Text(defect, "where")});
  }
  for (const Json& bias : Field(json, "bias")) result.bias.push_back(Bias(bias));
  for (const Json& scale : Field(json, "scale")) result.scale.push_back(Scale(scale));
  result.remarks = Texts(Field(json, "remarks"));
  return result;
}

calibration::TraceResult ReadVerdicts(const Json& json) {
  calibration::TraceResult trace;
  for (const Json& channel : Field(json, "channels")) trace.channels.push_back(Channel(channel));
  return trace;
}

}  // namespace gyrobench::cli

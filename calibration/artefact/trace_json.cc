#include "calibration/artefact/trace_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_number.h"
#include "calibration/artefact/vector_json.h"

namespace gyrobench::calibration {
namespace {

using nlohmann::json;

json ToJson(const ModelParameter& parameter) {
  return {{"name", parameter.name},
          {"value", Number(parameter.value)},
          {"unit", parameter.unit},
          {"std_error", Number(parameter.std_error)},
          {"bound", Number(parameter.bound)},
          {"statistical_std_error",
           Number(std::isfinite(parameter.statistical_std_error) ? parameter.statistical_std_error
                                                                 : parameter.std_error)}};
}

json ToJson(const HeldOut& held_out) {
  return {{"before", Number(held_out.before)},
          {"after", Number(held_out.after)},
          {"reduction_ci95", Numbers(held_out.reduction_ci95)}};
}

json BeforeAndAfter(const HeldOut& figure) {
  return {{"before", Number(figure.before)}, {"after", Number(figure.after)}};
}

json ToJson(const Defect& defect) {
  return {{"kind", defect.kind},
          {"count", defect.count},
          {"first_t_s", Number(defect.first_t_s)},
          {"where", defect.where}};
}

json ToJson(const Unidentifiable& unidentifiable) {
  return {{"id", unidentifiable.id},
          {"because", Message(unidentifiable)},
          {"settled_by", unidentifiable.settled_by}};
}

json ToJson(const Finding& finding) {
  return {{"test", finding.test},
          {"covariate", finding.covariate},
          {"p_value", Number(finding.p_value)},
          {"says", finding.says}};
}

json ToJson(const TracedEffect& effect);
json ToJson(const ChannelTrace& channel);
json ToJson(const TraceInput& input);

template <typename T>
json List(const std::vector<T>& values) {
  json list = json::array();
  for (const T& value : values) list.push_back(ToJson(value));
  return list;
}

json ToJson(const TracedEffect& effect) {
  return {{"id", effect.id},
          {"origin", Name(effect.origin)},
          {"owner", Name(effect.owner)},
          {"equation", effect.equation},
          {"cause", effect.cause},
          {"parameters", List(effect.parameters)},
          {"p_value", Number(effect.p_value)},
          {"rivals", effect.rivals},
          {"settled_by", effect.settled_by},
          {"chosen_on", Name(effect.chosen_on)},
          {"heldout_whitened_rms", ToJson(effect.heldout_whitened_rms)},
          {"heldout_angle_rms_deg", ToJson(effect.heldout_angle_rms_deg)}};
}

bool Tried(const ChannelTrace& channel) {
  return std::isfinite(channel.heldout_whitened_rms.after);
}

json ToJson(const TraceNoise& noise) {
  return {{"angle_random_walk_deg_sqrt_s", Number(noise.angle_random_walk_deg_sqrt_s)},
          {"bias_random_walk_deg_s_sqrt_s", Number(noise.bias_random_walk_deg_s_sqrt_s)},
          {"reference_deg", Number(noise.reference_deg)}};
}

json ToJson(const ChannelTrace& channel) {
  return {{"gyro", std::string(1, "xyz"[static_cast<std::size_t>(channel.axis)])},
          {"verdict", Name(channel.verdict)},
          {"summary", channel.summary},
          {"baseline",
           {{"parameters", List(channel.baseline.parameters)},
            {"reference_degC", Number(channel.baseline.reference_degC)},
            {"whitened_rms", Number(channel.baseline.whitened_rms)},
            {"angle_rms_deg", Number(channel.baseline.angle_rms_deg)}}},
          {"effects", List(channel.effects)},
          {"heldout_whitened_rms", ToJson(channel.heldout_whitened_rms)},
          {"heldout_angle_rms_deg", ToJson(channel.heldout_angle_rms_deg)},
          {"training_effects", Tried(channel) ? json(channel.training_effects) : json(nullptr)},
          {"forecast_angle_rms_deg", ToJson(channel.forecast_angle_rms_deg)},
          {"fitted_whitened_rms", BeforeAndAfter(channel.fitted_whitened_rms)},
          {"fitted_angle_rms_deg", BeforeAndAfter(channel.fitted_angle_rms_deg)},
          {"unidentifiable", List(channel.unidentifiable)},
          {"remaining",
           {{"white", channel.remaining.white}, {"findings", List(channel.remaining.findings)}}},
          {"noise", ToJson(channel.noise)},
          {"remarks", channel.remarks}};
}

json ToJson(const TraceInput& input) {
  return {{"file", input.file},
          {"samples", input.samples},
          {"duration_s", Number(input.duration_s)},
          {"defects", List(input.defects)}};
}

}  // namespace

json ToJson(const TraceResult& result) {
  return {{"format", kTraceFormat},
          {"inputs", List(result.inputs)},
          {"channels", List(result.channels)},
          {"vector", ToJson(result.vector)},
          {"reference_error",
           {{"says", result.reference_error},
            {"relative_std_uncertainty", Number(result.reference_uncertainty)}}},
          {"remarks", result.remarks}};
}

}  // namespace gyrobench::calibration

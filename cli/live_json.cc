#include "cli/live_text.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;

template <typename Message>
Json Common(const Message& m) {
  return {{"utime", m.utime}, {"run_id", m.run_id}, {"seq", m.seq}};
}

void Add(Json& json, Json more) { json.update(more); }

Json Fields(const status_t& m) {
  return {{"state", StateName(m.state)},
          {"stand", m.stand},
          {"version", m.version},
          {"virtual_stand", m.virtual_stand != 0},
          {"temperature_degC", m.temperature_degC},
          {"tick_ratio", m.tick_ratio},
          {"gyro_rate_hz", m.gyro_rate_hz},
          {"message", m.message}};
}

Json Fields(const run_t& m) {
  static constexpr const char* kEvents[] = {"start",    "segment_begin", "segment_end", "progress",
                                            "question", "answer",        "note",        "pause",
                                            "resume",   "stop"};
  const bool known = m.event >= 0 && m.event <= run_t::STOP;
  return {{"event", known ? Json(kEvents[m.event]) : Json(m.event)},
          {"procedure", m.procedure},
          {"segment_kind", m.segment_kind},
          {"segment_name", m.segment_name},
          {"segment_begin_utime", m.segment_begin_utime},
          {"segments_done", m.segments_done},
          {"progress", m.progress},
          {"remaining_s", m.remaining_s},
          {"text", m.text},
          {"choices", m.choices},
          {"outcome", m.outcome},
          {"record", m.record}};
}

Json Fields(const bias_result_t& m) {
  return {{"sensor_axis", SensorAxisName(m.sensor_axis)},
          {"final", m.final != 0},
          {"reference_temperature_degC", m.reference_temperature_degC},
          {"min_temperature_degC", m.min_temperature_degC},
          {"max_temperature_degC", m.max_temperature_degC},
          {"order", m.order},
          {"coefficient", m.coefficient},
          {"std_error", m.std_error},
          {"covariance", m.covariance},
          {"rms_error_lsb", m.rms_error_lsb},
          {"residual_rms_lsb", m.residual_rms_lsb},
          {"paper_coefficient", m.paper_coefficient},
          {"paper_rms_error_lsb", m.paper_rms_error_lsb},
          {"angle_random_walk_deg_sqrt_s", m.angle_random_walk_deg_sqrt_s},
          {"bias_random_walk_deg_s_sqrt_s", m.bias_random_walk_deg_s_sqrt_s}};
}

Json Fields(const scale_result_t& m) {
  Json json = {{"sensor_axis", SensorAxisName(m.sensor_axis)},
               {"final", m.final != 0},
               {"turns", m.turns},
               {"alpha_deg_s_per_lsb", m.alpha_deg_s_per_lsb},
               {"alpha_std_error", m.alpha_std_error},
               {"scale_error", m.scale_error},
               {"bias_lsb", m.bias_lsb},
               {"bias_std_error", m.bias_std_error},
               {"alpha_bias_covariance", m.alpha_bias_covariance},
               {"bias_temperature_degC", m.bias_temperature_degC},
               {"residual_rms_deg", m.residual_rms_deg},
               {"whitened_rms", m.whitened_rms},
               {"paper_alpha_deg_s_per_lsb", m.paper_alpha_deg_s_per_lsb},
               {"paper_alpha_std_error", m.paper_alpha_std_error},
               {"paper_first_rest_alpha_deg_s_per_lsb", m.paper_first_rest_alpha_deg_s_per_lsb}};
  Add(json, {{"min_rate_deg_s", m.min_rate_deg_s},
             {"max_rate_deg_s", m.max_rate_deg_s},
             {"min_temperature_degC", m.min_temperature_degC},
             {"max_temperature_degC", m.max_temperature_degC},
             {"angle_random_walk_deg_sqrt_s", m.angle_random_walk_deg_sqrt_s},
             {"bias_random_walk_deg_s_sqrt_s", m.bias_random_walk_deg_s_sqrt_s},
             {"reference_deg", m.reference_deg},
             {"tick_ratio", m.tick_ratio},
             {"tick_ratio_std_error", m.tick_ratio_std_error}});
  return json;
}

Json Fields(const model_result_t& m) {
  return {{"final", m.final != 0},
          {"a_deg_s_per_lsb", m.a_deg_s_per_lsb},
          {"a_std_error", m.a_std_error},
          {"reference_temperature_degC", m.reference_temperature_degC},
          {"b_lsb", m.b_lsb},
          {"b_std_error", m.b_std_error},
          {"whitened_rms", m.whitened_rms}};
}

Json Fields(const trace_result_t& m) {
  return {{"sensor_axis", SensorAxisName(m.sensor_axis)},
          {"final", m.final != 0},
          {"verdict", m.verdict},
          {"summary", m.summary},
          {"effect_index", m.effect_index},
          {"effect_count", m.effect_count},
          {"effect_id", m.effect_id},
          {"origin", m.origin},
          {"owner", m.owner},
          {"parameter_name", m.parameter_name},
          {"parameter_value", m.parameter_value},
          {"parameter_std_error", m.parameter_std_error},
          {"parameter_unit", m.parameter_unit},
          {"p_value", m.p_value},
          {"whitened_rms_before", m.whitened_rms_before},
          {"whitened_rms_after", m.whitened_rms_after},
          {"angle_rms_deg_before", m.angle_rms_deg_before},
          {"angle_rms_deg_after", m.angle_rms_deg_after},
          {"rivals", m.rivals},
          {"next_manoeuvre", m.next_manoeuvre}};
}

Json Fields(const fault_t& m) {
  return {{"active", m.active != 0}, {"source", m.source}, {"message", m.message}};
}

Json Fields(const gyro_t& m) {
  return {{"unit_tick", m.unit_tick},
          {"tick_rate_hz", m.tick_rate_hz},
          {"boot_count", m.boot_count},
          {"missed", m.missed},
          {"gyro_lsb_per_deg_s", m.gyro_lsb_per_deg_s},
          {"accel_lsb_per_g", m.accel_lsb_per_g},
          {"first_counter", m.first_counter},
          {"sample_utime", m.sample_utime},
          {"sample_tick", m.sample_tick},
          {"gyro_lsb", m.gyro_lsb},
          {"accel_lsb", m.accel_lsb},
          {"temperature_degC", m.temperature_degC}};
}

Json Fields(const angle_t& m) {
  return {{"axis", m.axis},
          {"counts", m.counts},
          {"angle_deg", m.angle_deg},
          {"utime_request", m.utime_request},
          {"utime_reply", m.utime_reply}};
}

Json Fields(const axes_t& m) {
  return {{"name", m.name},
          {"commanded_deg", m.commanded_deg},
          {"reference_deg", m.reference_deg},
          {"enabled", m.enabled},
          {"moving", m.moving},
          {"fault", m.fault},
          {"alarm", m.alarm}};
}

Json Whole(const Undecoded& m) { return {{"undecoded", m.why}}; }

template <typename Message>
Json Whole(const Message& message) {
  Json json = Common(message);
  Add(json, Fields(message));
  return json;
}

}  // namespace

Json LiveJson(const LiveMessage& message) {
  Json json = std::visit([](const auto& m) { return Whole(m); }, message.body);
  json["channel"] = message.channel;
  json["lost"] = message.lost;
  return json;
}

}  // namespace gyrobench::cli

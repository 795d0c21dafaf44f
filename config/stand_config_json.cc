#include <nlohmann/json.hpp>
#include <optional>

#include "config/stand_config.h"
#include "config/words.h"

namespace gyrobench::config {
namespace {

using nlohmann::json;

// Null: not read, or no such input.
void AddInputs(const std::optional<DriveInputs>& inputs, json* map) {
  const auto bit = [&inputs](std::optional<int> DriveInputs::*which) -> json {
    if (!inputs || !((*inputs).*which)) return nullptr;
    return *((*inputs).*which);
  };
  (*map)["inputs_address"] = inputs ? json(inputs->address) : json(nullptr);
  (*map)["emergency_stop_input_bit"] = bit(&DriveInputs::emergency_stop_bit);
  (*map)["limit_plus_input_bit"] = bit(&DriveInputs::limit_plus_bit);
  (*map)["limit_minus_input_bit"] = bit(&DriveInputs::limit_minus_bit);
  (*map)["active_input_level"] = inputs ? json(inputs->active_level) : json(nullptr);
}

json MapToJson(const DriveMap& map) {
  json out{{"kind", "drive"},
           {"model", map.model},
           {"pulses_per_turn_address", map.pulses_per_turn_address},
           {"pulses_per_turn", map.pulses_per_turn},
           {"enable_address", map.enable_address},
           {"status_address", map.status_address},
           {"fault_bit", map.fault_bit},
           {"enabled_bit", map.enabled_bit},
           {"running_bit", map.running_bit},
           {"command_done_bit", map.command_done_bit},
           {"path_done_bit", map.path_done_bit},
           {"position_address", map.position_address},
           {"word_order", NameOf(map.word_order)},
           {"alarm_address", map.alarm_address},
           {"control_address", map.control_address},
           {"clear_alarm_value", map.clear_alarm_value},
           {"save_value", map.save_value ? json(*map.save_value) : json(nullptr)},
           {"trigger_address", map.trigger_address},
           {"quick_stop_value", map.quick_stop_value},
           {"path_address", map.path_address},
           {"relative_mode", map.relative_mode},
           {"start_value", map.start_value},
           {"min_rpm", map.min_rpm},
           {"max_rpm", map.max_rpm},
           {"min_ramp_ms_per_1000rpm", map.min_ramp_ms_per_1000rpm},
           {"max_ramp_ms_per_1000rpm", map.max_ramp_ms_per_1000rpm}};
  AddInputs(map.inputs, &out);
  return out;
}

json MapToJson(const EncoderMap& map) {
  return {{"kind", "encoder"},
          {"model", map.model},
          {"function", map.function},
          {"address", map.address},
          {"words", map.words},
          {"word_order", NameOf(map.word_order)},
          {"counts_per_turn", map.counts_per_turn},
          {"range_counts", map.range_counts},
          {"delay_s", map.delay_s}};
}

json MapToJson(const GyroUnitMap& map) {
  return {{"kind", "gyro_unit"},
          {"model", map.model},
          {"identity_address", map.identity_address},
          {"magic", map.magic},
          {"protocol_version", map.protocol_version},
          {"counters_address", map.counters_address},
          {"block_address", map.block_address},
          {"block_span", map.block_span},
          {"block_header_words", map.block_header_words},
          {"sample_words", map.sample_words},
          {"max_samples_per_block", map.max_samples_per_block},
          {"settings_address", map.settings_address},
          {"tick_rate_hz", map.tick_rate_hz},
          {"who_am_i", map.who_am_i},
          {"gyro_range_deg_s", map.gyro_range_deg_s},
          {"gyro_lsb_per_deg_s", map.gyro_lsb_per_deg_s},
          {"accel_range_g", map.accel_range_g},
          {"accel_lsb_per_g", map.accel_lsb_per_g},
          {"filter_bandwidth_hz", map.filter_bandwidth_hz},
          {"filter_delay_s", map.filter_delay_s},
          {"temperature_lsb_per_degC", map.temperature_lsb_per_degC},
          {"temperature_offset_degC", map.temperature_offset_degC}};
}

json BusToJson(const BusConfig& bus) {
  json out = {{"response_timeout_s", bus.response_timeout_s}, {"retries", bus.retries}};
  if (bus.transport == BusConfig::Transport::kTcp) {
    out.update({{"transport", "tcp"}, {"host", bus.host}, {"port", bus.port}});
  } else {
    out.update({{"transport", "rtu"},
                {"device", bus.device},
                {"baud", bus.baud},
                {"parity", std::string(1, bus.parity)},
                {"stop_bits", bus.stop_bits}});
  }
  return out;
}

json AxisToJson(const AxisConfig& axis) {
  return {{"gear_ratio", axis.gear_ratio},
          {"shaft_accuracy_deg", axis.shaft_accuracy_deg},
          {"min_deg", axis.min_deg},
          {"max_deg", axis.max_deg},
          {"max_rate_deg_s", axis.max_rate_deg_s},
          {"max_acceleration_deg_s2", axis.max_acceleration_deg_s2},
          {"following_error_deg", axis.following_error_deg},
          {"drive",
           {{"bus", axis.drive.bus},
            {"unit", axis.drive.unit},
            {"map", MapToJson(axis.drive.map)},
            {"sign", axis.drive.sign}}},
          {"encoder",
           {{"bus", axis.encoder.bus},
            {"unit", axis.encoder.unit},
            {"map", MapToJson(axis.encoder.map)},
            {"sign", axis.encoder.sign},
            {"offset_deg", axis.encoder.offset_deg},
            {"rate_hz", axis.encoder.rate_hz},
            {"idle_rate_hz", axis.encoder.idle_rate_hz}}}};
}

json GyroToJson(const GyroConfig& gyro) {
  json out = {{"bus", gyro.bus},
              {"unit", gyro.unit},
              {"map", MapToJson(gyro.map)},
              {"range_deg_s", gyro.range_deg_s},
              {"filter", gyro.filter},
              {"rate_hz", gyro.rate_hz},
              {"accel_range_g", gyro.accel_range_g},
              {"min_degC", gyro.min_degC},
              {"max_degC", gyro.max_degC}};
  if (gyro.serial_number) out["serial_number"] = *gyro.serial_number;
  return out;
}

json RelaysToJson(const RelaysConfig& relays) {
  json out = {{"bus", relays.bus},
              {"unit", relays.unit},
              {"map",
               {{"kind", "relays"},
                {"model", relays.map.model},
                {"first_coil", relays.map.first_coil},
                {"channels", relays.map.channels}}},
              {"heater_max_degC", relays.heater_max_degC}};
  out.update(relays.channels);
  return out;
}

json GeometryToJson(StandGeometry geometry) {
  json out = json::object();
  for (const GeometryAngle& angle : AnglesOf(geometry)) out[angle.name] = *angle.value_deg;
  return out;
}

json SiteToJson(const SiteConfig& site) {
  json out = {{"heading_deg", site.heading_deg}};
  if (site.latitude_deg) out["latitude_deg"] = *site.latitude_deg;
  return out;
}

json ReferenceToJson(const ReferenceConfig& reference) {
  json out = json::object();
  if (reference.scale_uncertainty) out["scale_uncertainty"] = *reference.scale_uncertainty;
  if (reference.eccentricity_deg) out["eccentricity_deg"] = *reference.eccentricity_deg;
  if (reference.alignment_deg) out["alignment_deg"] = *reference.alignment_deg;
  return out;
}

json PathsToJson(const std::vector<std::filesystem::path>& paths) {
  json out = json::array();
  for (const auto& path : paths) out.push_back(path.string());
  return out;
}

}  // namespace

json ToJson(const StandConfig& stand) {
  json buses = json::object(), axes = json::object();
  for (const BusConfig& bus : stand.buses) buses[bus.name] = BusToJson(bus);
  for (const AxisConfig& axis : stand.axes) axes[axis.name] = AxisToJson(axis);
  json out{{"file", stand.file.string()},
           {"name", stand.name},
           {"bus", std::move(buses)},
           {"axis", std::move(axes)},
           {"gyro", GyroToJson(stand.gyro)},
           {"geometry", GeometryToJson(stand.geometry)},
           {"site", SiteToJson(stand.site)},
           {"reference", ReferenceToJson(stand.reference)},
           {"lcm",
            {{"url", stand.lcm.url},
             {"channel_prefix", stand.lcm.channel_prefix},
             {"required", stand.lcm.required}}},
           {"safety",
            {{"silence_s", stand.safety.silence_s},
             {"resume_within_s", stand.safety.resume_within_s},
             {"min_free_mib", stand.safety.min_free_mib}}},
           {"records", stand.records.string()},
           {"procedures", PathsToJson(stand.procedure_dirs)},
           {"control_socket", stand.control_socket.string()},
           {"control_socket_mode", stand.control_socket_mode},
           {"control_movers", stand.control_movers},
           {"virtual", stand.virtual_stand.has_value()}};
  if (stand.control_socket_owner) out["control_socket_owner"] = *stand.control_socket_owner;
  if (stand.control_socket_group) out["control_socket_group"] = *stand.control_socket_group;
  if (stand.relays) out["relays"] = RelaysToJson(*stand.relays);
  return out;
}

}  // namespace gyrobench::config

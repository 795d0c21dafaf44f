#include <nlohmann/json.hpp>

#include "base/json_number.h"
#include "calibration/artefact/vector_json.h"
#include "calibration/hold/calibrate_hold.h"

namespace gyrobench::calibration {
namespace {

using nlohmann::json;

json ToJson(const HoldInput& input) {
  json defects = json::array();
  for (const Defect& defect : input.defects) {
    defects.push_back({{"kind", defect.kind},
                       {"count", defect.count},
                       {"first_t_s", Number(defect.first_t_s)},
                       {"where", defect.where}});
  }
  return {{"file", input.info.source},
          {"samples", input.samples},
          {"duration_s", Number(input.duration_s)},
          {"gyro_rate_hz", Number(input.gyro_rate_hz)},
          {"rests", input.rests},
          {"turns", input.turns},
          {"defects", defects}};
}

json ToJson(const HoldNoiseResult& noise) {
  return {{"angle_random_walk_deg_sqrt_s", Number(noise.angle_random_walk_deg_sqrt_s)},
          {"rest_angle_random_walk_deg_sqrt_s", Number(noise.rest_angle_random_walk_deg_sqrt_s)},
          {"bias_random_walk_deg_s_sqrt_s", Number(noise.bias_random_walk_deg_s_sqrt_s)},
          {"accel_density_g_sqrt_s", Number(noise.accel_density_g_sqrt_s)},
          {"pose_scatter_g", Number(noise.pose_scatter_g)}};
}

json Faces(const HoldResult& result) {
  json faces = json::array();
  for (const HoldFace& face : result.faces)
    faces.push_back(
        {{"up", face.up}, {"nearest_deg", Number(face.nearest_deg)}, {"covered", face.covered}});
  return faces;
}

json LeftOut(const HoldResult& result) {
  json list = json::array();
  for (const HoldLeftOut& left : result.left_out)
    list.push_back({{"what", left.what},
                    {"file", left.file},
                    {"begin_s", Number(left.begin_s)},
                    {"end_s", Number(left.end_s)},
                    {"because", left.because}});
  return list;
}

json Findings(const HoldResult& result) {
  json list = json::array();
  for (const HoldFinding& finding : result.findings)
    list.push_back({{"test", finding.test},
                    {"channels", finding.channels},
                    {"p_value", Number(finding.p_value)},
                    {"in_model", finding.in_model},
                    {"says", finding.says}});
  return list;
}

}  // namespace

json ToJson(const HoldResult& result) {
  json inputs = json::array();
  for (const HoldInput& input : result.inputs) inputs.push_back(ToJson(input));
  return {{"format", kHoldFormat},
          {"inputs", inputs},
          {"sensor", result.sensor},
          {"gyro_lsb_zero", Number(result.gyro_lsb_zero)},
          {"rests", result.rests},
          {"turns", result.turns},
          {"duration_s", Number(result.duration_s)},
          {"faces", Faces(result)},
          {"turned_deg", Numbers(result.turned_deg)},
          {"left_out", LeftOut(result)},
          {"missing", result.missing},
          {"verdict", result.missing.empty() ? json(Name(result.verdict)) : json(nullptr)},
          {"summary", result.summary},
          {"findings", Findings(result)},
          {"remarks", result.remarks},
          {"unit", result.unit},
          {"sensitivity_given", result.sensitivity_given},
          {"units_per_deg_s", Numbers(result.units_per_deg_s)},
          {"bias_deg_s", Numbers(result.bias_deg_s)},
          {"bias_std_error_deg_s", Numbers(result.bias_std_error_deg_s)},
          {"temperature_degC", Number(result.temperature_degC)},
          {"min_temperature_degC", Number(result.min_temperature_degC)},
          {"max_temperature_degC", Number(result.max_temperature_degC)},
          {"max_rate_deg_s", Number(result.max_rate_deg_s)},
          {"vector", result.missing.empty() ? ToJson(result.vector) : json(nullptr)},
          {"noise", ToJson(result.noise)},
          {"angle_rms_nominal_deg", Number(result.angle_rms_nominal_deg)},
          {"angle_rms_deg", Number(result.angle_rms_deg)},
          {"turn_whitened_rms", Number(result.turn_whitened_rms)},
          {"accel_whitened_rms", Number(result.accel_whitened_rms)}};
}

}  // namespace gyrobench::calibration

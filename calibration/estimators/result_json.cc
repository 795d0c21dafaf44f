#include "calibration/estimators/result_json.h"

#include <nlohmann/json.hpp>

#include "base/json_number.h"

namespace gyrobench::calibration {
namespace {

using nlohmann::json;

const char* Name(SensorAxis axis) {
  switch (axis) {
    case SensorAxis::kX:
      return "x";
    case SensorAxis::kY:
      return "y";
    case SensorAxis::kZ:
      return "z";
  }
  return "z";
}

const char* Name(ReferenceKind kind) {
  switch (kind) {
    case ReferenceKind::kNone:
      return "none";
    case ReferenceKind::kStandAngles:
      return "stand_angles";
    case ReferenceKind::kSensorAngle:
      return "sensor_angle";
    case ReferenceKind::kOrientation:
      return "orientation";
  }
  return "none";
}

const char* Name(RateUnit unit) {
  switch (unit) {
    case RateUnit::kLsb:
      return "lsb";
    case RateUnit::kDegPerSecond:
      return "deg_s";
    case RateUnit::kRadPerSecond:
      return "rad_s";
  }
  return "lsb";
}

json ToJson(StandGeometry geometry) {
  json out = json::object();
  for (const GeometryAngle& angle : AnglesOf(geometry)) out[angle.name] = Number(*angle.value_deg);
  return out;
}

json ToJson(const MeasurementInfo& info) {
  return {{"source", info.source},
          {"gyro_unit", Name(info.gyro_unit)},
          {"gyro_present", info.gyro_present},
          {"accel_present", info.accel_present},
          {"temperature_present", info.temperature_present},
          {"gyro_units_per_deg_s", Number(info.gyro_units_per_deg_s)},
          {"gyro_lsb_zero", Number(info.gyro_lsb_zero)},
          {"accel_lsb_zero", Number(info.accel_lsb_zero)},
          {"reference", Name(info.reference)},
          {"ref_scale_uncertainty", Number(info.reference_uncertainty.scale)},
          {"ref_eccentricity_deg", Number(info.reference_uncertainty.eccentricity_deg)},
          {"ref_alignment_deg", Number(info.reference_uncertainty.alignment_deg)},
          {"stand_axis_present", info.stand_axis_present},
          {"reference_axis", Name(info.reference_axis)},
          {"geometry", ToJson(info.geometry)},
          {"site_latitude_deg", Number(info.site_latitude_deg)},
          {"site_heading_deg", Number(info.site_heading_deg)},
          {"gear_ratio", Number(info.gear_ratio)},
          {"stop_accuracy_deg", Number(info.stop_accuracy_deg)},
          {"gyro_delay_s", info.gyro_delay_s},
          {"ref_delay_s", info.reference_delay_s},
          {"sensor", info.sensor},
          {"power_on", info.power_on},
          {"notes", info.notes},
          {"covariates", info.covariates}};
}

json ToJson(const NoiseModel& noise) {
  return {{"angle_random_walk_deg_sqrt_s", Number(noise.angle_random_walk_deg_sqrt_s)},
          {"bias_random_walk_deg_s_sqrt_s", Number(noise.bias_random_walk_deg_s_sqrt_s)},
          {"reference_deg", Number(noise.reference_deg)}};
}

json ToJson(const BiasResult& bias) {
  json covariance = json::array();
  for (const std::vector<double>& row : bias.covariance) covariance.push_back(Numbers(row));
  return {{"axis", Name(bias.axis)},
          {"unit", bias.unit},
          {"reference_temperature_degC", Number(bias.reference_temperature_degC)},
          {"min_temperature_degC", Number(bias.min_temperature_degC)},
          {"max_temperature_degC", Number(bias.max_temperature_degC)},
          {"duration_s", Number(bias.duration_s)},
          {"coefficients", Numbers(bias.coefficients)},
          {"std_errors", Numbers(bias.std_errors)},
          {"covariance", covariance},
          {"rms_error", Number(bias.rms_error)},
          {"residual_rms", Number(bias.residual_rms)},
          {"paper_coefficients", Numbers(bias.paper_coefficients)},
          {"paper_rms_error", Number(bias.paper_rms_error)},
          {"noise", ToJson(bias.noise)},
          {"remarks", bias.remarks}};
}

json ToJson(const ScaleResult& scale) {
  return {{"axis", Name(scale.axis)},
          {"unit", scale.unit},
          {"turns", scale.turns},
          {"schedule", scale.schedule},
          {"alpha", Number(scale.alpha)},
          {"alpha_std_error", Number(scale.alpha_std_error)},
          {"alpha_statistical_std_error", Number(scale.alpha_statistical_std_error)},
          {"reference_uncertainty", Number(scale.reference_uncertainty)},
          {"scale_error", Number(scale.scale_error)},
          {"bias", Number(scale.bias)},
          {"bias_std_error", Number(scale.bias_std_error)},
          {"alpha_bias_covariance", Number(scale.alpha_bias_covariance)},
          {"bias_temperature_degC", Number(scale.bias_temperature_degC)},
          {"residual_rms_deg", Number(scale.residual_rms_deg)},
          {"whitened_rms", Number(scale.whitened_rms)},
          {"paper_alpha", Number(scale.paper_alpha)},
          {"paper_alpha_std_error", Number(scale.paper_alpha_std_error)},
          {"paper_first_rest_alpha", Number(scale.paper_first_rest_alpha)},
          {"min_rate_deg_s", Number(scale.min_rate_deg_s)},
          {"max_rate_deg_s", Number(scale.max_rate_deg_s)},
          {"min_temperature_degC", Number(scale.min_temperature_degC)},
          {"max_temperature_degC", Number(scale.max_temperature_degC)},
          {"noise", ToJson(scale.noise)},
          {"tick_ratio", Number(scale.tick_ratio)},
          {"tick_ratio_std_error", Number(scale.tick_ratio_std_error)},
          {"remarks", scale.remarks}};
}

}  // namespace

json ToJson(const AnalysisResult& result) {
  json defects = json::array(), bias = json::array(), scale = json::array();
  for (const Defect& defect : result.defects) {
    defects.push_back({{"kind", defect.kind},
                       {"count", defect.count},
                       {"first_t_s", Number(defect.first_t_s)},
                       {"where", defect.where}});
  }
  for (const BiasResult& one : result.bias) bias.push_back(ToJson(one));
  for (const ScaleResult& one : result.scale) scale.push_back(ToJson(one));
  return {{"info", ToJson(result.info)},
          {"samples", result.samples},
          {"reference_samples", result.reference_samples},
          {"first_time_s", Number(result.first_time_s)},
          {"duration_s", Number(result.duration_s)},
          {"gyro_rate_hz", Number(result.gyro_rate_hz)},
          {"defects", defects},
          {"bias", bias},
          {"scale", scale},
          {"remarks", result.remarks}};
}

}  // namespace gyrobench::calibration

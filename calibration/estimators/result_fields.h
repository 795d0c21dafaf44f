// The lists of fields of a result.
#pragma once

#include "base/measurement_fields.h"
#include "calibration/estimators/results.h"

namespace gyrobench::calibration {

// What is said of a measurement with its result. Its other fields are the record's.
template <typename Visitor>
void InfoFields(Visitor& field, FieldsOf<Visitor, MeasurementInfo>& info) {
  field("source", info.source);
  field("gyro_unit", info.gyro_unit, kRateUnitNames);
  field("gyro_present", info.gyro_present);
  field("accel_present", info.accel_present);
  field("temperature_present", info.temperature_present);
  field("gyro_units_per_deg_s", info.gyro_units_per_deg_s);
  field("gyro_lsb_zero", info.gyro_lsb_zero);
  field("accel_lsb_zero", info.accel_lsb_zero);
  field("reference", info.reference, kReferenceKindNames);
  field("ref_scale_uncertainty", info.reference_uncertainty.scale);
  field("ref_eccentricity_deg", info.reference_uncertainty.eccentricity_deg);
  field("ref_alignment_deg", info.reference_uncertainty.alignment_deg);
  field("stand_axis_present", info.stand_axis_present);
  field("reference_axis", info.reference_axis, kSensorAxisNames);
  field("geometry", info.geometry);
  field("site_latitude_deg", info.site_latitude_deg);
  field("site_heading_deg", info.site_heading_deg);
  field("gear_ratio", info.gear_ratio);
  field("stop_accuracy_deg", info.stop_accuracy_deg);
  field("gyro_delay_s", info.gyro_delay_s);
  field("ref_delay_s", info.reference_delay_s);
  field("sensor", info.sensor);
  field("power_on", info.power_on);
  field("notes", info.notes);
  field("covariates", info.covariates);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, BiasResult>& bias) {
  field("axis", bias.axis, kSensorAxisNames);
  field("unit", bias.unit);
  field("reference_temperature_degC", bias.reference_temperature_degC);
  field("min_temperature_degC", bias.min_temperature_degC);
  field("max_temperature_degC", bias.max_temperature_degC);
  field("duration_s", bias.duration_s);
  field("coefficients", bias.coefficients);
  field("std_errors", bias.std_errors);
  field("covariance", bias.covariance);
  field("rms_error", bias.rms_error);
  field("residual_rms", bias.residual_rms);
  field(Later("offset_scatter"), bias.offset_scatter);
  field(Later("offset_groups"), bias.offset_groups);
  field("paper_coefficients", bias.paper_coefficients);
  field("paper_rms_error", bias.paper_rms_error);
  field("noise", bias.noise);
  field("remarks", bias.remarks);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, ScaleResult>& scale) {
  field("axis", scale.axis, kSensorAxisNames);
  field("unit", scale.unit);
  field("turns", scale.turns);
  field("schedule", scale.schedule);
  field("alpha", scale.alpha);
  field("alpha_std_error", scale.alpha_std_error);
  field("alpha_statistical_std_error", scale.alpha_statistical_std_error);
  field("reference_uncertainty", scale.reference_uncertainty);
  field("scale_error", scale.scale_error);
  field("bias", scale.bias);
  field("bias_std_error", scale.bias_std_error);
  field("alpha_bias_covariance", scale.alpha_bias_covariance);
  field("bias_temperature_degC", scale.bias_temperature_degC);
  field("residual_rms_deg", scale.residual_rms_deg);
  field("whitened_rms", scale.whitened_rms);
  field("paper_alpha", scale.paper_alpha);
  field("paper_alpha_std_error", scale.paper_alpha_std_error);
  field("paper_first_rest_alpha", scale.paper_first_rest_alpha);
  field("min_rate_deg_s", scale.min_rate_deg_s);
  field("max_rate_deg_s", scale.max_rate_deg_s);
  field("min_temperature_degC", scale.min_temperature_degC);
  field("max_temperature_degC", scale.max_temperature_degC);
  field("noise", scale.noise);
  field(Later("noise_of_rests"), scale.noise_of_rests);
  field("tick_ratio", scale.tick_ratio);
  field("tick_ratio_std_error", scale.tick_ratio_std_error);
  field("remarks", scale.remarks);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, AnalysisResult>& result) {
  field.Group("info", [&](auto& info) { InfoFields(info, result.info); });
  field("samples", result.samples);
  field("reference_samples", result.reference_samples);
  field("first_time_s", result.first_time_s);
  field("duration_s", result.duration_s);
  field("gyro_rate_hz", result.gyro_rate_hz);
  field("defects", result.defects);
  field("bias", result.bias);
  field("scale", result.scale);
  field("remarks", result.remarks);
}

}  // namespace gyrobench::calibration

// The lists of fields of a calibration by held poses: docs/hold.md.
#pragma once

#include "base/measurement_fields.h"
#include "calibration/artefact/vector_fields.h"
#include "calibration/hold/calibrate_hold.h"

namespace gyrobench::calibration {

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, HoldInput>& input) {
  field("file", input.info.source);
  field("samples", input.samples);
  field("duration_s", input.duration_s);
  field("gyro_rate_hz", input.gyro_rate_hz);
  field("rests", input.rests);
  field("turns", input.turns);
  field("defects", input.defects);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, HoldLeftOut>& left) {
  field("what", left.what);
  field("file", left.file);
  field("begin_s", left.begin_s);
  field("end_s", left.end_s);
  field("because", left.because);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, HoldFace>& face) {
  field("up", face.up);
  field("nearest_deg", face.nearest_deg);
  field("covered", face.covered);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, HoldNoiseResult>& noise) {
  RandomWalks(field, noise);
  field("rest_angle_random_walk_deg_sqrt_s", noise.rest_angle_random_walk_deg_sqrt_s);
  field("accel_density_g_sqrt_s", noise.accel_density_g_sqrt_s);
  field("pose_scatter_g", noise.pose_scatter_g);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, HoldFinding>& finding) {
  field("test", finding.test);
  field("channels", finding.channels);
  field("p_value", finding.p_value);
  field("in_model", finding.in_model);
  field("says", finding.says);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, HoldResult>& result) {
  field.Constant("format", kHoldFormat);
  field("inputs", result.inputs);
  field("sensor", result.sensor);
  field("gyro_lsb_zero", result.gyro_lsb_zero);
  field("rests", result.rests);
  field("turns", result.turns);
  field("duration_s", result.duration_s);
  field("faces", result.faces);
  field("turned_deg", result.turned_deg);
  field("left_out", result.left_out);
  field("missing", result.missing);
  const NullUnless calibrated = {result.missing.empty()};
  field("verdict", result.verdict, calibrated, NamesUpTo(Verdict::kUnexplained));
  field("summary", result.summary);
  field("findings", result.findings);
  field("remarks", result.remarks);
  field("unit", result.unit);
  field("sensitivity_given", result.sensitivity_given);
  field("units_per_deg_s", result.units_per_deg_s);
  field("bias_deg_s", result.bias_deg_s);
  field("bias_std_error_deg_s", result.bias_std_error_deg_s);
  field("temperature_degC", result.temperature_degC);
  field("min_temperature_degC", result.min_temperature_degC);
  field("max_temperature_degC", result.max_temperature_degC);
  field("max_rate_deg_s", result.max_rate_deg_s);
  field("vector", result.vector, calibrated);
  field("noise", result.noise);
  field("angle_rms_nominal_deg", result.angle_rms_nominal_deg);
  field("angle_rms_deg", result.angle_rms_deg);
  field("turn_whitened_rms", result.turn_whitened_rms);
  field("accel_whitened_rms", result.accel_whitened_rms);
}

}  // namespace gyrobench::calibration

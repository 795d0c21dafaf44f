// The lists of fields of the three axes together: docs/calibration.md.
#pragma once

#include "base/json_fields.h"
#include "calibration/sensor/vector_calibration.h"

namespace gyrobench::calibration {

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, VectorMatrix>& matrix) {
  constexpr SquareOf kElements = {9};
  field("m", matrix.m);
  field("m_std_error", matrix.m_std_error);
  field("m_covariance", matrix.m_covariance, kElements);
  field("a", matrix.a);
  field("a_std_error", matrix.a_std_error);
  field("a_covariance", matrix.a_covariance, kElements);
  // Files of before the reference's uncertainty was carried have statistical errors alone.
  field.LaterAs("m_statistical_std_error", matrix.m_statistical_std_error, matrix.m_std_error);
  field.LaterAs("a_statistical_std_error", matrix.a_statistical_std_error, matrix.a_std_error);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, AxisSplit>& split) {
  field("scale", split.scale);
  field("scale_std_error", split.scale_std_error);
  field("non_orthogonality_deg", split.non_orthogonality_deg);
  field("non_orthogonality_std_error_deg", split.non_orthogonality_std_error_deg);
  field("r_mount", split.r_mount);
  field("mount_deg", split.mount_deg);
  field("mount_std_error_deg", split.mount_std_error_deg);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, GSensitivity>& g) {
  field.Constant("unit", "deg/s/g");
  field("value", g.value);
  field("std_error", g.std_error);
  // Not known of held poses, nor in older files: in some of them the Earth's rotation is counted.
  field(Later("statistical_std_error"), g.statistical_std_error);
  field("in_model", g.in_model);
  field("because", g.because);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, SharedParameter>& shared) {
  field("name", shared.name);
  field("unit", shared.unit);
  field("channels", shared.channels);
  field("value", shared.value);
  field("std_error", shared.std_error);
  field("p_value", shared.p_value);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, GravityCheck>& check) {
  field("rms_before_g", check.rms_before_g);
  field("rms_after_g", check.rms_after_g);
  field("scale", check.scale);
  field("scale_std_error", check.scale_std_error);
  field("offset_g", check.offset_g);
  field("offset_std_error_g", check.offset_std_error_g);
  field("non_orthogonality_deg", check.non_orthogonality_deg);
  field("non_orthogonality_std_error_deg", check.non_orthogonality_std_error_deg);
  field("largest_difference", check.largest_difference);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, AccelerometerCalibration>& accelerometer) {
  field("poses", accelerometer.poses);
  field("m", accelerometer.m);
  field("m_std_error", accelerometer.m_std_error);
  field("offset_g", accelerometer.offset_g);
  field("offset_std_error_g", accelerometer.offset_std_error_g);
  field("pose_scatter_g", accelerometer.pose_scatter_g);
  field("split", accelerometer.split);
  field("check", accelerometer.check);
  field("because", accelerometer.because);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, VectorCalibration>& vector) {
  field("missing", vector.missing);
  field("unit", vector.unit);
  field("matrix", vector.matrix);
  field("split", vector.split);
  field("g_sensitivity", vector.g_sensitivity);
  field("shared", vector.shared);
  field("shared_gain", vector.shared_gain);
  field("accelerometer", vector.accelerometer);
  field("remarks", vector.remarks);
}

}  // namespace gyrobench::calibration

#include "calibration/artefact/vector_json.h"

#include <nlohmann/json.hpp>

#include "base/json_number.h"

namespace gyrobench::calibration {
namespace {

using nlohmann::json;

constexpr std::size_t kElements = 9;

json Rows(const Matrix3& matrix) {
  return {Numbers(matrix[0]), Numbers(matrix[1]), Numbers(matrix[2])};
}

json ToJson(const VectorMatrix& matrix) {
  return {{"m", Rows(matrix.m)},
          {"m_std_error", Rows(matrix.m_std_error)},
          {"m_statistical_std_error", Rows(matrix.m_statistical_std_error)},
          {"m_covariance", SquareRows(matrix.m_covariance, kElements)},
          {"a", Rows(matrix.a)},
          {"a_std_error", Rows(matrix.a_std_error)},
          {"a_statistical_std_error", Rows(matrix.a_statistical_std_error)},
          {"a_covariance", SquareRows(matrix.a_covariance, kElements)}};
}

json ToJson(const AxisSplit& split) {
  return {{"scale", Numbers(split.scale)},
          {"scale_std_error", Numbers(split.scale_std_error)},
          {"non_orthogonality_deg", Numbers(split.non_orthogonality_deg)},
          {"non_orthogonality_std_error_deg", Numbers(split.non_orthogonality_std_error_deg)},
          {"r_mount", Rows(split.r_mount)},
          {"mount_deg", Numbers(split.mount_deg)},
          {"mount_std_error_deg", Numbers(split.mount_std_error_deg)}};
}

json ToJson(const GSensitivity& g) {
  return {{"unit", "deg/s/g"},
          {"value", Rows(g.value)},
          {"std_error", Rows(g.std_error)},
          {"in_model", g.in_model},
          {"because", g.because}};
}

json ToJson(const SharedParameter& shared) {
  return {{"name", shared.name},
          {"unit", shared.unit},
          {"channels", shared.channels},
          {"value", Number(shared.value)},
          {"std_error", Number(shared.std_error)},
          {"p_value", Number(shared.p_value)}};
}

json ToJson(const GravityCheck& check) {
  return {{"rms_before_g", Number(check.rms_before_g)},
          {"rms_after_g", Number(check.rms_after_g)},
          {"scale", Numbers(check.scale)},
          {"scale_std_error", Numbers(check.scale_std_error)},
          {"offset_g", Numbers(check.offset_g)},
          {"offset_std_error_g", Numbers(check.offset_std_error_g)},
          {"non_orthogonality_deg", Numbers(check.non_orthogonality_deg)},
          {"non_orthogonality_std_error_deg", Numbers(check.non_orthogonality_std_error_deg)},
          {"largest_difference", Number(check.largest_difference)}};
}

json ToJson(const AccelerometerCalibration& accelerometer);

template <typename T>
json OrNull(const std::optional<T>& part) {
  return part ? ToJson(*part) : json(nullptr);
}

json ToJson(const AccelerometerCalibration& accelerometer) {
  return {{"poses", accelerometer.poses},
          {"m", Rows(accelerometer.m)},
          {"m_std_error", Rows(accelerometer.m_std_error)},
          {"offset_g", Numbers(accelerometer.offset_g)},
          {"offset_std_error_g", Numbers(accelerometer.offset_std_error_g)},
          {"pose_scatter_g", Number(accelerometer.pose_scatter_g)},
          {"split", OrNull(accelerometer.split)},
          {"check", OrNull(accelerometer.check)},
          {"because", accelerometer.because}};
}

}  // namespace

json ToJson(const VectorCalibration& vector) {
  json shared = json::array();
  for (const SharedParameter& parameter : vector.shared) shared.push_back(ToJson(parameter));
  return {{"missing", vector.missing},
          {"unit", vector.unit},
          {"matrix", OrNull(vector.matrix)},
          {"split", OrNull(vector.split)},
          {"g_sensitivity", OrNull(vector.g_sensitivity)},
          {"shared", shared},
          {"shared_gain", Number(vector.shared_gain)},
          {"accelerometer", OrNull(vector.accelerometer)},
          {"remarks", vector.remarks}};
}

}  // namespace gyrobench::calibration

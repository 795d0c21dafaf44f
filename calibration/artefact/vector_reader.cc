#include "calibration/artefact/json_place.h"
#include "calibration/artefact/vector_json.h"

namespace gyrobench::calibration {
namespace {

Vector3 ReadVector(const Place& place) { return place.NumbersOrNull<3>(); }

Matrix3 ReadMatrix(const Place& place) {
  const std::vector<Place> rows = place.List();
  if (rows.size() != 3) place.Expected("3 rows of 3 numbers");
  return {ReadVector(rows[0]), ReadVector(rows[1]), ReadVector(rows[2])};
}

std::vector<double> ReadCovariance(const Place& place) {
  const std::vector<Place> rows = place.List();
  if (rows.size() != 9) place.Expected("9 rows of 9 numbers");
  std::vector<double> values;
  for (const Place& row : rows)
    for (const double value : row.NumbersOrNull<9>()) values.push_back(value);
  return values;
}

VectorMatrix ReadVectorMatrix(const Place& place) {
  // Files of before the reference's uncertainty was carried have statistical errors alone.
  place.Keys({"m", "m_std_error", "m_covariance", "a", "a_std_error", "a_covariance"},
             {"m_statistical_std_error", "a_statistical_std_error"});
  const auto either = [&](const char* key, const char* before) {
    return ReadMatrix(place[place.value().contains(key) ? key : before]);
  };
  return {ReadMatrix(place["m"]),
          ReadMatrix(place["m_std_error"]),
          ReadMatrix(place["a"]),
          ReadMatrix(place["a_std_error"]),
          ReadCovariance(place["m_covariance"]),
          ReadCovariance(place["a_covariance"]),
          either("m_statistical_std_error", "m_std_error"),
          either("a_statistical_std_error", "a_std_error")};
}

AxisSplit ReadSplit(const Place& place) {
  place.Keys({"scale", "scale_std_error", "non_orthogonality_deg",
              "non_orthogonality_std_error_deg", "r_mount", "mount_deg", "mount_std_error_deg"});
  AxisSplit split;
  split.scale = ReadVector(place["scale"]);
  split.scale_std_error = ReadVector(place["scale_std_error"]);
  split.non_orthogonality_deg = ReadVector(place["non_orthogonality_deg"]);
  split.non_orthogonality_std_error_deg = ReadVector(place["non_orthogonality_std_error_deg"]);
  split.r_mount = ReadMatrix(place["r_mount"]);
  split.mount_deg = ReadVector(place["mount_deg"]);
  split.mount_std_error_deg = ReadVector(place["mount_std_error_deg"]);
  return split;
}

GSensitivity ReadGSensitivity(const Place& place) {
  place.Keys({"unit", "value", "std_error", "in_model", "because"});
  if (place["unit"].Text() != "deg/s/g") place["unit"].Expected("\"deg/s/g\"");
  GSensitivity g;
  g.value = ReadMatrix(place["value"]);
  g.std_error = ReadMatrix(place["std_error"]);
  const std::vector<Place> flags = place["in_model"].List();
  if (flags.size() != 3) place["in_model"].Expected("3 of true or false");
  for (std::size_t c = 0; c < 3; ++c) g.in_model[c] = flags[c].Flag();
  g.because = place["because"].Texts();
  return g;
}

SharedParameter ReadShared(const Place& place) {
  place.Keys({"name", "unit", "channels", "value", "std_error", "p_value"});
  return {place["name"].Text(),
          place["unit"].Text(),
          place["channels"].Text(),
          place["value"].NumberOrNull(),
          place["std_error"].NumberOrNull(),
          place["p_value"].NumberOrNull()};
}

GravityCheck ReadCheck(const Place& place) {
  place.Keys({"rms_before_g", "rms_after_g", "scale", "scale_std_error", "offset_g",
              "offset_std_error_g", "non_orthogonality_deg", "non_orthogonality_std_error_deg",
              "largest_difference"});
  GravityCheck check;
  check.rms_before_g = place["rms_before_g"].NumberOrNull();
  check.rms_after_g = place["rms_after_g"].NumberOrNull();
  check.scale = ReadVector(place["scale"]);
  check.scale_std_error = ReadVector(place["scale_std_error"]);
  check.offset_g = ReadVector(place["offset_g"]);
  check.offset_std_error_g = ReadVector(place["offset_std_error_g"]);
  check.non_orthogonality_deg = ReadVector(place["non_orthogonality_deg"]);
  check.non_orthogonality_std_error_deg = ReadVector(place["non_orthogonality_std_error_deg"]);
  check.largest_difference = place["largest_difference"].NumberOrNull();
  return check;
}

template <typename Read>
auto OrNone(const Place& place, Read read) -> std::optional<decltype(read(place))> {
  if (place.value().is_null()) return std::nullopt;
  return read(place);
}

AccelerometerCalibration ReadAccelerometer(const Place& place) {
  place.Keys({"poses", "m", "m_std_error", "offset_g", "offset_std_error_g", "pose_scatter_g",
              "split", "check", "because"});
  AccelerometerCalibration out;
  out.poses = place["poses"].Count();
  out.m = ReadMatrix(place["m"]);
  out.m_std_error = ReadMatrix(place["m_std_error"]);
  out.offset_g = ReadVector(place["offset_g"]);
  out.offset_std_error_g = ReadVector(place["offset_std_error_g"]);
  out.pose_scatter_g = place["pose_scatter_g"].NumberOrNull();
  out.split = OrNone(place["split"], ReadSplit);
  out.check = OrNone(place["check"], ReadCheck);
  out.because = place["because"].Texts();
  return out;
}

}  // namespace

VectorCalibration VectorFromJson(const Place& place) {
  place.Keys({"missing", "unit", "matrix", "split", "g_sensitivity", "shared", "shared_gain",
              "accelerometer", "remarks"});
  VectorCalibration out;
  out.missing = place["missing"].Texts();
  out.unit = place["unit"].Text();
  out.matrix = OrNone(place["matrix"], ReadVectorMatrix);
  out.split = OrNone(place["split"], ReadSplit);
  out.g_sensitivity = OrNone(place["g_sensitivity"], ReadGSensitivity);
  for (const Place& shared : place["shared"].List()) out.shared.push_back(ReadShared(shared));
  out.shared_gain = place["shared_gain"].NumberOrNull();
  out.accelerometer = OrNone(place["accelerometer"], ReadAccelerometer);
  out.remarks = place["remarks"].Texts();
  return out;
}

}  // namespace gyrobench::calibration
